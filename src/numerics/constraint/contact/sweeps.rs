//! Iterative solution for the contact impulses: projected Gauss-Seidel sweeps over the gaps of all pairs in a fixed
//! order, starting from the pressures of the previous increment (Jean 1999, Comput. Methods Appl. Mech. Engrg. 177,
//! 235).

use super::direct::DirectSolver;
use super::light::LightBody;
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::platform::PortableMath as _;
use crate::state::energies::ImpactKind;

/// Coefficients of one degree of freedom in a row, along the normal and along the surface.
#[derive(Clone, Copy, Debug)]
pub struct GapTerm {
    /// Index of the degree of freedom.
    pub dof: u32,
    /// Derivative of the gap by the degree of freedom.
    pub normal: f64,
    /// Derivative of the slip by the degree of freedom.
    pub slip: f64,
}

/// The weighted gap of one point.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactRow {
    /// Start and end of the row's terms in the list of all terms.
    pub terms: [u32; 2],
    /// Index of the multiplier.
    pub key: u32,
    /// Index of the contact law.
    pub law: u32,
    /// Whether the row belongs to a single point: its area is then 1 and its multiplier an impulse.
    pub is_single_point: bool,
    /// Kind of the impact, if the surfaces meet.
    pub(super) impact: ImpactKind,
    /// Index of the row's point on an analytical surface, if it has one. The gap is then that at the end of an
    /// increment without contact minus its change, and may be negative.
    pub closest_point: Option<u32>,
    /// Area of the hat function.
    pub area: f64,
    /// Gap times area, corrected by the initial clearance. For a soft law without the overlap that no work was done
    /// for.
    pub gap: f64,
    /// Rate of the gap times area without contact.
    free_rate: f64,
    /// Rate at which the gap times area may close in this increment.
    pub(super) bias: f64,
    /// Change of the rate by an impulse per unit of area, along the normal and along the surface.
    pub(super) compliance: [f64; 2],
    /// Normal impulse that limits friction, as a linear function of the normal impulse: value at zero and derivative;
    /// `None` if the impulse itself is the limit.
    pub(super) slow_impulse: Option<[f64; 2]>,
    /// Impulse per unit of area, along the normal.
    pub normal_impulse: f64,
    /// Impulse per unit of area, along the surface.
    pub shear_impulse: f64,
    /// Impulse per unit of area along the second direction of slip of a row in space.
    pub(super) second_shear_impulse: f64,
    pub(super) sticks: bool,
    /// Impulse per unit of area of [`super::slip_damping`], along the surface.
    pub damping: f64,
    /// Pressure per closing velocity of contact damping in soft contact.
    pub(super) dashpot: f64,
    pub(super) coefficient: f64,
    /// Largest impulse per unit of area along the surface; `None` for that of the law.
    pub(super) largest_shear: Option<f64>,
}

impl ContactRow {
    /// Creates a row without gap and area.
    pub fn of(key: u32, law: u32) -> ContactRow {
        ContactRow { key, law, ..ContactRow::default() }
    }

    /// Returns the impulse of friction and damping per unit of area.
    pub fn whole_shear(&self) -> f64 {
        self.shear_impulse + self.damping
    }

    /// Returns the normal impulse whose product with the friction coefficient limits friction, and its derivative by the
    /// normal impulse. It differs from the normal impulse by at most the fraction [`MOST_DELAYED`].
    pub(super) fn limiting_impulse(&self) -> [f64; 2] {
        let Some([slow, share]) = self.slow_impulse else { return [self.normal_impulse, 1.0] };
        let [least, most] = [1.0 - MOST_DELAYED, 1.0 + MOST_DELAYED];
        let delayed = slow + share * self.normal_impulse;
        if delayed < least * self.normal_impulse {
            [least * self.normal_impulse, least]
        } else if delayed > most * self.normal_impulse {
            [most * self.normal_impulse, most]
        } else {
            [delayed, share]
        }
    }

