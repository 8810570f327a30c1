//! Direct solution for the contact impulses. Surfaces of revolution are curves, so a row shares degrees of freedom only
//! with rows near it. The matrix is therefore banded, and its factorisation costs little more than one sweep. The
//! status of rows (open, sliding, sticking) starts from the previous increment and is corrected in iterations: the
//! semi-smooth Newton method for frictional contact (Alart and Curnier 1991, Comput. Methods Appl. Mech. Engrg. 92,
//! 353; as active sets Hüeber and Wohlmuth 2005, Comput. Methods Appl. Mech. Engrg. 194, 3147). Free rigid bodies are
//! columns outside the band, for any mass. If the iterations do not end, or rows depend on each other,
//! [`super::sweeps`] solves instead.

use super::sweeps::{
    ContactInterval, ContactRow, ContactRows, ContactStep, ContactVelocities, GapTerm, TOLERANCE, closed_overlap,
    largest_shear, shear_limit, soft_pressure,
};
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};
use crate::kernel::lanes::inline_from_fn;
use crate::kernel::lists::Memory;
use nalgebra::{SMatrix, SVector};

/// Status of a contact row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ContactStatus {
    Open,
    /// In contact and sliding; the friction impulse has its largest size in this direction (1, -1, or 0 without
    /// friction).
    Slides(f64),
    Sticks,
}

/// Unknown of the linear system: a normal impulse, or the shear impulse of a sticking row.
#[derive(Clone, Copy, Debug)]
struct ContactUnknown {
    row: u32,
    shears: bool,
    /// Derivative of the shear impulse by the normal impulse in a sliding row.
    friction_slope: f64,
}

impl ContactUnknown {
    /// Returns the coefficient of a degree of freedom in the rate that the unknown controls.
    fn test(&self, term: &GapTerm) -> f64 {
        if self.shears { term.slip } else { term.normal }
    }

    /// Returns the impulse on a degree of freedom from a unit of the unknown.
    fn impulse(&self, term: &GapTerm) -> f64 {
        if self.shears { term.slip } else { term.normal + self.friction_slope * term.slip }
    }

    /// Returns the change of the rate that the unknown controls by a unit of the unknown `of` of another row.
    #[inline]
    fn entry(&self, of: &ContactUnknown, block: &CouplingBlock) -> f64 {
        let [by_pressure, by_shear] = block[usize::from(self.shears)];
        if of.shears { by_shear } else { by_pressure + of.friction_slope * by_shear }
    }
}

/// Changes of the rates of a row, along the normal and along the surface, by a unit of the normal impulse and of the
/// shear impulse of another row.
type CouplingBlock = [[f64; 2]; 2];

/// Entry in the linked list of the rows that move a degree of freedom.
#[derive(Clone, Copy, Debug)]
struct RowLink {
    next: u32,
    row: u32,
    normal: f64,
    slip: f64,
}

/// The rows that a row is coupled with: from the `first` one up to itself.
#[derive(Clone, Copy, Debug)]
struct CoupledRows {
    first: u32,
    /// Index of the block of the first row.
    begin: u32,
}

/// Work arrays of the direct contact solver.
#[derive(Clone, Debug, Default, Memory)]
pub(super) struct DirectSolver {
    status: Vec<ContactStatus>,
    /// Rates of each row along the normal and along the surface, times its area.
    rates: Vec<[f64; 2]>,
    /// Rows that each row is coupled with, of lower or equal index.
    coupled: Vec<CoupledRows>,
    /// Blocks of all rows, one row after the other. They do not depend on the status of rows.
    blocks: Vec<CouplingBlock>,
    unknowns: Vec<ContactUnknown>,
    /// Index of the first unknown of each row; one more entry at the end.
    unknowns_of_row: Vec<u32>,
    /// For each unknown, the last one that it is coupled with.
    last_coupled: Vec<u32>,
    /// For each degree of freedom, the first of the rows that move it.
    first: Vec<u32>,
    /// For each degree of freedom, the last entry of its chain in `links`.
    last: Vec<u32>,
    links: Vec<RowLink>,
    /// Banded matrix, row by row; a row has twice the half width plus one entries.
    band: Vec<f64>,
    /// Largest number of matrix entries.
    band_capacity: usize,
    /// Largest number of blocks.
    block_capacity: usize,
    half_width: usize,
    /// Diagonal of the matrix before elimination.
    diagonal: Vec<f64>,
    /// Right-hand side, and one column for each rigid body.
    columns: Vec<[f64; COLUMNS]>,
    /// Impulses of the unknowns on the rigid bodies.
    on_bodies: Vec<[f64; BODIES]>,
}

