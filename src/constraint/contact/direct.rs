//! The impulses of contact at once. Surfaces of revolution are curves: a row shares degrees of freedom with rows near it along the
//! curve alone, so that how rows move each other is a band matrix, and its factors cost little more than one sweep. Which rows
//! press, stick or slide is guessed from the increment before and set right in rounds: the semi-smooth Newton method for contact
//! with friction (Alart and Curnier 1991, Comput. Methods Appl. Mech. Engrg. 92, 353; as active sets Hüeber and Wohlmuth 2005,
//! Comput. Methods Appl. Mech. Engrg. 194, 3147). Rigid bodies that move freely stand beside the band, whatever their mass.
//! Never here: sweeps, which take over where rounds do not end or rows depend on each other.

use super::sweeps::{Given, Motion, Row, Rows, Span, TOLERANCE, Term, closed_overlap, most_shear};
use crate::kernel::interaction::{Law, Overclosure};
use crate::kernel::lanes::{InlineMap, inline_from_fn};
use crate::kernel::lists::MemoryUse;
use nalgebra::{SMatrix, SVector};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Status {
    Open,
    /// Presses; what friction can do is done along this direction, against the slip.
    Slides(f64),
    Sticks,
}

/// One entry of the matrix's rows and columns: a pressure, or the shear of what sticks.
#[derive(Clone, Copy, Debug)]
struct Unknown {
    row: u32,
    shears: bool,
    /// How the shear grows with the pressure where the row slides.
    rubs: f64,
}

impl Unknown {
    /// The share of a degree of freedom in the rate that the unknown is there for.
    fn test(&self, term: &Term) -> f64 {
        if self.shears { term.slip } else { term.normal }
    }

    /// The impulse on a degree of freedom by one of the unknown.
    fn impulse(&self, term: &Term) -> f64 {
        if self.shears { term.slip } else { term.normal + self.rubs * term.slip }
    }
}

/// An unknown that moves a degree of freedom, in the list of those that do.
#[derive(Clone, Copy, Debug)]
struct Link {
    next: u32,
    unknown: u32,
    test: f64,
    impulse: f64,
}

/// Rooms of the direct solution.
#[derive(Clone, Debug, Default)]
pub(super) struct Direct {
    status: Vec<Status>,
    unknowns: Vec<Unknown>,
    /// Of each degree of freedom the first unknown that moves it, then the last link.
    first: Vec<u32>,
    last: Vec<u32>,
    links: Vec<Link>,
    /// Rows of the band, of twice the half width and the diagonal.
    band: Vec<f64>,
    /// How many numbers it may have.
    room: usize,
    half_width: usize,
    /// Its diagonal before elimination.
    diagonal: Vec<f64>,
    /// The right-hand side, and a column for each rigid body.
    columns: Vec<[f64; COLUMNS]>,
    /// Impulses of unknowns on the rigid bodies.
    on_bodies: Vec<[f64; BODIES]>,
}

/// Rigid bodies that can stand beside the band.
const BODIES: usize = 4;
const COLUMNS: usize = BODIES + 1;
const ROUNDS: u32 = 16;
/// Numbers of the band that there is room for, a row of contact: half widths up to 11 where all rows stick, 23 where none does.
const ROOM: usize = 48;
/// The least part of a diagonal that elimination may leave: rows that depend on each other are for sweeps.
const LEAST_PIVOT: f64 = 1e-9;
const NONE: u32 = u32::MAX;

impl Direct {
    /// Room for this many rows and degrees of freedom, of which the copy of a contact has none.
    pub(super) fn reserve(&mut self, rows: usize, dofs: usize) {
        // What there is room for must not follow from what was there before: it decides how impulses are found.
        *self = Direct { room: ROOM * rows, ..Direct::default() };
        self.status.reserve(rows);
        self.unknowns.reserve(2 * rows);
        self.links.reserve(64 * rows);
        self.band.reserve(self.room);
        self.diagonal.reserve(2 * rows);
        self.columns.reserve(2 * rows);
        self.on_bodies.reserve(2 * rows);
        self.first.resize(dofs, NONE);
        self.last.resize(dofs, NONE);
    }

