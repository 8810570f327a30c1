//! Porous metal plasticity in the lanes of a block.
#![allow(clippy::needless_range_loop)] // Loops over lanes, with one array per quantity.

use super::lane_roots::{Flags, any};
use super::points::ReturnedPoints;
use super::porous_metal::{DENSITY, PorousMetal, STRAIN, VOIDS};
use super::porous_return::{Flowed, NEWTON_STEPS, PorousConstants, PorousIncrement, TOLERANCE};
use crate::kernel::hardening::TableLines;
use crate::kernel::lanes::{InlineMap, LANES, Lanes};

/// States of the lanes before the increment.
struct LanesBefore<'a> {
    strain: Lanes,
    voids: Lanes,
    hardening: TableLines<'a>,
}

impl<'a> LanesBefore<'a> {
    #[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
    fn of(&self, points: &ReturnedPoints, l: usize) -> PorousIncrement<'a> {
        let (mises, mean) = (points.mises[l], -points.pressure[l]);
        PorousIncrement { strain: self.strain[l], voids: self.voids[l], hardening: self.hardening.of(l), mises, mean }
    }
}

/// States of the lanes after flow, one array per quantity.
struct LanesFlowed {
    mises: Lanes,
    mean: Lanes,
    strain: Lanes,
    voids: Lanes,
    nucleation: Lanes,
    yield_stress: Lanes,
    effective: [Lanes; 2],
    cosh: Lanes,
    sinh: Lanes,
    excess: Lanes,
    mismatch: Lanes,
}

impl LanesFlowed {
    #[inline(always)] // Likewise.
    fn zero() -> LanesFlowed {
        let [mises, mean, strain, voids] = [[0.0; LANES]; 4];
        let [nucleation, yield_stress, cosh, sinh] = [[0.0; LANES]; 4];
        let ([excess, mismatch], effective) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        LanesFlowed { mises, mean, strain, voids, nucleation, yield_stress, effective, cosh, sinh, excess, mismatch }
    }

    #[inline(always)] // Likewise.
    fn of(&self, l: usize) -> Flowed {
        Flowed {
            mises: self.mises[l],
            mean: self.mean[l],
            strain: self.strain[l],
            voids: self.voids[l],
            nucleation: self.nucleation[l],
            yield_stress: self.yield_stress[l],
            effective: [self.effective[0][l], self.effective[1][l]],
            cosh: self.cosh[l],
            sinh: self.sinh[l],
            excess: self.excess[l],
            mismatch: self.mismatch[l],
        }
    }

    #[inline(always)] // Likewise.
    fn put(&mut self, l: usize, state: Flowed) {
        let Flowed { mises, mean, strain, voids, nucleation, yield_stress, .. } = state;
        (self.mises[l], self.mean[l], self.strain[l], self.voids[l]) = (mises, mean, strain, voids);
        (self.nucleation[l], self.yield_stress[l]) = (nucleation, yield_stress);
        [self.effective[0][l], self.effective[1][l]] = state.effective;
        (self.cosh[l], self.sinh[l], self.excess[l], self.mismatch[l]) =
            (state.cosh, state.sinh, state.excess, state.mismatch);
    }
}

impl PorousMetal {
    /// Returns the points of a block to the yield surface. Leaves to the update of a point what does not converge by Newton's
    /// method, ends beyond the line of the table or deletes the element.
    #[inline(always)] // Likewise.
    pub(super) fn return_lanes(&self, states: &mut [Lanes], points: &mut ReturnedPoints) {
        let law = self.constants();
        match law.nucleation {
            None => self.return_with(PorousConstants { nucleation: None, ..law }, states, points),
            Some(voids) => self.return_with(PorousConstants { nucleation: Some(voids), ..law }, states, points),
        }
    }

    #[inline(always)] // Likewise.
    fn return_with(&self, law: PorousConstants, states: &mut [Lanes], points: &mut ReturnedPoints) {
        let (strain, voids) = (states[STRAIN], states[VOIDS]);
        let before = LanesBefore { strain, voids, hardening: self.hardening.lines(&strain) };
        let (mut now, mut open) = (LanesFlowed::zero(), [0; LANES]);
        for l in 0..LANES {
            let trial = law.trial(&before.of(points, l));
            open[l] = points.open[l] & u64::from(trial.excess > TOLERANCE);
            now.put(l, trial);
        }
        if !any(&open) {
            return points.stay_elastic();
        }
        let failure = self.failure.map_or(f64::INFINITY, |failure| failure.failure);
        let failed = newton_in_lanes(law, &before, points, &open, &mut now);
        let [mut strains, mut new_voids] = [strain, voids];
        for l in 0..LANES {
            let (start, end) = (before.of(points, l), now.of(l));
            let is_ordinary = start.hardening.holds_at(end.strain) & (end.voids < failure);
            let is_returned = open[l] & (1 - failed[l]) & u64::from(is_ordinary);
            let choose = |new: f64, old: f64| if is_returned == 1 { new } else { old };
            strains[l] = choose(end.strain, strain[l]);
            new_voids[l] = choose(end.voids, voids[l]);
            let mean = choose(end.mean, start.mean);
            let share = choose(end.mises / start.mises, 1.0);
            let deviator = points.trial(l).deviator.inline_map(|part| share * part);
            points.return_to_deviator(l, -mean, deviator, (start.mean - mean) / law.moduli.bulk);
            points.open[l] = open[l] & (1 - is_returned);
        }
        for l in 0..LANES {
            states[DENSITY][l] = if new_voids[l] == voids[l] { states[DENSITY][l] } else { 1.0 - new_voids[l] };
        }
        (states[STRAIN], states[VOIDS]) = (strains, new_voids);
    }
}

/// Moves open lanes to the yield surface by Newton's method from the trial; returns flags of lanes that do not converge.
#[inline(always)] // Likewise.
fn newton_in_lanes(
    law: PorousConstants,
    before: &LanesBefore<'_>,
    points: &ReturnedPoints,
    open: &Flags,
    now: &mut LanesFlowed,
) -> Flags {
    let ([mut flow, mut dilation], mut active) = ([[0.0; LANES]; 2], *open);
    for _ in 0..NEWTON_STEPS {
        for l in 0..LANES {
            let (start, state) = (before.of(points, l), now.of(l));
            let [next_flow, next_dilation] = law.newton_step::<true>(&start, &state, [flow[l], dilation[l]]);
            flow[l] = if active[l] == 1 { next_flow } else { flow[l] };
            dilation[l] = if active[l] == 1 { next_dilation } else { dilation[l] };
            let state = law.flowed::<true>(&start, flow[l], dilation[l]);
            active[l] &= u64::from(!law.is_end(&state));
            now.put(l, state);
        }
        if !any(&active) {
            break;
        }
    }
    active
}
