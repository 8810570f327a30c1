//! The phase of a block whose yield surface has moved: the trial stress reckoned from the back stress.
//! Never here: the law by which the yield surface moves.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use super::block::Workspace;
use crate::kernel::lanes::LANES;
use crate::kernel::real::Real;
use crate::kernel::rotation::rotated;

impl<T: Real> Workspace<T> {
    /// Turns the back stress with the material, and reckons the trial stress from it.
    #[inline(always)]
    pub(super) fn shift(&mut self) {
        for l in 0..LANES {
            let back = rotated([0, 1, 2, 3].map(|i| self.back[i][l]), self.spin[l]);
            for i in 0..4 {
                self.back[i][l] = back[i];
                self.deviator[i][l] = self.deviator[i][l] - back[i];
            }
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| self.deviator[i][l] * self.deviator[i][l]);
            self.trial[l] = (T::of(1.5) * (a + b + c) + T::of(3.0) * d).root();
        }
    }

    /// Plastic work against the back stress of a lane: 3/2 dp times the back stress along the relative stress.
    #[inline(always)]
    pub(super) fn work_against_back(&self, l: usize) -> T {
        let part = |i: usize| self.back[i][l] * self.deviator[i][l];
        let along = (part(0) + part(1)) + (part(2) + T::of(2.0) * part(3));
        if self.flow[l] > T::ZERO {
            T::of(1.5) * self.volume[l] * self.flow[l] * along / self.trial[l]
        } else {
            T::ZERO
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LANES, Workspace};

    /// The tangent of half the angle is half the spin, so a spin of 2 is a quarter turn: rr and zz change places, and the
    /// shear its sign.
    #[test]
    fn the_back_stress_turns_with_the_material() {
        let mut scratch: Workspace = Workspace::default();
        scratch.spin.fill(2.0);
        for (i, value) in [3.0, -2.0, -1.0, 0.5].into_iter().enumerate() {
            scratch.back[i] = [value; LANES];
        }
        scratch.shift();
        let expected = [-2.0, 3.0, -1.0, -0.5];
        for i in 0..4 {
            assert!((scratch.back[i][3] - expected[i]).abs() < 1e-15, "{:?}", scratch.back);
            assert_eq!(scratch.deviator[i], scratch.back[i].map(|b| -b));
        }
        // Von Mises stress of (3, -2, -1; 0.5).
        let mises = (0.5f64 * (25.0 + 1.0 + 16.0) + 0.75).sqrt();
        assert!((scratch.trial[0] - mises).abs() < 1e-14);
    }
}
