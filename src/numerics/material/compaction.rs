//! Compaction of porous materials: the P-alpha law of Herrmann (1969, J. Appl. Phys. 40, 2490) in the form of Carroll and Holt
//! (1972, J. Appl. Phys. 43, 759), p = p_solid(alpha rho, e)/alpha, for a solid with a linear Hugoniot.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the other laws.

use super::eos::{EosLine, LinearEos, UsUp, advance, advance_energy, specific_volume};
use super::returns::lane_roots::{LaneStarts, any, lane_roots};
use super::returns::root::{Start, nearby_root};
use crate::kernel::lanes::{LANES, Lanes};
use crate::material::carried::carried_state;
use crate::material::volumetric::PressureUpdate;
use crate::state::archive::Persist;

/// Error of the distension.
const ACCURACY: f64 = 1e-14;

/// Steps of the integration of the elastic distension up to the pressure at which compaction begins.
const STEPS: usize = 200;

/// A porous material. The distension alpha is the density of the solid over that of the porous material.
#[derive(Clone, Debug)]
pub struct PorousCompaction {
    /// Solid without pores.
    solid: UsUp,
    /// Distension at the start, and that at which compaction begins.
    distensions: [f64; 2],
    /// Sound speed of the porous material at the start, length per time.
    speed: f64,
    /// Pressures at which compaction begins and ends, stress.
    pressures: [f64; 2],
}

/// Distensions of the elements of a block.
#[derive(Clone, Debug, Persist)]
pub struct DistensionState {
    /// Smallest distension on the crush curve so far.
    smallest: Lanes,
    current: Lanes,
}

/// Distensions of a point.
#[derive(Clone, Copy, Debug)]
pub struct PointDistension {
    /// Smallest distension on the crush curve so far.
    pub smallest: f64,
    /// Current distension.
    pub current: f64,
}

impl DistensionState {
    /// Returns the current distension of a lane.
    pub(super) fn current(&self, lane: usize) -> f64 {
        self.current[lane]
    }
}

/// Path of the distension over the pressure from a state: the elastic line, then the crush curve.
#[derive(Clone, Copy)]
struct DistensionPath {
    /// Pressure and distension at which the elastic line meets the crush curve.
    meeting: [f64; 2],
    /// Slope of the elastic line.
    slope: f64,
}

impl DistensionPath {
    /// Returns whether the pores are closed.
    #[inline(always)] // Into loops over lanes.
    fn is_closed(self) -> bool {
        (self.slope == 0.0) & (self.meeting[1] <= 1.0)
    }
}

/// State of the pores of a point.
#[derive(Clone, Copy)]
struct PorousPoint {
    pressure: f64,
    distension: f64,
    /// Volume of the solid per mass.
    solid_volume: f64,
    /// Slope of the elastic line, distension over pressure.
    slope: f64,
}

impl PorousPoint {
    /// Returns the work per mass that the pores do on the elastic line until the pressure vanishes.
    #[inline(always)] // Into loops over lanes.
    fn recoverable(self) -> f64 {
        -0.5 * self.slope * self.pressure * self.pressure * self.solid_volume
    }
}

impl PorousCompaction {
    /// Creates the law from the solid, the sound speed and porosity at the start, and the pressures at which compaction begins
    /// and ends. Equation (7.15).
    pub fn new(solid: UsUp, speed: f64, porosity: f64, pressures: [f64; 2]) -> PorousCompaction {
        let start = 1.0 / (1.0 - porosity);
        let mut law = PorousCompaction { solid, distensions: [start; 2], speed, pressures };
        // Runge and Kutta's method of fourth order.
        let width = pressures[0] / STEPS as f64;
        let mut distension = start;
        for _ in 0..STEPS {
            let first = law.elastic_slope(distension);
            let second = law.elastic_slope(distension + 0.5 * width * first);
            let third = law.elastic_slope(distension + 0.5 * width * second);
            let fourth = law.elastic_slope(distension + width * third);
            distension += width / 6.0 * (first + 2.0 * (second + third) + fourth);
        }
        law.distensions[1] = distension;
        law
    }

    /// Returns the density of the porous material at the start.
    pub fn initial_density(&self) -> f64 {
        self.solid.density / self.distensions[0]
    }

    pub(super) fn start(&self) -> DistensionState {
        let PointDistension { smallest, current } = self.start_of_point();
        DistensionState { smallest: [smallest; LANES], current: [current; LANES] }
    }

    /// Returns the distensions of a point at the start.
    pub fn start_of_point(&self) -> PointDistension {
        let [current, smallest] = self.distensions;
        PointDistension { smallest, current }
    }

