//! The impulses with which surfaces end an increment without going on into each other: projected Gauss-Seidel sweeps over the
//! gaps of all pairs, in a fixed order, warm from the pressures of the increment before (Jean 1999, Comput. Methods Appl. Mech.
//! Engrg. 177, 235).
//! Never here: where gaps come from.

use super::direct::Direct;
use super::light::Light;
use crate::kernel::interaction::{Law, Overclosure};
use crate::kernel::lists::MemoryUse;

/// The share of one degree of freedom in a gap, along the normal and along the surface.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    pub dof: u32,
    /// Derivative of the gap by it.
    pub normal: f64,
    /// Derivative of the slip by it.
    pub slip: f64,
}

/// The weighted gap of one point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Row {
    /// Where its terms begin and end.
    pub terms: [u32; 2],
    /// Which of the points that carry multipliers it is.
    pub key: u32,
    pub law: u32,
    /// Whether it is of a point that meets by itself: its area is one, its multiplier an impulse.
    pub alone: bool,
    /// Which of the places on analytical surfaces it is in front of: its gap is that at the end of an increment without contact, less
    /// what that closes it by, and may lie below zero.
    pub foot: Option<u32>,
    /// Area of its hat function.
    pub area: f64,
    /// Gap times area, less what was there at the start where that is taken off.
    pub gap: f64,
    /// Rate at which the gap times area may close in this increment.
    pub(super) bias: f64,
    /// Change of the rate by an impulse a unit of area, along the normal and along the surface.
    pub(super) gives: [f64; 2],
    /// Impulses a unit of area.
    pub pressed: f64,
    /// Along the surface.
    pub sheared: f64,
    pub(super) sticks: bool,
    pub(super) coefficient: f64,
}

impl Row {
    /// A row without gap or area.
    pub fn of(key: u32, law: u32) -> Row {
        Row { key, law, ..Row::default() }
    }

    /// Takes the rate at which it may close.
    fn take_bias(&mut self, law: &Law, span: Span) {
        let open = self.gap - law.overclosure.begins() * self.area;
        self.bias = if self.foot.is_some() { open } else { open.max(0.0) } / span.ahead;
    }

    #[inline(always)]
    pub(super) fn own<'a>(&self, terms: &'a [Term]) -> &'a [Term] {
        &terms[self.terms[0] as usize..self.terms[1] as usize]
    }

    pub(super) fn give(&mut self, own: &[Term], motion: &Motion) {
        self.gives = [0.0; 2];
        for t in own {
            let w = motion.inverse_mass[t.dof as usize];
            self.gives[0] += w * t.normal * t.normal;
            self.gives[1] += w * t.slip * t.slip;
        }
    }
}

/// All that moves in contact: velocities and inverse masses of its degrees of freedom.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Velocities over the increment.
    pub velocity: Vec<f64>,
    /// One over the mass; 0 of what is prescribed.
    pub inverse_mass: Vec<f64>,
}

impl Motion {
    /// Rate of a gap times its area.
    pub(super) fn rate(&self, terms: &[Term]) -> f64 {
        terms.iter().map(|t| t.normal * self.velocity[t.dof as usize]).sum()
    }

    /// Rate of the slip times the area.
    pub fn slip(&self, terms: &[Term]) -> f64 {
        terms.iter().map(|t| t.slip * self.velocity[t.dof as usize]).sum()
    }

    pub(super) fn push(&mut self, terms: &[Term], impulse: f64) {
        for t in terms {
            self.velocity[t.dof as usize] += self.inverse_mass[t.dof as usize] * t.normal * impulse;
        }
    }

    pub(super) fn shear(&mut self, terms: &[Term], impulse: f64) {
        for t in terms {
            self.velocity[t.dof as usize] += self.inverse_mass[t.dof as usize] * t.slip * impulse;
        }
    }
}

/// The increment that impulses act in.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    pub ahead: f64,
    /// Time over which forces act on velocities: half of both increments around.
    pub half: f64,
}

#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    pub laws: &'a [Law],
    /// Pressure and shear stress of each key in the increment before.
    pub before: &'a [[f64; 2]],
    pub span: Span,
}

#[derive(Clone, Debug, Default)]
pub struct Rows {
    pub terms: Vec<Term>,
    /// In the order in which sweeps take them.
    pub rows: Vec<Row>,
    pub sweeps: u32,
    /// Degrees of freedom of rigid bodies that move freely.
    pub bodies: Vec<u32>,
    /// Those of them that are lighter than what they meet.
    pub(super) light: Vec<Light>,
    pub(super) direct: Direct,
    /// Of each degree of freedom its last term.
    slots: Vec<u32>,
    /// The first term of the row that is being made.
    opened: u32,
}

/// No degree of freedom: a rigid body does not move along r.
pub(super) const NONE: u32 = u32::MAX;

