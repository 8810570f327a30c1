//! A material point of a law on a path of strains, or of strain and lateral stress.

use super::MOST_STATES;
use super::law::{ReturnPoint, StressReturn, TrialStress, contraction};
use super::root::{Start, nearby_root};
use crate::kernel::lanes::InlineMap;
use crate::kernel::stress::pressure;

/// Largest strain increment of one update of the law; longer increments are divided, except where a jump is exact.
const LONGEST_INCREMENT: f64 = 1e-3;
/// Largest lateral strain increment, over the axial one, that is tried for a lateral stress.
const WIDEST: f64 = 20.0;
/// Accepted error of the lateral stress, over the bulk modulus.
const STRESS_TOLERANCE: f64 = 1e-13;

/// State of a point, small enough to be copied for a trial. Components are rr, zz, hoop, rz; there is no rotation.
#[derive(Clone)]
pub struct LawPath<'a> {
    law: &'a dyn StressReturn,
    states: [f64; MOST_STATES],
    count: usize,
    /// Characteristic length of the element that the point represents.
    length: f64,
    /// Stress, positive in tension.
    pub stress: [f64; 4],
    /// Logarithmic strains since the start.
    pub strain: [f64; 4],
    /// Whether the last increment had plastic flow or a change of the law's damage or compaction.
    pub is_flowing: bool,
}

impl<'a> LawPath<'a> {
    /// Creates a point without stress.
    pub fn new(law: &'a dyn StressReturn, length: f64) -> LawPath<'a> {
        let initial = law.initial_state();
        let mut states = [0.0; MOST_STATES];
        states[..initial.len()].copy_from_slice(&initial);
        let (stress, strain) = ([0.0; 4], [0.0; 4]);
        LawPath { law, states, count: initial.len(), length, stress, strain, is_flowing: false }
    }

    /// Applies a strain increment that lasts `dt`.
    pub fn advance(&mut self, strain: [f64; 4], dt: f64) {
        let largest = strain.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
        let longest = if self.law.is_exact_over_jumps() { f64::INFINITY } else { LONGEST_INCREMENT };
        let parts = (largest / longest).ceil().max(1.0);
        let part = strain.inline_map(|component| component / parts);
        self.is_flowing = false;
        for _ in 0..parts as usize {
            let moduli = self.law.moduli();
            let mut point = ReturnPoint::new(part, self.stress, &mut self.states[..self.count], moduli);
            (point.length, point.dt) = (self.length, dt / parts);
            self.law.update(&mut point);
            let ReturnPoint { stress, plastic, compacted, .. } = point;
            self.is_flowing |= contraction(plastic, plastic) > 0.0 || compacted != 0.0;
            self.stress = stress;
            for (total, part) in self.strain.iter_mut().zip(part) {
                *total += part;
            }
        }
    }

    /// Applies an axial strain increment while the radial and the hoop stress become `lateral`. Returns whether such a state
    /// was found.
    pub fn advance_axially(&mut self, increment: f64, lateral: f64) -> bool {
        let bulk = self.law.moduli().bulk;
        let after = |widening: f64| {
            let mut path = self.clone();
            path.advance([widening, increment, widening, 0.0], f64::INFINITY);
            path
        };
        let excess = |widening: f64| (after(widening).stress[0] - lateral) / bulk;
        let first = excess(0.0);
        // The excess increases with the lateral strain.
        let side = if first > 0.0 { -1.0 } else { 1.0 };
        let start = Start { start: 0.0, first: first.abs(), guess: -0.4 * first };
        let limit = side * WIDEST * increment.abs();
        let Some(widening) = nearby_root(start, limit, STRESS_TOLERANCE, |x| -side * excess(x)) else { return false };
        *self = after(widening);
        true
    }

    /// Returns the pressure and the von Mises stress.
    pub fn invariants(&self) -> [f64; 2] {
        [pressure(self.stress), TrialStress::of(self.stress).mises]
    }
}
