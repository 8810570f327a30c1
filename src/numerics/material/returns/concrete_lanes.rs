//! Concrete damaged plasticity in the lanes of a block.
#![allow(clippy::needless_range_loop)] // Loops over lanes, with one array per quantity.

use super::concrete::{
    COMPRESSION_DAMAGE, COMPRESSION_STRAIN, ConcreteDamagedPlasticity, DEGRADATION, TENSION_DAMAGE, TENSION_STRAIN,
    scaled,
};
use super::concrete_return::{ConcreteConstants, ConcretePath};
use super::concrete_tables::ConcreteLines;
use super::lane_roots::{Flags, LaneStarts, any, lane_roots};
use super::law::TrialStress;
use super::points::ReturnedPoints;
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, put_column};
use crate::kernel::stress::principal;
use crate::material::increment::StrainIncrement;

/// Paths of the lanes of a block.
struct LanePaths<'a> {
    tables: [ConcreteLines<'a>; 2],
    strains: [Lanes; 2],
    deviators: [Lanes; 3],
    first_shares: Lanes,
    /// Effective stress at the start of the increment.
    effective: [Lanes; 4],
}

/// Ends of the paths.
struct LaneEnds {
    returned: Flags,
    flow: Lanes,
    /// Increments of the equivalent plastic strains.
    strains: [Lanes; 2],
    damages: [Lanes; 2],
}

impl<'a> LanePaths<'a> {
    #[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
    fn path(&self, of: ConcreteConstants, points: &ReturnedPoints, l: usize) -> ConcretePath<'a> {
        let [a, b, c] = &self.deviators;
        let tables = [self.tables[0].of(l), self.tables[1].of(l)];
        ConcretePath {
            tables,
            of,
            trial: points.trial(l),
            deviator: [a[l], b[l], c[l]],
            start: [self.strains[0][l], self.strains[1][l]],
            start_strengths: [tables[0].effective, tables[1].effective],
            per_dt: 0.0,
            first_share: self.first_shares[l],
        }
    }
}

impl ConcreteDamagedPlasticity {
    /// Returns the points of a block to the yield surface, with tables without rate. Leaves to the update of a point what ends
    /// beyond the part of a table or deletes the element.
    #[inline(always)] // Likewise.
    pub(super) fn return_lanes(
        &self,
        states: &mut [Lanes],
        length: &Lanes,
        strain: &StrainIncrement,
        points: &mut ReturnedPoints,
    ) {
        if !(self.compression.is_static() && self.tension.is_static()) {
            return;
        }
        let effective = self.effective_trial(&states[DEGRADATION], strain, points);
        let strains = [states[COMPRESSION_STRAIN], states[TENSION_STRAIN]];
        let tables = [self.compression.empty_lines(), self.tension.empty_lines()];
        let mut paths =
            LanePaths { tables, strains, deviators: [[0.0; LANES]; 3], first_shares: [f64::NAN; LANES], effective };
        paths.tables[0].fill(&paths.strains[0], length);
        paths.tables[1].fill(&paths.strains[1], length);
        let mut ends = LaneEnds {
            returned: [0; LANES],
            flow: [0.0; LANES],
            strains: [[0.0; LANES]; 2],
            damages: [states[COMPRESSION_DAMAGE], states[TENSION_DAMAGE]],
        };
        let starts = self.starts(&mut paths, points);
        if any(&starts.open) {
            self.return_open_lanes(&starts, &paths, points, &mut ends);
            self.leave_failed((states, length), &paths, points, &mut ends);
        }
        for l in 0..LANES {
            points.open[l] = starts.open[l] & (1 - ends.returned[l]);
        }
        self.finish_lanes(states, &paths, &ends, points);
    }

    /// Computes the trials from the effective stress at the start of the increment, which is returned.
    #[inline(always)] // Likewise.
    fn effective_trial(
        &self,
        degradation: &Lanes,
        strain: &StrainIncrement,
        points: &mut ReturnedPoints,
    ) -> [Lanes; 4] {
        let mut effective = strain.carried;
        if degradation.iter().all(|degradation| *degradation == 0.0) {
            return effective;
        }
        for l in 0..LANES {
            let previous = scaled(column(&strain.carried, l), 1.0 / (1.0 - degradation[l]));
            let trial = TrialStress::elastic(previous, column(&strain.strain, l), self.moduli);
            put_column(&mut effective, l, previous);
            put_column(&mut points.deviator, l, trial.deviator);
            (points.pressure[l], points.mises[l]) = (trial.pressure, trial.mises);
        }
        effective
    }

    /// Returns where the flows start.
    #[inline(always)] // Likewise.
    fn starts(&self, paths: &mut LanePaths<'_>, points: &ReturnedPoints) -> LaneStarts {
        let of = self.constants();
        let zero = [0.0; LANES];
        let limit = [f64::INFINITY; LANES];
        let mut starts =
            LaneStarts { start: zero, first: zero, guess: zero, limit, tolerance: zero, open: points.open };
        let mut has_other_share = [0; LANES];
        for l in 0..LANES {
            let deviator = principal(column(&points.deviator, l));
            for i in 0..3 {
                paths.deviators[i][l] = deviator[i];
            }
            let path = paths.path(of, points, l);
            let trial = path.trial;
            let first =
                self.surface.value([trial.pressure, trial.mises, deviator[2] - trial.pressure], path.start_strengths);
            starts.first[l] = first;
            starts.guess[l] = path.first_flow(first);
            starts.tolerance[l] = path.tolerance();
            starts.open[l] &= u64::from(first > 1e-11 * path.start_strengths[0]);
            has_other_share[l] = starts.open[l] & u64::from(!path.has_one_share(column(&paths.effective, l)));
        }
        if any(&has_other_share) {
            for l in 0..LANES {
                let share = paths.path(of, points, l).share_at_contact(column(&paths.effective, l), starts.first[l]);
                paths.first_shares[l] = if has_other_share[l] == 1 { share } else { f64::NAN };
            }
        }
        starts
    }

