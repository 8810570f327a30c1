//! Random numbers of tests.

/// Reproducible random numbers (splitmix64).
pub struct RandomSequence(pub u64);

impl RandomSequence {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.next()
    }

    pub fn count(&mut self, from: usize, to: usize) -> usize {
        (from as f64 + (to + 1 - from) as f64 * self.next()) as usize
    }

    pub fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(all.len() as f64 * self.next()) as usize]
    }
}
