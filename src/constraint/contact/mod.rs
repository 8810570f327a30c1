//! Contact of surfaces with each other, with themselves and with analytical ones: no overlap grows, whatever the stiffness of what
//! meets.
//! Never here: deck words, which surfaces there are.
//!
//! Each point of one surface of a pair carries a pressure, the multiplier of the gap in front of it, weighted with its hat
//! function over the surface of revolution ([`gaps`]). In each increment impulses are found with which the velocity ahead closes
//! no gap by more than it has, `G v + max(g, 0)/dt >= 0` with pressures not below zero, and friction within Coulomb's cone
//! ([`sweeps`]). An overlap that is there is stopped and not thrown out. In front of
//! analytical surfaces each point has a gap of its own ([`analytical`]). Nothing here limits the increment.

pub mod analytical;
mod continuation;
pub mod curve;
mod direct;
mod gaps;
mod heat;
mod light;
mod search;
mod shown;
mod sweeps;

use crate::kernel::lanes::InlineMap;
use std::any::Any;

use self::analytical::{Analytical, Foot};
use self::curve::{Carrier, Curve, Point};
use self::gaps::{Gaps, Seen};
use self::heat::Crossing;
use self::search::Search;
use self::shown::Shown;
use self::sweeps::{Given, Motion, NONE, Row, Rows, Span};
use super::{Constraint, ConstraintForces, ConstraintUpkeep, ConstraintView, HeatExchange, StoredConstraint};
use crate::kernel::interaction::Law;
use crate::kernel::lists::MemoryUse;
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::{Archive, persist_struct};
use crate::state::dofs::{Dof, Dofs};
use crate::state::magnitude::Clock;

/// Two surfaces that may meet, or one that may meet itself.
#[derive(Clone, Debug)]
pub struct Pair {
    pub id: EffectId,
    /// Its number among the pairs of all steps.
    pub number: usize,
    /// The curve whose points carry pressures.
    pub own: usize,
    /// The other one; `None` where it is the same, or an analytical surface.
    pub other: Option<usize>,
    /// The analytical surface, where it is one.
    pub analytical: Option<usize>,
    /// Which of the laws of the contact it follows; of penalty springs the first: each point of the own curve has one.
    pub law: usize,
    pub springs: bool,
    /// The law of points that meet by themselves, whose multipliers are impulses and no pressures.
    pub of_points: usize,
    /// Whether the own curve is the first surface of the pair as it was given: forces are those on that.
    pub first: bool,
    /// What gaps at the start are taken as.
    pub begins: Option<Begins>,
    search: Search,
    seen: Vec<Seen>,
    /// The first of its keys: each point of the own curve has one.
    first_key: u32,
}

impl Pair {
    /// A pair with a row of the ledger and a number, of one curve with another or, where that is the same, with itself, under
    /// the first of the laws. `length` is the smaller of the longest facets of both.
    pub fn new(id: EffectId, number: usize, [own, other]: [usize; 2], length: f64) -> Pair {
        let other = (own != other).then_some(other);
        let search = Search::new(length, 0.0, 0, 0);
        Pair {
            id,
            number,
            own,
            other,
            analytical: None,
            law: 0,
            springs: false,
            of_points: 0,
            first: true,
            begins: None,
            search,
            seen: Vec::new(),
            first_key: 0,
        }
    }

    /// The same of a curve with an analytical surface.
    pub fn in_front_of(id: EffectId, number: usize, own: usize, analytical: usize, length: f64) -> Pair {
        Pair { analytical: Some(analytical), ..Pair::new(id, number, [own, own], length) }
    }

    /// The law of a point of the own curve.
    fn law_of(&self, index: usize) -> u32 {
        (if self.springs { self.law + index } else { self.law }) as u32
    }
}

/// What gaps at the start are taken as, where they are in a range: what they have too much or too little is taken off for good.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Begins {
    pub gap: f64,
    /// From the deepest overlap to the widest gap.
    pub range: [f64; 2],
}