    /// Finds the flows of the lanes outside the yield surface.
    #[inline(always)] // Likewise.
    fn return_open_lanes(
        &self,
        starts: &LaneStarts,
        paths: &LanePaths<'_>,
        points: &ReturnedPoints,
        ends: &mut LaneEnds,
    ) {
        let of = self.constants();
        let (flows, failed) = lane_roots(
            starts,
            #[inline(always)]
            |flows| {
                let mut values = [0.0; LANES];
                for l in 0..LANES {
                    let path = paths.path(of, points, l);
                    values[l] = path.outside::<true>(&path.state(flows[l]));
                }
                values
            },
        );
        let [mut in_compression, mut in_tension] = [[0.0; LANES]; 2];
        let [mut compression_damage, mut tension_damage] = ends.damages;
        for l in 0..LANES {
            let path = paths.path(of, points, l);
            let state = path.state(flows[l]);
            let is_on_line =
                |side: usize| u64::from(path.tables[side].holds_at(path.start[side] + state.strains[side]));
            let is_returned = starts.open[l] & (1 - failed[l]) & is_on_line(0) & is_on_line(1);
            let [compression, tension] = [0, 1].inline_map(|side| path.strength::<true>(&state, side).damage);
            let choose = |new: f64, old: f64| if is_returned == 1 { new } else { old };
            ends.returned[l] = is_returned;
            ends.flow[l] = choose(flows[l], 0.0);
            compression_damage[l] = choose(compression, compression_damage[l]);
            tension_damage[l] = choose(tension, tension_damage[l]);
            in_compression[l] = choose(state.strains[0], 0.0);
            in_tension[l] = choose(state.strains[1], 0.0);
        }
        ends.strains = [in_compression, in_tension];
        ends.damages = [compression_damage, tension_damage];
    }

    /// Leaves points that are deleted to the update of a point.
    #[inline(always)] // Likewise.
    fn leave_failed(
        &self,
        (states, length): (&[Lanes], &Lanes),
        paths: &LanePaths<'_>,
        points: &ReturnedPoints,
        ends: &mut LaneEnds,
    ) {
        if self.failure.is_none() {
            return;
        }
        let of = self.constants();
        let (returned, previous) = (ends.returned, [states[COMPRESSION_DAMAGE], states[TENSION_DAMAGE]]);
        for l in (0..LANES).filter(|l| returned[*l] == 1) {
            let path = paths.path(of, points, l);
            let state = path.state(ends.flow[l]);
            if self.fails([0, 1].inline_map(|side| path.strength::<true>(&state, side)), length[l]) {
                (ends.returned[l], ends.flow[l]) = (0, 0.0);
                for side in 0..2 {
                    (ends.strains[side][l], ends.damages[side][l]) = (0.0, previous[side][l]);
                }
            }
        }
    }

    /// Sets stresses and states.
    #[inline(always)] // Likewise.
    fn finish_lanes(&self, states: &mut [Lanes], paths: &LanePaths<'_>, ends: &LaneEnds, points: &mut ReturnedPoints) {
        let of = self.constants();
        let ([compression, tension], mut degradations) = (ends.damages, states[DEGRADATION]);
        for l in 0..LANES {
            let path = paths.path(of, points, l);
            // The trial without flow.
            let (trial, end) = (path.trial, path.state(ends.flow[l]));
            // Other lanes than these keep their states.
            let is_done = points.live[l] & (1 - points.open[l]) == 1;
            let old = degradations[l];
            let new = self.degradation(end.principal, [compression[l], tension[l]]);
            let new = if is_done { new } else { old };
            let before = TrialStress::of(column(&paths.effective, l));
            let lost = self.lost_energy(before, trial, [end.share, end.pressure], new - old);
            points.lost[l] = if is_done { lost } else { 0.0 };
            let deviator = trial.deviator.inline_map(|part| end.share * part);
            points.return_to_deviator(l, end.pressure, deviator, (end.pressure - trial.pressure) / of.bulk);
            degradations[l] = new;
        }
        for l in 0..LANES {
            let nominal = scaled(column(&points.stress, l), 1.0 - degradations[l]);
            put_column(&mut points.stress, l, nominal);
        }
        for (state, increment) in [(COMPRESSION_STRAIN, &ends.strains[0]), (TENSION_STRAIN, &ends.strains[1])] {
            for l in 0..LANES {
                states[state][l] += increment[l];
            }
        }
        (states[COMPRESSION_DAMAGE], states[TENSION_DAMAGE]) = (compression, tension);
        states[DEGRADATION] = degradations;
    }
}