    /// Returns the bulk modulus at the start, on the chord to the distension at which compaction begins. Equation (7.16).
    pub fn initial_bulk_modulus(&self) -> f64 {
        let start = self.start_of_point();
        let fixed = self.stiffness(1.0 / self.initial_density(), start.current);
        fixed / (1.0 - fixed / start.current * self.path(start.smallest).slope)
    }

    /// Returns the elastic slope d(alpha)/dp at a distension. Equation (7.15).
    #[inline(always)] // Into loops over lanes.
    fn elastic_slope(&self, distension: f64) -> f64 {
        let UsUp { density, c0, .. } = self.solid;
        let ratio = 1.0 + (distension - 1.0) * (self.speed - c0) / (c0 * (self.distensions[0] - 1.0));
        distension * distension / (density * c0 * c0) * (1.0 - 1.0 / (ratio * ratio))
    }

    /// Returns the distension on the crush curve. Equation (7.14).
    #[inline(always)] // Into loops over lanes.
    fn crushed(&self, pressure: f64) -> f64 {
        let [begin, end] = self.pressures;
        let left = (end - pressure) * (1.0 / (end - begin));
        let left = if left > 0.0 { left } else { 0.0 };
        1.0 + (self.distensions[1] - 1.0) * left * left
    }

    /// Returns the path from a smallest distension. Unloading from a state of the crush curve is a straight line, so that it
    /// dissipates nothing; before the first compaction the line is the chord.
    #[inline(always)] // Into loops over lanes.
    fn path(&self, smallest: f64) -> DistensionPath {
        let ([start, elastic], [begin, end]) = (self.distensions, self.pressures);
        let left = (smallest - 1.0) * (1.0 / (elastic - 1.0));
        let left = if left > 0.0 { left.sqrt() } else { 0.0 };
        // Each number by itself: a choice between two paths would keep loops over lanes scalar.
        let is_first = smallest >= elastic;
        let (crushed, line) = (self.elastic_slope(smallest), (elastic - start) / begin);
        let pressure = if is_first { begin } else { end - (end - begin) * left };
        let meeting = [pressure, if is_first { elastic } else { smallest }];
        DistensionPath { meeting, slope: if is_first { line } else { crushed } }
    }

    /// Returns the distension at a pressure.
    #[inline(always)] // Into loops over lanes.
    fn distension(&self, path: DistensionPath, pressure: f64) -> f64 {
        let DistensionPath { meeting: [limit, smallest], slope } = path;
        if pressure > limit { self.crushed(pressure) } else { smallest + (pressure - limit) * slope }
    }

    /// Returns the slope of the path at a pressure.
    #[inline(always)] // Into loops over lanes.
    fn path_slope(&self, path: DistensionPath, pressure: f64) -> f64 {
        let [begin, end] = self.pressures;
        let left = (end - pressure) * (1.0 / (end - begin));
        let left = if left > 0.0 { left } else { 0.0 };
        let crushing = -2.0 * (self.distensions[1] - 1.0) * left / (end - begin);
        if pressure > path.meeting[0] { crushing } else { path.slope }
    }

    /// Returns the bulk modulus at a fixed distension, without the part of the energy.
    #[inline(always)] // Into loops over lanes.
    fn stiffness(&self, specific_volume: f64, distension: f64) -> f64 {
        self.line(specific_volume, distension).cold_slope / specific_volume
    }

    /// Returns the pressure line of the porous material at a fixed distension. Equation (7.13).
    #[inline(always)] // Into loops over lanes.
    fn line(&self, specific_volume: f64, distension: f64) -> EosLine {
        let per_distension = 1.0 / distension;
        let volume = specific_volume * per_distension;
        let EosLine { cold, per_energy, cold_slope, energy_slope } = self.solid.curve(1.0 / volume, volume);
        EosLine { cold: cold * per_distension, per_energy: per_energy * per_distension, cold_slope, energy_slope }
    }

    /// Returns where the search of the distension starts, from the path, the current distension, the bulk modulus of the
    /// porous material and the pressure there.
    #[inline(always)] // Into loops over lanes.
    fn start_of_search(&self, path: DistensionPath, current: f64, [stiffness, pressure]: [f64; 2]) -> Start {
        let first = current - self.distension(path, pressure);
        // A smaller distension lowers the pressure, at a given volume.
        let slope = 1.0 - self.path_slope(path, pressure) * (stiffness - pressure) / current;
        Start { start: current, first, guess: current - first / slope }
    }