    pub(super) fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.status)
            + MemoryUse::of(&self.unknowns)
            + MemoryUse::of(&self.first)
            + MemoryUse::of(&self.last)
            + MemoryUse::of(&self.links)
            + MemoryUse::of(&self.band)
            + MemoryUse::of(&self.diagonal)
            + MemoryUse::of(&self.columns)
            + MemoryUse::of(&self.on_bodies)
    }
}

/// How shear grows with pressure where friction is at its largest.
fn rubs(row: &Row, law: &Law, direction: f64, half: f64) -> f64 {
    let capped = row.coefficient * row.pressed >= law.friction.largest * half;
    if capped || direction == 0.0 { 0.0 } else { direction * row.coefficient }
}

/// How a row begins to press: by what it would take alone.
fn begins(row: &Row, law: &Law, rate: f64, slip: f64) -> Status {
    if row.coefficient <= 0.0 || row.gives[1] <= 0.0 {
        return Status::Slides(0.0);
    }
    let held = -slip / row.gives[1];
    let pressed = -(rate + row.bias) / row.gives[0];
    let slides = law.overclosure == Overclosure::Hard && held.abs() > row.coefficient * pressed;
    if slides { Status::Slides(held.signum()) } else { Status::Sticks }
}

/// Whether a row that pressed presses no longer: where its impulse would have to pull, or, if it gives way, where it is open.
fn lets_go(row: &Row, law: &Overclosure, rate: impl Fn() -> f64, span: Span) -> bool {
    match law {
        Overclosure::Hard => row.pressed <= 0.0,
        soft => closed_overlap(row, soft, rate(), span) <= -soft.begins(),
    }
}

impl Rows {
    /// Finds the impulses from those that rows have. Returns whether they were found, to the part [`TOLERANCE`] of the `reference`
    /// velocity.
    pub(super) fn solve_directly(&mut self, motion: &mut Motion, reference: f64, given: Given<'_>) -> bool {
        if self.bodies.len() > BODIES {
            return false;
        }
        self.guess(given);
        let allowed = TOLERANCE * reference;
        for round in 0..ROUNDS {
            let changed = self.set_right(motion, allowed, given);
            self.obey(motion, given);
            if !changed && round > 0 && self.wrong(motion, given) <= allowed {
                self.direct.status.iter().zip(&mut self.rows).for_each(|(s, row)| row.sticks = *s == Status::Sticks);
                return true;
            }
            if !self.step(motion, given) {
                return false;
            }
        }
        false
    }

    /// Statuses from the impulses of the increment before.
    fn guess(&mut self, given: Given<'_>) {
        let Rows { rows, direct, .. } = self;
        direct.status.clear();
        for row in rows.iter() {
            let most = most_shear(row, &given.laws[row.law as usize], given.span.half);
            direct.status.push(match row.pressed > 0.0 {
                false => Status::Open,
                // What is held along the surface otherwise gives friction no way.
                true if row.gives[1] <= 0.0 => Status::Slides(0.0),
                true if row.sheared.abs() < most * (1.0 - 1e-9) => Status::Sticks,
                true => Status::Slides(row.sheared.signum()),
            });
        }
    }

    /// Changes the statuses that the impulses contradict. Returns whether any changed.
    fn set_right(&mut self, motion: &Motion, allowed: f64, given: Given<'_>) -> bool {
        let Rows { rows, terms, direct, .. } = self;
        let mut changed = false;
        for (row, status) in rows.iter().zip(&mut direct.status) {
            let own = row.own(terms);
            let law = &given.laws[row.law as usize];
            let next = match *status {
                Status::Open => {
                    let rate = motion.rate(own);
                    let closes = match law.overclosure {
                        Overclosure::Hard => rate + row.bias < -allowed * row.area,
                        _ => {
                            closed_overlap(row, &law.overclosure, rate, given.span)
                                > allowed * given.span.ahead - law.overclosure.begins()
                        }
                    };
                    if closes { begins(row, law, rate, motion.slip(own)) } else { Status::Open }
                }
                _ if lets_go(row, &law.overclosure, || motion.rate(own), given.span) => Status::Open,
                Status::Sticks => {
                    let most = most_shear(row, law, given.span.half);
                    if row.sheared.abs() > most { Status::Slides(row.sheared.signum()) } else { Status::Sticks }
                }
                Status::Slides(direction) => {
                    let slip = motion.slip(own);
                    let stops = direction * slip > allowed * row.area;
                    let held = row.sheared - slip / row.gives[1];
                    match stops {
                        true if held.abs() > most_shear(row, law, given.span.half) => Status::Slides(held.signum()),
                        true => Status::Sticks,
                        false => Status::Slides(direction),
                    }
                }
            };
            changed |= next != *status;
            *status = next;
        }
        changed
    }