    /// Whether the row transmits a force. The damping of a row that separates acts in the increment of the separation.
    pub fn acts(&self) -> bool {
        self.normal_impulse > 0.0 || self.damping != 0.0
    }

    /// Returns the fraction of the increment at whose end a soft law is evaluated.
    pub(super) fn evaluation_point(&self, law: &PressureOverclosure) -> f64 {
        law.evaluation_point(-self.gap / self.area)
    }

    /// Computes the rate at which the gap may close.
    pub(super) fn take_bias(&mut self, law: &InteractionLaw, span: ContactInterval) {
        let open = self.gap - law.overclosure.onset_gap() * self.area;
        self.bias = if self.closest_point.is_some() { open } else { open.max(0.0) } / span.dt;
    }

    /// Changes the normal impulse to that which the rate of the gap needs. Returns the size of the change. Equation
    /// (10.3).
    fn press(
        &mut self,
        own: &[GapTerm],
        motion: &mut ContactVelocities,
        law: &InteractionLaw,
        span: ContactInterval,
    ) -> f64 {
        let rate = motion.rate(own);
        let pressed = match &law.overclosure {
            PressureOverclosure::Hard => (self.normal_impulse - (rate + self.bias) / self.compliance[0]).max(0.0),
            soft => soft_impulse(self, soft, rate - self.compliance[0] * self.normal_impulse, span),
        };
        let change = pressed - self.normal_impulse;
        if change != 0.0 {
            self.normal_impulse = pressed;
            motion.push(own, change);
        }
        change.abs()
    }

    /// Changes the shear impulse to that which prevents the slip, within its limit. Returns the size of the change.
    fn shear(&mut self, own: &[GapTerm], motion: &mut ContactVelocities, law: &InteractionLaw, half: f64) -> f64 {
        let limit = shear_limit(self, law, half);
        let sticking_impulse = self.shear_impulse - motion.slip(own) / self.compliance[1];
        let sheared = sticking_impulse.clamp(-limit, limit);
        self.sticks = sticking_impulse == sheared;
        let change = sheared - self.shear_impulse;
        if change != 0.0 {
            self.shear_impulse = sheared;
            motion.shear(own, change);
        }
        change.abs()
    }

    /// Changes the shear impulses along both directions of slip to those that prevent the slip, within their limit. Returns
    /// the size of the larger change.
    fn shear_in_plane(
        &mut self,
        terms: &[GapTerm],
        motion: &mut ContactVelocities,
        law: &InteractionLaw,
        half: f64,
    ) -> f64 {
        let (limit, old) = (shear_limit(self, law, half), [self.shear_impulse, self.second_shear_impulse]);
        let directions = [self.terms_in(terms), self.second_terms_in(terms)];
        let sticking = [0, 1].inline_map(|i: usize| old[i] - motion.slip(directions[i]) / self.compliance[1]);
        let size = sticking[0].portable_hypot(sticking[1]);
        let factor = if size > limit { limit / size } else { 1.0 };
        [self.shear_impulse, self.second_shear_impulse] = sticking.inline_map(|impulse| factor * impulse);
        let changes = [self.shear_impulse - old[0], self.second_shear_impulse - old[1]];
        directions.into_iter().zip(changes).for_each(|(direction, change)| motion.shear(direction, change));
        changes[0].abs().max(changes[1].abs())
    }

