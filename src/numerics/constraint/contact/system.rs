//! The system of a contact: surfaces, pairs, laws, degrees of freedom and values of the keys, with the search of
//! candidates, the rows of an increment and their solution.

use super::analytical::AnalyticalSurface;
use super::curve::{FacetCurve, SurfacePoint};
use super::dofs::ContactDofs;
use super::gaps::GapIntegrator;
use super::keys::KeyValues;
use super::measured_gaps::{GapSources, MeasuredGaps};
use super::pairs::{ContactPair, pair_of};
use super::surfaces::ContactSurfaces;
use super::sweeps::{ContactInterval, ContactStep};
use super::user_friction::FrictionScene;
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lists::Memory;
use crate::routines::FrictionInput;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::energies::{EnergyTotals, ImpactLosses};
use crate::state::halt::HaltReason;

/// Surfaces in contact, and what their impulses are solved from.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: pairs; derived: laws, measured)]
#[memory(flat: laws)]
pub struct ContactSystem {
    pub(super) surfaces: ContactSurfaces,
    pub(super) pairs: Vec<ContactPair>,
    pub(super) laws: Vec<InteractionLaw>,
    pub(super) dofs: ContactDofs,
    pub(super) keys: KeyValues,
    pub(super) measured: MeasuredGaps,
}

impl ContactSystem {
    /// Creates the system of pairs of curves, and of curves with analytical surfaces.
    pub(super) fn new(
        points: Vec<SurfacePoint>,
        curves: Vec<FacetCurve>,
        analyticals: Vec<AnalyticalSurface>,
        mut pairs: Vec<ContactPair>,
        laws: Vec<InteractionLaw>,
    ) -> ContactSystem {
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
        ContactSystem { surfaces, pairs, laws, dofs, keys, measured }
    }

    /// Takes the degrees of freedom of a step, and allocates what its increments need.
    pub(super) fn begin(&mut self, dofs: &mut Dofs) {
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
    }

    /// Returns the pairs of two surfaces with facets.
    pub(super) fn mesh_pairs(&self) -> impl Iterator<Item = &ContactPair> {
        self.pairs.iter().filter(|pair| pair.analytical.is_none())
    }

    /// Finds the surfaces that are near each other before adaptive meshes change, at the start of an increment of which only
    /// the motion of bodies has been made. The lists of earlier increments are not used, for they depend on when they were
    /// built.
    pub fn begin_mesh_motion(&mut self, dofs: &Dofs) {
        if self.mesh_pairs().next().is_none() {
            return;
        }
        if self.surfaces.uncovered {
            self.surfaces.list_points();
        }
        self.surfaces.read_places(|_| None, dofs);
        self.follow_deletions();
        self.search();
    }

    /// Builds the lists again after reading; rows do not depend on when lists were built.
    pub(super) fn list_again(&mut self) {
        self.surfaces.list_points();
        self.activate_pairs_with_values();
        self.keys.forget_written();
        self.dofs.forget_written();
    }

    /// Measures the gaps at the start of an increment, for which the motion is known.
    pub(super) fn begin_increment(&mut self, dofs: &Dofs, dt: f64) {
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
    }

    /// Applies the impulses to velocities and positions, and adds their work. Equations (10.2), (10.6).
    pub(super) fn apply_impulses(&mut self, dofs: &mut Dofs, dt: f64) {
        let work = self.dofs.apply_impulses(&self.surfaces.near.dofs, dofs, dt);
        let of_springs = self.add_row_work(1.0, &mut dofs.energies.impacts);
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
        let of_springs = self.add_row_work(part, &mut dofs.energies.impacts);
        add_energies(&mut dofs.energies, work.of_impulses, of_springs);
        work.on_free_dofs
    }

