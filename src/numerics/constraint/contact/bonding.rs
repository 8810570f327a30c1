//! Bonds of contact surfaces as part of the contact: which points are bonded, tractions and impulses, energies, the bound
//! of the frequency, output, and continuation in the next step.

use std::collections::HashMap;

use super::cohesion::{BondStatus, BondedPoint, CohesivePair, CohesiveSurfaces, FootVector, opened};
use super::continuation::previous_ends;
use super::curve::{FacetCurve, PointCarrier};
use super::dofs::ContactDofs;
use super::pairs::{ContactPair, pair_of};
use super::shown::SurfaceForces;
use super::surfaces::{ContactSurfaces, PointIdentity};
use super::sweeps::NONE;
use super::system::ContactSystem;
use crate::constraint::NodeRelation;
use crate::kernel::lanes::InlineMap;
use crate::kernel::traction_separation::{DissipatedEnergy, TractionSeparationLaw};
use crate::state::archive::StateArchive;
use crate::state::dofs::{Dof, Dofs};
use crate::variables::Variable;

/// Largest gap of a point that is bonded when its pair comes into force, as a fraction of the facet length of the pair.
/// Meshes of matching curved surfaces have such gaps.
const TOUCHING: f64 = 0.05;

/// Factor of the normal stiffness in the bound of the frequency. Normal tractions act in tension only: a body that pulls at
/// a spring of the frequency ω for one increment gets back at most its energy if (ω dt)² <= 2, and not 4.
const ONE_SIDED: f64 = 2.0;

impl CohesiveSurfaces {
    /// Creates the cohesive behaviour of `pairs`, which ascend by the index of the contact pair.
    pub(super) fn new(
        contact: &mut ContactSystem,
        laws: Vec<TractionSeparationLaw>,
        mut pairs: Vec<CohesivePair>,
    ) -> CohesiveSurfaces {
        let ContactSystem { surfaces, pairs: contact_pairs, dofs, .. } = contact;
        let mut count = 0;
        for cohesive in &mut pairs {
            let pair = &mut contact_pairs[cohesive.pair];
            pair.is_cohesive = true;
            cohesive.first = count;
            count += surfaces.curves[pair.secondary].points.len();
        }
        surfaces.active.activate(pairs.iter().map(|cohesive| cohesive.pair), contact_pairs, &surfaces.curves);
        CohesiveSurfaces {
            laws,
            pairs,
            points: vec![BondedPoint::default(); count],
            impulses: vec![0.0; dofs.count()],
            sums: vec![0.0; dofs.count()],
            squared_frequency: 0.0,
        }
    }

    /// Returns the points of a cohesive pair.
    fn points_of(&self, contact: &ContactSystem, cohesive: &CohesivePair) -> &[BondedPoint] {
        let count = contact.surfaces.curves[contact.pairs[cohesive.pair].secondary].points.len();
        &self.points[cohesive.first..cohesive.first + count]
    }

    /// Returns the numbers of bonded points and of all points on the secondary surface of a pair; `None` without cohesive
    /// behaviour.
    pub(super) fn bonded_points(&self, contact: &ContactSystem, pair: usize) -> Option<[usize; 2]> {
        let points = self.points_of(contact, &self.pairs[self.index_of(pair)?]);
        Some([points.iter().filter(|point| point.status == BondStatus::Bonded).count(), points.len()])
    }

    /// Returns the index of the cohesive behaviour of a pair of the contact; `None` without one.
    pub(super) fn index_of(&self, pair: usize) -> Option<usize> {
        self.pairs.binary_search_by_key(&pair, |cohesive| cohesive.pair).ok()
    }

