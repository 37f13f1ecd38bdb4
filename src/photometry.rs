//! Light quantities. All are linear RGB triples; the newtypes keep apart what has different units.
//!
//! Light units are Quake's: a stored luxel level is irradiance times the range scale (0.5 by
//! default), and the engine shows texel x level / 128.

use glam::Vec3;
use std::ops::{Add, AddAssign, Mul, Sub};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[repr(transparent)]
        pub struct $name(pub Vec3);

        impl $name {
            /// No light at all.
            pub const ZERO: Self = Self(Vec3::ZERO);
        }
        impl Add for $name {
            type Output = Self;
            fn add(self, other: Self) -> Self { Self(self.0 + other.0) }
        }
        impl AddAssign for $name {
            fn add_assign(&mut self, other: Self) { self.0 += other.0; }
        }
        impl Sub for $name {
            type Output = Self;
            fn sub(self, other: Self) -> Self { Self(self.0 - other.0) }
        }
        impl Mul<f32> for $name {
            type Output = Self;
            fn mul(self, scale: f32) -> Self { Self(self.0 * scale) }
        }
    };
}

quantity! {
    /// Light arriving per unit area, in light units, from 0 up (negative lights may push it below).
    Irradiance
}
quantity! {
    /// Light leaving a diffuse surface per unit area, in the same units as [`Irradiance`]: a surface
    /// that sees exitance M everywhere receives irradiance M.
    Exitance
}

/// Share of the irradiance that a diffuse surface sends back, per channel, in [0, 1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(transparent)]
pub struct Reflectance(pub Vec3);

impl Mul<Irradiance> for Reflectance {
    type Output = Exitance;
    /// Exitance of a diffuse reflector: M = rho E.
    fn mul(self, e: Irradiance) -> Exitance {
        Exitance(self.0 * e.0)
    }
}
