//! Work of isentropes: the largest work that a material can do from a state, without work or heat from outside.

use super::eos::{EosLine, IdealGas, LinearEos};

/// Increment of the logarithm of the volume along an isentrope, and the largest number of increments.
const INCREMENT: f64 = 0.01;
const MOST: usize = 4000;

/// Number of bisections for the end of limited tension.
const BISECTIONS: usize = 40;

/// Specific volume and specific energy at which the tension falls below a limit on the way from a state that exceeds it,
/// at a constant tension equal to the limit; the state itself if it does not exceed the limit.
pub(super) fn end_of_limited_tension(
    line: impl Fn(f64) -> EosLine,
    ambient: f64,
    limit: f64,
    [specific_volume, specific_energy]: [f64; 2],
) -> [f64; 2] {
    // The limited tension does this work per specific volume on the way.
    let energy = |volume: f64| specific_energy + (limit - ambient) * (volume - specific_volume);
    let exceeds = |volume: f64| {
        let EosLine { cold, per_energy, .. } = line(volume);
        -(cold + per_energy * energy(volume)) > limit
    };
    if !exceeds(specific_volume) {
        return [specific_volume, specific_energy];
    }
    let (mut low, mut high) = (specific_volume, specific_volume);
    for _ in 0..MOST {
        low = high * libm::exp(-INCREMENT);
        if !exceeds(low) {
            break;
        }
        high = low;
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        *(if exceeds(middle) { &mut high } else { &mut low }) = middle;
    }
    [high, energy(high)]
}

/// Returns the work per mass of the isentrope from a specific volume and energy to the volume without pressure. `line`
/// gives the pressure line at a specific volume.
pub(super) fn isentropic_work(
    line: impl Fn(f64) -> EosLine,
    ambient: f64,
    specific_volume: f64,
    specific_energy: f64,
) -> f64 {
    let pressure = |volume: f64, energy: f64| {
        let EosLine { cold, per_energy, .. } = line(volume);
        cold + per_energy * energy
    };
    let (mut volume, mut energy, mut work) = (specific_volume, specific_energy, 0.0);
    let start = pressure(volume, energy);
    // A material in tension does work as it contracts.
    let half = if start > 0.0 { 0.5 * INCREMENT } else { -0.5 * INCREMENT };
    for _ in 0..MOST {
        let first = pressure(volume, energy);
        let (middle, end) = (volume * libm::exp(half), volume * libm::exp(2.0 * half));
        let mean = pressure(middle, energy - (first + ambient) * (middle - volume));
        // NaN ends the isentrope, too.
        let goes_on = mean * start > 0.0;
        if !goes_on {
            // Up to the volume without pressure the pressure is linear.
            let left = first / (first - mean) * (middle - volume);
            return work + if left.is_finite() { 0.5 * first * left } else { 0.0 };
        }
        work += mean * (end - volume);
        energy -= (mean + ambient) * (end - volume);
        volume = end;
    }
    work
}

impl IdealGas {
    /// Returns the largest work per mass against the ambient pressure. It is that of the isentrope to the ambient
    /// pressure, and the whole specific energy without one.
    pub(super) fn available_energy(&self, specific_volume: f64, specific_energy: f64) -> f64 {
        let ratio = self.gas_constant / self.specific_heat;
        let pressure = ratio * specific_energy / specific_volume;
        if self.ambient() <= 0.0 || pressure <= 0.0 {
            return specific_energy.max(0.0);
        }
        let volume = specific_volume * libm::pow(pressure / self.ambient, 1.0 / (1.0 + ratio));
        let energy = self.ambient * volume / ratio;
        (specific_energy - energy + self.ambient * (specific_volume - volume)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{end_of_limited_tension, isentropic_work};
    use crate::material::eos::{IdealGas, LinearEos, UsUp};

    const AIR: IdealGas = IdealGas { gas_constant: 287.0, specific_heat: 717.5, ambient: 1e5, absolute_zero: 0.0 };

    /// A gas in equilibrium with the ambient pressure does no work; one with twice the pressure or half the pressure does that
    /// of the isentrope p v^1.4 by quadrature.
    #[test]
    fn gas_does_the_work_of_its_isentrope() {
        for pressure in [1e5, 2e5, 0.5e5] {
            let (volume, energy) = (0.8, pressure * 0.8 / 0.4);
            let end = volume * libm::pow(pressure / 1e5, 1.0 / 1.4);
            let quadrature: f64 = (0..10_000)
                .map(|i| volume + (end - volume) * (f64::from(i) + 0.5) / 1e4)
                .map(|v| (pressure * libm::pow(volume / v, 1.4) - 1e5) * (end - volume) / 1e4)
                .sum();
            let closed = AIR.available_energy(volume, energy);
            let integrated = isentropic_work(|v| AIR.curve(1.0 / v, v), 1e5, volume, energy);
            assert!((closed - quadrature).abs() < 1e-6 * 1e5 * volume, "{closed} {quadrature}");
            assert!((integrated - quadrature).abs() < 1e-4 * 1e5 * volume, "{integrated} {quadrature}");
        }
    }

    /// A hot metal at its reference density releases p²/(2 K rho0) for small pressures, in tension as well.
    #[test]
    fn metal_releases_its_elastic_energy() {
        let law = UsUp { density: 8930.0, c0: 3940.0, s: 1.489, gamma0: 2.02 };
        for energy in [1e3, -1e3] {
            let pressure = law.gamma0 * law.density * energy;
            let elastic = 0.5 * pressure * pressure / (law.density * law.c0 * law.c0 * law.density);
            let work = isentropic_work(|v| law.curve(1.0 / v, v), 0.0, 1.0 / law.density, energy);
            assert!((work / elastic - 1.0).abs() < 0.01, "{work} {elastic}");
        }
        assert_eq!(isentropic_work(|v| law.curve(1.0 / v, v), 0.0, 1.0 / law.density, 0.0), 0.0);
    }

    /// The tension is the limit where it ends, and the energy falls by its work. States below the limit do not change.
    #[test]
    fn limited_tension_ends_at_its_limit() {
        let law = UsUp { density: 8930.0, c0: 3940.0, s: 1.489, gamma0: 2.02 };
        let line = |v: f64| law.curve(1.0 / v, v);
        let (start, limit) = ([1.3 / law.density, 2e4], 2e9);
        let [volume, energy] = end_of_limited_tension(line, 0.0, limit, start);
        let (curve, reference) = (line(volume), 1.0 / law.density);
        let tension = -(curve.cold + curve.per_energy * energy);
        assert!((tension / limit - 1.0).abs() < 1e-9 && volume > reference, "{tension} {volume}");
        let lost = limit * (start[0] - volume);
        assert!((start[1] - energy - lost).abs() < 1e-9 * lost, "{energy}");
        let below = [1.001 * reference, 0.0];
        assert_eq!(end_of_limited_tension(line, 0.0, limit, below), below);
    }
}