    /// Returns the indices of the cohesive pair and of the point that a key of the contact belongs to.
    fn place_of(&self, contact: &ContactSystem, key: u32) -> Option<(usize, usize)> {
        let pair = pair_of(&contact.pairs, key);
        let cohesive = self.index_of(pair)?;
        let ContactPair { secondary, first_key, .. } = contact.pairs[pair];
        let index = (key - first_key) as usize;
        (index < contact.surfaces.curves[secondary].points.len())
            .then_some((cohesive, self.pairs[cohesive].first + index))
    }

    /// Bonds the points of new pairs that are in contact according to the current rows.
    pub(super) fn bond_new_pairs(&mut self, contact: &ContactSystem) {
        for at in 0..self.pairs.len() {
            if !self.pairs[at].has_begun {
                let count = contact.surfaces.curves[contact.pairs[self.pairs[at].pair].secondary].points.len();
                let first = self.pairs[at].first;
                self.points[first..first + count].fill(BondedPoint::default());
            }
        }
        for row in &contact.measured.rows.rows {
            let Some((at, point)) = self.place_of(contact, row.key).filter(|found| !self.pairs[found.0].has_begun)
            else {
                continue;
            };
            let pair = &contact.pairs[self.pairs[at].pair];
            if row.gap <= TOUCHING * pair.search.length * row.area {
                self.points[point] = bond(contact, pair, point - self.pairs[at].first, row.area).unwrap_or_default();
            }
        }
    }

    /// Bonds points that have come into contact in the previous increment.
    fn bond_pressed_points(&mut self, contact: &ContactSystem) {
        if !self.pairs.iter().any(|cohesive| cohesive.bonds_later || cohesive.bonds_again) {
            return;
        }
        for row in &contact.measured.rows.rows {
            let Some((at, point)) = self.place_of(contact, row.key) else { continue };
            let cohesive = &self.pairs[at];
            let bonds = match self.points[point].status {
                BondStatus::Free => cohesive.bonds_later,
                BondStatus::Separated => cohesive.bonds_again,
                BondStatus::Bonded | BondStatus::Failed => false,
            };
            if bonds && contact.keys.pressures[row.key as usize][0] > 0.0 {
                let bonded = bond(contact, &contact.pairs[cohesive.pair], point - cohesive.first, row.area);
                self.points[point] = bonded.unwrap_or(self.points[point]);
            }
        }
    }

    /// Updates separations and tractions at the start of an increment, after the time `dt` of the previous one, and the
    /// impulses over the time `half`. Returns the energy that damage and the deletion of elements dissipate.
    fn update(&mut self, contact: &ContactSystem, [half, dt]: [f64; 2]) -> DissipatedEnergy {
        let CohesiveSurfaces { laws, pairs, points, impulses, .. } = self;
        impulses.fill(0.0);
        let mut dissipated = DissipatedEnergy::default();
        for cohesive in pairs.iter() {
            let pair = &contact.pairs[cohesive.pair];
            let (secondary, other) = contact.surfaces.sides(pair);
            for (index, &place) in secondary.points.iter().enumerate() {
                let point = &mut points[cohesive.first + index];
                if point.status == BondStatus::Failed
                    && contact.keys.pressures[pair.first_key as usize + index][0] == 0.0
                {
                    point.status = BondStatus::Separated;
                }
                if point.status != BondStatus::Bonded {
                    continue;
                }
                let law = &laws[cohesive.law_of(index)];
                if !has_surfaces(secondary, index, other, point.facet) {
                    dissipated.add(law.released(point.history.damage, opened(point.separation)), point.area);
                    (point.status, point.traction, point.history.damage) = (BondStatus::Failed, [0.0; 2], 1.0);
                    continue;
                }
                let shape = &other.shapes[point.facet as usize];
                let foot = FootVector::new(shape, point.part, contact.surfaces.places[place as usize]);
                dissipated.add(point.separate(law, &foot, dt), 1.0);
                let between = point.traction.inline_map(|traction| point.area * traction * half);
                let [a, b] = other.facets[point.facet as usize];
                for (at, impulse) in [place, a, b].into_iter().zip(foot.forces(point.part, between)) {
                    add_impulse(&contact.dofs, impulses, at, impulse);
                }
            }
        }
        dissipated
    }