    /// Returns the limit of the distension for a start below the path.
    #[inline(always)] // Likewise.
    fn most(&self) -> f64 {
        1.0 + 2.0 * (self.distensions[0] - 1.0)
    }

    /// Returns the distension at which a pressure that depends on it is on the path; `stiffness` is the bulk modulus of the
    /// porous material at the current distension.
    fn solve(&self, path: DistensionPath, current: f64, stiffness: f64, pressure: impl Fn(f64) -> f64) -> f64 {
        let excess = |distension: f64| distension - self.distension(path, pressure(distension));
        if path.is_closed() {
            return 1.0;
        }
        let start = self.start_of_search(path, current, [stiffness, pressure(current)]);
        // A NaN is kept, so that the run halts.
        if start.first >= 0.0 {
            return nearby_root(start, 1.0, ACCURACY, excess).unwrap_or(1.0);
        }
        let (most, start) = (self.most(), Start { first: -start.first, ..start });
        nearby_root(start, most, ACCURACY, |distension| -excess(distension)).unwrap_or(most)
    }

    /// Returns the pressure at the end of an increment of a lane with a distension, for the energy before it.
    #[inline(always)] // Into loops over lanes.
    fn end_pressure(&self, update: &PressureUpdate, l: usize, energy: f64, distension: f64) -> f64 {
        let line = self.line(specific_volume(update, l), distension);
        line.cold + line.per_energy * advance_energy(update, l, line, energy, 0.0)
    }

    /// Returns the distension of a lane at the end of an increment.
    fn solve_lane(&self, state: PointDistension, energy: f64, update: &PressureUpdate, l: usize) -> f64 {
        let stiffness = self.stiffness(specific_volume(update, l), state.current);
        let pressure = |distension: f64| self.end_pressure(update, l, energy, distension);
        self.solve(self.path(state.smallest), state.current, stiffness, pressure)
    }

    /// Returns the distensions of a block at the end of an increment.
    #[inline(always)] // Likewise.
    fn solve_block(&self, state: &DistensionState, energy: &Lanes, update: &PressureUpdate) -> Lanes {
        let zero = [0.0; LANES];
        let tolerance = [ACCURACY; LANES];
        let mut starts = LaneStarts { start: zero, first: zero, guess: zero, limit: zero, tolerance, open: [0; LANES] };
        let [mut meetings, mut smallest, mut slopes] = [zero; 3];
        for l in 0..LANES {
            let (path, current) = (self.path(state.smallest[l]), state.current[l]);
            let stiffness = self.stiffness(specific_volume(update, l), current);
            let pressure = self.end_pressure(update, l, energy[l], current);
            let start = self.start_of_search(path, current, [stiffness, pressure]);
            (meetings[l], smallest[l], slopes[l]) = (path.meeting[0], path.meeting[1], path.slope);
            starts.start[l] = if path.is_closed() { 1.0 } else { current };
            (starts.first[l], starts.guess[l]) = (start.first, start.guess);
            starts.limit[l] = if start.first > 0.0 { 1.0 } else { self.most() };
            starts.open[l] = u64::from(start.first.abs() > ACCURACY) & u64::from(!path.is_closed());
        }
        let (mut distensions, failed) = lane_roots(
            &starts,
            #[inline(always)]
            |distensions| {
                let mut values = zero;
                for l in 0..LANES {
                    let path = DistensionPath { meeting: [meetings[l], smallest[l]], slope: slopes[l] };
                    let pressure = self.end_pressure(update, l, energy[l], distensions[l]);
                    values[l] = distensions[l] - self.distension(path, pressure);
                }
                values
            },
        );
        if any(&failed) {
            for l in (0..LANES).filter(|l| failed[*l] == 1) {
                let point = PointDistension { smallest: state.smallest[l], current: state.current[l] };
                distensions[l] = self.solve_lane(point, energy[l], update, l);
            }
        }
        distensions
    }

    /// Returns the pressure line on the elastic path, at a specific volume and energy: a constant.
    pub(super) fn unloading_line(&self, state: &DistensionState, lane: usize, [volume, energy]: [f64; 2]) -> EosLine {
        let path = self.path(state.smallest[lane]);
        let pressure = |distension: f64| {
            let EosLine { cold, per_energy, .. } = self.line(volume, distension);
            cold + per_energy * energy
        };
        let current = state.current[lane];
        let distension = self.solve(path, current, self.stiffness(volume, current), pressure);
        EosLine { cold: pressure(distension), per_energy: 0.0, cold_slope: 0.0, energy_slope: 0.0 }
    }