    /// Searches candidates from the shapes of all exposed facets.
    pub(super) fn search(&mut self) {
        self.surfaces.search(&mut self.pairs, &self.dofs.of_points);
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
    pub(super) fn measure(&mut self, dt: f64) {
        self.measured.clear();
        self.keys.clear_openings(&self.surfaces.active);
        self.measure_curves();
        let ContactSystem { surfaces, pairs, laws, dofs, keys, measured } = self;
        for &index in &surfaces.active.analytical {
            measured.measure_analytical(&pairs[index as usize], surfaces, laws, dofs, keys, dt);
        }
    }

    pub(super) fn measure_curves(&mut self) {
        let ContactSystem { surfaces, pairs, laws, dofs, keys, measured } = self;
        surfaces.select_close(pairs);
        let sources = GapSources { surfaces, laws, keys, dofs_of: &dofs.of_points };
        for &index in &surfaces.active.near {
            measured.measure_pair(&mut pairs[index as usize], sources);
        }
    }

    /// Finds the neighbours of facets after elements have been deleted. The pressures of points without elements become
    /// zero: the multiplier of a single point is a force, and that of a point that has just lost its elements was a pressure.
    pub(super) fn follow_deletions(&mut self) {
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

    /// Reads positions at the start of the increment and velocities without contact, of near points. Returns whether
    /// candidates must be searched again, because there are none or a point has moved too far; all points are then read.
    pub(super) fn read_motion(&mut self, dofs: &Dofs, dt: f64) -> bool {
        let ContactSystem { surfaces, dofs: own_dofs, .. } = self;
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

    /// Adds the work of a part of the impulse of each row to the energy of its pair and to the losses. Returns the work of
    /// penalty springs.
    fn add_row_work(&mut self, part: f64, losses: &mut ImpactLosses) -> f64 {
        let ContactSystem { surfaces, pairs, dofs, measured, .. } = self;
        let mut of_springs = 0.0;
        for row in measured.rows.rows.iter().filter(|row| row.normal_impulse > 0.0) {
            let index = pair_of(pairs, row.key);
            let terms = measured.rows.terms_of(row).iter();
            let rate: f64 = terms.map(|t| t.normal * dofs.means[t.dof as usize]).sum();
            let (pair, work) = (&mut pairs[index], part * row.normal_impulse * rate);
            pair.absorbed -= work;
            if pair.springs && !row.is_single_point {
                of_springs += work;
            } else {
                losses.add(row.impact, -work);
            }
            if work > pair.largest_release.0 {
                let points = &surfaces.curves[pair.secondary].points;
                let point = points[(row.key - pair.first_key) as usize % points.len()];
                pair.largest_release = (work, surfaces.places[point as usize]);
            }
        }
        of_springs
    }

    /// Solves for the impulses of the rows in an increment of length `dt`. `friction` is the user subroutine for friction; the
    /// impulses are solved for again if it changes a friction coefficient.
    pub(super) fn solve(
        &mut self,
        dofs: &mut Dofs,
        dt: f64,
        friction: Option<FrictionInput<'_>>,
    ) -> Result<(), HaltReason> {
        let ContactSystem { surfaces, pairs, laws, dofs: own_dofs, keys, measured } = self;
        let span = ContactInterval { dt, half: own_dofs.half };
        dofs.energies.initial_overlap += keys.stored_energy.limit_overlaps(&mut measured.rows, laws, &surfaces.active);
        let (step, mut outcome) = (ContactStep { laws, pressures: &keys.pressures, span }, Ok(()));
        keys.slip_damping.begin(&surfaces.active);
        if let Some(reference) = measured.rows.begin(&own_dofs.motion, step) {
            keys.slip_damping.apply(&mut measured.rows, &mut own_dofs.motion, step);
            if let Some(user_friction) = &keys.user_friction {
                user_friction.set_coefficients(&mut measured.rows, step);
            }
            measured.rows.solve(&mut own_dofs.motion, reference, step);
            measured.correct_arc_gaps(surfaces, own_dofs, reference, step);
            if let (Some(mut input), Some(user_friction)) = (friction, &mut keys.user_friction) {
                let scene = FrictionScene { surfaces, dofs: own_dofs, step, friction_work: dofs.energies.friction };
                let changes = user_friction.call(&mut measured.rows, scene, &mut input);
                if let Ok(true) = changes {
                    measured.rows.solve_again(&mut own_dofs.motion, reference, step);
                    measured.correct_arc_gaps(surfaces, own_dofs, reference, step);
                }
                outcome = changes.map(|_| ());
            }
        }
        let (rows, motion) = (&measured.rows, &own_dofs.motion);
        keys.slip_damping.update(rows, motion, (laws, span.half), |key| pair_of(pairs, key), &surfaces.active);
        keys.stored_energy.add_work(rows, laws, motion, span);
        keys.store_pressures(rows, span.half, &surfaces.active);
        own_dofs.gather_impulses(rows);
        outcome
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
