//! Contact of surfaces with each other, with themselves and with analytical surfaces. Overlaps do not grow, for any
//! stiffness of the bodies.
//!
//! Each point of one surface of a pair carries a pressure. It is the Lagrange multiplier of the gap in front of the
//! point, weighted with the point's hat function over the surface of revolution ([`gaps`]). The impulses of an
//! increment satisfy `G v + max(g, 0)/dt >= 0` for the velocities `v` after the impulses. Pressures are not negative,
//! and friction is within Coulomb's cone ([`sweeps`]). An existing overlap is kept and not pushed apart. In front of an
//! analytical surface each point has a separate gap ([`analytical`]). Contact does not limit the time increment.

mod active_pairs;
pub mod analytical;
mod analytical_rows;
mod area;
mod bonding;
pub mod cohesion;
mod continuation;
pub mod curve;
mod direct;
mod dofs;
mod gaps;
pub mod heat;
mod impact;
mod impact_limit;
mod keys;
mod light;
mod measured_gaps;
mod mesh_continuation;
mod mesh_motion;
mod near;
mod pairs;
mod search;
mod shown;
mod slip_damping;
pub mod stations;
mod stored_energy;
mod surfaces;
mod sweeps;
mod user_friction;
pub mod wall_stations;
mod written;

use self::analytical::AnalyticalSurface;
use self::cohesion::CohesiveSurfaces;
use self::curve::{FacetCurve, SurfacePoint};
use self::dofs::ContactDofs;
use self::gaps::GapIntegrator;
use self::heat::{ContactHeat, HeatKey};
use self::impact_limit::ImpactLimit;
use self::keys::KeyValues;
use self::measured_gaps::{GapSources, MeasuredGaps};
use self::mesh_continuation::MeshContinuation;
use self::pairs::pair_of;
pub use self::pairs::{ContactPair, InitialClearance};
use self::stations::StationContact;
use self::surfaces::ContactSurfaces;
use self::sweeps::{ContactInterval, ContactRow, ContactStep};
use self::user_friction::FrictionScene;
use super::bonds::MergedDofs;
use super::{Constraint, ConstraintForces, NodeRelation, StoredConstraint};
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::routines::FrictionInput;
use crate::state::EffectId;
use crate::state::archive::{Persist, StateArchive};
use crate::state::dofs::{Dof, Dofs};
use crate::state::energies::EnergyTotals;
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::AmplitudeClock;

/// Contact of all pairs of a step.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: pairs, stations; present: heat, cohesion; derived: laws, measured, mesh; then: ContactConstraint::list_again)]
#[memory(flat: laws; inside: cohesion, heat, mesh)]
pub struct ContactConstraint {
    surfaces: ContactSurfaces,
    pairs: Vec<ContactPair>,
    /// Pairs of a rigid body with six degrees of freedom and an analytical surface.
    stations: Vec<StationContact>,
    laws: Vec<InteractionLaw>,
    dofs: ContactDofs,
    keys: KeyValues,
    measured: MeasuredGaps,
    /// Limit of the time increment by impacts.
    impact: ImpactLimit,
    /// Bonds of surfaces; `None` without cohesive behaviour.
    cohesion: Option<Box<CohesiveSurfaces>>,
    /// Heat exchange; `None` if no temperatures are solved for.
    heat: Option<Box<ContactHeat>>,
    /// Continuation of contact when adaptive meshes change; `None` without such meshes.
    mesh: Option<Box<MeshContinuation>>,
}

/// An overlap of two surfaces at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceOverlap {
    /// Depth, as the mean over the hat function of a point.
    pub depth: f64,
    /// Coordinates of the point.
    pub place: [f64; 2],
}

/// Gaps of a pair at the start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InitialGaps {
    /// The deepest overlap that is kept.
    pub overlap: Option<SurfaceOverlap>,
    /// Points whose gaps are set to the initial clearance.
    pub adjusted: Vec<AdjustedGap>,
}

/// A gap at the start that is set to the initial clearance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdjustedGap {
    /// Index of the point.
    pub point: u32,
    /// Geometric gap; negative for an overlap.
    pub gap: f64,
}