/// Change of the rates in a sweep, as a part of the fastest approach, at which sweeps end.
pub(super) const TOLERANCE: f64 = 1e-9;
/// Part of the fastest velocity of all that rounding can make of the approach.
const ROUNDING: f64 = 1e-10;
pub const MOST_SWEEPS: u32 = 200;
/// Rounds for the root of a pressure-overclosure relationship.
const ROUNDS: usize = 30;

impl Rows {
    /// Room for this many keys and degrees of freedom. Where deletion can uncover what lies within a body keys are many, and those in
    /// contact at a time about as many as its outside has.
    pub(super) fn reserve(&mut self, keys: usize, dofs: usize) {
        let rows = keys.min(1000 + 16 * keys.isqrt());
        reserve_total(&mut self.terms, 32 * rows);
        reserve_total(&mut self.rows, rows);
        reserve_total(&mut self.light, self.bodies.len());
        self.slots.resize(dofs, NONE);
        self.direct.reserve(rows, dofs);
    }

    pub(super) fn clear(&mut self) {
        self.terms.clear();
        self.rows.clear();
    }

    pub(super) fn open(&mut self) {
        self.opened = self.terms.len() as u32;
    }

    /// Adds the share of a point with these degrees of freedom. The direction along the surface is the normal's, a quarter turn
    /// counter-clockwise.
    #[inline]
    pub(super) fn add_share(&mut self, [r, z]: [u32; 2], of: [f64; 2]) {
        self.add_term(r, of[0], -of[1]);
        self.add_term(z, of[1], of[0]);
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
                self.terms.push(Term { dof, normal, slip });
            }
        }
    }

    pub(super) fn close(&mut self, mut row: Row) {
        row.terms = [self.opened, self.terms.len() as u32];
        self.rows.push(row);
    }

    /// Finds the impulses; velocities in `motion` are those they give. Nothing is done where nothing approaches. Sweeps begin where
    /// the direct solution finds no end. Returns the velocity that errors are held against; `None` where nothing approaches.
    pub fn solve(&mut self, motion: &mut Motion, given: Given<'_>) -> Option<f64> {
        self.sweeps = 0;
        let reference = self.begin(motion, given)?;
        self.begin_warm(motion, given);
        self.find(motion, reference, given);
        Some(reference)
    }

    /// Finds the impulses from those that rows have, whose gaps may be others than they were found for.
    pub(super) fn solve_again(&mut self, motion: &mut Motion, reference: f64, given: Given<'_>) {
        self.rows.iter_mut().for_each(|row| row.take_bias(&given.laws[row.law as usize], given.span));
        self.find(motion, reference, given);
    }

    fn find(&mut self, motion: &mut Motion, reference: f64, given: Given<'_>) {
        if !self.solve_directly(motion, reference, given) {
            self.unload(motion);
            self.solve_by_sweeps(motion, reference, given);
        }
    }

    /// Keeps the rows that this increment may close. Returns the velocity that errors are held against; `None` where nothing
    /// approaches.
    pub(super) fn begin(&mut self, motion: &Motion, given: Given<'_>) -> Option<f64> {
        let approach = self.prepare(motion, given);
        if approach <= 0.0 {
            self.rows.clear();
            return None;
        }
        let fastest = self.terms.iter().fold(0.0_f64, |v, t| v.max(motion.velocity[t.dof as usize].abs()));
        self.keep_near(motion, approach, given);
        Some(approach.max(ROUNDING * fastest))
    }

    pub(super) fn solve_by_sweeps(&mut self, motion: &mut Motion, reference: f64, given: Given<'_>) {
        self.hold_light(motion, given.laws);
        self.begin_warm(motion, given);
        self.start_light(motion);
        while self.sweeps < MOST_SWEEPS {
            self.sweeps += 1;
            let change = self.sweep(motion, given);
            if change.max(self.move_light(motion)) <= TOLERANCE * reference {
                break;
            }
        }
        self.release_light(motion);
    }

    fn unload(&mut self, motion: &mut Motion) {
        let Rows { terms, rows, .. } = self;
        for row in rows {
            let own = row.own(terms);
            motion.push(own, -row.pressed);
            motion.shear(own, -row.sheared);
            (row.pressed, row.sheared) = (0.0, 0.0);
        }
    }

    /// Begins with the pressures of the increment before. Friction that depends on the rate of slip takes that which they leave.
    pub(super) fn begin_warm(&mut self, motion: &mut Motion, given: Given<'_>) {
        let Rows { terms, rows, .. } = self;
        for row in rows.iter_mut() {
            let own = row.own(terms);
            let [pressure, shear] = given.before[row.key as usize];
            row.pressed = pressure * given.span.half;
            let most = most_shear(row, &given.laws[row.law as usize], given.span.half);
            row.sheared = (shear * given.span.half).clamp(-most, most);
            motion.push(own, row.pressed);
            motion.shear(own, row.sheared);
        }
        for row in rows.iter_mut() {
            let own = row.own(terms);
            let friction = &given.laws[row.law as usize].friction;
            if friction.decay != 0.0 {
                row.coefficient = friction.coefficient(motion.slip(own).abs() / row.area);
            }
        }
    }

    /// What rows need; returns the fastest approach beyond what is let through, as a velocity.
    fn prepare(&mut self, motion: &Motion, given: Given<'_>) -> f64 {
        let Rows { terms, rows, .. } = self;
        rows.retain_mut(|row| {
            let own = row.own(terms);
            row.give(own, motion);
            row.gives[0] > 0.0 && row.area > 0.0
        });
        let mut approach: f64 = 0.0;
        for row in rows.iter_mut() {
            let own = row.own(terms);
            let law = &given.laws[row.law as usize];
            row.take_bias(law, given.span);
            row.coefficient = law.friction.at_rest;
            let short = -(motion.rate(own) + row.bias) / row.area;
            // What gives way presses wherever it is closed, at whatever rate.
            let closed = law.overclosure != Overclosure::Hard && row.bias <= 0.0;
            let by_closure =
                if closed { (-row.gap / row.area + law.overclosure.begins()) / given.span.ahead } else { 0.0 };
            approach = approach.max(short).max(by_closure);
        }
        approach
    }

    /// Leaves out rows that nothing in this increment can close.
    fn keep_near(&mut self, motion: &Motion, approach: f64, given: Given<'_>) {
        let Rows { terms, rows, .. } = self;
        rows.retain(|row| {
            let own = row.own(terms);
            let begins = given.laws[row.law as usize].overclosure.begins() * row.area;
            row.gap - begins + given.span.ahead * motion.rate(own) <= 2.0 * given.span.ahead * row.area * approach
        });
    }

    /// One sweep; returns the largest change of a rate, as a velocity.
    fn sweep(&mut self, motion: &mut Motion, given: Given<'_>) -> f64 {
        let Rows { terms, rows, .. } = self;
        let mut largest: f64 = 0.0;
        for row in rows.iter_mut() {
            let own = row.own(terms);
            let law = &given.laws[row.law as usize];
            let rate = motion.rate(own);
            let pressed = match &law.overclosure {
                Overclosure::Hard => (row.pressed - (rate + row.bias) / row.gives[0]).max(0.0),
                soft => give_way(row, soft, rate - row.gives[0] * row.pressed, given.span),
            };
            let change = pressed - row.pressed;
            if change != 0.0 {
                row.pressed = pressed;
                motion.push(own, change);
                largest = largest.max(change.abs() * row.gives[0] / row.area);
            }
            if row.coefficient > 0.0 && row.gives[1] > 0.0 {
                let most = most_shear(row, law, given.span.half);
                let held = row.sheared - motion.slip(own) / row.gives[1];
                let sheared = held.clamp(-most, most);
                row.sticks = held == sheared;
                let change = sheared - row.sheared;
                if change != 0.0 {
                    row.sheared = sheared;
                    motion.shear(own, change);
                    largest = largest.max(change.abs() * row.gives[1] / row.area);
                }
            }
        }
        largest
    }

    pub fn terms_of(&self, row: &Row) -> &[Term] {
        row.own(&self.terms)
    }

    /// Memory of the arrays.
    pub fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.terms)
            + MemoryUse::of(&self.rows)
            + MemoryUse::of(&self.bodies)
            + MemoryUse::of(&self.light)
            + MemoryUse::of(&self.slots)
            + self.direct.memory()
    }
}