    /// Computes the bound of the frequency from the stiffness of the bonds and the masses that they join, by the theorem of
    /// Gershgorin as [`crate::element::cohesive::bounds`].
    fn bound_frequency(&mut self, contact: &ContactSystem) {
        let mut sums = std::mem::take(&mut self.sums);
        sums.fill(0.0);
        self.for_each_bond(contact, |stiffness, ends| {
            for (dof, weight) in ends {
                if dof != NONE {
                    sums[dof as usize] += weight.abs() * stiffness;
                }
            }
        });
        let mut squared: f64 = 0.0;
        self.for_each_bond(contact, |_, ends| {
            let row = |(dof, weight): (u32, f64)| match sums.get(dof as usize) {
                Some(sum) => weight.abs() * sum * contact.dofs.motion.inverse_mass[dof as usize],
                None => 0.0,
            };
            squared = squared.max(ends.inline_map(row).iter().sum());
        });
        (self.sums, self.squared_frequency) = (sums, squared);
    }

    /// Passes to `visit` the stiffness of each bond along r and z, and the degrees of freedom of the point and both ends of
    /// the facet with their weights.
    fn for_each_bond(&self, contact: &ContactSystem, mut visit: impl FnMut(f64, [(u32, f64); 3])) {
        for cohesive in &self.pairs {
            let (secondary, other) = contact.surfaces.sides(&contact.pairs[cohesive.pair]);
            for (index, &place) in secondary.points.iter().enumerate() {
                let point = &self.points[cohesive.first + index];
                if point.status != BondStatus::Bonded {
                    continue;
                }
                let stiffness = self.laws[cohesive.law_of(index)].largest_stiffness(ONE_SIDED);
                let [a, b] = other.facets[point.facet as usize];
                let leverage = point.leverage(other.shapes[point.facet as usize].length);
                for axis in 0..2 {
                    let dof = |at: u32| contact.dofs.of_points[at as usize][axis];
                    let ends =
                        [(dof(place), 1.0), (dof(a), 1.0 - point.part + leverage), (dof(b), point.part + leverage)];
                    visit(point.area * stiffness, ends);
                }
            }
        }
    }

    /// Bonds the points of pairs that come into force at the current coordinates, and bounds the frequency.
    pub(super) fn begin(&mut self, contact: &mut ContactSystem, dofs: &Dofs) {
        let any_new = self.pairs.iter().any(|cohesive| !cohesive.has_begun);
        if contact.surfaces.uncovered || any_new {
            // All positions are read.
            contact.surfaces.list_points();
        }
        contact.read_motion(dofs, 0.0);
        if any_new {
            measure_current(contact, dofs);
            self.bond_new_pairs(contact);
        }
        self.pairs.iter_mut().for_each(|cohesive| cohesive.has_begun = true);
        self.bound_frequency(contact);
    }

    /// Updates the bonds at the start of an increment of length `dt` and applies their impulses to the motion over it.
    /// Friction does not act on points whose bond has no damage.
    pub(super) fn act(&mut self, contact: &mut ContactSystem, dofs: &mut Dofs, dt: f64) {
        self.bond_pressed_points(contact);
        book_dissipation(self.update(contact, [contact.dofs.half, 2.0 * contact.dofs.half - dt]), dofs);
        self.bound_frequency(contact);
        for index in 0..contact.measured.rows.rows.len() {
            let key = contact.measured.rows.rows[index].key;
            let Some((pair, point)) = self.place_of(contact, key) else { continue };
            let (cohesive, bonded) = (&self.pairs[pair], &self.points[point]);
            if bonded.status == BondStatus::Bonded && bonded.history.damage == 0.0 {
                let law = if contact.pairs[cohesive.pair].springs { point - cohesive.first } else { 0 };
                contact.measured.rows.rows[index].law = (cohesive.intact_law + law) as u32;
            }
        }
        for i in 0..contact.dofs.count() {
            let change = contact.dofs.motion.inverse_mass[i] * self.impulses[i];
            if change != 0.0 {
                contact.dofs.motion.velocity[i] += change;
                contact.dofs.change_velocity(i, change, dofs, dt);
            }
        }
    }