/// All contact of a step.
#[derive(Clone, Debug, Default)]
pub struct Contact {
    points: Vec<Point>,
    curves: Vec<Curve>,
    pairs: Vec<Pair>,
    analyticals: Vec<Analytical>,
    /// Where rows meet analytical surfaces in this increment.
    feet: Vec<Foot>,
    laws: Vec<Law>,
    /// Degrees of freedom of each point along r and z; [`NONE`] where it has none.
    dofs_of: Vec<[u32; 2]>,
    /// What each degree of freedom is of the scene, and whether its motion is prescribed.
    dofs: Vec<(Dof, bool)>,
    /// Pressure and shear stress of each key over the increment behind.
    pressures: Vec<[f64; 2]>,
    /// What is taken off the gap of each key; empty where nothing is.
    fits: Vec<f64>,
    /// The first law of penalty springs: all that follow are theirs; `None` where there are none.
    springs: Option<u32>,
    /// Heat where surfaces meet; `None` where there are no temperatures.
    crossing: Option<Box<Crossing>>,
    /// Mean velocity of each degree of freedom over the impulse of the increment; empty where no row asks for its own work.
    means: Vec<f64>,
    places: Vec<[f64; 2]>,
    /// Points that are looked at: of bare facets, and those that no element has.
    near: Vec<u32>,
    /// Where points were when lists were made; empty where there are none.
    listed: Vec<[f64; 2]>,
    gaps: Gaps,
    rows: Rows,
    motion: Motion,
    /// Impulses along the normal and along the surface.
    impulses: Vec<[f64; 2]>,
    bodies: Vec<Carried>,
    /// Time over which forces acted on velocities last.
    half: f64,
    /// Whether elements have gone since the increment before.
    uncovered: bool,
    shown: Shown,
}

/// A rigid body in contact.
#[derive(Clone, Copy, Debug)]
struct Carried {
    /// Which of the degrees of freedom it is.
    dof: usize,
    body: usize,
    prescribed: bool,
    /// Acceleration by contact in the increment behind, where it moves freely.
    pushed: f64,
}

/// An overlap of two surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// How deep, in the mean over the hat function of a point.
    pub depth: f64,
    pub place: [f64; 2],
}

impl Contact {
    /// The contact of some pairs of curves over points, with each other and with analytical surfaces.
    pub fn new(
        points: Vec<Point>,
        curves: Vec<Curve>,
        mut analyticals: Vec<Analytical>,
        mut pairs: Vec<Pair>,
        laws: Vec<Law>,
    ) -> Contact {
        let mut contact = Contact { laws, ..Contact::default() };
        contact.number(&points);
        let mut keys = 0;
        for pair in &mut pairs {
            let own = &curves[pair.own];
            let others = pair.other.map_or(own.facets.len(), |o| curves[o].facets.len());
            let lift = own.highest() + pair.other.map_or(own.highest(), |o| curves[o].highest());
            pair.first_key = keys;
            keys += analytical::keys(&curves, &analyticals, pair);
            if let Some(met) = pair.analytical {
                analyticals[met].lift = (0..own.own.len()).map(|i| own.lift_of(i)).collect();
                continue;
            }
            pair.search = Search::new(pair.search.length, lift, own.facets.len(), others);
            pair.seen = vec![Seen::default(); own.facets.len()];
        }
        let facets: usize = pairs.iter().map(|p| p.seen.len()).sum();
        contact.pressures = vec![[0.0; 2]; keys as usize];
        contact.shown = Shown::new(keys as usize, &points);
        contact.places = vec![[0.0; 2]; points.len()];
        contact.listed = Vec::with_capacity(points.len());
        contact.near = Vec::with_capacity(2 * points.len() + analyticals.len());
        let meets = |p: &&Pair| p.analytical.is_some();
        contact.feet = Vec::with_capacity(pairs.iter().filter(meets).map(|p| 2 * curves[p.own].own.len()).sum());
        contact.gaps = Gaps::new(facets);
        contact.rows.reserve(keys as usize, contact.dofs.len());
        (contact.points, contact.curves, contact.pairs) = (points, curves, pairs);
        contact.analyticals = analyticals;
        contact.list_points();
        contact
    }

