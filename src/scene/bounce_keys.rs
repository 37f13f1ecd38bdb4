//! What worldspawn says of bounced light (contract section 8.1).

use super::dirt::SetNumber;
use super::keys;
use crate::bsp::Entity;

/// Value of `bounce` that asks for as many bounces as it takes.
pub(crate) const ALL_BOUNCES: &str = "all";

/// Worldspawn's settings of bounced light.
#[derive(Clone, Debug, PartialEq)]
pub struct BounceSettings {
    /// `bounce`: most bounces; 0 is direct light only, `None` is until little is left.
    pub most: Option<u32>,
    /// `bouncescale`: factor on bounced light, 0 to 100.
    pub scale: f32,
    /// `bouncecolorscale`: share of the texture's colour in its reflectance, 0 to 1; the rest is
    /// grey 127 / 255. `None` is what the settings of the scene say.
    pub colour_share: Option<f32>,
    /// `bouncestyled`: light of styles other than 0 bounces too.
    pub styled: bool,
    /// `tex_saturation_boost`: how far the mean colours of textures are pushed away from grey, 0 to 1.
    pub saturation: f32,
}

impl Default for BounceSettings {
    fn default() -> Self {
        Self { most: None, scale: 1.0, colour_share: None, styled: true, saturation: 0.0 }
    }
}

impl BounceSettings {
    pub(crate) fn read(world: &Entity, set: &mut SetNumber<'_>) -> Self {
        let mut s = Self::default();
        set(&["bouncescale"], 0.0, 100.0, &mut s.scale);
        set(&["tex_saturation_boost"], 0.0, 1.0, &mut s.saturation);
        // NaN stands for keys that are not there or no numbers.
        let mut number = |name: &str, most: f32| {
            let mut value = f32::NAN;
            set(&[name], 0.0, most, &mut value);
            (!value.is_nan()).then_some(value)
        };
        s.most = number("bounce", f32::MAX).map(|n| n as u32);
        s.colour_share = number("bouncecolorscale", 1.0);
        s.styled = world.setting("bouncestyled").is_none_or(keys::boolean);
        // Light that is not even direct does not bounce.
        if world.setting("nolighting").is_some_and(keys::boolean) {
            s.most = Some(0);
        }
        s
    }
}
