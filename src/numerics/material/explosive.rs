//! High explosives with programmed burn and JWL detonation products (Jones, Wilkins and Lee; ABAQUS Analysis User's
//! Guide, "Equation of state", JWL high explosive equation of state). Reactions driven by pressure are not modelled.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the other laws.

use super::eos::{EosLine, LinearEos, advance, specific_volume};
use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::kernel::transcendental::exp_of;
use crate::material::BlockStart;
use crate::material::carried::carried_state;
use crate::material::volumetric::PressureUpdate;
use crate::state::archive::Persist;

/// Width of the burn front in elements (ABAQUS Analysis User's Guide, "Equation of state", JWL).
const WIDTH: f64 = 2.5;

/// JWL pressure of the products: p = A (1 - omega rho/(R1 rho0)) exp(-R1 rho0/rho) + B (1 - omega rho/(R2 rho0))
/// exp(-R2 rho0/rho) + omega rho e.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JwlProducts {
    pub density: f64,
    /// Constants A and B, stress.
    pub pressures: [f64; 2],
    /// R1 and R2.
    pub exponents: [f64; 2],
    pub omega: f64,
}

impl LinearEos for JwlProducts {
    #[inline(always)]
    fn curve(&self, density: f64, specific_volume: f64) -> EosLine {
        // Density and volume relative to the reference state.
        let (compression, volume) = (density * (1.0 / self.density), self.density * specific_volume);
        // Terms of the cold pressure, and their derivatives with respect to the volume.
        let term = |i: usize| {
            let (r, share) = (self.exponents[i], self.omega / self.exponents[i] * compression);
            let decayed = self.pressures[i] * exp_of(-r * volume);
            [decayed * (1.0 - share), decayed * (share * compression - r * (1.0 - share))]
        };
        let ([first, first_slope], [second, second_slope]) = (term(0), term(1));
        EosLine {
            cold: first + second,
            per_energy: self.omega * density,
            cold_slope: -(first_slope + second_slope) * volume * specific_volume,
            energy_slope: self.omega,
        }
    }

    fn floor(&self) -> f64 {
        0.0
    }
}

/// Point at which the detonation starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetonationPoint {
    /// Position `[r, z]`.
    pub place: [f64; 2],
    /// Total time of ignition.
    pub time: f64,
}

/// An explosive with a constant detonation speed.
#[derive(Clone, Debug)]
pub struct HighExplosive {
    pub products: JwlProducts,
    /// Speed of the detonation front, length per time.
    pub speed: f64,
    /// Initial internal energy per mass.
    pub energy: f64,
    /// Bulk modulus of the unburnt explosive.
    pub unburnt: f64,
    /// Points at which the detonation starts; the earliest arrival of a front ignites an element.
    pub points: Vec<DetonationPoint>,
}

/// Burn fraction, arrival time of the detonation front and burn rate of the elements of a block.
#[derive(Clone, Debug, Persist)]
pub struct BurnState {
    /// Burn fraction, 0 to 1.
    burnt: Lanes,
    /// Total time at which the detonation front arrives, and burn rate (1/time) from then on.
    lit: Lanes,
    pace: Lanes,
}

impl BurnState {
    /// Updates the burn fractions for a total time.
    pub(super) fn advance(&mut self, now: f64) {
        for l in 0..LANES {
            let share = (now - self.lit[l]) * self.pace[l];
            let share = if share < 1.0 { share } else { 1.0 };
            self.burnt[l] = if share > 0.0 { share } else { 0.0 };
        }
    }

    /// Returns the total time at which the detonation front arrives at a lane.
    pub(super) fn arrival(&self, lane: usize) -> f64 {
        self.lit[lane]
    }

    /// Returns the burn fraction of a lane.
    pub(super) fn share(&self, lane: usize) -> f64 {
        self.burnt[lane]
    }
}

impl HighExplosive {
    /// Computes arrival times and burn rates; each element burns from the point whose front arrives first.
    pub(super) fn start_burn(&self, start: &BlockStart) -> BurnState {
        let (mut lit, mut pace) = ([f64::INFINITY; LANES], [0.0; LANES]);
        for l in 0..start.count {
            let [r, z] = [0, 1].inline_map(|i: usize| start.centre[i][l]);
            let arrival =
                |point: &DetonationPoint| point.time + libm::hypot(r - point.place[0], z - point.place[1]) / self.speed;
            lit[l] = self.points.iter().map(arrival).fold(f64::INFINITY, f64::min);
            pace[l] = self.speed / (WIDTH * start.area[l].sqrt());
        }
        BurnState { burnt: [0.0; LANES], lit, pace }
    }