    /// Returns the terms of the second direction of slip of a row in space, which follow those of the row.
    pub(super) fn second_terms_in<'a>(&self, terms: &'a [GapTerm]) -> &'a [GapTerm] {
        let [begin, end] = self.terms.inline_map(|at| at as usize);
        &terms[end..2 * end - begin]
    }

    #[inline(always)]
    pub(super) fn terms_in<'a>(&self, terms: &'a [GapTerm]) -> &'a [GapTerm] {
        &terms[self.terms[0] as usize..self.terms[1] as usize]
    }

    pub(super) fn update_compliance(&mut self, own: &[GapTerm], motion: &ContactVelocities) {
        self.compliance = [0.0; 2];
        for t in own {
            let w = motion.inverse_mass[t.dof as usize];
            self.compliance[0] += w * t.normal * t.normal;
            self.compliance[1] += w * t.slip * t.slip;
        }
    }

    /// Computes the compliance and the rate without contact. Returns the largest velocity of the terms.
    fn update_without_contact(&mut self, own: &[GapTerm], motion: &ContactVelocities) -> f64 {
        self.update_compliance(own, motion);
        self.free_rate = motion.rate(own);
        own.iter().fold(0.0, |fastest: f64, t| fastest.max(motion.velocity[t.dof as usize].abs()))
    }
}

/// Velocities and inverse masses of the degrees of freedom in contact.
#[derive(Clone, Debug, Default, Memory)]
pub struct ContactVelocities {
    /// Velocities over the increment.
    pub velocity: Vec<f64>,
    /// One over the mass; 0 for prescribed motions.
    pub inverse_mass: Vec<f64>,
}

impl ContactVelocities {
    /// Returns the rate of a gap times its area.
    pub(super) fn rate(&self, terms: &[GapTerm]) -> f64 {
        terms.iter().map(|t| t.normal * self.velocity[t.dof as usize]).sum()
    }

    /// Returns the slip rate times the area.
    pub fn slip(&self, terms: &[GapTerm]) -> f64 {
        terms.iter().map(|t| t.slip * self.velocity[t.dof as usize]).sum()
    }

    /// Returns the rate of a gap and the slip rate, both times the area.
    #[inline]
    pub(super) fn rates(&self, terms: &[GapTerm]) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for t in terms {
            let velocity = self.velocity[t.dof as usize];
            sums[0] += t.normal * velocity;
            sums[1] += t.slip * velocity;
        }
        sums
    }

    /// Adds the velocities by impulses along the normal and along the surface.
    #[inline]
    pub(super) fn push_and_shear(&mut self, terms: &[GapTerm], [pressed, sheared]: [f64; 2]) {
        for t in terms {
            self.velocity[t.dof as usize] +=
                self.inverse_mass[t.dof as usize] * (t.normal * pressed + t.slip * sheared);
        }
    }

    pub(super) fn push(&mut self, terms: &[GapTerm], impulse: f64) {
        for t in terms {
            self.velocity[t.dof as usize] += self.inverse_mass[t.dof as usize] * t.normal * impulse;
        }
    }

    pub(super) fn shear(&mut self, terms: &[GapTerm], impulse: f64) {
        for t in terms {
            self.velocity[t.dof as usize] += self.inverse_mass[t.dof as usize] * t.slip * impulse;
        }
    }
}

/// Time interval in which impulses act.
#[derive(Clone, Copy, Debug)]
pub struct ContactInterval {
    /// Length of the increment.
    pub dt: f64,
    /// Time over which forces act on velocities: half of the previous and half of the current increment.
    pub half: f64,
}

/// Laws, pressures and time interval that a solution starts from.
#[derive(Clone, Copy, Debug)]
pub struct ContactStep<'a> {
    pub laws: &'a [InteractionLaw],
    /// Pressure and shear stress of each key in the increment before.
    pub pressures: &'a [[f64; 2]],
    pub span: ContactInterval,
}

/// Contact rows of all pairs and their solution.
#[derive(Clone, Debug, Default, Memory)]
pub struct ContactRows {
    pub terms: Vec<GapTerm>,
    /// Rows in the order of the sweeps.
    pub rows: Vec<ContactRow>,
    /// Number of sweeps of the last solution.
    pub sweeps: u32,
    /// Degrees of freedom of free rigid bodies.
    pub bodies: Vec<u32>,
    /// Free rigid bodies that are lighter than the nodes they touch.
    pub(super) light: Vec<LightBody>,
    pub(super) direct: DirectSolver,
    /// For each degree of freedom, its last term.
    slots: Vec<u32>,
    /// Work array: velocity of each degree of freedom under a uniform impulse per area.
    response: Vec<f64>,
    /// First term of the row that is being assembled.
    opened: u32,
}

