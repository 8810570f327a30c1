//! Rigid bodies that are lighter than the nodes they meet.
//! Never here: sweeps, gaps.
//!
//! All gaps in front of a light body move with it: an impulse on one throws the body out of the way of all others, and sweeps that
//! change one row after the other shift the impulses between rows at a crawl. So its velocity is held while rows are swept, which
//! then depend on each other by their nodes alone. Behind each sweep it goes towards the velocity that the impulses give it,
//! by the part 1/(1 + w k) of the way, with w one over its mass and k the mass that stands behind the rows that press: Uzawa's
//! iteration on the body's own term of the energy (Glowinski and Le Tallec 1989, Augmented Lagrangian and Operator-Splitting Methods,
//! 2). As k = sum g^2/a, with g the row's share of the body and a what its nodes give way, is never below the mass that moves
//! when all rows move alike, the way ends without overshoot.

use super::sweeps::{Motion, Rows, Term};
use crate::kernel::interaction::{Law, Overclosure};

/// A light body in this increment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    dof: u32,
    inverse_mass: f64,
    /// Its velocity without contact.
    predicted: f64,
}

/// The share of a degree of freedom in a row, along the normal and along the surface.
fn share(terms: &[Term], dof: u32) -> Option<[f64; 2]> {
    terms.iter().find(|t| t.dof == dof).map(|t| [t.normal, t.slip])
}

impl Rows {
    /// Finds the bodies that are lighter than what they meet, and holds them. What gives way presses little for how far it moves:
    /// there sweeps go fast by themselves.
    pub(super) fn hold_light(&mut self, motion: &mut Motion, laws: &[Law]) {
        self.light.clear();
        for &dof in &self.bodies {
            let inverse_mass = motion.inverse_mass[dof as usize];
            let mut met = 0.0;
            for row in &self.rows {
                if let Some([g, _]) = share(self.terms_of(row), dof).filter(|s| s[0] != 0.0) {
                    let others = (row.gives[0] - inverse_mass * g * g).max(0.0);
                    let hard = laws[row.law as usize].overclosure == Overclosure::Hard;
                    met += if hard { g * g / others } else { f64::INFINITY };
                }
            }
            // Where a row has nothing else that gives way, nothing is met that could be moved.
            if met.is_finite() && inverse_mass * met > 1.0 {
                self.light.push(Light { dof, inverse_mass, predicted: motion.velocity[dof as usize] });
                motion.inverse_mass[dof as usize] = 0.0;
            }
        }
        if self.light.is_empty() {
            return;
        }
        let Rows { terms, rows, .. } = self;
        for row in rows {
            row.give(row.own(terms), motion);
        }
    }

    /// Gives light bodies the velocity of what they pressed on, which impulses of the increment before have set going.
    pub(super) fn start_light(&mut self, motion: &mut Motion) {
        for light in &self.light {
            let (mut sum, mut met) = (0.0, 0.0);
            for row in self.rows.iter().filter(|row| row.pressed > 0.0) {
                let terms = self.terms_of(row);
                if let Some([g, _]) = share(terms, light.dof) {
                    sum += g * (motion.rate(terms) + row.bias) / row.gives[0];
                    met += g * g / row.gives[0];
                }
            }
            if met > 0.0 {
                motion.velocity[light.dof as usize] -= sum / met;
            }
        }
    }

    /// Moves light bodies behind a sweep; returns how far the fastest is from what the impulses give it.
    pub(super) fn move_light(&self, motion: &mut Motion) -> f64 {
        let mut furthest: f64 = 0.0;
        for light in &self.light {
            let (mut impulse, mut met) = (0.0, 0.0);
            for row in self.rows.iter().filter(|row| row.pressed > 0.0) {
                let Some([g, t]) = share(self.terms_of(row), light.dof) else { continue };
                impulse += g * row.pressed + t * row.sheared;
                met += g * g / row.gives[0];
                if row.sticks && row.gives[1] > 0.0 {
                    met += t * t / row.gives[1];
                }
            }
            let velocity = &mut motion.velocity[light.dof as usize];
            let left = light.predicted + light.inverse_mass * impulse - *velocity;
            *velocity += left / (1.0 + light.inverse_mass * met);
            furthest = furthest.max(left.abs());
        }
        furthest
    }

    /// Lets light bodies go, with the velocity that the impulses give them.
    pub(super) fn release_light(&mut self, motion: &mut Motion) {
        for light in &self.light {
            let on = |row| share(self.terms_of(row), light.dof).map_or(0.0, |[g, t]| g * row.pressed + t * row.sheared);
            let impulse: f64 = self.rows.iter().map(on).sum();
            motion.velocity[light.dof as usize] = light.predicted + light.inverse_mass * impulse;
            motion.inverse_mass[light.dof as usize] = light.inverse_mass;
        }
        self.light.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::super::sweeps::{Given, MOST_SWEEPS, Motion, Row, Rows, Span, Term};
    use crate::kernel::interaction::Law;

    /// A plate of this mass comes with velocity -1, and is pushed, against twelve nodes of mass 1 in a row, hats over them.
    fn plate(mass: f64) -> (Rows, Motion) {
        let count = 12_u32;
        let mut rows = Rows::default();
        rows.bodies.push(count);
        for k in 0..count {
            let begin = rows.terms.len() as u32;
            for (n, part) in [(k.wrapping_sub(1), 1.0 / 6.0), (k, 4.0 / 6.0), (k + 1, 1.0 / 6.0)] {
                if n < count {
                    rows.terms.push(Term { dof: n, normal: -part, slip: 0.0 });
                }
            }
            let area = -rows.terms[begin as usize..].iter().map(|t| t.normal).sum::<f64>();
            rows.terms.push(Term { dof: count, normal: area, slip: 0.0 });
            let mut row = Row::of(k, 0);
            (row.terms, row.area) = ([begin, rows.terms.len() as u32], area);
            rows.rows.push(row);
        }
        let mut velocity = vec![0.0; 13];
        let mut inverse_mass = vec![1.0; 13];
        (velocity[12], inverse_mass[12]) = (-1.0, 1.0 / mass);
        let mut motion = Motion { velocity, inverse_mass };
        let span = Span { ahead: 1.0, half: 1.0 };
        let given = Given { laws: &[Law::default()], before: &[[0.0; 2]; 12], span };
        if let Some(reference) = rows.begin(&motion, given) {
            rows.solve_by_sweeps(&mut motion, reference, given);
        }
        (rows, motion)
    }

    /// However light the plate is, nothing goes on into it, nothing that has left it is pressed, and momentum stays.
    #[test]
    fn sweeps_converge_however_light_a_body_is() {
        for mass in [1e3, 10.0, 1.0, 1e-1, 1e-2, 1e-4, 1e-6] {
            let (rows, motion) = plate(mass);
            let plate = motion.velocity[12];
            println!("plate of {mass:e}: {} sweeps, {plate:.3e}", rows.sweeps);
            assert!(rows.sweeps < MOST_SWEEPS, "{mass}: {}", rows.sweeps);
            let momentum: f64 = motion.velocity[..12].iter().sum::<f64>() + mass * plate;
            assert!((momentum / mass + 1.0).abs() < 1e-9, "{mass}: {momentum}");
            for row in &rows.rows {
                let rate = motion.rate(rows.terms_of(row)) / row.area;
                assert!(rate > -1e-8 && (row.pressed == 0.0 || rate < 1e-8), "{mass}: {rate:e} {row:?}");
            }
        }
    }
}