/// Reserves capacity for so many entries in all, whatever the list holds.
fn reserve_total<T>(list: &mut Vec<T>, entries: usize) {
    list.reserve_exact(entries.saturating_sub(list.len()));
}

/// The overlap at which a law presses that gives way, where the gap grows at a rate.
pub(super) fn closed_overlap(row: &Row, law: &Overclosure, rate: f64, span: Span) -> f64 {
    -(row.gap + law.look_ahead() * span.ahead * rate) / row.area
}

/// The largest impulse along the surface.
pub(super) fn most_shear(row: &Row, law: &Law, half: f64) -> f64 {
    let most = if row.pressed > 0.0 { row.coefficient * row.pressed } else { 0.0 };
    most.min(law.friction.largest * half)
}

/// The impulse of a law that gives way: the pressure at an overlap late enough in the increment that no stiffness limits it. `free` is the rate without it. One root: the pressure falls as the impulse grows.
fn give_way(row: &Row, law: &Overclosure, free: f64, span: Span) -> f64 {
    let overlap = |impulse: f64| closed_overlap(row, law, free + row.gives[0] * impulse, span);
    let steeper = span.half * law.look_ahead() * span.ahead * row.gives[0] / row.area;
    let [first, _] = law.pressure(overlap(0.0));
    let (mut low, mut high) = (0.0, span.half * first);
    let mut impulse = row.pressed.clamp(low, high);
    for _ in 0..ROUNDS {
        let [pressure, slope] = law.pressure(overlap(impulse));
        let left = impulse - span.half * pressure;
        if left > 0.0 {
            high = impulse;
        } else {
            low = impulse;
        }
        let mut next = impulse - left / (1.0 + slope * steeper);
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