/// Marks a missing degree of freedom: a rigid body does not move along r.
pub(super) const NONE: u32 = u32::MAX;

/// Largest difference between the normal impulse and the one that limits friction, as a fraction of the former: friction
/// on short contacts, as on eroding surfaces, follows the pressure.
const MOST_DELAYED: f64 = 0.5;
/// Largest change of a rate in a sweep at convergence, as a fraction of the largest approach velocity.
pub(super) const TOLERANCE: f64 = 1e-9;
/// Rounding error of the approach velocity, as a fraction of the largest velocity.
const ROUNDING: f64 = 1e-10;
/// Impulses that a sweep changes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SweptImpulses {
    All,
    Normal,
    Shear,
}

/// Largest number of sweeps.
pub const MOST_SWEEPS: u32 = 200;
/// Largest number of sweeps over rows in space, and [`TOLERANCE`] there: a few points determine the motion of the body, and
/// errors turn it.
const MOST_SWEEPS_IN_SPACE: u32 = 500;
const TOLERANCE_IN_SPACE: f64 = 1e-12;
/// Largest number of iterations for the pressure of a soft law.
const ROUNDS: usize = 30;

impl ContactRows {
    /// Allocates for this number of keys and degrees of freedom.
    pub(super) fn reserve(&mut self, keys: usize, dofs: usize) {
        let rows = most_rows(keys);
        reserve_total(&mut self.terms, 32 * rows);
        reserve_total(&mut self.rows, rows);
        reserve_total(&mut self.light, self.bodies.len());
        self.slots.resize(dofs, NONE);
        self.response.resize(dofs, 0.0);
        self.direct.reserve(rows, dofs);
    }

    /// Allocates for this number of rows in space.
    pub(super) fn reserve_in_space(&mut self, rows: usize, dofs: usize) {
        reserve_total(&mut self.terms, 2 * dofs * rows);
        reserve_total(&mut self.rows, rows);
        self.response.resize(dofs, 0.0);
    }

    pub(super) fn clear(&mut self) {
        self.terms.clear();
        self.rows.clear();
    }

    pub(super) fn open(&mut self) {
        self.opened = self.terms.len() as u32;
    }

    /// Adds the derivatives of the gap by the positions of points.
    #[inline]
    pub(super) fn add_shares(&mut self, shares: impl Iterator<Item = (u32, [f64; 2])>, dofs_of: &[[u32; 2]]) {
        shares.for_each(|(point, of)| self.add_share(dofs_of[point as usize], of));
    }

    /// Adds the derivatives of a gap by the position of a point. The tangent is the normal turned by 90 degrees
    /// counter-clockwise.
    #[inline(always)]
    pub(super) fn add_share(&mut self, [r, z]: [u32; 2], of: [f64; 2]) {
        if !self.add_pair([r, z], of) {
            self.add_term(r, of[0], -of[1]);
            self.add_term(z, of[1], of[0]);
        }
    }

    /// Adds both derivatives at once for a node with two degrees of freedom, whose terms follow each other. Returns
    /// `false` for all other points.
    #[inline(always)]
    fn add_pair(&mut self, [r, z]: [u32; 2], of: [f64; 2]) -> bool {
        if r == NONE || z != r + 1 || of == [0.0; 2] {
            return false;
        }
        let (slots, end) = (&mut self.slots[r as usize..=z as usize], self.terms.len() as u32);
        let ends = slots[0].saturating_add(2);
        if slots[0] >= self.opened
            && ends <= end
            && let [first, second] = &mut self.terms[ends as usize - 2..ends as usize]
            && first.dof == r
            && second.dof == z
        {
            first.normal += of[0];
            first.slip -= of[1];
            second.normal += of[1];
            second.slip += of[0];
            return true;
        }
        let is_in_row =
            |slot: u32, dof| slot >= self.opened && self.terms.get(slot as usize).is_some_and(|t| t.dof == dof);
        if is_in_row(slots[0], r) || is_in_row(slots[1], z) {
            return false;
        }
        slots.copy_from_slice(&[end, end + 1]);
        self.terms.push(GapTerm { dof: r, normal: of[0], slip: -of[1] });
        self.terms.push(GapTerm { dof: z, normal: of[1], slip: of[0] });
        true
    }

