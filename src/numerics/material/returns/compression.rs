//! Pressure as a polynomial of the compression, and its recoverable energy.

use crate::kernel::stress::mises;

/// Pressure K1 mu + K2 mu² + K3 mu³ + shift of the compression mu = V0/V - 1, without the higher terms in expansion, and not below a
/// limit in tension. The shift is a bulking pressure, or minus K1 times the plastic compaction. Equation (20.21).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompressionLaw {
    /// K1, K2, K3, stress.
    pub moduli: [f64; 3],
    /// Pressure at mu = 0, stress.
    pub shift: f64,
    /// Smallest pressure, not positive, stress.
    pub tension: f64,
}

impl CompressionLaw {
    /// Returns the pressure at a compression. Equation (20.21).
    pub fn pressure(&self, compression: f64) -> f64 {
        self.unlimited(compression).max(self.tension)
    }

    fn unlimited(&self, compression: f64) -> f64 {
        let [k1, k2, k3] = self.moduli;
        let higher = if compression > 0.0 { compression * compression * (k2 + k3 * compression) } else { 0.0 };
        k1 * compression + higher + self.shift
    }

    /// Returns the bulk modulus in the current configuration, (1 + mu) dp/dmu without the limit in tension.
    pub fn bulk_modulus(&self, compression: f64) -> f64 {
        let [k1, k2, k3] = self.moduli;
        let higher = if compression > 0.0 { compression * (2.0 * k2 + 3.0 * k3 * compression) } else { 0.0 };
        (1.0 + compression) * (k1 + higher)
    }

    /// Returns the work that the pressure does until it vanishes, per initial volume, from a compression and the logarithm of
    /// 1 plus it. Equation (20.22).
    pub fn recoverable_energy(&self, compression: f64, logarithm: f64) -> f64 {
        // With higher terms the pressure vanishes in expansion, or at mu = 0 without a shift.
        let [k1, ..] = self.moduli;
        let unloaded = if self.shift == 0.0 { 0.0 } else { self.antiderivative_from_zero(-self.shift / k1) };
        let at_limit = (self.tension - self.shift) / k1;
        if compression >= at_limit {
            return self.antiderivative(compression, logarithm) - unloaded;
        }
        let expanded = compression / (1.0 + compression) - at_limit / (1.0 + at_limit);
        self.antiderivative_from_zero(at_limit) - unloaded + self.tension * expanded
    }

    fn antiderivative_from_zero(&self, compression: f64) -> f64 {
        self.antiderivative(compression, libm::log1p(compression))
    }

    /// Returns the integral of p/(1 + mu)² from 0.
    fn antiderivative(&self, compression: f64, logarithm: f64) -> f64 {
        let [k1, k2, k3] = self.moduli;
        let volume = compression / (1.0 + compression);
        let linear = k1 * (logarithm - volume) + self.shift * volume;
        if compression < 0.0 || k2 == 0.0 && k3 == 0.0 {
            return linear;
        }
        let square = compression - 2.0 * logarithm + volume;
        let cube = 0.5 * compression * compression - 2.0 * compression + 3.0 * logarithm - volume;
        linear + k2 * square + k3 * cube
    }
}

/// Returns the recoverable energy per current volume of a stress: of its deviator, and of the pressure, whose energy is per
/// initial volume. `dilation` is the logarithm of the volume ratio.
pub fn energy_of_stress_and_pressure(stress: [f64; 4], shear: f64, of_pressure: f64, dilation: f64) -> f64 {
    let mises = mises(stress);
    mises * mises / (6.0 * shear) + of_pressure / libm::exp(dilation)
}

#[cfg(test)]
mod tests {
    use super::CompressionLaw;

    /// The energy is the sum of the pressure times the volume changes, from the pressure-free volume.
    #[test]
    fn energy_is_the_work_of_the_pressure() {
        let law = CompressionLaw { moduli: [10.0, -5.0, 20.0], shift: 0.4, tension: -0.3 };
        let unloaded = -0.04;
        for compression in [0.3, 0.01, -0.05, -0.2] {
            let (start, end) = (1.0 / (1.0 + unloaded), 1.0 / (1.0 + compression));
            let steps = 40_000;
            let width = (end - start) / f64::from(steps);
            let work = |i: i32| -law.pressure(1.0 / (start + (f64::from(i) + 0.5) * width) - 1.0) * width;
            let sum: f64 = (0..steps).map(work).sum();
            let energy = law.recoverable_energy(compression, libm::log1p(compression));
            assert!((energy - sum).abs() < 1e-8 + 1e-5 * energy, "{compression}: {energy} {sum}");
        }
    }

    #[test]
    fn bulk_modulus_is_the_slope_of_the_pressure() {
        let law = CompressionLaw { moduli: [10.0, -5.0, 20.0], shift: 0.4, tension: -0.3 };
        for compression in [-0.01_f64, 0.02, 0.4] {
            let strain = 1e-6;
            let compressed = (1.0 + compression) / (1.0 - strain) - 1.0;
            let slope = (law.pressure(compressed) - law.pressure(compression)) / strain;
            assert!((slope / law.bulk_modulus(compression) - 1.0).abs() < 1e-4, "{slope}");
        }
    }
}
