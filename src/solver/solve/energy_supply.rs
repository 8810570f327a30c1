//! Energy put in: the largest energy so far that the model had at the start, could release, or has received. No energy
//! of the model can exceed it, whatever the terms of the energy balance are.

use crate::material::available::AvailableEnergy;
use crate::state::archive::Persist;
use crate::state::energies::EnergyTotals;

/// Number of intervals of time in which the fronts of detonations are sorted.
const INTERVALS: usize = 256;

/// Energies that the model can release, and the energy put in.
#[derive(Clone, Debug, Default, Persist)]
pub struct EnergySupply {
    /// Total times and the energies that are available from then on, in ascending order.
    available: Vec<[f64; 2]>,
    /// Largest available energy per mass: that of the mass which enters through Eulerian boundaries.
    per_mass: f64,
    /// Largest increase of the elastic moduli over temperature and fields, as a fraction.
    stiffening: f64,
    /// Whether viscous heat of elements can do work again: in gases and explosives.
    returns_heat: bool,
    /// Largest strain energy so far, not above the energy put in without that of stiffening.
    strain: f64,
    /// Energy put in without that of stiffening.
    without_stiffening: f64,
    /// Energy that elements can have released so far.
    released: f64,
    /// Energy put in.
    put_in: f64,
}

impl EnergySupply {
    /// Begins an analysis with the energies of its elements and their masses.
    pub fn begin(
        &mut self,
        energies: impl IntoIterator<Item = (AvailableEnergy, f64)>,
        stiffening: f64,
        returns_heat: bool,
    ) {
        let (mut sum, mut per_mass, mut fronts) = (0.0, 0.0_f64, Vec::new());
        for (available, mass) in energies {
            per_mass = per_mass.max(available.energy / mass);
            match available.from {
                f64::NEG_INFINITY => sum += available.energy,
                from if from.is_finite() => fronts.push(available),
                _ => (),
            }
        }
        let times = fronts.iter().map(|front| front.from);
        let [first, last] =
            times.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], time| [low.min(time), high.max(time)]);
        let width = (last - first) / INTERVALS as f64;
        let mut sums = [0.0; INTERVALS + 1];
        for front in &fronts {
            let interval = if width > 0.0 { ((front.from - first) / width) as usize } else { 0 };
            sums[interval.min(INTERVALS)] += front.energy;
        }
        self.available = vec![[f64::NEG_INFINITY, sum]];
        for (i, energy) in sums.into_iter().enumerate().filter(|interval| interval.1 > 0.0) {
            sum += energy;
            self.available.push([first + i as f64 * width, sum]);
        }
        (self.per_mass, self.stiffening, self.returns_heat) = (per_mass, stiffening, returns_heat);
    }

    /// Returns the energy put in.
    #[inline(always)]
    pub fn put_in(&self) -> f64 {
        self.put_in
    }

    /// Returns the energy that elements can have released: their internal and strain energy may be below zero by as much.
    #[inline(always)]
    pub fn released(&self) -> f64 {
        self.released
    }

    /// Returns the part of a viscous heat that can do work again.
    #[inline(always)]
    pub fn returned(&self, viscous: f64) -> f64 {
        if self.returns_heat { viscous } else { 0.0 }
    }

    /// Adds what bodies and loads have put in: initial energy and external work.
    #[inline(always)]
    pub fn take(&mut self, given: f64) {
        if given > self.put_in {
            self.put_in = given;
        }
    }

    /// Adds what bodies and loads have put in, and the energy that deformable bodies can release at this time. Equation
    /// (14.5).
    pub fn take_with_elements(&mut self, given: f64, energies: &EnergyTotals, total_time: f64) {
        let passed = self.available.partition_point(|entry| entry[0] <= total_time);
        let available = self.available[..passed].last().map_or(0.0, |entry| entry[1]);
        let entered = self.per_mass * energies.flow.mass_in;
        let released = available + entered + energies.supplied;
        self.without_stiffening = self.without_stiffening.max(given + released);
        self.strain = self.strain.max((energies.internal - energies.plastic).min(self.without_stiffening));
        let released = released + self.stiffening * self.strain;
        self.released = self.released.max(released);
        self.take(given + released + energies.initial_overlap);
    }
}

#[cfg(test)]
mod tests {
    use super::{AvailableEnergy, EnergySupply};
    use crate::state::energies::EnergyTotals;

    /// Loads put in 8 and take 5 back: the energy put in stays 8, as no energy came back from elsewhere.
    #[test]
    fn work_that_flows_out_is_not_taken_off() {
        let mut supply = EnergySupply::default();
        for work in [3.0, 8.0, 3.0] {
            supply.take_with_elements(work, &EnergyTotals::default(), 0.0);
        }
        assert_eq!(supply.put_in(), 8.0);
    }

    /// An explosive releases the energy of the elements that the front has reached, an initial stress its own at once.
    #[test]
    fn explosives_release_energy_as_they_burn() {
        let mut supply = EnergySupply::default();
        let burning = |i: u32| (AvailableEnergy { energy: 1.0, from: 1e-6 * f64::from(i) }, 1.0);
        let mut list: Vec<_> = (0..1000).map(burning).collect();
        let unburnt = AvailableEnergy { energy: 5.0, from: f64::INFINITY };
        list.extend([(AvailableEnergy::initial(20.0), 1.0), (unburnt, 1.0)]);
        supply.begin(list, 0.0, false);
        for (time, energy) in [(-1.0, 20.0), (0.25e-3, 270.0), (0.5e-3, 520.0), (1.0, 1020.0)] {
            supply.take_with_elements(0.0, &EnergyTotals::default(), time);
            assert!((supply.put_in() - energy).abs() <= (1000.0_f64 / 256.0).ceil(), "{time}: {}", supply.put_in());
        }
        assert_eq!(supply.released(), 1020.0);
    }

    /// Mass that enters brings its own energy, and temperature what its expansion does.
    #[test]
    fn inflow_and_expansion_put_energy_in() {
        let mut supply = EnergySupply::default();
        supply.begin([(AvailableEnergy::initial(1.0), 0.1)], 0.0, false);
        let mut energies = EnergyTotals { supplied: 4.0, ..EnergyTotals::default() };
        energies.flow.mass_in = 0.2;
        supply.take_with_elements(3.0, &energies, 0.0);
        assert_eq!([supply.released(), supply.put_in()], [7.0, 10.0]);
    }

    /// Moduli that increase threefold can release twice the strain energy, of which no more counts than was put in.
    #[test]
    fn stiffening_releases_strain_energy() {
        let mut supply = EnergySupply::default();
        supply.begin([], 2.0, false);
        let energies = |internal| EnergyTotals { internal, ..EnergyTotals::default() };
        supply.take(6.0);
        supply.take_with_elements(6.0, &energies(5.0), 0.0);
        assert_eq!(supply.released(), 10.0);
        supply.take_with_elements(6.0, &energies(1e6), 0.0);
        assert_eq!([supply.released(), supply.put_in()], [12.0, 18.0]);
    }
}