    /// Takes the laws from this one on for those of penalty springs.
    pub fn with_springs(mut self, first: usize) -> Contact {
        self.springs = Some(first as u32);
        self.means = vec![0.0; self.dofs.len()];
        self
    }

    /// Lets heat cross where surfaces meet: `has` says of which nodes temperatures are solved for.
    pub fn with_heat(mut self, has: impl Fn(usize) -> bool) -> Contact {
        let mut keys = Vec::with_capacity(self.pressures.len());
        for pair in &self.pairs {
            let of = |curve: usize| self.curves[curve].own.iter().copied();
            keys.extend(of(pair.own).map(|point| (point, pair.first)));
            let loose = pair.other.filter(|o| self.curves[*o].has_loose_points());
            keys.extend(loose.into_iter().flat_map(of).map(|point| (point, !pair.first)));
            // In front of corners of analytical surfaces points have two.
            let twice = pair.first_key as usize + self.keys_of(pair) as usize - keys.len();
            keys.extend(of(pair.own).take(twice).map(|point| (point, pair.first)));
        }
        let crossing = Crossing::new((&self.points, &self.dofs_of), self.dofs.len(), keys, has);
        self.crossing = Some(Box::new(crossing));
        self.means = vec![0.0; self.dofs.len()];
        self
    }

    /// Looks at how surfaces lie when points are at these places, at the start: takes gaps as none where a pair says so, and gives
    /// the deepest overlap of each pair, with its place.
    pub fn start(&mut self, places: &[[f64; 2]]) -> Vec<Option<Overlap>> {
        self.places.copy_from_slice(places);
        self.curves.iter_mut().for_each(|c| c.shape(places));
        self.list();
        self.measure(0.0);
        let mut deepest: Vec<Option<Overlap>> = vec![None; self.pairs.len()];
        let mut fits = vec![0.0; self.pressures.len()];
        for row in &mut self.rows.rows {
            let at = self.pairs.partition_point(|p| p.first_key <= row.key) - 1;
            let (pair, mut gap) = (&self.pairs[at], row.gap / row.area);
            if let Some(begins) = pair.begins.filter(|b| (b.range[0]..=b.range[1]).contains(&gap)) {
                fits[row.key as usize] = gap - begins.gap;
                gap = begins.gap;
                row.gap = gap * row.area;
            }
            let Some(&point) = self.curves[pair.own].own.get((row.key - pair.first_key) as usize) else { continue };
            if gap < deepest[at].map_or(0.0, |d: Overlap| -d.depth) {
                deepest[at] = Some(Overlap { depth: -gap, place: places[point as usize] });
            }
        }
        if fits.iter().any(|f| *f != 0.0) {
            self.fits = fits;
        }
        self.show_openings();
        self.let_heat_cross();
        self.listed.clear();
        deepest
    }

    /// Gives degrees of freedom to points.
    fn number(&mut self, points: &[Point]) {
        for point in points {
            self.dofs_of.push(match point.carrier {
                Carrier::Node(n) => {
                    self.dofs.extend([0, 1].inline_map(|axis| (Dof::Node(n, axis), !point.free[axis])));
                    [self.dofs.len() as u32 - 2, self.dofs.len() as u32 - 1]
                }
                Carrier::Body(b, _) => {
                    let known = self.dofs.iter().position(|d| d.0 == Dof::Body(b));
                    [
                        NONE,
                        known.unwrap_or_else(|| {
                            self.dofs.push((Dof::Body(b), false));
                            self.dofs.len() - 1
                        }) as u32,
                    ]
                }
            });
        }
        let count = self.dofs.len();
        self.motion = Motion { velocity: vec![0.0; count], inverse_mass: vec![0.0; count] };
        self.impulses = vec![[0.0; 2]; count];
    }