    /// Adds derivatives of a gap that belong to no slip.
    pub(super) fn add_normal_share(&mut self, [r, z]: [u32; 2], of: [f64; 2]) {
        self.add_term(r, of[0], 0.0);
        self.add_term(z, of[1], 0.0);
    }

    #[inline]
    fn add_term(&mut self, dof: u32, normal: f64, slip: f64) {
        if dof == NONE || (normal == 0.0 && slip == 0.0) {
            return;
        }
        let slot = &mut self.slots[dof as usize];
        match self.terms.get_mut(*slot as usize) {
            Some(known) if *slot >= self.opened && known.dof == dof => {
                known.normal += normal;
                known.slip += slip;
            }
            _ => {
                *slot = self.terms.len() as u32;
                self.terms.push(GapTerm { dof, normal, slip });
            }
        }
    }

    pub(super) fn close(&mut self, mut row: ContactRow) {
        row.terms = [self.opened, self.terms.len() as u32];
        self.rows.push(row);
    }

    /// Adds the open row after the last row with one of the `keys`, so that the matrix of [`super::direct`] has a narrow
    /// band.
    pub(super) fn close_after(&mut self, row: ContactRow, keys: [u32; 2]) {
        self.close(row);
        let last = self.rows.len() - 1;
        if let Some(at) = self.rows[..last].iter().rposition(|row| keys.contains(&row.key)) {
            self.rows[at + 1..].rotate_right(1);
        }
    }

    /// Solves for the impulses after [`ContactRows::begin`], which returned the `reference` velocity; `motion` then
    /// holds the velocities after them. Sweeps are used if the direct solver fails.
    pub fn solve(&mut self, motion: &mut ContactVelocities, reference: f64, step: ContactStep<'_>) {
        self.begin_warm(motion, step);
        self.find(motion, reference, step);
    }

    /// Solves again from the current impulses, after gaps have changed.
    pub(super) fn solve_again(&mut self, motion: &mut ContactVelocities, reference: f64, step: ContactStep<'_>) {
        self.rows.iter_mut().for_each(|row| row.take_bias(&step.laws[row.law as usize], step.span));
        self.find(motion, reference, step);
    }

    fn find(&mut self, motion: &mut ContactVelocities, reference: f64, step: ContactStep<'_>) {
        if !self.solve_directly(motion, reference, step) {
            self.unload(motion);
            self.solve_by_sweeps(motion, reference, step);
        }
    }

    /// Keeps the rows that may close in this increment. Returns the velocity that errors are relative to; `None` if no
    /// gap closes.
    pub(super) fn begin(&mut self, motion: &ContactVelocities, step: ContactStep<'_>) -> Option<f64> {
        self.sweeps = 0;
        let [approach, fastest] = self.prepare(motion, step);
        self.set_dashpots(motion, step.laws);
        if approach <= 0.0 {
            self.rows.clear();
            return None;
        }
        self.keep_near(approach, step);
        Some(approach.max(ROUNDING * fastest))
    }

    pub(super) fn solve_by_sweeps(&mut self, motion: &mut ContactVelocities, reference: f64, step: ContactStep<'_>) {
        self.hold_light(motion, step.laws);
        self.begin_warm(motion, step);
        self.start_light(motion);
        if !self.sweep_until_converged(motion, reference, step, SweptImpulses::All) {
            self.solve_in_turns(motion, reference, step);
        }
        self.release_light(motion);
    }