impl ContactConstraint {
    /// Creates contact of pairs of curves, and of curves with analytical surfaces.
    pub fn new(
        points: Vec<SurfacePoint>,
        curves: Vec<FacetCurve>,
        analyticals: Vec<AnalyticalSurface>,
        mut pairs: Vec<ContactPair>,
        laws: Vec<InteractionLaw>,
    ) -> ContactConstraint {
        let mut surfaces = ContactSurfaces::new(points, curves, analyticals);
        let keys = surfaces.list_pairs(&mut pairs);
        let dofs = ContactDofs::new(&surfaces.points);
        let facets: usize = pairs.iter().map(|pair| pair.facet_gaps.len()).sum();
        let on_analyticals = pairs.iter().filter(|pair| pair.analytical.is_some());
        let closest = on_analyticals.map(|pair| 2 * surfaces.curves[pair.secondary].points.len()).sum();
        let mut measured = MeasuredGaps {
            facets: GapIntegrator::new(facets),
            closest: Vec::with_capacity(closest),
            ..MeasuredGaps::default()
        };
        measured.rows.reserve(keys as usize, dofs.count());
        surfaces.reserve_near(dofs.count());
        let mut keys = KeyValues::new(keys as usize, &laws);
        if let Some(friction) = &mut keys.user_friction {
            friction.points = points_of_keys(&surfaces, &pairs);
        }
        ContactConstraint { surfaces, pairs, laws, dofs, keys, measured, ..ContactConstraint::default() }
    }

    /// Returns the contact with additional pairs of rigid bodies with six degrees of freedom.
    pub fn with_stations(self, stations: Vec<StationContact>) -> ContactConstraint {
        ContactConstraint { stations, ..self }
    }

    /// Returns the contact in which the points of each set of nodes with equal motion have one common degree of freedom.
    /// The first node of a set is the one with the prescribed motion, if there is one; `SurfacePoint::free` of its points
    /// states whether there is.
    pub fn with_equal_motions(mut self, sets: Vec<MergedDofs>) -> ContactConstraint {
        self.dofs.merge(sets, &self.surfaces.points);
        self
    }

    /// Sets the node numbers that a user subroutine for friction receives; `number` returns that of a point.
    pub fn with_node_numbers(mut self, number: impl Fn(u32) -> i32) -> ContactConstraint {
        if let Some(friction) = &mut self.keys.user_friction {
            friction.numbers = (0..self.surfaces.points.len() as u32).map(number).collect();
        }
        self
    }

    /// Returns whether contact points belong to nodes with equal motion.
    pub fn has_equal_motions(&self) -> bool {
        !self.dofs.merged.is_empty()
    }

    /// Returns the contact with heat exchange; `has` returns whether a node has a temperature, `of_body` the node with
    /// the temperature of a rigid body.
    pub fn with_heat(
        mut self,
        has: impl Fn(usize) -> bool,
        of_body: impl Fn(usize) -> Option<usize>,
    ) -> ContactConstraint {
        let ContactConstraint { surfaces, pairs, dofs, keys: values, .. } = &self;
        let mut keys: Vec<HeatKey> = Vec::with_capacity(values.count());
        for pair in pairs {
            let points_of = |curve: usize| surfaces.curves[curve].points.iter().copied();
            let sink_of = |body: Option<usize>| body.and_then(&of_body).map(|node| node as u32);
            let sink = sink_of(match pair.analytical {
                Some(surface) => surfaces.body_of_point(surfaces.analyticals[surface].point),
                None => pair.other.and_then(|other| surfaces.body_of_curve(other)),
            });
            keys.extend(points_of(pair.secondary).map(|point| HeatKey { point, first: pair.first, sink }));
            let with_single_points = pair.other.filter(|other| surfaces.curves[*other].has_single_points());
            let own_sink = sink_of(surfaces.body_of_curve(pair.secondary));
            let single_points = with_single_points.into_iter().flat_map(points_of);
            keys.extend(single_points.map(|point| HeatKey { point, first: !pair.first, sink: own_sink }));
            if surfaces.has_two_keys(pair) {
                keys.extend(points_of(pair.secondary).map(|point| HeatKey { point, first: pair.first, sink }));
            }
        }
        let exchange = ContactHeat::new((&surfaces.points, &dofs.of_points), dofs.count(), keys, has);
        self.heat = Some(Box::new(exchange));
        self
    }

    /// Returns the heat exchange across the surfaces; `None` if no temperatures are solved for.
    pub fn heat(&self) -> Option<&ContactHeat> {
        self.heat.as_deref()
    }

