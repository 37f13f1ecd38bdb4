//! A shader laid out over a polygon.

use super::Shader;
use glam::{DVec3, DVec4};

/// How the values of a patch vary over it.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// What it shows.
    shader: Shader,
    /// World to the shader's axes: `row.xyz . p + row.w`.
    axes: [DVec4; 2],
    /// Mean factor of each channel over the polygon, 0 to 1.
    pub mean: DVec3,
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
        let mut pattern = Self { shader, axes: [axis(s), axis(normal.cross(s))], mean: DVec3::ONE };
        pattern.mean = pattern.mean_over(v);
        pattern
    }

    /// Factor of each channel at a point, 0 to 1.
    pub fn factor(&self, p: DVec3) -> DVec3 {
        let [s, t] = self.axes.map(|row| row.dot(p.extend(1.0)));
        self.shader.factor(s, t).into()
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