    /// Places at the start of the increment and velocities without contact, from where all has been carried freely.
    fn look(&mut self, dofs: &Dofs, dt: f64) {
        for &p in &self.near {
            let (at, point) = (p as usize, &self.points[p as usize]);
            let [r, z] = self.dofs_of[at];
            match point.carrier {
                Carrier::Node(n) => {
                    let node = &dofs.nodes[n];
                    self.places[at] = [node.r - dt * node.v_r, node.z - dt * node.v_z];
                    self.motion.velocity[r as usize] = node.v_r;
                    self.motion.velocity[z as usize] = node.v_z;
                    for dof in [r, z] {
                        let held = self.dofs[dof as usize].1;
                        self.motion.inverse_mass[dof as usize] = if held { 0.0 } else { dofs.nodes.inverse_mass[n] };
                    }
                }
                Carrier::Body(b, [start_r, start_z]) => {
                    let (body, held) = (&dofs.bodies[b], self.dofs[z as usize].1);
                    self.places[at] = [start_r, start_z + body.before.displacement];
                    self.motion.velocity[z as usize] = body.velocity_half;
                    self.motion.inverse_mass[z as usize] = if held { 0.0 } else { body.inverse_mass };
                }
            }
        }
    }

    /// Lists the points that bare facets have and those that no element has.
    fn list_points(&mut self) {
        self.near.clear();
        self.near.extend(self.analyticals.iter().map(|a| a.point));
        for curve in &self.curves {
            let points = curve.bare_own.iter().chain(&curve.orphans).map(|&i| curve.own[i as usize]);
            self.near.extend(points);
        }
        self.near.sort_unstable();
        self.near.dedup();
        self.listed.clear();
    }

    /// Makes lists anew where something has moved too far since they were made.
    fn list(&mut self) {
        let searched = |p: &&Pair| p.analytical.is_none();
        let slack = self.pairs.iter().filter(searched).map(|p| p.search.slack()).fold(f64::INFINITY, f64::min);
        if slack == f64::INFINITY {
            return;
        }
        let far = |&p: &u32| {
            let (a, b) = (self.places[p as usize], self.listed[p as usize]);
            let d = [a[0] - b[0], a[1] - b[1]];
            d[0] * d[0] + d[1] * d[1] > slack * slack
        };
        if !self.listed.is_empty() && !self.near.iter().any(far) {
            return;
        }
        self.listed.clear();
        self.listed.extend_from_slice(&self.places);
        for pair in self.pairs.iter_mut().filter(|p| p.analytical.is_none()) {
            pair.search.build(&self.curves[pair.own], pair.other.map(|o| &self.curves[o]), &self.places);
        }
    }

    /// The gaps of all pairs as rows, in an increment of the length `dt`.
    fn measure(&mut self, dt: f64) {
        self.gaps.shares.clear();
        self.rows.clear();
        self.feet.clear();
        self.shown.clear();
        self.measure_curves();
        for pair in 0..self.pairs.len() {
            self.measure_analytical(pair, dt);
        }
    }

    fn measure_curves(&mut self) {
        let Contact { curves, pairs, gaps, rows, dofs_of, fits, places, .. } = self;
        for pair in pairs.iter_mut().filter(|p| p.analytical.is_none()) {
            let own = &curves[pair.own];
            let other = pair.other.map_or(own, |o| &curves[o]);
            let (mut any, reach) = (false, pair.search.reach());
            for (at, &k) in own.bare.iter().enumerate() {
                let candidates = pair.search.facets.of(at);
                pair.seen[k as usize] = match candidates.is_empty() {
                    true => Seen::default(),
                    false => gaps.see(own, k as usize, other, candidates, reach),
                };
                any |= pair.seen[k as usize].area != [0.0; 2];
            }
            if any {
                for &index in &own.bare_own {
                    add_row(rows, pair, own, index as usize, gaps, dofs_of, fits);
                }
            }
            for (at, &index) in own.orphans.iter().enumerate() {
                let key = pair.first_key + index;
                add_point_row(
                    rows,
                    gaps,
                    (own, index, key),
                    other,
                    pair.search.orphans.of(at),
                    (pair, places, dofs_of),
                );
            }
            // A curve that meets itself has its loose points once.
            let others = pair.other.map(|o| &curves[o]);
            for (at, index) in others.into_iter().flat_map(|o| o.loose()).enumerate() {
                let key = pair.first_key + own.own.len() as u32 + index;
                add_point_row(rows, gaps, (other, index, key), own, pair.search.others.of(at), (pair, places, dofs_of));
            }
        }
    }