    /// Measures the gaps at the start from the coordinates of the points, sets initial clearances and returns the
    /// gaps of each pair.
    pub fn start(&mut self, places: &[[f64; 2]]) -> Vec<InitialGaps> {
        self.surfaces.places.copy_from_slice(places);
        self.search();
        self.measure(0.0);
        let mut gaps = vec![InitialGaps::default(); self.pairs.len()];
        let mut offsets = vec![0.0; self.keys.count()];
        for row in &mut self.measured.rows.rows {
            let index = pair_of(&self.pairs, row.key);
            let (pair, mut gap) = (&self.pairs[index], row.gap / row.area);
            let point = self.surfaces.curves[pair.secondary].points.get((row.key - pair.first_key) as usize).copied();
            if let Some(clearance) = pair.initial_clearance.filter(|c| (c.range[0]..=c.range[1]).contains(&gap)) {
                offsets[row.key as usize] = gap - clearance.gap;
                gaps[index].adjusted.extend(point.map(|point| AdjustedGap { point, gap }));
                gap = clearance.gap;
                row.gap = gap * row.area;
            }
            let Some(point) = point else { continue };
            if gap < gaps[index].overlap.map_or(0.0, |overlap| -overlap.depth) {
                gaps[index].overlap = Some(SurfaceOverlap { depth: -gap, place: places[point as usize] });
            }
        }
        if offsets.iter().any(|offset| *offset != 0.0) {
            self.keys.gap_offsets = offsets;
        }
        self.keys.store_openings(&self.measured.rows.rows);
        self.update_heat_rows();
        self.bond_new_pairs();
        self.surfaces.listed.clear();
        gaps
    }

    /// Reads positions at the start of the increment and velocities without contact, of near points. Returns whether
    /// candidates must be searched again, because there are none or a point has moved too far; all points are then read.
    fn read_motion(&mut self, dofs: &Dofs, dt: f64) -> bool {
        let ContactConstraint { surfaces, dofs: own_dofs, .. } = self;
        let mut read_points = |surfaces: &mut ContactSurfaces, points: &[u32]| {
            for &point in points {
                surfaces.places[point as usize] = surfaces.place_of(point, dofs, dt);
                own_dofs.read_point(point as usize, surfaces.points[point as usize].carrier, dofs);
            }
        };
        let mut searches = surfaces.listed.is_empty();
        if !searches {
            let near = std::mem::take(&mut surfaces.near.points);
            read_points(surfaces, &near);
            surfaces.near.points = near;
            searches = surfaces.has_moved_far(dofs, dt);
        }
        if searches {
            let active_points = std::mem::take(&mut surfaces.active_points);
            read_points(surfaces, &active_points);
            surfaces.active_points = active_points;
        }
        own_dofs.read_merged(dofs);
        searches
    }

    /// Searches candidates from the shapes of all exposed facets.
    fn search(&mut self) {
        let ContactConstraint { surfaces, pairs, dofs, cohesion, .. } = self;
        let is_cohesive = |pair: usize| cohesion.as_ref().is_some_and(|cohesion| cohesion.index_of(pair).is_some());
        surfaces.search(pairs, is_cohesive, &dofs.of_points);
        self.begin_added_pairs();
    }

    /// Begins the pairs that the search has made active. In a run, soft contact of new pairs has stored no energy.
    fn begin_added_pairs(&mut self) {
        if self.dofs.half != 0.0 {
            for &index in &self.surfaces.active.added {
                self.keys.stored_energy.begin_keys(self.pairs[index as usize].keys());
            }
        }
    }

    /// Activates the pairs with values: those of a previous contact or of a restart file.
    fn activate_pairs_with_values(&mut self) {
        let has_values = |pair: &ContactPair| pair.has_touched || pair.keys().any(|key| self.keys.has_value(key));
        let indices: Vec<usize> = (0..self.pairs.len()).filter(|index| has_values(&self.pairs[*index])).collect();
        self.surfaces.active.activate(indices.into_iter(), &mut self.pairs, &self.surfaces.curves);
    }

    /// Measures the gaps of all pairs as rows, for an increment of length `dt`.
    fn measure(&mut self, dt: f64) {
        self.measured.clear();
        self.keys.clear_openings(&self.surfaces.active);
        self.measure_curves();
        for index in 0..self.surfaces.active.analytical.len() {
            self.measure_analytical(self.surfaces.active.analytical[index] as usize, dt);
        }
    }