    /// Changes impulses to what statuses allow.
    fn obey(&mut self, motion: &mut Motion, given: Given<'_>) {
        let Rows { rows, terms, direct, .. } = self;
        for (row, status) in rows.iter_mut().zip(&direct.status) {
            let own = row.own(terms);
            let (pressed, sheared) = match *status {
                Status::Open => (0.0, 0.0),
                Status::Sticks => (row.pressed.max(0.0), row.sheared),
                Status::Slides(0.0) => (row.pressed.max(0.0), 0.0),
                Status::Slides(direction) => {
                    (row.pressed.max(0.0), direction * most_shear(row, &given.laws[row.law as usize], given.span.half))
                }
            };
            if pressed != row.pressed {
                motion.push(own, pressed - row.pressed);
                row.pressed = pressed;
            }
            if sheared != row.sheared {
                motion.shear(own, sheared - row.sheared);
                row.sheared = sheared;
            }
        }
    }

    /// The furthest that a row is from what its status asks, as a velocity.
    fn wrong(&self, motion: &Motion, given: Given<'_>) -> f64 {
        let mut furthest: f64 = 0.0;
        for (row, status) in self.rows.iter().zip(&self.direct.status) {
            if *status == Status::Open {
                continue;
            }
            let own = self.terms_of(row);
            let off = match &given.laws[row.law as usize].overclosure {
                Overclosure::Hard => motion.rate(own) + row.bias,
                soft => {
                    let [pressure, _] = soft.pressure(closed_overlap(row, soft, motion.rate(own), given.span));
                    (row.pressed - given.span.half * pressure) * row.gives[0]
                }
            };
            furthest = furthest.max(off.abs() / row.area);
            if *status == Status::Sticks {
                furthest = furthest.max(motion.slip(own).abs() / row.area);
            }
        }
        furthest
    }

    /// Goes to the impulses that the statuses ask for. Returns whether there are such.
    fn step(&mut self, motion: &mut Motion, given: Given<'_>) -> bool {
        self.list_unknowns(given);
        if self.direct.unknowns.is_empty() {
            return true;
        }
        if !self.assemble(motion, given) || !self.direct.eliminate(1 + self.bodies.len()) {
            return false;
        }
        if !self.bodies.is_empty() {
            let inverse_mass = |at: usize| self.bodies.get(at).map_or(0.0, |b| motion.inverse_mass[*b as usize]);
            let masses = inline_from_fn(inverse_mass);
            if !self.direct.join_bodies(masses) {
                return false;
            }
        }
        let Rows { rows, terms, direct, .. } = self;
        for (unknown, [change, ..]) in direct.unknowns.iter().zip(&direct.columns) {
            if !change.is_finite() {
                return false;
            }
            let row = &mut rows[unknown.row as usize];
            let own = row.own(terms);
            if unknown.shears {
                row.sheared += change;
                motion.shear(own, *change);
            } else {
                row.pressed += change;
                motion.push(own, *change);
                if unknown.rubs != 0.0 {
                    row.sheared += unknown.rubs * change;
                    motion.shear(own, unknown.rubs * change);
                }
            }
        }
        true
    }

