//! How bright light styles are in a still picture.

/// Brightness of a style letter step: `a` is 0, `m` twelve steps and `z` twenty-five.
const STEP: u32 = 22;
/// Mean step of the animated styles 0 to 11 of the engine's viewer program, in whole letters as an
/// engine with flat light styles shows them. Style 0 is the steady `m`.
const MEAN_STEPS: [u32; 12] = [12, 12, 12, 5, 6, 15, 12, 6, 4, 6, 8, 5];
/// The step of a light that is on.
const ON: u32 = 12;
/// The style that engines keep dark.
const TEST_STYLE: u8 = 63;

/// Brightness of a style in 1/256 of its lightmap: 264 for `m`. Animated styles have their mean,
/// switchable ones are on.
pub(super) fn style_scale(style: u8) -> u32 {
    let on = if style == TEST_STYLE { 0 } else { ON };
    STEP * MEAN_STEPS.get(usize::from(style)).copied().unwrap_or(on)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_and_switchable_lights_have_264() {
        assert_eq!([0, 1, 32, 62, 200].map(style_scale), [264; 5]);
        assert_eq!([4, 63].map(style_scale), [132, 0]);
    }
}