    /// Adds the work of the bonds after the impulses of contact: the impulse times the mean of the velocities before and
    /// after all impulses. The work on a prescribed motion is external work.
    pub(super) fn add_work(&self, contact: &ContactDofs, dofs: &mut Dofs, dt: f64) {
        let Dofs { bodies, nodes, energies, .. } = dofs;
        let (mut work, half) = (0.0, contact.half);
        for (i, &(dof, prescribed)) in contact.list.iter().enumerate().filter(|(i, _)| self.impulses[*i] != 0.0) {
            let impulse = self.impulses[i];
            let mean = match dof {
                Dof::Node(n, axis) => {
                    let after = *nodes[n].velocity(axis);
                    after - 0.5 * half * nodes.acceleration[n][axis]
                }
                Dof::Body(b) => {
                    let body = &bodies[b];
                    let previous = body.before.velocity - (half - 0.5 * dt) * body.acceleration;
                    if !prescribed {
                        // The impulses of contact have taken this work for that of another contact.
                        let change = contact.motion.inverse_mass[i] * impulse;
                        let [normal, slip] = contact.impulses[i];
                        energies.contact += 0.5 * change * (normal + slip);
                    }
                    0.5 * (previous + body.velocity_half)
                }
            };
            if prescribed {
                energies.external -= impulse * mean;
            }
            work += impulse * mean;
        }
        energies.internal -= work;
    }

    /// Adds the impulses over half an increment to the velocities at mid-increment, as
    /// [`ContactSystem::complete_velocities`] does for those of contact. Returns their work on free degrees of freedom.
    pub(super) fn complete_velocities(&mut self, contact: &mut ContactSystem, dofs: &mut Dofs) -> f64 {
        let dt = dofs.nodes.previous_dt;
        if contact.dofs.half == 0.0 || dt == 0.0 {
            return 0.0;
        }
        contact.begin_mesh_motion(dofs);
        book_dissipation(self.update(contact, [0.5 * dt, dt]), dofs);
        let (mut work, mut work_on_free) = (0.0, 0.0);
        for (i, &(_, prescribed)) in contact.dofs.list.iter().enumerate().filter(|(i, _)| self.impulses[*i] != 0.0) {
            let impulse = self.impulses[i];
            let change = contact.dofs.motion.inverse_mass[i] * impulse;
            let of_impulse = impulse * (contact.dofs.complete_velocity(i, change, dofs) + 0.5 * change);
            work += of_impulse;
            if prescribed {
                dofs.energies.external -= of_impulse;
            } else {
                work_on_free += of_impulse;
            }
        }
        dofs.energies.internal -= work;
        work_on_free
    }

