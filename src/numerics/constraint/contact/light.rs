//! Treatment of free rigid bodies that are lighter than the nodes they touch.
//!
//! All gaps in front of a light body depend on its velocity. An impulse in one row moves the body away from all others,
//! and sweeps converge very slowly. The body's velocity is therefore held during a sweep, so that rows are coupled by
//! nodes only. After each sweep the velocity is changed by the fraction 1/(1 + w k) of its error. Here w is one over
//! the body's mass, and k = sum g^2/a is the effective mass of the rows under pressure (g: coefficient of the body in a
//! row, a: compliance of the nodes). This is Uzawa's iteration on the body's energy (Glowinski and Le Tallec 1989,
//! Augmented Lagrangian and Operator-Splitting Methods, 2). It does not overshoot, because k is at least the mass that
//! moves with the body.

use super::sweeps::{ContactRows, ContactVelocities, GapTerm};
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};

/// A body that is lighter than the nodes that it touches; its velocity is held during the sweeps.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBody {
    dof: u32,
    inverse_mass: f64,
    /// Velocity of the body without contact.
    predicted: f64,
}

/// Returns the coefficients of a degree of freedom in a row, along the normal and along the surface.
fn share(terms: &[GapTerm], dof: u32) -> Option<[f64; 2]> {
    terms.iter().find(|t| t.dof == dof).map(|t| [t.normal, t.slip])
}

impl ContactRows {
    /// Finds the bodies that are lighter than the nodes they touch, and holds their velocities. Soft contact is left
    /// out, because its sweeps converge quickly.
    pub(super) fn hold_light(&mut self, motion: &mut ContactVelocities, laws: &[InteractionLaw]) {
        self.light.clear();
        for &dof in &self.bodies {
            let inverse_mass = motion.inverse_mass[dof as usize];
            let mut effective_mass = 0.0;
            for row in &self.rows {
                if let Some([g, _]) = share(self.terms_of(row), dof).filter(|s| s[0] != 0.0) {
                    let others = (row.compliance[0] - inverse_mass * g * g).max(0.0);
                    let hard = laws[row.law as usize].overclosure == PressureOverclosure::Hard;
                    effective_mass += if hard { g * g / others } else { f64::INFINITY };
                }
            }
            // The sum is infinite if a row has no compliance without the body: then the body touches something
            // immovable.
            if effective_mass.is_finite() && inverse_mass * effective_mass > 1.0 {
                self.light.push(LightBody { dof, inverse_mass, predicted: motion.velocity[dof as usize] });
                motion.inverse_mass[dof as usize] = 0.0;
            }
        }
        if self.light.is_empty() {
            return;
        }
        let ContactRows { terms, rows, .. } = self;
        for row in rows {
            row.update_compliance(row.terms_in(terms), motion);
        }
    }

    /// Sets the velocity of light bodies to that of the rows under pressure, as the initial value of the iteration.
    pub(super) fn start_light(&mut self, motion: &mut ContactVelocities) {
        for light in &self.light {
            let (mut sum, mut effective_mass) = (0.0, 0.0);
            for row in self.rows.iter().filter(|row| row.normal_impulse > 0.0) {
                let terms = self.terms_of(row);
                if let Some([g, _]) = share(terms, light.dof) {
                    sum += g * (motion.rate(terms) + row.bias) / row.compliance[0];
                    effective_mass += g * g / row.compliance[0];
                }
            }
            if effective_mass > 0.0 {
                motion.velocity[light.dof as usize] -= sum / effective_mass;
            }
        }
    }