    fn measure_curves(&mut self) {
        let ContactConstraint { surfaces, pairs, laws, dofs, keys, measured, .. } = self;
        surfaces.select_close(pairs);
        let sources = GapSources { surfaces, laws, keys, dofs_of: &dofs.of_points };
        for &index in &surfaces.active.near {
            measured.measure_pair(&mut pairs[index as usize], sources);
        }
    }

    /// Finds the neighbours of facets after elements have been deleted. The pressures of points without elements become
    /// zero: the multiplier of a single point is a force, and that of a point that has just lost its elements was a pressure.
    fn follow_deletions(&mut self) {
        if !std::mem::take(&mut self.surfaces.uncovered) {
            return;
        }
        self.surfaces.find_neighbors();
        for pair in self.surfaces.active.list.iter().map(|index| &self.pairs[*index as usize]) {
            for &index in &self.surfaces.curves[pair.secondary].orphans {
                self.keys.pressures[(pair.first_key + index) as usize] = [0.0; 2];
            }
        }
    }

    /// Applies the impulses to velocities and positions, and adds their work and the heat that friction generates.
    /// Equations (10.2), (10.6).
    fn apply_impulses(&mut self, dofs: &mut Dofs, dt: f64) {
        let work = self.dofs.apply_impulses(&self.surfaces.near.dofs, dofs, dt);
        let of_springs = self.add_row_work(1.0);
        if let Some(exchange) = &mut self.heat {
            let (rows, means) = (&self.measured.rows, &self.dofs.means);
            let rate =
                |row: &ContactRow| rows.terms_of(row).iter().map(|t| t.slip * means[t.dof as usize]).sum::<f64>();
            exchange.add_friction_heat(rows, &self.laws, |row| row.whole_shear() * rate(row));
        }
        add_energies(&mut dofs.energies, work.of_impulses, of_springs);
    }

    /// Adds the impulses of half an increment to the velocities at mid-increment, and their work. With the accelerations the
    /// velocities are then those at the current instant. Returns the work on free degrees of freedom, the kinetic energy
    /// that they gain.
    pub fn complete_velocities(&mut self, dofs: &mut Dofs) -> f64 {
        let previous_dt = dofs.nodes.previous_dt;
        if self.dofs.half == 0.0 || previous_dt == 0.0 {
            return 0.0;
        }
        let part = 0.5 * previous_dt / self.dofs.half;
        let work = self.dofs.complete_velocities(&self.surfaces.near.dofs, part, dofs);
        let of_springs = self.add_row_work(part);
        add_energies(&mut dofs.energies, work.of_impulses, of_springs);
        work.on_free_dofs
    }

    /// Adds the work of a part of the impulse of each row to the energy of its pair. Returns the work of penalty springs.
    fn add_row_work(&mut self, part: f64) -> f64 {
        let ContactConstraint { surfaces, pairs, dofs, measured, .. } = self;
        let mut of_springs = 0.0;
        for row in measured.rows.rows.iter().filter(|row| row.normal_impulse > 0.0) {
            let index = pair_of(pairs, row.key);
            let terms = measured.rows.terms_of(row).iter();
            let rate: f64 = terms.map(|t| t.normal * dofs.means[t.dof as usize]).sum();
            let (pair, work) = (&mut pairs[index], part * row.normal_impulse * rate);
            pair.absorbed -= work;
            if pair.springs && !row.is_single_point {
                of_springs += work;
            }
            if work > pair.largest_release.0 {
                let points = &surfaces.curves[pair.secondary].points;
                let point = points[(row.key - pair.first_key) as usize % points.len()];
                pair.largest_release = (work, surfaces.places[point as usize]);
            }
        }
        of_springs
    }

    /// Updates heat exchange before any row is left out.
    fn update_heat_rows(&mut self) {
        let ContactConstraint { surfaces, pairs, laws, keys, measured, heat, .. } = self;
        let Some(exchange) = heat else { return };
        exchange.update_rows(&measured.rows, laws, &keys.pressures);
        // Points near analytical surfaces have rows only while they approach.
        for pair in surfaces.active.analytical.iter().map(|index| &pairs[*index as usize]) {
            let secondary = &surfaces.curves[pair.secondary];
            for &index in &secondary.exposed_points {
                let key = pair.first_key + index;
                let (opening, [pressure, _]) = (keys.opening[key as usize], keys.pressures[key as usize]);
                if !opening.is_nan() {
                    let law = &laws[pair.law_of(index as usize) as usize];
                    let area = secondary.area(index as usize, &surfaces.places);
                    exchange.add_conduction(key, area, [opening, pressure], law);
                }
            }
        }
    }