    /// Impulses of the rows on degrees of freedom, and the pressures that are kept.
    fn gather_impulses(&mut self) {
        let Contact { rows, impulses, pressures, half, .. } = self;
        pressures.fill([0.0; 2]);
        impulses.fill([0.0; 2]);
        for row in &rows.rows {
            pressures[row.key as usize] = [row.pressed / *half, row.sheared / *half];
            for term in rows.terms_of(row) {
                let on = &mut impulses[term.dof as usize];
                on[0] += term.normal * row.pressed;
                on[1] += term.slip * row.sheared;
            }
        }
    }

    /// Changes velocities and places, and books the work of the impulses: an impulse does itself times the mean of the velocities
    /// before and after. What acts on a prescribed motion is work of that motion.
    fn act(&mut self, dofs: &mut Dofs, dt: f64) {
        let half = self.half;
        let Dofs { bodies, nodes, energies, .. } = dofs;
        let mut work = [0.0; 2];
        self.means.fill(0.0);
        for (i, &(dof, prescribed)) in self.dofs.iter().enumerate() {
            let [normal, slip] = self.impulses[i];
            if normal == 0.0 && slip == 0.0 {
                continue;
            }
            let change = self.motion.inverse_mass[i] * (normal + slip);
            let mean = match dof {
                Dof::Node(n, axis) => {
                    let node = &mut nodes[n];
                    let predicted = *node.velocity(axis);
                    *node.velocity(axis) = predicted + change;
                    *node.coordinate(axis) += dt * change;
                    let acceleration = &mut nodes.acceleration[n][axis];
                    let before = predicted - half * *acceleration;
                    *acceleration += change / half;
                    0.5 * (before + (predicted + change))
                }
                Dof::Body(b) => {
                    let body = &mut bodies[b];
                    let before = body.before.velocity - (half - 0.5 * dt) * body.acceleration;
                    let so_far = body.velocity_half - before - half * body.acceleration;
                    body.velocity_half += change;
                    body.displacement += dt * change;
                    if !prescribed {
                        // What surfaces did before in this increment acts over the new velocity.
                        energies.contact -= 0.5 * body.mass * so_far * change;
                    }
                    0.5 * (before + body.velocity_half)
                }
            };
            if let Some(kept) = self.means.get_mut(i) {
                *kept = mean;
            }
            if prescribed {
                energies.external -= (normal + slip) * mean;
            }
            work[0] += normal * mean;
            work[1] += slip * mean;
        }
        let springs = self.work_of_springs();
        if let Some(crossing) = &mut self.crossing {
            let (rows, means) = (&self.rows, &self.means);
            let rate = |row: &Row| rows.terms_of(row).iter().map(|t| t.slip * means[t.dof as usize]).sum::<f64>();
            crossing.rub(rows, &self.laws, |row| row.sheared * rate(row));
        }
        energies.penalty -= springs;
        energies.contact -= work[0] - springs;
        energies.friction -= work[1];
    }

    fn work_of_springs(&self) -> f64 {
        let Some(first) = self.springs else { return 0.0 };
        let own = self.rows.rows.iter().filter(|row| row.law >= first && row.pressed > 0.0);
        let terms = |row: &Row| self.rows.terms_of(row).iter();
        own.map(|row| row.pressed * terms(row).map(|t| t.normal * self.means[t.dof as usize]).sum::<f64>()).sum()
    }

