//! What varies over a patch: a shader laid out over a polygon, or the albedo of a map's surface or what it
//! gives off by itself.

use super::Shader;
use crate::scene::Shading;
use glam::{DVec3, DVec4, Vec3};
use std::sync::Arc;

/// How the values of a patch vary over it.
#[derive(Clone, Debug)]
pub struct Pattern {
    shows: Shows,
    /// Mean factor of each channel over the polygon, 0 to 1.
    pub mean: DVec3,
}

/// What a pattern shows.
#[derive(Clone, Debug)]
enum Shows {
    /// A shader, and from the world to its axes: `row.xyz . p + row.w`.
    Shader(Box<(Shader, [DVec4; 2])>),
    /// The albedo of a surface; where its factor is 1, it is this.
    Surface(Arc<Shading>, Vec3),
    /// The share and colour of what a surface gives off.
    Glow(Arc<Shading>),
}

/// Points along each axis at which a pattern is looked up for its mean.
const LOOKS: u32 = 240;

impl Pattern {
    /// Lays a shader out over a quad. The first edge that has a length is the first axis.
    pub fn over(shader: Shader, v: [DVec3; 4]) -> Self {
        let edge = if v[0] == v[1] { v[2] - v[1] } else { v[1] - v[0] };
        let s = edge.normalize();
        let normal = (v[2] - v[0]).cross(v[3] - v[1]).normalize();
        let axis = |along: DVec3| {
            let (low, high) =
                v.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                    (low.min(along.dot(*p)), high.max(along.dot(*p)))
                });
            (along / (high - low)).extend(-low / (high - low))
        };
        let shows = Shows::Shader(Box::new((shader, [axis(s), axis(normal.cross(s))])));
        let mut pattern = Self { shows, mean: DVec3::ONE };
        pattern.mean = pattern.mean_over(v);
        pattern
    }

    /// The albedo of a surface, which is `base` where the factor of `shading` is 1, over a patch with a mean
    /// albedo of `mean`.
    pub fn of_surface(shading: Arc<Shading>, base: Vec3, mean: Vec3) -> Self {
        Self { shows: Shows::Surface(shading, base), mean: mean.as_dvec3() }
    }

    /// What a surface gives off by itself, over a patch where the mean of that is `mean`.
    pub fn of_glow(shading: Arc<Shading>, mean: Vec3) -> Self {
        Self { shows: Shows::Glow(shading), mean: mean.as_dvec3() }
    }

    /// Factor of each channel at a point, 0 to 1; for surfaces of maps, their albedo or glow.
    pub fn factor(&self, p: DVec3) -> DVec3 {
        match &self.shows {
            Shows::Shader(laid_out) => {
                let (shader, axes) = &**laid_out;
                let [s, t] = axes.map(|row| row.dot(p.extend(1.0)));
                shader.factor(s, t).into()
            }
            Shows::Surface(shading, base) => shading.albedo(*base, p.as_vec3()).as_dvec3(),
            Shows::Glow(shading) => shading.glow(p.as_vec3()).as_dvec3(),
        }
    }

    /// The mean of [`factor`](Self::factor) over some points, over that of the patch; `None` without points.
    pub fn relative_over(&self, points: impl Iterator<Item = DVec3>) -> Option<DVec3> {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for point in points {
            sum += self.factor(point);
            count += 1.0;
        }
        (count > 0.0).then(|| self.over_mean(sum / count))
    }

    /// The same over the mean.
    pub fn relative(&self, p: DVec3) -> DVec3 {
        self.over_mean(self.factor(p))
    }

    /// The value that is found where the factor is 1, of values whose mean is `value`; 0 where the mean
    /// factor is.
    pub fn over_mean(&self, value: DVec3) -> DVec3 {
        let share = |x: f64, mean: f64| if mean > 0.0 { x / mean } else { 0.0 };
        DVec3::from_array(std::array::from_fn(|i| share(value[i], self.mean[i])))
    }

    /// The mean factor, by an even grid of points: exact for a gradient over a rectangle, and for a
    /// checker whose cells the points divide evenly.
    fn mean_over(&self, v: [DVec3; 4]) -> DVec3 {
        let at = |k: u32| (f64::from(k) + 0.5) / f64::from(LOOKS);
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for i in 0..LOOKS {
            for j in 0..LOOKS {
                let (s, t) = (at(i), at(j));
                let p = v[0].lerp(v[1], s).lerp(v[3].lerp(v[2], s), t);
                // Area that the bilinear map gives the point.
                let (du, dv) =
                    ((v[1] - v[0]).lerp(v[2] - v[3], t), (v[3] - v[0]).lerp(v[2] - v[1], s));
                let weight = du.cross(dv).length();
                sum += self.factor(p) * weight;
                weights += weight;
            }
        }
        sum / weights
    }
}