/// Largest number of rigid bodies with columns outside the band.
const BODIES: usize = 4;
const COLUMNS: usize = BODIES + 1;
const ROUNDS: u32 = 16;
/// Matrix entries allocated for each row of contact: half widths up to 11 if all rows stick, up to 23 without sticking
/// rows.
const ENTRIES_PER_ROW: usize = 48;
/// Blocks allocated for each row of contact.
const BLOCKS_PER_ROW: usize = 24;
/// Smallest fraction of a diagonal that elimination may leave, without and with sticking rows. If less is left, rows depend
/// on each other. Pressures alone do not then grow, but pressures and shear impulses of rows that almost prevent the same
/// motion can be large and balance each other.
const LEAST_PIVOTS: [f64; 2] = [1e-9, 1e-6];
const NONE: u32 = u32::MAX;

impl DirectSolver {
    /// Allocates for this number of rows and degrees of freedom; a copied contact has no capacity.
    pub(super) fn reserve(&mut self, rows: usize, dofs: usize) {
        // The capacity decides which solver is used, so it must not depend on previous allocations.
        *self = DirectSolver { band_capacity: ENTRIES_PER_ROW * rows, ..DirectSolver::default() };
        self.status.reserve(rows);
        self.rates.reserve(rows);
        self.coupled.reserve(rows);
        self.block_capacity = BLOCKS_PER_ROW * rows;
        self.blocks.reserve(self.block_capacity);
        self.unknowns.reserve(2 * rows);
        self.unknowns_of_row.reserve(rows + 1);
        self.last_coupled.reserve(2 * rows);
        self.links.reserve(32 * rows);
        self.band.reserve(self.band_capacity);
        self.diagonal.reserve(2 * rows);
        self.columns.reserve(2 * rows);
        self.on_bodies.reserve(2 * rows);
        self.first.resize(dofs, NONE);
        self.last.resize(dofs, NONE);
    }
}

/// Returns the derivative of the shear impulse by the normal impulse at the friction limit.
fn friction_slope(row: &ContactRow, law: &InteractionLaw, direction: f64, half: f64) -> f64 {
    let [limiting, share] = row.limiting_impulse();
    let capped = row.coefficient * limiting >= largest_shear(row, law, half);
    if capped || direction == 0.0 { 0.0 } else { direction * row.coefficient * share }
}

/// Returns the status of a row that closes, from the impulses that it needs without other rows.
fn initial_status(row: &ContactRow, law: &InteractionLaw, rate: f64, slip: f64) -> ContactStatus {
    if row.coefficient <= 0.0 || row.compliance[1] <= 0.0 {
        return ContactStatus::Slides(0.0);
    }
    let sticking_impulse = -slip / row.compliance[1];
    let pressed = -(rate + row.bias) / row.compliance[0];
    let slides = !law.is_soft() && sticking_impulse.abs() > row.coefficient * pressed;
    if slides { ContactStatus::Slides(sticking_impulse.signum()) } else { ContactStatus::Sticks }
}

/// Returns whether a closed row opens: a hard row with a tensile impulse, or a soft one with a gap.
fn opens(row: &ContactRow, law: &PressureOverclosure, rate: f64, span: ContactInterval) -> bool {
    match law {
        PressureOverclosure::Hard => row.normal_impulse <= 0.0,
        soft => closed_overlap(row, soft, rate, span) <= -soft.onset_gap() || is_pulled_open(row, soft, rate, span),
    }
}

/// Returns whether damping would make the pressure of a soft law negative.
fn is_pulled_open(row: &ContactRow, law: &PressureOverclosure, rate: f64, span: ContactInterval) -> bool {
    row.dashpot > 0.0 && soft_pressure(row, law, rate, span)[0] == 0.0
}