    /// Solves for the impulses of the rows in an increment of length `dt`.
    fn solve(&mut self, dofs: &mut Dofs, dt: f64, friction: Option<FrictionInput<'_>>) -> Result<(), HaltReason> {
        let span = ContactInterval { dt, half: self.dofs.half };
        let ContactConstraint {
            surfaces: ContactSurfaces { active, .. }, laws, dofs: own_dofs, keys, measured, ..
        } = self;
        let (rows, motion, mut outcome) = (&mut measured.rows, &mut own_dofs.motion, Ok(()));
        dofs.energies.initial_overlap += keys.stored_energy.limit_overlaps(rows, laws, active);
        let step = ContactStep { laws, pressures: &keys.pressures, span };
        keys.slip_damping.begin(active);
        if let Some(reference) = rows.begin(motion, step) {
            keys.slip_damping.apply(rows, motion, step);
            if let Some(user_friction) = &keys.user_friction {
                user_friction.set_coefficients(rows, step);
            }
            rows.solve(motion, reference, step);
            self.correct_arc_gaps(reference, span);
            if let Some(mut input) = friction {
                outcome = self.solve_with_friction(reference, span, dofs.energies.friction, &mut input);
            }
        }
        let ContactConstraint {
            surfaces: ContactSurfaces { active, .. },
            pairs,
            laws,
            dofs: own_dofs,
            keys,
            measured,
            ..
        } = self;
        let (rows, motion) = (&measured.rows, &own_dofs.motion);
        keys.slip_damping.update(rows, motion, (laws, span.half), |key| pair_of(pairs, key), active);
        keys.stored_energy.add_work(rows, laws, motion, span);
        keys.store_pressures(rows, span.half, active);
        own_dofs.gather_impulses(rows);
        outcome
    }

    /// Calls the user subroutine for friction, and solves again if it has changed a friction coefficient.
    fn solve_with_friction(
        &mut self,
        reference: f64,
        span: ContactInterval,
        friction_work: f64,
        input: &mut FrictionInput<'_>,
    ) -> Result<(), HaltReason> {
        let ContactConstraint { surfaces, laws, dofs, keys, measured, .. } = self;
        let Some(user_friction) = &mut keys.user_friction else { return Ok(()) };
        let step = ContactStep { laws, pressures: &keys.pressures, span };
        if user_friction.call(&mut measured.rows, FrictionScene { surfaces, dofs, step, friction_work }, input)? {
            measured.rows.solve_again(&mut dofs.motion, reference, step);
            self.correct_arc_gaps(reference, span);
        }
        Ok(())
    }

    /// Moves the bodies over an increment; `friction` is the user subroutine for friction, if contact calls one.
    fn advance(&mut self, dofs: &mut Dofs, dt: f64, friction: Option<FrictionInput<'_>>) -> Result<(), HaltReason> {
        self.dofs.begin_increment(&dofs.nodes, dt);
        if self.surfaces.uncovered {
            self.surfaces.list_points();
        }
        let searches = self.read_motion(dofs, dt);
        self.follow_deletions();
        if searches {
            self.search();
        } else {
            self.surfaces.shape_near();
        }
        self.measure(dt);
        self.keys.store_openings(&self.measured.rows.rows);
        self.update_heat_rows();
        self.act_cohesion(dofs, dt);
        self.impact.advance(dt);
        self.limit_impacts(dt);
        let outcome = self.solve(dofs, dt, friction);
        self.apply_impulses(dofs, dt);
        self.add_cohesive_work(dofs, dt);
        self.stations.iter_mut().for_each(|stations| stations.act(&mut self.dofs, dofs, dt));
        let cohesion = self.cohesion.as_ref();
        self.dofs.push_bodies(dofs, |dof| cohesion.map_or(0.0, |cohesion| cohesion.impulses[dof]));
        self.keys.add_slip(&self.measured.rows, &self.dofs.motion, dt);
        outcome
    }

    /// Informs it that elements with these corner nodes have been deleted.
    pub fn remove_elements(&mut self, deleted: &[ElementNodes]) {
        self.surfaces.remove_elements(deleted);
    }

