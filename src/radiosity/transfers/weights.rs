//! Form factors as they are kept: in single precision, or in two bytes each.

/// How exactly form factors are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Precision {
    /// In two bytes, each within 2^-11 of itself; the sum of a row stays. For factors below 0.25.
    Short,
    /// In four.
    #[default]
    Single,
}

/// Many form factors.
pub(super) enum Weights {
    Single(Vec<f32>),
    Short(Vec<Short>),
}

/// A form factor below 2 in two bytes: 5 bits of exponent, 11 of mantissa, in the places that they have in
/// single precision, so that shifting them there gives 2^-96 times the factor. Below 2^-30 it
/// gets less exact, and 0 below 2^-41.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Short(pub u16);

/// A form factor to be multiplied by light.
pub(super) trait Weight: Copy {
    /// What sums of products are still to be multiplied by: a power of two.
    const SCALE: f64;
    /// The factor but for this.
    fn unscaled(self) -> f64;
}

impl Weight for f32 {
    const SCALE: f64 = 1.0;
    #[inline]
    fn unscaled(self) -> f64 {
        f64::from(self)
    }
}

impl Weight for Short {
    const SCALE: f64 = (1_u128 << 96) as f64;
    #[inline]
    fn unscaled(self) -> f64 {
        f64::from(f32::from_bits(u32::from(self.0) << 12))
    }
}

impl Short {
    /// The largest that is not above `f`.
    fn below(f: f32) -> Self {
        const UNSCALE: f32 = (1.0 / Short::SCALE) as f32;
        let bits = (f.max(0.0) * UNSCALE).to_bits() >> 12;
        Self(bits.min(u16::MAX.into()) as u16)
    }

    fn value(self) -> f32 {
        (self.unscaled() * Self::SCALE) as f32
    }
}

/// From this on two bytes are too few: what they are off by can be more than all others of the row can
/// make up for, 1e-4 where one patch fills the view.
const LARGE: f32 = 0.25;

impl Precision {
    /// The same, or what such factors need.
    pub(super) fn fit_for(self, mut factors: impl Iterator<Item = f32>) -> Self {
        if factors.any(|f| f >= LARGE) { Self::Single } else { self }
    }

    /// Bytes of a form factor.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Single => size_of::<f32>(),
            Self::Short => size_of::<Short>(),
        }
    }

    /// Rounds the factors of a row to what can be kept. Which way each is rounded makes up for those
    /// before it.
    pub(super) fn round<'a>(self, row: impl Iterator<Item = &'a mut f32>) {
        if self == Self::Single {
            return;
        }
        let mut missing = 0.0;
        for factor in row {
            let wanted = f64::from(*factor) + missing;
            let below = Short::below(*factor);
            let [below, above] = [below, Short(below.0.saturating_add(1))].map(Short::value);
            let up = f64::from(above) - wanted < wanted - f64::from(below);
            *factor = if up { above } else { below };
            missing = wanted - f64::from(*factor);
        }
    }
}

impl Weights {
    pub(super) fn new(precision: Precision) -> Self {
        match precision {
            Precision::Single => Self::Single(Vec::new()),
            Precision::Short => Self::Short(Vec::new()),
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Single(weights) => weights.len(),
            Self::Short(weights) => weights.len(),
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Single(weights) => size_of_val(&weights[..]),
            Self::Short(weights) => size_of_val(&weights[..]),
        }
    }

    /// Factors in single precision.
    pub(super) fn range(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = f32> + '_ {
        let (single, short) = match self {
            Self::Single(weights) => (&weights[range], &[][..]),
            Self::Short(weights) => (&[][..], &weights[range]),
        };
        single.iter().copied().chain(short.iter().map(|s| s.value()))
    }

    /// Appends factors that [`Precision::round`] has rounded.
    pub(super) fn extend(&mut self, factors: impl Iterator<Item = f32>) {
        match self {
            Self::Single(weights) => weights.extend(factors),
            Self::Short(weights) => weights.extend(factors.map(Short::below)),
        }
    }

    /// Replaces one.
    pub(super) fn set(&mut self, at: usize, factor: f32) {
        match self {
            Self::Single(weights) => weights[at] = factor,
            Self::Short(weights) => weights[at] = Short::below(factor),
        }
    }

    pub(super) fn shrink_to_fit(&mut self) {
        match self {
            Self::Single(weights) => weights.shrink_to_fit(),
            Self::Short(weights) => weights.shrink_to_fit(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn short(f: f32) -> f32 {
        let mut row = [f];
        Precision::Short.round(row.iter_mut());
        row[0]
    }

    #[test]
    fn two_bytes_hold_any_form_factor_and_what_they_hold_stays() {
        for k in 0..=u16::MAX {
            assert_eq!(Short::below(Short(k).value()), Short(k));
        }
        for f in [1.0, 0.25, 0.0, 3.0 / 4096.0, 2.0_f32.powi(-30)] {
            assert_eq!(short(f), f);
        }
        let mut f = 1.999_f32;
        while f > 2.0_f32.powi(-30) {
            assert!((short(f) / f - 1.0).abs() <= 2.0_f32.powi(-12), "{f}");
            f *= 0.998_37;
        }
        assert!(short(1e-12) < 2e-12);
        for f in [-1.0, f32::NAN] {
            assert_eq!(short(f), 0.0);
        }
        assert!(short(f32::INFINITY) < 2.0);
    }

    #[test]
    fn sums_of_rows_stay_where_one_patch_fills_most_of_the_view() {
        let mut off = 0.0_f64;
        for k in 0..1000 {
            let most = 0.02 + 0.96 * k as f32 / 1000.0;
            let mut row = vec![(1.0 - most) / 64.0; 65];
            row[64] = most;
            let sum = |row: &[f32]| row.iter().map(|&f| f64::from(f)).sum::<f64>();
            let before = sum(&row);
            Precision::Short.fit_for(row.iter().copied()).round(row.iter_mut());
            off = off.max((sum(&row) - before).abs());
        }
        assert!(off < 4e-5, "{off}");
    }

    #[test]
    fn sums_of_rows_stay_and_no_factor_moves_far() {
        let row: Vec<f32> = (0..500).map(|k| (k as f32 * 1.7).sin().abs().powi(9) * 4e-3).collect();
        let mut rounded = row.clone();
        Precision::Short.round(rounded.iter_mut());
        let sum = |row: &[f32]| row.iter().map(|&f| f64::from(f)).sum::<f64>();
        assert!((sum(&row) - sum(&rounded)).abs() < 2e-6 * sum(&row));
        for (f, r) in row.iter().zip(&rounded) {
            assert!((f - r).abs() <= f * 2.0_f32.powi(-11) + 2.0_f32.powi(-41));
        }
        let mut same = row.clone();
        Precision::Single.round(same.iter_mut());
        assert_eq!(same, row);
    }
}