impl ContactRows {
    /// Solves for the impulses, starting from those stored in the rows. Returns whether the solution converged to
    /// [`TOLERANCE`] times the `reference` velocity.
    pub(super) fn solve_directly(
        &mut self,
        motion: &mut ContactVelocities,
        reference: f64,
        step: ContactStep<'_>,
    ) -> bool {
        if self.bodies.len() > BODIES {
            return false;
        }
        if !self.couple(motion) {
            return false;
        }
        self.guess(step);
        self.update_rates(motion);
        let allowed = TOLERANCE * reference;
        for round in 0..ROUNDS {
            let changed = self.update_statuses(allowed, step);
            if self.enforce_statuses(motion, step) {
                self.update_rates(motion);
            }
            if !changed && round > 0 && self.largest_error(step) <= allowed {
                self.direct
                    .status
                    .iter()
                    .zip(&mut self.rows)
                    .for_each(|(s, row)| row.sticks = *s == ContactStatus::Sticks);
                return true;
            }
            if !self.step(motion, step) {
                return false;
            }
        }
        false
    }

    /// Computes the blocks between rows that move the same degrees of freedom. Returns whether they fit into their
    /// allocation.
    fn couple(&mut self, motion: &ContactVelocities) -> bool {
        let ContactRows { rows, terms, direct, bodies, .. } = self;
        let DirectSolver { coupled, blocks, first, last, links, block_capacity, .. } = direct;
        coupled.clear();
        blocks.clear();
        links.clear();
        // A prescribed motion, for example that of a fixed rigid body, couples no rows.
        let couples = |term: &&GapTerm| {
            motion.inverse_mass[term.dof as usize] != 0.0 && (bodies.is_empty() || !bodies.contains(&term.dof))
        };
        let mut fits = true;
        for (at, row) in rows.iter().enumerate() {
            let row_terms = row.terms_in(terms);
            let mut lowest = at as u32;
            for term in row_terms.iter().filter(couples) {
                let known = &mut first[term.dof as usize];
                if *known == NONE {
                    *known = at as u32;
                }
                lowest = lowest.min(*known);
            }
            let begin = blocks.len();
            coupled.push(CoupledRows { first: lowest, begin: begin as u32 });
            let count = at + 1 - lowest as usize;
            fits = begin + count <= *block_capacity;
            if !fits {
                break;
            }
            blocks.resize(begin + count, [[0.0; 2]; 2]);
            for term in row_terms.iter().filter(couples) {
                let (dof, GapTerm { normal, slip, .. }) = (term.dof as usize, *term);
                let w = motion.inverse_mass[dof];
                let (pressed, sheared) = (w * normal, w * slip);
                let mut add = |row: usize, normal: f64, slip: f64| {
                    let block = &mut blocks[begin + row - lowest as usize];
                    block[0][0] += pressed * normal;
                    block[0][1] += pressed * slip;
                    block[1][0] += sheared * normal;
                    block[1][1] += sheared * slip;
                };
                add(at, normal, slip);
                let mut next = last[dof];
                last[dof] = links.len() as u32;
                links.push(RowLink { next, row: at as u32, normal, slip });
                while next != NONE {
                    let link = links[next as usize];
                    add(link.row as usize, link.normal, link.slip);
                    next = link.next;
                }
            }
        }
        for term in rows.iter().flat_map(|row| row.terms_in(terms)) {
            (first[term.dof as usize], last[term.dof as usize]) = (NONE, NONE);
        }
        fits
    }

    fn update_rates(&mut self, motion: &ContactVelocities) {
        let ContactRows { rows, terms, direct, .. } = self;
        direct.rates.clear();
        direct.rates.extend(rows.iter().map(|row| motion.rates(row.terms_in(terms))));
    }

    /// Sets statuses from the impulses of the previous increment.
    fn guess(&mut self, step: ContactStep<'_>) {
        let ContactRows { rows, direct, .. } = self;
        direct.status.clear();
        for row in rows.iter() {
            let limit = shear_limit(row, &step.laws[row.law as usize], step.span.half);
            direct.status.push(match row.normal_impulse > 0.0 {
                false => ContactStatus::Open,
                // No friction impulse is possible if the motion along the surface is prescribed.
                true if row.compliance[1] <= 0.0 => ContactStatus::Slides(0.0),
                true if row.shear_impulse.abs() < limit * (1.0 - 1e-9) => ContactStatus::Sticks,
                true => ContactStatus::Slides(row.shear_impulse.signum()),
            });
        }
    }