    /// Solves for the normal impulses without friction, then for the shear impulses within the limits that follow. Rows that
    /// depend on each other can have large impulses that balance each other, normal ones against shear ones; neither
    /// problem has such solutions. Sweeps over shear impulses within constant limits reduce the kinetic energy at each row,
    /// so that friction creates no energy even if they do not converge. The rates of the gaps that friction then changes are
    /// corrected in the next increment.
    fn solve_in_turns(&mut self, motion: &mut ContactVelocities, reference: f64, step: ContactStep<'_>) {
        self.unload(motion);
        self.sweep_until_converged(motion, reference, step, SweptImpulses::Normal);
        self.sweep_until_converged(motion, reference, step, SweptImpulses::Shear);
    }

    /// Makes at most [`MOST_SWEEPS`] sweeps. Returns whether they converged.
    fn sweep_until_converged(
        &mut self,
        motion: &mut ContactVelocities,
        reference: f64,
        step: ContactStep<'_>,
        swept: SweptImpulses,
    ) -> bool {
        self.sweeps = 0;
        while self.sweeps < MOST_SWEEPS {
            self.sweeps += 1;
            let change = self.sweep(motion, step, swept);
            if change.max(self.move_light(motion)) <= TOLERANCE * reference {
                return true;
            }
        }
        false
    }

    /// Solves for the impulses of rows in space, which have two directions of slip, by sweeps that start from the current
    /// impulses.
    pub(super) fn solve_in_space(&mut self, motion: &mut ContactVelocities, reference: f64, step: ContactStep<'_>) {
        let ContactRows { terms, rows, .. } = self;
        for row in rows.iter_mut() {
            let (friction, second) = (&step.laws[row.law as usize].friction, row.second_terms_in(terms));
            let of_slip = second.iter().map(|t| motion.inverse_mass[t.dof as usize] * t.slip * t.slip);
            row.compliance[1] = of_slip.sum::<f64>().max(row.compliance[1]);
            let slip = motion.slip(row.terms_in(terms)).portable_hypot(motion.slip(second));
            row.coefficient = friction.coefficient(slip / row.area);
        }
        for _ in 0..MOST_SWEEPS_IN_SPACE {
            if self.sweep_in_space(motion, step) <= TOLERANCE_IN_SPACE * reference {
                break;
            }
        }
    }

    /// Makes one sweep over rows in space; returns the largest change of a rate, as a velocity.
    fn sweep_in_space(&mut self, motion: &mut ContactVelocities, step: ContactStep<'_>) -> f64 {
        let ContactRows { terms, rows, .. } = self;
        let mut largest: f64 = 0.0;
        for row in rows {
            let law = &step.laws[row.law as usize];
            let pressed = row.press(row.terms_in(terms), motion, law, step.span) * row.compliance[0];
            largest = largest.max(pressed / row.area);
            if row.coefficient > 0.0 {
                let sheared = row.shear_in_plane(terms, motion, law, step.span.half) * row.compliance[1];
                largest = largest.max(sheared / row.area);
            }
        }
        largest
    }

    fn unload(&mut self, motion: &mut ContactVelocities) {
        let ContactRows { terms, rows, .. } = self;
        for row in rows {
            let row_terms = row.terms_in(terms);
            motion.push(row_terms, -row.normal_impulse);
            motion.shear(row_terms, -row.shear_impulse);
            (row.normal_impulse, row.shear_impulse) = (0.0, 0.0);
        }
    }

    /// Starts from the pressures of the previous increment. A friction coefficient that depends on the slip rate uses
    /// the rate after these impulses.
    pub(super) fn begin_warm(&mut self, motion: &mut ContactVelocities, step: ContactStep<'_>) {
        let ContactRows { terms, rows, .. } = self;
        for row in rows.iter_mut() {
            let row_terms = row.terms_in(terms);
            let [pressure, shear] = step.pressures[row.key as usize];
            row.normal_impulse = pressure * step.span.half;
            let limit = shear_limit(row, &step.laws[row.law as usize], step.span.half);
            row.shear_impulse = (shear * step.span.half).clamp(-limit, limit);
            if row.normal_impulse != 0.0 || row.shear_impulse != 0.0 {
                motion.push_and_shear(row_terms, [row.normal_impulse, row.shear_impulse]);
            }
        }
        for row in rows.iter_mut() {
            let friction = &step.laws[row.law as usize].friction;
            if friction.decay != 0.0 {
                row.coefficient = friction.coefficient(motion.slip(row.terms_in(terms)).abs() / row.area);
            }
        }
    }