    /// What rows pass on of heat, before any is left out.
    fn let_heat_cross(&mut self) {
        if let Some(crossing) = &mut self.crossing {
            crossing.take(&self.rows, &self.laws, &self.pressures);
        }
    }

    /// What bodies that move freely took in this increment, in place of what they took in the one behind.
    fn push_bodies(&mut self, dofs: &mut Dofs) {
        let half = self.half;
        for carried in self.bodies.iter_mut().filter(|c| !c.prescribed) {
            let [normal, slip] = self.impulses[carried.dof];
            let body = &mut dofs.bodies[carried.body];
            body.contact -= carried.pushed;
            carried.pushed = (normal + slip) * body.inverse_mass / half;
            body.contact += carried.pushed;
        }
    }
}

/// The row of one point, from what the facets around it see.
fn add_row(rows: &mut Rows, pair: &Pair, own: &Curve, index: usize, gaps: &Gaps, dofs_of: &[[u32; 2]], fits: &[f64]) {
    let mut row = Row::of(pair.first_key + index as u32, pair.law_of(index));
    let facets = || own.around_own(index).iter().filter(|f| own.there[f.0 as usize]);
    for &(facet, end) in facets() {
        let (seen, end) = (&pair.seen[facet as usize], end as usize);
        row.area += seen.area[end];
        row.gap += seen.gap[end];
    }
    if row.area <= 0.0 {
        return;
    }
    if let Some(fit) = fits.get(row.key as usize) {
        row.gap -= fit * row.area;
    }
    rows.open();
    for &(facet, end) in facets() {
        for share in gaps.shares_of(&pair.seen[facet as usize]) {
            rows.add_share(dofs_of[share.point as usize], share.of[end as usize]);
        }
    }
    rows.close(row);
}

/// The row of a point that meets a curve by itself: its area is one, its multiplier an impulse.
fn add_point_row(
    rows: &mut Rows,
    gaps: &mut Gaps,
    (of, index, key): (&Curve, u32, u32),
    against: &Curve,
    candidates: &[u32],
    (pair, places, dofs_of): (&Pair, &[[f64; 2]], &[[u32; 2]]),
) {
    if candidates.is_empty() {
        return;
    }
    let point = of.own[index as usize];
    let seen = gaps.see_point((point, places[point as usize]), against, candidates, pair.search.reach());
    let Some(seen) = seen else { return };
    rows.open();
    for share in gaps.shares_of(&seen) {
        rows.add_share(dofs_of[share.point as usize], share.of[0]);
    }
    let mut row = Row::of(key, pair.of_points as u32);
    (row.alone, row.area, row.gap) = (true, seen.area[0], seen.gap[0]);
    rows.close(row);
}

impl Constraint for Contact {
    fn effect(&self) -> EffectId {
        self.pairs.first().map_or(0, |p| p.id)
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        let before = std::mem::take(&mut self.bodies);
        self.rows.bodies.clear();
        for (i, (dof, held)) in self.dofs.iter_mut().enumerate() {
            if let Dof::Body(body) = *dof {
                *held = dofs.bodies[body].prescribed;
                let known = before.iter().find(|known| known.body == body && !*held);
                let pushed = known.map_or(0.0, |known| known.pushed);
                dofs.bodies[body].contact += pushed;
                self.bodies.push(Carried { dof: i, body, prescribed: *held, pushed });
                self.rows.bodies.extend((!*held).then_some(i as u32));
            }
        }
        self.rows.reserve(self.pressures.len(), self.dofs.len());
    }

    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>) {
        if self.half == 0.0 {
            return;
        }
        for carried in self.bodies.iter().filter(|c| c.prescribed) {
            let [normal, slip] = self.impulses[carried.dof];
            dofs.bodies[carried.body].reaction -= (normal + slip) / self.half;
        }
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>, dt: f64) {
        self.half = dofs.nodes.half;
        if self.uncovered {
            self.list_points();
        }
        self.look(dofs, dt);
        if std::mem::take(&mut self.uncovered) {
            self.curves.iter_mut().for_each(|c| c.join(&self.places));
        }
        self.curves.iter_mut().for_each(|c| c.shape(&self.places));
        self.list();
        self.measure(dt);
        self.show_openings();
        self.let_heat_cross();
        let span = Span { ahead: dt, half: self.half };
        let given = Given { laws: &self.laws, before: &self.pressures, span };
        if let Some(reference) = self.rows.solve(&mut self.motion, given) {
            self.end_on_arcs(reference, span);
        }
        self.gather_impulses();
        self.act(dofs, dt);
        self.push_bodies(dofs);
        self.show(dt);
    }

    fn view(&self) -> ConstraintView<'_> {
        let heat = self.crossing.as_deref().map(|crossing| crossing as &dyn HeatExchange);
        ConstraintView { carried: None, moves_nodes: true, forces: Some(self), contact: Some(self), heat }
    }

    fn upkeep(&mut self) -> Option<&mut dyn ConstraintUpkeep> {
        Some(self)
    }
}