    /// Takes the bonds of the pairs that the previous contact has, too. Bonded surfaces have no new meshes themselves.
    pub(super) fn take_over(
        &mut self,
        contact: &ContactSystem,
        old_cohesion: &CohesiveSurfaces,
        (previous, nodes): (&ContactSystem, &NodeRelation<'_>),
    ) {
        let ContactSystem { surfaces, pairs, .. } = contact;
        for cohesive in &mut self.pairs {
            let pair = &pairs[cohesive.pair];
            let is_same = |old: &&CohesivePair| pair.continues(&previous.pairs[old.pair]);
            if let Some(old) = old_cohesion.pairs.iter().find(is_same) {
                cohesive.has_begun = true;
                let old = BondedSurface {
                    surfaces: &previous.surfaces,
                    pair: &previous.pairs[old.pair],
                    points: &old_cohesion.points[old.first..],
                };
                old.pass_bonds((surfaces, pair), &mut self.points[cohesive.first..], nodes);
            }
        }
    }

    /// Rejects bonds to facets that do not exist.
    pub(super) fn check(&self, contact: &ContactSystem, archive: &mut StateArchive<'_>) {
        for cohesive in &self.pairs {
            let (_, other) = contact.surfaces.sides(&contact.pairs[cohesive.pair]);
            let exists =
                |point: &BondedPoint| point.status != BondStatus::Bonded || (point.facet as usize) < other.facets.len();
            if !self.points_of(contact, cohesive).iter().all(exists) {
                archive.reject(|| "a contact point is bonded to a facet that does not exist".to_owned());
            }
        }
    }

    /// Returns pressure and shear stress of the bond of a key.
    pub(super) fn stresses(&self, contact: &ContactSystem, key: usize) -> [f64; 2] {
        let bond = self.place_of(contact, key as u32);
        bond.map_or([0.0; 2], |(_, point)| self.points[point].traction.inline_map(|traction| -traction))
    }

    /// Returns an output variable of a bond; `None` for other variables, and for a key without cohesive behaviour.
    pub(super) fn value(&self, contact: &ContactSystem, key: usize, variable: Variable) -> Option<f64> {
        let (cohesive, point) = self.place_of(contact, key as u32)?;
        let history = &self.points[point].history;
        match variable {
            Variable::SurfaceDamage => Some(history.damage),
            _ => (self.pairs[cohesive].criterion == Some(variable)).then_some(history.criterion),
        }
    }

    /// Adds the forces of bonds on the own surface of a pair.
    pub(super) fn add_forces(&self, contact: &ContactSystem, pair: &ContactPair, sum: &mut SurfaceForces) {
        let Some(at) = self.index_of(pair_of(&contact.pairs, pair.first_key)) else { return };
        let (_, other) = contact.surfaces.sides(pair);
        for point in self.points_of(contact, &self.pairs[at]) {
            let BondedPoint { status, facet, area, traction, .. } = *point;
            if status != BondStatus::Bonded {
                continue;
            }
            let shape = &other.shapes[facet as usize];
            for i in 0..2 {
                sum.pressure[i] -= contact.dofs.output_share * area * traction[0] * shape.normal[i];
                sum.friction[i] -= contact.dofs.output_share * area * traction[1] * shape.along[i] / shape.length;
            }
        }
    }
}

/// Returns whether neither the surface around a point nor the facet of its foot has lost its element.
fn has_surfaces(own: &FacetCurve, index: usize, other: &FacetCurve, facet: u32) -> bool {
    other.is_exposed[facet as usize] && own.exposed_around(index).next().is_some()
}

/// Adds an impulse on a point.
fn add_impulse(contact: &ContactDofs, impulses: &mut [f64], point: u32, impulse: [f64; 2]) {
    for (dof, part) in contact.of_points[point as usize].into_iter().zip(impulse) {
        if dof != NONE {
            impulses[dof as usize] += part;
        }
    }
}

/// Returns a point of the own curve of a pair as bonded to the closest opposite facet; `None` if there is none.
fn bond(contact: &ContactSystem, pair: &ContactPair, index: usize, area: f64) -> Option<BondedPoint> {
    let (secondary, other) = contact.surfaces.sides(pair);
    let point = secondary.points[index];
    let position = contact.surfaces.places[point as usize];
    let mut best: Option<(f64, u32, f64)> = None;
    for &(k, _) in secondary.exposed_around(index) {
        let shares = contact.measured.facets.shares_of(&pair.facet_gaps[k as usize]);
        for (facet, _) in shares.iter().flat_map(|share| other.around(share.point)) {
            let (normal, shape) = (secondary.shapes[k as usize].normal, &other.shapes[facet as usize]);
            let faces = normal[0] * shape.normal[0] + normal[1] * shape.normal[1] < 0.0;
            if !other.is_exposed[facet as usize] || !faces || other.facets[facet as usize].contains(&point) {
                continue;
            }
            let d = [position[0] - shape.from[0], position[1] - shape.from[1]];
            let along = d[0] * shape.along[0] + d[1] * shape.along[1];
            let part = (along / (shape.length * shape.length)).clamp(0.0, 1.0);
            let apart = [0, 1].inline_map(|i: usize| d[i] - part * shape.along[i]);
            let square = apart[0] * apart[0] + apart[1] * apart[1];
            if best.is_none_or(|(least, known, _)| square < least || square == least && facet < known) {
                best = Some((square, facet, part));
            }
        }
    }
    let (_, facet, part) = best?;
    let reference = FootVector::new(&other.shapes[facet as usize], part, position).components;
    Some(BondedPoint { status: BondStatus::Bonded, facet, part, area, reference, ..BondedPoint::default() })
}

/// Measures the gaps between the increments.
fn measure_current(contact: &mut ContactSystem, dofs: &Dofs) {
    for (point, place) in contact.surfaces.points.iter().zip(&mut contact.surfaces.places) {
        if let PointCarrier::Body(body, [r, z]) = point.carrier {
            *place = [r, z + dofs.bodies[body].displacement];
        }
    }
    if contact.surfaces.uncovered {
        contact.surfaces.find_neighbors();
    }
    contact.search();
    contact.measure(0.0);
    contact.keys.store_openings(&contact.measured.rows.rows);
}

/// Adds the energy that bonds dissipate.
fn book_dissipation(dissipated: DissipatedEnergy, dofs: &mut Dofs) {
    dofs.energies.plastic += dissipated.by_damage;
    dofs.energies.damaged += dissipated.by_damage;
    dofs.energies.internal -= dissipated.by_viscosity;
    dofs.energies.viscous += dissipated.by_viscosity;
}

/// The bonds of a cohesive pair of a previous contact.
struct BondedSurface<'a> {
    surfaces: &'a ContactSurfaces,
    pair: &'a ContactPair,
    /// Points of its secondary surface, which come first.
    points: &'a [BondedPoint],
}