    /// Returns the energy per mass that unburnt explosive releases on the way to zero pressure.
    pub(super) fn unburnt_energy(&self, specific_volume: f64) -> f64 {
        let ratio = self.products.density * specific_volume;
        self.unburnt / self.products.density * ((ratio - 1.0) - libm::log(ratio))
    }

    /// Updates pressures and energies of a block. The burn fraction has the pressure of the products, the rest that of
    /// the unburnt explosive. Until an element has burnt completely, its bulk modulus is at least rho D², so that the
    /// time increment resolves the detonation.
    #[inline(always)]
    pub(super) fn advance_block(&self, burn: &BurnState, energy: &mut Lanes, update: &mut PressureUpdate) {
        let strong = self.products.density * self.speed * self.speed;
        for l in 0..LANES {
            let density = update.mass[l] / update.volume[l];
            let EosLine { cold, per_energy, cold_slope, energy_slope } =
                self.products.curve(density, specific_volume(update, l));
            let burnt = burn.burnt[l];
            let rest = (1.0 - burnt) * self.unburnt / self.products.density;
            let curve = EosLine {
                cold: burnt * cold + rest * (density - self.products.density),
                per_energy: burnt * per_energy,
                cold_slope: burnt * cold_slope + rest,
                energy_slope: burnt * energy_slope,
            };
            let floor = if burnt < 1.0 { strong } else { 1e-12 * strong };
            energy[l] = advance(update, l, curve, energy[l], [0.0, floor]);
        }
    }
}

carried_state!(BurnState { burnt, lit, pace });

#[cfg(test)]
mod tests {
    use super::{EosLine, HighExplosive, JwlProducts, LinearEos};

    fn at(density: f64) -> EosLine {
        TNT.curve(density, 1.0 / density)
    }

    const TNT: JwlProducts =
        JwlProducts { density: 1630.0, pressures: [3.712e11, 3.231e9], exponents: [4.15, 0.95], omega: 0.3 };

    #[test]
    fn slopes_are_derivatives() {
        for density in [300.0, 1630.0, 2200.0] {
            let step = 1e-3;
            let slope = (at(density + step).cold - at(density - step).cold) / (2.0 * step);
            assert!((slope / at(density).cold_slope - 1.0).abs() < 1e-6, "{density}: {slope}");
        }
    }

    /// The Hugoniot of the products touches the Rayleigh line of a detonation at 6930 m/s in the Chapman-Jouguet state,
    /// for which the handbook gives 21.0 GPa with these constants (Dobratz and Crawford 1985, UCRL-52997).
    #[test]
    fn detonation_matches_the_chapman_jouguet_state() {
        let hugoniot = |volume: f64| {
            let curve = at(TNT.density / volume);
            // p = a + b (e0 + p (v0 - v)/2)
            let (e0, half) = (4.29e6, 0.5 * (1.0 - volume) / TNT.density);
            (curve.cold + curve.per_energy * e0) / (1.0 - curve.per_energy * half)
        };
        let speed2 = |volume: f64| hugoniot(volume) / (TNT.density * (1.0 - volume));
        let (best, speed) = (600..950)
            .map(|i| f64::from(i) * 1e-3)
            .map(|v| (v, speed2(v).sqrt()))
            .fold((0.0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
        println!("detonation {speed:.1} m/s, {:.3e} Pa at {best}", hugoniot(best));
        assert!((speed / 6930.0 - 1.0).abs() < 5e-3 && (hugoniot(best) / 21.0e9 - 1.0).abs() < 1e-2);
    }

    /// The energy of unburnt explosive is the work of its pressure K (rho/rho0 - 1), by quadrature.
    #[test]
    fn unburnt_explosive_releases_the_work_of_its_pressure() {
        let law = HighExplosive { products: TNT, speed: 6930.0, energy: 4.29e6, unburnt: 1e10, points: Vec::new() };
        let reference = 1.0 / TNT.density;
        for ratio in [0.9, 1.0, 1.05] {
            let (start, n) = (ratio * reference, 1000);
            let part = (reference - start) / f64::from(n);
            let volumes = (0..n).map(|i| start + part * (f64::from(i) + 0.5));
            let work: f64 = volumes.map(|v| 1e10 * (reference / v - 1.0) * part).sum();
            assert!((law.unburnt_energy(start) - work).abs() < 1e-5 * work.abs() + 1e-9, "{ratio}");
        }
    }
}