    /// Changes the statuses that contradict the impulses. Returns whether any changed.
    fn update_statuses(&mut self, allowed: f64, step: ContactStep<'_>) -> bool {
        let ContactRows { rows, direct, .. } = self;
        let mut changed = false;
        for ((row, status), &[rate, slip]) in rows.iter().zip(&mut direct.status).zip(&direct.rates) {
            let law = &step.laws[row.law as usize];
            let next = match *status {
                ContactStatus::Open => {
                    let closes = match law.overclosure {
                        PressureOverclosure::Hard => rate + row.bias < -allowed * row.area,
                        _ => {
                            let overlap = closed_overlap(row, &law.overclosure, rate, step.span);
                            let overlaps = overlap > allowed * step.span.dt - law.overclosure.onset_gap();
                            overlaps && !is_pulled_open(row, &law.overclosure, rate, step.span)
                        }
                    };
                    if closes { initial_status(row, law, rate, slip) } else { ContactStatus::Open }
                }
                _ if opens(row, &law.overclosure, rate, step.span) => ContactStatus::Open,
                ContactStatus::Sticks => {
                    let limit = shear_limit(row, law, step.span.half);
                    if row.shear_impulse.abs() > limit {
                        ContactStatus::Slides(row.shear_impulse.signum())
                    } else {
                        ContactStatus::Sticks
                    }
                }
                ContactStatus::Slides(direction) => {
                    let stops = direction * slip > allowed * row.area;
                    let sticking_impulse = row.shear_impulse - slip / row.compliance[1];
                    match stops {
                        true if sticking_impulse.abs() > shear_limit(row, law, step.span.half) => {
                            ContactStatus::Slides(sticking_impulse.signum())
                        }
                        true => ContactStatus::Sticks,
                        false => ContactStatus::Slides(direction),
                    }
                }
            };
            changed |= next != *status;
            *status = next;
        }
        changed
    }

    /// Limits the impulses to those that the statuses allow. Returns whether any changed.
    fn enforce_statuses(&mut self, motion: &mut ContactVelocities, step: ContactStep<'_>) -> bool {
        let ContactRows { rows, terms, direct, .. } = self;
        let mut changed = false;
        for (row, status) in rows.iter_mut().zip(&direct.status) {
            let row_terms = row.terms_in(terms);
            let (pressed, sheared) = match *status {
                ContactStatus::Open => (0.0, 0.0),
                ContactStatus::Sticks => (row.normal_impulse.max(0.0), row.shear_impulse),
                ContactStatus::Slides(0.0) => (row.normal_impulse.max(0.0), 0.0),
                ContactStatus::Slides(direction) => (
                    row.normal_impulse.max(0.0),
                    direction * shear_limit(row, &step.laws[row.law as usize], step.span.half),
                ),
            };
            if pressed != row.normal_impulse {
                motion.push(row_terms, pressed - row.normal_impulse);
                row.normal_impulse = pressed;
                changed = true;
            }
            if sheared != row.shear_impulse {
                motion.shear(row_terms, sheared - row.shear_impulse);
                row.shear_impulse = sheared;
                changed = true;
            }
        }
        changed
    }

    /// Returns the largest violation of the status conditions, as a velocity.
    fn largest_error(&self, step: ContactStep<'_>) -> f64 {
        let mut furthest: f64 = 0.0;
        for ((row, status), &[rate, slip]) in self.rows.iter().zip(&self.direct.status).zip(&self.direct.rates) {
            if *status == ContactStatus::Open {
                continue;
            }
            let off = match &step.laws[row.law as usize].overclosure {
                PressureOverclosure::Hard => rate + row.bias,
                soft => {
                    let [pressure, _] = soft_pressure(row, soft, rate, step.span);
                    (row.normal_impulse - step.span.half * pressure) * row.compliance[0]
                }
            };
            furthest = furthest.max(off.abs() / row.area);
            if *status == ContactStatus::Sticks {
                furthest = furthest.max(slip.abs() / row.area);
            }
        }
        furthest
    }