impl BondedSurface<'_> {
    /// Passes the bonds to the `points` of the pair that continues.
    fn pass_bonds(
        &self,
        (surfaces, pair): (&ContactSurfaces, &ContactPair),
        points: &mut [BondedPoint],
        nodes: &NodeRelation<'_>,
    ) {
        let same = |point: PointIdentity| {
            previous_ends(point, nodes).and_then(|(ends, _)| (ends[0] == ends[1]).then_some(ends[0]))
        };
        let facets: HashMap<[Option<PointIdentity>; 2], u32> = surfaces
            .facet_owners(pair.other.unwrap_or(pair.secondary))
            .map(|facet| facet.inline_map(same))
            .zip(0..)
            .collect();
        let old_facets = self.surfaces.facet_owners(self.pair.other.unwrap_or(self.pair.secondary));
        let old_facets: Vec<_> = old_facets.map(|facet| facet.inline_map(Some)).collect();
        let old_points =
            self.surfaces.curves[self.pair.secondary].points.iter().map(|point| self.surfaces.identity(*point));
        let known: HashMap<_, &BondedPoint> = old_points.zip(self.points).collect();
        for (number, point) in surfaces.curves[pair.secondary].points.iter().zip(points) {
            let previous = same(surfaces.identity(*number)).and_then(|point| known.get(&point));
            *point = previous.map_or(BondedPoint::default(), |known| **known);
            match old_facets.get(point.facet as usize).and_then(|facet| facets.get(facet)) {
                Some(facet) => point.facet = *facet,
                // The surface no longer contains the facet of the foot.
                None => *point = BondedPoint::default(),
            }
        }
    }
}