    /// Computes compliances and biases; returns the largest approach velocity beyond the allowed rates, and the largest
    /// velocity.
    fn prepare(&mut self, motion: &ContactVelocities, step: ContactStep<'_>) -> [f64; 2] {
        let ContactRows { terms, rows, .. } = self;
        let mut fastest: f64 = 0.0;
        rows.retain_mut(|row| {
            let row_terms = row.terms_in(terms);
            fastest = fastest.max(row.update_without_contact(row_terms, motion));
            row.compliance[0] > 0.0 && row.area > 0.0
        });
        let mut approach: f64 = 0.0;
        for row in rows.iter_mut() {
            let law = &step.laws[row.law as usize];
            row.take_bias(law, step.span);
            row.coefficient = law.friction.at_rest;
            let short = -(row.free_rate + row.bias) / row.area;
            // Soft contact has pressure wherever it is closed, at any rate.
            let closed = law.is_soft() && row.bias <= 0.0;
            let by_closure =
                if closed { (-row.gap / row.area + law.overclosure.onset_gap()) / step.span.dt } else { 0.0 };
            approach = approach.max(short).max(by_closure);
        }
        [approach, fastest]
    }

    /// Sets the damping of soft contact, which acts while surfaces overlap at the start of the increment. The mass per
    /// area is that which a uniform pressure on all rows moves. Equation (10.15).
    fn set_dashpots(&mut self, motion: &ContactVelocities, laws: &[InteractionLaw]) {
        let law_of = |row: &ContactRow| &laws[row.law as usize];
        let is_damped = |row: &ContactRow| law_of(row).damping.is_some() && law_of(row).is_soft();
        let ContactRows { terms, rows, response, .. } = self;
        if !rows.iter().any(is_damped) {
            return;
        }
        response.fill(0.0);
        for term in rows.iter().flat_map(|row| row.terms_in(terms)) {
            response[term.dof as usize] += motion.inverse_mass[term.dof as usize] * term.normal;
        }
        for row in rows.iter_mut() {
            let mass = || {
                let uniform: f64 = row.terms_in(terms).iter().map(|t| t.normal * response[t.dof as usize]).sum();
                row.area / uniform
            };
            row.dashpot = dashpot(law_of(row), -row.gap / row.area, mass);
        }
    }

    /// Leaves out rows that cannot close in this increment.
    fn keep_near(&mut self, approach: f64, step: ContactStep<'_>) {
        self.rows.retain(|row| {
            let begins = step.laws[row.law as usize].overclosure.onset_gap() * row.area;
            row.gap - begins + step.span.dt * row.free_rate <= 2.0 * step.span.dt * row.area * approach
        });
    }

    /// Makes one sweep; returns the largest change of a rate, as a velocity.
    fn sweep(&mut self, motion: &mut ContactVelocities, step: ContactStep<'_>, swept: SweptImpulses) -> f64 {
        let ContactRows { terms, rows, .. } = self;
        let mut largest: f64 = 0.0;
        for row in rows.iter_mut() {
            let row_terms = row.terms_in(terms);
            let law = &step.laws[row.law as usize];
            if swept != SweptImpulses::Shear {
                let change = row.press(row_terms, motion, law, step.span);
                largest = largest.max(change * row.compliance[0] / row.area);
            }
            if swept != SweptImpulses::Normal && row.coefficient > 0.0 && row.compliance[1] > 0.0 {
                let change = row.shear(row_terms, motion, law, step.span.half);
                largest = largest.max(change * row.compliance[1] / row.area);
            }
        }
        largest
    }