    /// Updates pressures, energies and distensions of a block.
    #[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
    pub(super) fn advance_block(&self, state: &mut DistensionState, energy: &mut Lanes, update: &mut PressureUpdate) {
        let distensions = self.solve_block(state, energy, update);
        for l in 0..LANES {
            let mut point = PointDistension { smallest: state.smallest[l], current: state.current[l] };
            energy[l] = self.finish_lane(&mut point, distensions[l], energy[l], update, l);
            (state.smallest[l], state.current[l]) = (point.smallest, point.current);
        }
    }

    /// Returns the energy per mass that the collapse of pores dissipates between two states: the work of the pressure on
    /// the distension, less the change of its recoverable part. Equation (7.17).
    #[inline(always)] // Into loops over lanes.
    fn collapse_energy(before: PorousPoint, after: PorousPoint) -> f64 {
        let work = 0.25 * (before.pressure + after.pressure) * (before.solid_volume + after.solid_volume);
        work * (before.distension - after.distension) - (after.recoverable() - before.recoverable())
    }

    /// Updates pressure and distensions of a lane; returns its energy. Equation (7.16).
    pub(super) fn advance_lane(
        &self,
        state: &mut PointDistension,
        energy: f64,
        update: &mut PressureUpdate,
        l: usize,
    ) -> f64 {
        let distension = self.solve_lane(*state, energy, update, l);
        self.finish_lane(state, distension, energy, update, l)
    }

    /// Updates pressure and distensions of a lane from its distension at the end; returns its energy.
    #[inline(always)] // Into loops over lanes.
    fn finish_lane(
        &self,
        state: &mut PointDistension,
        distension: f64,
        energy: f64,
        update: &mut PressureUpdate,
        l: usize,
    ) -> f64 {
        let (volume, path, distension_before) = (specific_volume(update, l), self.path(state.smallest), state.current);
        let energy = advance(update, l, self.line(volume, distension), energy, [0.0, self.solid.floor()]);
        let pressure = -update.mean[l];
        state.current = distension;
        let is_crushed = pressure > path.meeting[0];
        state.smallest = if is_crushed { distension } else { state.smallest };
        let crushed_slope = self.path(distension).slope;
        let slope = if is_crushed { crushed_slope } else { path.slope };
        let volume_before = volume - update.middle[l] * update.dilation[l] / update.mass[l];
        // Crushing begins where the elastic line meets the crush curve.
        let [pressure_before, crushed_before] = path.meeting;
        let solid_volume = volume_before / distension_before;
        let before =
            PorousPoint { pressure: pressure_before, distension: crushed_before, solid_volume, slope: path.slope };
        let after = PorousPoint { pressure, distension, solid_volume: volume / distension, slope };
        let collapse = update.mass[l] * PorousCompaction::collapse_energy(before, after);
        let is_element = update.middle[l] > 0.0;
        update.compacted[l] = if is_crushed & is_element { collapse } else { update.compacted[l] };
        // The elastic change of the distension makes the material softer than at a fixed distension.
        let softer = 1.0 - (update.bulk[l] - pressure) / distension * slope;
        update.bulk[l] /= if softer > 1.0 { softer } else { 1.0 };
        energy
    }
}

carried_state!(DistensionState { smallest, current });

#[cfg(test)]
mod tests {
    use super::{PorousCompaction, UsUp};

    fn aluminium() -> PorousCompaction {
        let solid = UsUp { density: 2700.0, c0: 5350.0, s: 1.34, gamma0: 2.0 };
        PorousCompaction::new(solid, 3500.0, 0.2, [80e6, 700e6])
    }

    /// The bulk modulus at the start is the density times the square of the given sound speed, and the path is continuous.
    #[test]
    fn sound_speed_at_the_start_is_the_given_one() {
        let law = aluminium();
        let start = law.distensions[0];
        let line = law.line(1.0 / law.initial_density(), start);
        let fixed = law.initial_density() * line.cold_slope;
        let bulk = fixed / (1.0 - fixed / start * law.elastic_slope(start));
        let speed = (bulk / law.initial_density()).sqrt();
        assert!((speed / 3500.0 - 1.0).abs() < 1e-9, "{speed}");
        for smallest in [law.distensions[1], 1.1, 1.0] {
            let path = law.path(smallest);
            let below = law.distension(path, path.meeting[0] * (1.0 - 1e-12));
            let above = law.distension(path, path.meeting[0] * (1.0 + 1e-12));
            assert!((below - above).abs() < 1e-9 && (above - smallest).abs() < 1e-9, "{below} {above}");
        }
    }
}