    /// Updates the velocities of light bodies after a sweep; returns the largest error of a velocity.
    pub(super) fn move_light(&self, motion: &mut ContactVelocities) -> f64 {
        let mut furthest: f64 = 0.0;
        for light in &self.light {
            let (mut impulse, mut effective_mass) = (0.0, 0.0);
            for row in self.rows.iter().filter(|row| row.normal_impulse > 0.0) {
                let Some([g, t]) = share(self.terms_of(row), light.dof) else { continue };
                impulse += g * row.normal_impulse + t * row.shear_impulse;
                effective_mass += g * g / row.compliance[0];
                if row.sticks && row.compliance[1] > 0.0 {
                    effective_mass += t * t / row.compliance[1];
                }
            }
            let velocity = &mut motion.velocity[light.dof as usize];
            let error = light.predicted + light.inverse_mass * impulse - *velocity;
            *velocity += error / (1.0 + light.inverse_mass * effective_mass);
            furthest = furthest.max(error.abs());
        }
        furthest
    }

    /// Releases light bodies with the velocities that follow from the impulses.
    pub(super) fn release_light(&mut self, motion: &mut ContactVelocities) {
        for light in &self.light {
            let on = |row| {
                share(self.terms_of(row), light.dof)
                    .map_or(0.0, |[g, t]| g * row.normal_impulse + t * row.shear_impulse)
            };
            let impulse: f64 = self.rows.iter().map(on).sum();
            motion.velocity[light.dof as usize] = light.predicted + light.inverse_mass * impulse;
            motion.inverse_mass[light.dof as usize] = light.inverse_mass;
        }
        self.light.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::super::sweeps::{
        ContactInterval, ContactRow, ContactRows, ContactStep, ContactVelocities, GapTerm, MOST_SWEEPS,
    };
    use crate::kernel::interaction::InteractionLaw;

    /// Returns a plate of this mass with velocity -1 against twelve nodes of mass 1.
    fn plate(mass: f64) -> (ContactRows, ContactVelocities) {
        let count = 12_u32;
        let mut rows = ContactRows::default();
        rows.bodies.push(count);
        for k in 0..count {
            let begin = rows.terms.len() as u32;
            for (n, part) in [(k.wrapping_sub(1), 1.0 / 6.0), (k, 4.0 / 6.0), (k + 1, 1.0 / 6.0)] {
                if n < count {
                    rows.terms.push(GapTerm { dof: n, normal: -part, slip: 0.0 });
                }
            }
            let area = -rows.terms[begin as usize..].iter().map(|t| t.normal).sum::<f64>();
            rows.terms.push(GapTerm { dof: count, normal: area, slip: 0.0 });
            let mut row = ContactRow::of(k, 0);
            (row.terms, row.area) = ([begin, rows.terms.len() as u32], area);
            rows.rows.push(row);
        }
        let mut velocity = vec![0.0; 13];
        let mut inverse_mass = vec![1.0; 13];
        (velocity[12], inverse_mass[12]) = (-1.0, 1.0 / mass);
        let mut motion = ContactVelocities { velocity, inverse_mass };
        let span = ContactInterval { dt: 1.0, half: 1.0 };
        let step = ContactStep { laws: &[InteractionLaw::default()], pressures: &[[0.0; 2]; 12], span };
        if let Some(reference) = rows.begin(&motion, step) {
            rows.solve_by_sweeps(&mut motion, reference, step);
        }
        (rows, motion)
    }

    /// For any mass of the plate there is no penetration, only closed rows have pressure, and momentum is conserved.
    #[test]
    fn sweeps_converge_for_light_bodies() {
        for mass in [1e3, 10.0, 1.0, 1e-1, 1e-2, 1e-4, 1e-6] {
            let (rows, motion) = plate(mass);
            let plate = motion.velocity[12];
            println!("plate of {mass:e}: {} sweeps, {plate:.3e}", rows.sweeps);
            assert!(rows.sweeps < MOST_SWEEPS, "{mass}: {}", rows.sweeps);
            let momentum: f64 = motion.velocity[..12].iter().sum::<f64>() + mass * plate;
            assert!((momentum / mass + 1.0).abs() < 1e-9, "{mass}: {momentum}");
            for row in &rows.rows {
                let rate = motion.rate(rows.terms_of(row)) / row.area;
                assert!(rate > -1e-8 && (row.normal_impulse == 0.0 || rate < 1e-8), "{mass}: {rate:e} {row:?}");
            }
        }
    }
}