    fn list_unknowns(&mut self, given: Given<'_>) {
        let Rows { rows, direct, .. } = self;
        direct.unknowns.clear();
        for (at, (row, status)) in rows.iter().zip(&direct.status).enumerate() {
            let row_at = at as u32;
            match *status {
                Status::Open => {}
                Status::Slides(direction) => {
                    let rubs = rubs(row, &given.laws[row.law as usize], direction, given.span.half);
                    direct.unknowns.push(Unknown { row: row_at, shears: false, rubs });
                }
                Status::Sticks => {
                    direct.unknowns.extend([false, true].inline_map(|shears| Unknown {
                        row: row_at,
                        shears,
                        rubs: 0.0,
                    }));
                }
            }
        }
    }

    /// The band, the right-hand side and what stands beside them. Returns whether there is room for the band.
    fn assemble(&mut self, motion: &Motion, given: Given<'_>) -> bool {
        self.find_width();
        let Rows { rows, terms, direct, bodies, .. } = self;
        let (count, half) = (direct.unknowns.len(), direct.half_width);
        let width = 2 * half + 1;
        if count * width > direct.room {
            self.forget();
            return false;
        }
        direct.band.clear();
        direct.band.resize(count * width, 0.0);
        direct.columns.clear();
        direct.on_bodies.clear();
        direct.links.clear();
        for (at, unknown) in direct.unknowns.iter().enumerate() {
            let row = &rows[unknown.row as usize];
            let own = row.own(terms);
            let (mut column, mut on_bodies) = ([0.0; COLUMNS], [0.0; BODIES]);
            let mut compliance = 0.0;
            column[0] = if unknown.shears {
                -motion.slip(own)
            } else {
                let (asked, gives) =
                    asked(row, &given.laws[row.law as usize].overclosure, motion.rate(own), given.span);
                compliance = gives;
                asked
            };
            for term in own {
                let (test, impulse) = (unknown.test(term), unknown.impulse(term));
                let w = motion.inverse_mass[term.dof as usize];
                if w == 0.0 || (test == 0.0 && impulse == 0.0) {
                    continue;
                }
                if let Some(body) = bodies.iter().position(|b| *b == term.dof) {
                    column[1 + body] += test;
                    on_bodies[body] += impulse;
                    continue;
                }
                let last = &mut direct.last[term.dof as usize];
                let mut next = *last;
                *last = direct.links.len() as u32;
                direct.links.push(Link { next, unknown: at as u32, test, impulse });
                direct.band[at * width + half] += w * test * impulse;
                while next != NONE {
                    let link = direct.links[next as usize];
                    let away = at - link.unknown as usize;
                    direct.band[at * width + half - away] += w * test * link.impulse;
                    direct.band[link.unknown as usize * width + half + away] += w * link.test * impulse;
                    next = link.next;
                }
            }
            direct.band[at * width + half] += compliance;
            direct.columns.push(column);
            direct.on_bodies.push(on_bodies);
        }
        direct.diagonal.clear();
        direct.diagonal.extend(direct.band.iter().skip(half).step_by(width).take(count));
        self.forget();
        true
    }

    /// The half width of the band: how far unknowns that move the same degree of freedom are from each other.
    fn find_width(&mut self) {
        let Rows { rows, terms, direct, bodies, .. } = self;
        direct.half_width = 0;
        for (at, unknown) in direct.unknowns.iter().enumerate() {
            let row = &rows[unknown.row as usize];
            for term in row.own(terms) {
                if (unknown.test(term) == 0.0 && unknown.impulse(term) == 0.0) || bodies.contains(&term.dof) {
                    continue;
                }
                let first = &mut direct.first[term.dof as usize];
                if *first == NONE {
                    *first = at as u32;
                }
                direct.half_width = direct.half_width.max(at - *first as usize);
            }
        }
    }

    /// Empties the lists of degrees of freedom.
    fn forget(&mut self) {
        let Rows { rows, terms, direct, .. } = self;
        for unknown in &direct.unknowns {
            let row = &rows[unknown.row as usize];
            for term in row.own(terms) {
                direct.first[term.dof as usize] = NONE;
                direct.last[term.dof as usize] = NONE;
            }
        }
    }
}