    pub fn terms_of(&self, row: &ContactRow) -> &[GapTerm] {
        row.terms_in(&self.terms)
    }
}

/// Returns the largest number of rows that are in contact at a time. If element deletion can expose inner facets, keys
/// are many, but rows in contact about as many as on the initial surface.
pub(super) fn most_rows(keys: usize) -> usize {
    keys.min(1000 + 16 * keys.isqrt())
}

/// Reserves a total capacity of `entries`.
pub(super) fn reserve_total<T>(list: &mut Vec<T>, entries: usize) {
    list.reserve_exact(entries.saturating_sub(list.len()));
}

/// Returns the overlap at which a soft law is evaluated, if the gap changes at this rate.
pub(super) fn closed_overlap(row: &ContactRow, law: &PressureOverclosure, rate: f64, span: ContactInterval) -> f64 {
    -(row.gap + row.evaluation_point(law) * span.dt * rate) / row.area
}

/// Returns the pressure of a soft law with its damping, if the gap changes at this rate, and the slope of the law. Surfaces
/// do not attract each other. Equation (10.14).
pub(super) fn soft_pressure(row: &ContactRow, law: &PressureOverclosure, rate: f64, span: ContactInterval) -> [f64; 2] {
    let [pressure, slope] = law.pressure(closed_overlap(row, law, rate, span));
    [(pressure - row.dashpot * (rate / row.area)).max(0.0), slope]
}

/// Returns the pressure per closing velocity of contact damping at an overlap, for the mass per area in contact.
pub(super) fn dashpot(law: &InteractionLaw, overlap: f64, mass: impl FnOnce() -> f64) -> f64 {
    match law.damping {
        Some(damping) if law.is_soft() && overlap > -law.overclosure.onset_gap() => {
            damping.coefficient(law.overclosure.linearized(overlap)[1], mass())
        }
        _ => 0.0,
    }
}

/// Returns the largest possible impulse along the surface. Equation (10.4).
pub(super) fn shear_limit(row: &ContactRow, law: &InteractionLaw, half: f64) -> f64 {
    let limit = if row.normal_impulse > 0.0 { row.coefficient * row.limiting_impulse()[0] } else { 0.0 };
    limit.min(largest_shear(row, law, half))
}

/// Returns the largest impulse along the surface for any pressure.
pub(super) fn largest_shear(row: &ContactRow, law: &InteractionLaw, half: f64) -> f64 {
    row.largest_shear.unwrap_or(law.friction.largest * half)
}

/// Returns the normal impulse of a soft law. The pressure is evaluated at an overlap late enough in the increment that
/// the stiffness does not limit the time increment. `free` is the rate without the impulse. The root is unique because
/// the pressure decreases with the impulse.
pub(super) fn soft_impulse(row: &ContactRow, law: &PressureOverclosure, free: f64, span: ContactInterval) -> f64 {
    let pressure_at = |impulse: f64| soft_pressure(row, law, free + row.compliance[0] * impulse, span);
    let steeper = span.half * row.evaluation_point(law) * span.dt * row.compliance[0] / row.area;
    let resistance = span.half * row.compliance[0] / row.area * row.dashpot;
    let [first, _] = pressure_at(0.0);
    let (mut low, mut high) = (0.0, span.half * first);
    let mut impulse = row.normal_impulse.clamp(low, high);
    for _ in 0..ROUNDS {
        let [pressure, slope] = pressure_at(impulse);
        let excess = impulse - span.half * pressure;
        if excess > 0.0 {
            high = impulse;
        } else {
            low = impulse;
        }
        let mut next = impulse - excess / (1.0 + slope * steeper + resistance);
        if !(low..=high).contains(&next) {
            next = 0.5 * (low + high);
        }
        if (next - impulse).abs() <= 1e-14 * high {
            return next;
        }
        impulse = next;
    }
    impulse
}