    /// Makes one Newton step to the impulses that satisfy the status conditions. Returns `false` if the matrix is
    /// singular.
    fn step(&mut self, motion: &mut ContactVelocities, step: ContactStep<'_>) -> bool {
        loop {
            self.list_unknowns(step);
            if self.direct.unknowns.is_empty() {
                return true;
            }
            if !self.assemble(step) {
                return false;
            }
            match self.direct.eliminate(1 + self.bodies.len()) {
                Ok(()) => break,
                Err(dependent) if self.direct.unknowns[dependent].shears => {
                    self.leave_to_other_rows(dependent, motion, step);
                }
                Err(_) => return false,
            }
        }
        if !self.bodies.is_empty() {
            let inverse_mass = |at: usize| self.bodies.get(at).map_or(0.0, |b| motion.inverse_mass[*b as usize]);
            let masses = inline_from_fn(inverse_mass);
            if !self.direct.join_bodies(masses) {
                return false;
            }
        }
        let ContactRows { rows, terms, direct, .. } = self;
        for (unknown, [change, ..]) in direct.unknowns.iter().zip(&direct.columns) {
            if !change.is_finite() {
                return false;
            }
            let row = &mut rows[unknown.row as usize];
            let row_terms = row.terms_in(terms);
            let [pressed, sheared] =
                if unknown.shears { [0.0, *change] } else { [*change, unknown.friction_slope * change] };
            row.normal_impulse += pressed;
            row.shear_impulse += sheared;
            motion.push_and_shear(row_terms, [pressed, sheared]);
        }
        self.update_rates(motion);
        true
    }

    /// Removes the shear impulse of a sticking row whose slip other sticking rows already prevent. Such rows have no unique
    /// impulses: large opposite ones would remain, which no longer balance when the areas of the rows change.
    fn leave_to_other_rows(&mut self, unknown: usize, motion: &mut ContactVelocities, step: ContactStep<'_>) {
        let row = self.direct.unknowns[unknown].row as usize;
        self.direct.status[row] = ContactStatus::Slides(0.0);
        if self.enforce_statuses(motion, step) {
            self.update_rates(motion);
        }
    }

    fn list_unknowns(&mut self, step: ContactStep<'_>) {
        let ContactRows { rows, direct, .. } = self;
        direct.unknowns.clear();
        direct.unknowns_of_row.clear();
        for (at, (row, status)) in rows.iter().zip(&direct.status).enumerate() {
            direct.unknowns_of_row.push(direct.unknowns.len() as u32);
            let unknown = |shears, friction_slope| ContactUnknown { row: at as u32, shears, friction_slope };
            match *status {
                ContactStatus::Open => {}
                ContactStatus::Slides(direction) => {
                    let slope = friction_slope(row, &step.laws[row.law as usize], direction, step.span.half);
                    direct.unknowns.push(unknown(false, slope));
                }
                ContactStatus::Sticks => direct.unknowns.extend([unknown(false, 0.0), unknown(true, 0.0)]),
            }
        }
        direct.unknowns_of_row.push(direct.unknowns.len() as u32);
    }

    /// Assembles the band, the right-hand side and the columns of rigid bodies. Returns whether the band fits into its
    /// allocation.
    fn assemble(&mut self, step: ContactStep<'_>) -> bool {
        if !self.direct.assemble_band() {
            return false;
        }
        let ContactRows { rows, terms, direct, bodies, .. } = self;
        let (half, width) = (direct.half_width, 2 * direct.half_width + 1);
        direct.columns.clear();
        direct.on_bodies.clear();
        for (at, unknown) in direct.unknowns.iter().enumerate() {
            let row = &rows[unknown.row as usize];
            let [rate, slip] = direct.rates[unknown.row as usize];
            let (mut column, mut on_bodies) = ([0.0; COLUMNS], [0.0; BODIES]);
            column[0] = if unknown.shears {
                -slip
            } else {
                let law = &step.laws[row.law as usize].overclosure;
                let (required, compliance) = required_change(row, law, rate, step.span);
                direct.band[at * width + half] += compliance;
                required
            };
            for (body, dof) in bodies.iter().enumerate() {
                if let Some(term) = row.terms_in(terms).iter().find(|term| term.dof == *dof) {
                    (column[1 + body], on_bodies[body]) = (unknown.test(term), unknown.impulse(term));
                }
            }
            direct.columns.push(column);
            direct.on_bodies.push(on_bodies);
        }
        direct.diagonal.clear();
        direct.diagonal.extend(direct.band.iter().skip(half).step_by(width).take(direct.unknowns.len()));
        true
    }
}