/// What the rate of a row's gap has still to change by, and by how much it gives way itself, a unit of impulse: none where
/// surfaces are hard; else the law's straight line at the overlap that there is.
fn asked(row: &Row, law: &Overclosure, rate: f64, span: Span) -> (f64, f64) {
    if *law == Overclosure::Hard {
        return (-(rate + row.bias), 0.0);
    }
    let [pressure, slope] = law.line(closed_overlap(row, law, rate, span));
    let gives = row.area / (span.half * law.look_ahead() * span.ahead * slope);
    ((span.half * pressure - row.pressed) * gives, gives)
}

impl Direct {
    /// Elimination within the band, from the columns in use. Returns whether all rows were independent.
    fn eliminate(&mut self, used: usize) -> bool {
        let (count, half) = (self.unknowns.len(), self.half_width);
        let width = 2 * half + 1;
        for p in 0..count {
            let pivot = self.band[p * width + half];
            if pivot.is_nan() || pivot.abs() <= LEAST_PIVOT * self.diagonal[p].abs() {
                return false;
            }
            let last = (p + half).min(count - 1);
            let (above, below) = self.band.split_at_mut((p + 1) * width);
            let from = &above[p * width + half + 1..p * width + half + 1 + last - p];
            let (solved, rest) = self.columns.split_at_mut(p + 1);
            for i in p + 1..=last {
                let begin = (i - p - 1) * width + half - (i - p);
                let factor = below[begin] / pivot;
                if factor == 0.0 {
                    continue;
                }
                for (entry, pivots) in below[begin + 1..begin + 1 + from.len()].iter_mut().zip(from) {
                    *entry -= factor * pivots;
                }
                for (entry, pivots) in rest[i - p - 1][..used].iter_mut().zip(&solved[p]) {
                    *entry -= factor * pivots;
                }
            }
        }
        for p in (0..count).rev() {
            let last = (p + half).min(count - 1);
            let (this, later) = self.columns.split_at_mut(p + 1);
            let column = &mut this[p];
            for (j, known) in later[..last - p].iter().enumerate() {
                let entry = self.band[p * width + half + 1 + j];
                for (c, k) in column[..used].iter_mut().zip(known) {
                    *c -= entry * k;
                }
            }
            let pivot = self.band[p * width + half];
            column[..used].iter_mut().for_each(|c| *c /= pivot);
        }
        true
    }

    /// Takes the motion of rigid bodies into the unknowns: what they take changes their velocities, which all rows in front of them
    /// see. Returns whether the velocities were found.
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
    use super::super::sweeps::{Given, Motion, Row, Rows, Span, Term};
    use crate::kernel::interaction::{Friction, Law, Overclosure};

    /// Numbers between -1 and 1 without order, the same in every run.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// Hats of a row of points on what lies below, which is coarser, moves at random and may be a rigid body of this mass as well;
    /// normals turn from point to point.
    fn scene(numbers: &mut Numbers, count: u32, body: Option<f64>) -> (Rows, Motion) {
        let below = count / 3 + 2;
        let dofs = 2 * (count + below) + 1;
        let mut rows = Rows::default();
        rows.direct.reserve(count as usize, dofs as usize);
        rows.bodies.extend(body.map(|_| dofs - 1));
        for k in 0..count {
            let begin = rows.terms.len() as u32;
            let angle = 0.6 * numbers.next();
            let n = [angle.sin(), angle.cos()];
            let mut add = |dof: u32, part: f64, axis: usize| {
                let slip = [-n[1], n[0]][axis];
                rows.terms.push(Term { dof, normal: part * n[axis], slip: part * slip });
            };
            for (node, part) in [(k.wrapping_sub(1), 1.0 / 6.0), (k, 4.0 / 6.0), (k + 1, 1.0 / 6.0)] {
                if node < count {
                    (0..2).for_each(|axis| add(2 * node + axis, part, axis as usize));
                }
            }
            let at = k / 3;
            let part = f64::from(k % 3) / 3.0;
            match body {
                Some(_) => add(dofs - 1, -1.0, 1),
                None => {
                    for (node, part) in [(at, part - 1.0), (at + 1, -part)] {
                        (0..2).for_each(|axis| add(2 * (count + node) + axis, part, axis as usize));
                    }
                }
            }
            let mut row = Row::of(k, 0);
            (row.terms, row.area) = ([begin, rows.terms.len() as u32], 1.0);
            row.gap = 0.3 * numbers.next().max(0.0);
            rows.rows.push(row);
        }
        let velocity = (0..dofs).map(|_| numbers.next()).collect();
        let mut inverse_mass: Vec<f64> = (0..dofs).map(|_| 1.5 + numbers.next()).collect();
        if let Some(mass) = body {
            inverse_mass[dofs as usize - 1] = 1.0 / mass;
        }
        (rows, Motion { velocity, inverse_mass })
    }