    /// Lists are built again after reading; rows do not depend on when lists were built.
    fn list_again(&mut self, archive: &mut StateArchive<'_>) {
        if archive.reads() {
            self.surfaces.list_points();
            self.activate_pairs_with_values();
            self.keys.forget_written();
            self.dofs.forget_written();
            self.check_bonds(archive);
        }
    }
}

/// Returns the point of each key.
fn points_of_keys(surfaces: &ContactSurfaces, pairs: &[ContactPair]) -> Vec<u32> {
    let of_pair = |pair: &ContactPair| {
        let (secondary, other) = surfaces.sides(pair);
        let points = secondary.points.iter().chain(&other.points).copied();
        points.take(pair.keys().len()).collect::<Vec<_>>()
    };
    pairs.iter().flat_map(of_pair).collect()
}

/// Adds the work of impulses along the normal and along the surface; that of springs is part of the former.
fn add_energies(energies: &mut EnergyTotals, work: [f64; 2], of_springs: f64) {
    energies.penalty -= of_springs;
    energies.contact -= work[0] - of_springs;
    energies.friction -= work[1];
}

impl Constraint for ContactConstraint {
    fn effect(&self) -> EffectId {
        let of_stations = self.stations.first().map_or(0, |stations| stations.pair.id);
        self.pairs.first().map_or(of_stations, |pair| pair.id)
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        let keys = self.keys.count();
        self.dofs.begin(&mut self.measured.rows, dofs);
        self.measured.rows.reserve(keys, self.dofs.count());
        self.dofs.reserve();
        self.keys.reserve();
        self.surfaces.reserve_near(self.dofs.count());
        self.surfaces.active.reserve(&mut self.pairs, &self.surfaces.curves);
        self.measured.facets.reserve(keys);
        if self.laws.iter().any(|law| law.is_soft()) {
            self.measured.facets.reserve_edges(keys);
        }
        self.begin_cohesion(dofs);
        self.limit_first_impacts(dofs);
        let starts = self.dofs.half == 0.0;
        self.stations.iter_mut().for_each(|stations| stations.begin(dofs, starts));
    }

    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {
        if self.dofs.half == 0.0 {
            return;
        }
        for known in self.dofs.bodies.iter().filter(|known| known.prescribed) {
            let impulse = self.whole_impulse(known.dof);
            dofs.bodies[known.body].reaction -= impulse / self.dofs.half * self.dofs.output_share;
        }
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>, dt: f64) {
        // Without a subroutine nothing fails.
        let _ = self.advance(dofs, dt, None);
    }

    fn motion_with_friction(
        &mut self,
        dofs: &mut Dofs,
        _clock: &AmplitudeClock<'_>,
        dt: f64,
        friction: FrictionInput<'_>,
    ) -> Result<(), HaltReason> {
        self.advance(dofs, dt, Some(friction))
    }

    fn max_increment(&self, _clock: &AmplitudeClock<'_>) -> IncrementLimit {
        let of_stations = self.stations.iter().map(|stations| stations.longest);
        IncrementLimit { time: of_stations.fold(self.impact.increment, f64::min), jump: false }
    }

    fn moves_nodes(&self) -> bool {
        !self.pairs.is_empty()
    }

    fn forces(&self) -> Option<&dyn ConstraintForces> {
        Some(self)
    }
}

impl ConstraintForces for ContactConstraint {
    fn constraint_force(&self, dof: Dof) -> f64 {
        let ContactDofs { half, output_share, .. } = self.dofs;
        if half == 0.0 {
            return 0.0;
        }
        self.index_of(dof).map_or(0.0, |index| self.whole_impulse(index) / half * output_share)
    }

    fn index_of(&self, dof: Dof) -> Option<usize> {
        self.dofs.index_of_prescribed(dof)
    }

    fn impulse(&self, _dof: Dof, index: usize, _half: f64) -> f64 {
        self.whole_impulse(index)
    }
}

impl StoredConstraint for ContactConstraint {
    fn continue_from(&mut self, previous: &dyn Constraint) {
        if let Some(previous) = previous.as_kind() {
            self.take_over(previous);
        }
    }

    fn follow_new_mesh(&mut self, previous: &dyn Constraint, nodes: &NodeRelation<'_>, dofs: &Dofs) {
        if let Some(previous) = previous.as_kind() {
            self.move_to_new_mesh(previous, nodes, dofs);
        }
    }
}