/// Returns the change of rate that a row still needs, and its own compliance per unit of impulse. Hard surfaces have no
/// compliance; a soft law is linearised at the current overlap.
fn required_change(row: &ContactRow, law: &PressureOverclosure, rate: f64, span: ContactInterval) -> (f64, f64) {
    if *law == PressureOverclosure::Hard {
        return (-(rate + row.bias), 0.0);
    }
    let [pressure, slope] = law.linearized(closed_overlap(row, law, rate, span));
    let gives = row.area / (span.half * row.evaluation_point(law) * span.dt * slope + span.half * row.dashpot);
    let pressure = pressure - row.dashpot * (rate / row.area);
    ((span.half * pressure - row.normal_impulse) * gives, gives)
}

impl DirectSolver {
    /// Assembles the band from the blocks. Returns whether it fits into its allocation.
    fn assemble_band(&mut self) -> bool {
        let DirectSolver { band, unknowns, unknowns_of_row, last_coupled, coupled, blocks, .. } = self;
        let lowest = |row: u32| unknowns_of_row[coupled[row as usize].first as usize] as usize;
        let distances = unknowns.iter().enumerate().map(|(at, unknown)| at - lowest(unknown.row));
        let half = distances.max().unwrap_or(0);
        let width = 2 * half + 1;
        if unknowns.len() * width > self.band_capacity {
            return false;
        }
        self.half_width = half;
        band.clear();
        band.resize(unknowns.len() * width, 0.0);
        last_coupled.clear();
        for (at, unknown) in unknowns.iter().enumerate() {
            let (CoupledRows { first, begin }, from) = (coupled[unknown.row as usize], lowest(unknown.row));
            last_coupled.push(at as u32);
            for (other, of) in (from..at).zip(&unknowns[from..at]) {
                last_coupled[other] = at as u32;
                let block = &blocks[(begin + of.row - first) as usize];
                let transposed = [[block[0][0], block[1][0]], [block[0][1], block[1][1]]];
                band[at * width + half + other - at] = unknown.entry(of, block);
                band[other * width + half + at - other] = of.entry(unknown, &transposed);
            }
            band[at * width + half] = unknown.entry(unknown, &blocks[(begin + unknown.row - first) as usize]);
        }
        true
    }

    /// Eliminates within the band for the first `used` columns.
    ///
    /// # Errors
    /// The index of an unknown that depends on previous ones.
    fn eliminate(&mut self, used: usize) -> Result<(), usize> {
        let (count, half) = (self.unknowns.len(), self.half_width);
        let width = 2 * half + 1;
        let least = LEAST_PIVOTS[usize::from(self.unknowns.iter().any(|unknown| unknown.shears))];
        for p in 0..count {
            let pivot = self.band[p * width + half];
            if pivot.is_nan() || pivot.abs() <= least * self.diagonal[p].abs() {
                return Err(p);
            }
            let coupled = self.last_coupled[p] as usize - p;
            let (above, below) = self.band.split_at_mut((p + 1) * width);
            let pivots = &above[p * width + half + 1..p * width + half + 1 + coupled];
            let (solved, later) = self.columns.split_at_mut(p + 1);
            let solved = &solved[p];
            for (i, (row, column)) in below.chunks_exact_mut(width).zip(&mut later[..coupled]).enumerate() {
                let begin = half - 1 - i;
                let factor = row[begin] / pivot;
                if factor == 0.0 {
                    continue;
                }
                for (entry, above) in row[begin + 1..begin + 1 + coupled].iter_mut().zip(pivots) {
                    *entry -= factor * above;
                }
                for (entry, above) in column[..used].iter_mut().zip(solved) {
                    *entry -= factor * above;
                }
            }
        }
        for p in (0..count).rev() {
            let coupled = self.last_coupled[p] as usize - p;
            let row = &self.band[p * width + half..p * width + half + 1 + coupled];
            let (this, later) = self.columns.split_at_mut(p + 1);
            let column = &mut this[p];
            for (entry, known) in row[1..].iter().zip(later.iter()) {
                for (c, k) in column[..used].iter_mut().zip(known) {
                    *c -= entry * k;
                }
            }
            column[..used].iter_mut().for_each(|c| *c /= row[0]);
        }
        Ok(())
    }

