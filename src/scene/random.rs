//! Random numbers that are the same in every run.

/// What spreads jittered lights: the additive feedback generator that C libraries commonly use for an
/// unseeded `rand()`, x(n) = x(n-3) + x(n-31) modulo 2^32, of which the upper 31 bits are used.
pub(crate) struct Random {
    state: [u32; 31],
    at: usize,
}

impl Random {
    /// The generator with seed 1.
    pub fn new() -> Self {
        let mut state = [1_u32; 31];
        for i in 1..31 {
            state[i] = (u64::from(state[i - 1]) * 16807 % 2_147_483_647) as u32;
        }
        let mut random = Self { state, at: 3 };
        // Numbers 31 to 33 repeat the first three, so the ring starts at the fourth.
        // The first 310 numbers are thrown away: the seed shows through in them.
        for _ in 0..310 {
            random.step();
        }
        random
    }

    fn step(&mut self) -> u32 {
        // x(n-31) is the slot to be overwritten, x(n-3) lies 28 slots ahead of it in the ring.
        let value = self.state[self.at].wrapping_add(self.state[(self.at + 28) % 31]);
        self.state[self.at] = value;
        self.at = (self.at + 1) % 31;
        value >> 1
    }

    /// Next number in 0 to 1.
    pub fn next(&mut self) -> f32 {
        self.step() as f32 / 2_147_483_647.0
    }
}

/// Numbers that depend on the seed alone: SplitMix64 (G. Steele, D. Lea and C. Flood, "Fast splittable
/// pseudorandom number generators", 2014).
pub(crate) struct SplitMix(pub u64);

impl SplitMix {
    /// Next number, from 0 to below 1.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_well_known_one() {
        let mut random = Random::new();
        let first: Vec<u32> = (0..4).map(|_| random.step()).collect();
        assert_eq!(first, [1_804_289_383, 846_930_886, 1_681_692_777, 1_714_636_915]);
    }
}