impl ConstraintForces for Contact {
    fn constraint_force(&self, dof: Dof) -> f64 {
        if self.half == 0.0 {
            return 0.0;
        }
        let at = self.dofs.iter().position(|d| *d == (dof, true));
        at.map_or(0.0, |i| (self.impulses[i][0] + self.impulses[i][1]) / self.half)
    }
}

impl ConstraintUpkeep for Contact {
    fn remove_elements(&mut self, deleted: &[ElementNodes]) {
        let Contact { curves, shown, uncovered, .. } = self;
        for curve in curves.iter_mut() {
            let points = deleted.iter().filter_map(|boundary| shown.points(boundary));
            if curve.release(points) {
                curve.list();
                *uncovered = true;
            }
        }
    }
}

impl StoredConstraint for Contact {
    fn continue_from(&mut self, previous: &dyn Constraint) {
        if let Some(previous) = (previous as &dyn Any).downcast_ref::<Contact>() {
            self.take_over(previous);
        }
    }

    fn memory(&self) -> MemoryUse {
        let of_pair = |p: &Pair| p.search.memory() + MemoryUse::of(&p.seen);
        MemoryUse::of(&self.pairs)
            + self.pairs.iter().map(of_pair).sum()
            + MemoryUse::of(&self.curves)
            + self.curves.iter().map(Curve::memory).sum()
            + self.gaps.memory()
            + self.shown.memory()
            + self.rows.memory()
            + MemoryUse::of(&self.points)
            + MemoryUse::of(&self.analyticals)
            + MemoryUse::of(&self.feet)
            + MemoryUse::of(&self.laws)
            + MemoryUse::of(&self.dofs_of)
            + MemoryUse::of(&self.dofs)
            + MemoryUse::of(&self.pressures)
            + MemoryUse::of(&self.fits)
            + MemoryUse::of(&self.means)
            + MemoryUse::of(&self.places)
            + MemoryUse::of(&self.near)
            + MemoryUse::of(&self.listed)
            + MemoryUse::of(&self.impulses)
            + MemoryUse::of(&self.bodies)
            + MemoryUse::of(&self.motion.velocity)
            + MemoryUse::of(&self.motion.inverse_mass)
            + self.crossing.iter().map(|crossing| crossing.memory()).sum()
    }
}

persist_struct!(Carried { pushed } derived { dof, body, prescribed });

persist_struct!(Contact {
    curves: fixed, pressures: fixed, impulses: fixed, bodies: fixed, half, shown, uncovered, crossing: present
} derived {
    points, pairs, analyticals, feet, laws, dofs_of, dofs, fits, springs, means, places, near, listed, gaps, rows, motion
} then Contact::list_again);

impl Contact {
    /// Lists are made from what has been read; rows do not depend on when they were made.
    fn list_again(&mut self, archive: &mut Archive<'_>) {
        if archive.reads() {
            self.list_points();
        }
    }
}