    /// Solves for the velocities of rigid bodies and substitutes them into the unknowns. Returns whether a solution was
    /// found.
    fn join_bodies(&mut self, inverse_masses: [f64; BODIES]) -> bool {
        let mut matrix = SMatrix::<f64, BODIES, BODIES>::zeros();
        let mut right = SVector::<f64, BODIES>::zeros();
        for (at, w) in inverse_masses.iter().enumerate() {
            matrix[(at, at)] = if *w > 0.0 { 1.0 / w } else { 1.0 };
        }
        for (on, column) in self.on_bodies.iter().zip(&self.columns) {
            for (i, q) in on.iter().enumerate().filter(|q| *q.1 != 0.0) {
                right[i] += q * column[0];
                for j in 0..BODIES {
                    matrix[(i, j)] += q * column[1 + j];
                }
            }
        }
        let Some(change) = matrix.lu().solve(&right) else { return false };
        for column in &mut self.columns {
            column[0] -= (0..BODIES).map(|j| column[1 + j] * change[j]).sum::<f64>();
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::sweeps::{ContactInterval, ContactRow, ContactRows, ContactStep, ContactVelocities, GapTerm};
    use crate::kernel::interaction::{CoulombFriction, InteractionLaw, PressureOverclosure};

    /// Reproducible pseudo-random numbers between -1 and 1.
    struct RandomNumbers(u64);

    impl RandomNumbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// Rows of points against a coarser surface with random velocities, or against a rigid body of this mass; normals
    /// differ from point to point.
    fn scene(numbers: &mut RandomNumbers, count: u32, body: Option<f64>) -> (ContactRows, ContactVelocities) {
        let below = count / 3 + 2;
        let dofs = 2 * (count + below) + 1;
        let mut rows = ContactRows::default();
        rows.direct.reserve(count as usize, dofs as usize);
        rows.bodies.extend(body.map(|_| dofs - 1));
        for k in 0..count {
            let begin = rows.terms.len() as u32;
            let angle = 0.6 * numbers.next();
            let n = [angle.sin(), angle.cos()];
            let mut add = |dof: u32, part: f64, axis: usize| {
                let slip = [-n[1], n[0]][axis];
                rows.terms.push(GapTerm { dof, normal: part * n[axis], slip: part * slip });
            };
            for (node, part) in [(k.wrapping_sub(1), 1.0 / 6.0), (k, 4.0 / 6.0), (k + 1, 1.0 / 6.0)] {
                if node < count {
                    (0..2).for_each(|axis| add(2 * node + axis, part, axis as usize));
                }
            }
            let facet = k / 3;
            let part = f64::from(k % 3) / 3.0;
            match body {
                Some(_) => add(dofs - 1, -1.0, 1),
                None => {
                    for (node, part) in [(facet, part - 1.0), (facet + 1, -part)] {
                        (0..2).for_each(|axis| add(2 * (count + node) + axis, part, axis as usize));
                    }
                }
            }
            let mut row = ContactRow::of(k, 0);
            (row.terms, row.area) = ([begin, rows.terms.len() as u32], 1.0);
            row.gap = 0.3 * numbers.next().max(0.0);
            rows.rows.push(row);
        }
        let velocity = (0..dofs).map(|_| numbers.next()).collect();
        let mut inverse_mass: Vec<f64> = (0..dofs).map(|_| 1.5 + numbers.next()).collect();
        if let Some(mass) = body {
            inverse_mass[dofs as usize - 1] = 1.0 / mass;
        }
        (rows, ContactVelocities { velocity, inverse_mass })
    }

    /// Checks the contact conditions: no gap closes too far, pressure only where closed, friction within its cone and
    /// against the slip, no slip of sticking rows.
    fn holds(rows: &ContactRows, motion: &ContactVelocities, law: &InteractionLaw) {
        for row in &rows.rows {
            let (rate, slip) = (motion.rate(rows.terms_of(row)), motion.slip(rows.terms_of(row)));
            assert!(row.normal_impulse >= 0.0, "{row:?}");
            if !law.is_soft() {
                assert!(
                    rate + row.bias > -1e-8 && (row.normal_impulse == 0.0 || rate + row.bias < 1e-8),
                    "{rate:e} {row:?}"
                );
            } else {
                let [pressure, slope] =
                    law.overclosure.pressure(-(row.gap + row.evaluation_point(&law.overclosure) * rate));
                let off = (row.normal_impulse - pressure).abs();
                assert!(off < 1e-8 * (1.0 + slope), "{off:e} of {pressure}, {slope}, {} sweeps", rows.sweeps);
            }
            let limit = law.friction.at_rest * row.normal_impulse;
            assert!(row.shear_impulse.abs() <= limit * (1.0 + 1e-12), "{row:?}");
            assert!(
                row.shear_impulse.abs() < limit * (1.0 - 1e-12) || row.shear_impulse * slip <= 1e-8,
                "{slip:e} {row:?}"
            );
            assert!(row.shear_impulse.abs() >= limit * (1.0 - 1e-12) || slip.abs() < 1e-8, "{slip:e} {row:?}");
        }
    }

    /// Contact conditions are satisfied in random scenes with and without friction, against deformable bodies and rigid
    /// bodies of any mass. Hard contact needs no sweep.
    #[test]
    fn random_scenes_satisfy_contact_conditions() {
        let span = ContactInterval { dt: 1.0, half: 1.0 };
        let soft = [
            PressureOverclosure::Linear(3.0),
            PressureOverclosure::Exponential([0.2, 1.0]),
            PressureOverclosure::Spring(2.0),
        ];
        let bodies = [None, Some(1e3), Some(1.0), Some(1e-3), Some(1e-6)];
        for (overclosure, friction) in [
            (PressureOverclosure::Hard, 0.0),
            (PressureOverclosure::Hard, 0.2),
            (soft[0].clone(), 0.0),
            (soft[1].clone(), 0.0),
            (soft[0].clone(), 0.1),
        ] {
            let law =
                InteractionLaw { overclosure, friction: CoulombFriction::of(friction), ..InteractionLaw::default() };
            let (mut numbers, mut swept, mut scenes) = (RandomNumbers(7), 0, 0);
            // Bodies far lighter than an exponential law can stop also need sweeps, which are slow.
            let light = if matches!(law.overclosure, PressureOverclosure::Exponential(_)) { 3 } else { bodies.len() };
            for &body in &bodies[..light] {
                for count in [1, 2, 3, 7, 20, 60] {
                    for _ in 0..20 {
                        let (mut rows, mut motion) = scene(&mut numbers, count, body);
                        let pressures = vec![[0.0; 2]; count as usize];
                        let step = ContactStep { laws: std::slice::from_ref(&law), pressures: &pressures, span };
                        if let Some(reference) = rows.begin(&motion, step) {
                            rows.solve(&mut motion, reference, step);
                        }
                        scenes += 1;
                        swept += usize::from(rows.sweeps > 0);
                        holds(&rows, &motion, &law);
                    }
                }
            }
            println!("{law:?}: {swept} of {scenes} by sweeps");
            assert!(swept == 0 || law.is_soft(), "{law:?}: {swept} of {scenes}");
        }
    }

    /// A point near the beginning of a long surface does not widen the band of the matrix: contact needs no sweep.
    #[test]
    fn row_of_a_corner_is_next_to_rows_of_its_facet() {
        let (mut rows, mut motion) = scene(&mut RandomNumbers(7), 200, None);
        rows.open();
        rows.terms.extend([4, 5, 6, 7].map(|dof| GapTerm { dof, normal: 0.3 * f64::from(dof - 4), slip: 0.1 }));
        let mut corner = ContactRow::of(200, 0);
        (corner.area, corner.is_single_point) = (1.0, true);
        rows.close_after(corner, [2, 3]);
        assert_eq!(rows.rows.iter().map(|row| row.key).collect::<Vec<_>>()[2..6], [2, 3, 200, 4]);
        let law = InteractionLaw { friction: CoulombFriction::of(0.2), ..InteractionLaw::default() };
        let (span, pressures) = (ContactInterval { dt: 1.0, half: 1.0 }, vec![[0.0; 2]; 201]);
        let step = ContactStep { laws: std::slice::from_ref(&law), pressures: &pressures, span };
        let reference = rows.begin(&motion, step).expect("surfaces approach");
        rows.solve(&mut motion, reference, step);
        assert_eq!(rows.sweeps, 0);
        holds(&rows, &motion, &law);
    }
}