    /// What rows must keep: no gap closes by more than it has, what presses is closed, friction is within its cone, holds what it
    /// does not let slide, and lets slide against itself.
    fn holds(rows: &Rows, motion: &Motion, law: &Law) {
        for row in &rows.rows {
            let (rate, slip) = (motion.rate(rows.terms_of(row)), motion.slip(rows.terms_of(row)));
            assert!(row.pressed >= 0.0, "{row:?}");
            if law.overclosure == Overclosure::Hard {
                assert!(rate + row.bias > -1e-8 && (row.pressed == 0.0 || rate + row.bias < 1e-8), "{rate:e} {row:?}");
            } else {
                let [pressure, slope] = law.overclosure.pressure(-(row.gap + law.overclosure.look_ahead() * rate));
                let off = (row.pressed - pressure).abs();
                assert!(off < 1e-8 * (1.0 + slope), "{off:e} of {pressure}, {slope}, {} sweeps", rows.sweeps);
            }
            let most = law.friction.at_rest * row.pressed;
            assert!(row.sheared.abs() <= most * (1.0 + 1e-12), "{row:?}");
            assert!(row.sheared.abs() < most * (1.0 - 1e-12) || row.sheared * slip <= 1e-8, "{slip:e} {row:?}");
            assert!(row.sheared.abs() >= most * (1.0 - 1e-12) || slip.abs() < 1e-8, "{slip:e} {row:?}");
        }
    }

    /// In random scenes, with and without friction, before deforming and rigid bodies however light, laws hold. Those of hard surfaces
    /// are solved without a sweep; of soft ones that are pressed together at great speed some are not.
    #[test]
    fn laws_hold_in_random_scenes() {
        let span = Span { ahead: 1.0, half: 1.0 };
        let soft = [Overclosure::Linear(3.0), Overclosure::Exponential([0.2, 1.0]), Overclosure::Spring(2.0)];
        let bodies = [None, Some(1e3), Some(1.0), Some(1e-3), Some(1e-6)];
        for (overclosure, friction) in [
            (Overclosure::Hard, 0.0),
            (Overclosure::Hard, 0.2),
            (soft[0].clone(), 0.0),
            (soft[1].clone(), 0.0),
            (soft[0].clone(), 0.1),
        ] {
            let law = Law { overclosure, friction: Friction::of(friction), ..Law::default() };
            let (mut numbers, mut swept, mut scenes) = (Numbers(7), 0, 0);
            // Bodies far lighter than what an exponential law stops are for sweeps, too, a crawl.
            let light = if matches!(law.overclosure, Overclosure::Exponential(_)) { 3 } else { bodies.len() };
            for &body in &bodies[..light] {
                for count in [1, 2, 3, 7, 20, 60] {
                    for _ in 0..20 {
                        let (mut rows, mut motion) = scene(&mut numbers, count, body);
                        let before = vec![[0.0; 2]; count as usize];
                        let given = Given { laws: std::slice::from_ref(&law), before: &before, span };
                        rows.solve(&mut motion, given);
                        scenes += 1;
                        swept += usize::from(rows.sweeps > 0);
                        holds(&rows, &motion, &law);
                    }
                }
            }
            println!("{law:?}: {swept} of {scenes} by sweeps");
            assert!(swept == 0 || law.overclosure != Overclosure::Hard, "{law:?}: {swept} of {scenes}");
        }
    }
}
