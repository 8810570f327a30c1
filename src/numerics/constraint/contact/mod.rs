//! Contact of surfaces with each other, with themselves and with analytical surfaces. Overlaps do not grow, for any
//! stiffness of the bodies.
//!
//! Each point of one surface of a pair carries a pressure. It is the Lagrange multiplier of the gap in front of the
//! point, weighted with the point's hat function over the surface of revolution ([`gaps`]). The impulses of an
//! increment satisfy `G v + max(g, 0)/dt >= 0` for the velocities `v` after the impulses. Pressures are not negative,
//! and friction is within Coulomb's cone ([`sweeps`]). An existing overlap is kept and not pushed apart. In front of an
//! analytical surface each point has a separate gap ([`analytical`]). Contact does not limit the time increment.

pub mod analytical;
mod area;
mod bonding;
pub mod cohesion;
mod continuation;
pub mod curve;
mod direct;
mod gaps;
pub mod heat;
mod impact;
mod impact_limit;
mod light;
mod mesh_continuation;
mod mesh_motion;
mod near;
mod search;
mod shown;
mod slip_damping;
mod stored_energy;
mod sweeps;

use crate::kernel::lanes::InlineMap;
use std::collections::HashMap;

use self::analytical::{AnalyticalSurface, ClosestPoint};
use self::cohesion::CohesiveSurfaces;
use self::curve::{FacetCurve, PointCarrier, SurfacePoint};
use self::gaps::{FacetGap, GapIntegrator};
use self::heat::{ContactHeat, HeatKey};
use self::impact_limit::ImpactLimit;
use self::mesh_continuation::MeshContinuation;
use self::near::NearParts;
use self::search::ContactSearch;
use self::shown::ContactOutput;
use self::slip_damping::SlipDamping;
use self::stored_energy::StoredEnergy;
use self::sweeps::{ContactInterval, ContactRow, ContactRows, ContactStep, ContactVelocities, NONE};
use super::bonds::MergedDofs;
use super::{Constraint, ConstraintForces, NodeRelation, StoredConstraint};
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::{Persist, StateArchive};
use crate::state::dofs::{Dof, Dofs};
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::AmplitudeClock;

/// Two surfaces that may come into contact, or one with self-contact.
#[derive(Clone, Debug, Memory)]
#[memory(uncounted: name)]
pub struct ContactPair {
    /// Row of the ledger.
    pub id: EffectId,
    /// Number among the pairs of all steps.
    pub number: usize,
    /// Name of the pair in warnings.
    pub name: String,
    /// Index of the curve whose points carry pressures.
    pub own: usize,
    /// Index of the other curve; `None` for self-contact and for an analytical surface.
    pub other: Option<usize>,
    /// Index of the analytical surface, if the other surface is one.
    pub analytical: Option<usize>,
    /// Index of the law of the pair; with penalty springs, the index of the first spring: each point of the own curve
    /// has one.
    pub law: usize,
    /// Whether the pair has penalty springs.
    pub springs: bool,
    /// Index of the law of single points, whose multipliers are impulses instead of pressures.
    pub of_points: usize,
    /// Whether the own curve is the first surface of the pair in the deck; output forces are those on the first
    /// surface.
    pub first: bool,
    /// Smallest thickness of the deformable elements at both surfaces; infinite without any, and in
    /// self-contact.
    pub thickness: f64,
    /// Clearance at the start, if the deck gives one.
    pub initial_clearance: Option<InitialClearance>,
    /// Energy that the pair has stored and dissipated in its normal direction.
    pub absorbed: f64,
    /// Largest energy that a row has released in an increment, and its coordinates.
    pub largest_release: (f64, [f64; 2]),
    search: ContactSearch,
    facet_gaps: Vec<FacetGap>,
    /// First key of the pair; each point of the own curve has one.
    first_key: u32,
}

impl ContactPair {
    /// Creates a pair of two curves, or of one curve with itself, with the first law of the contact. `length` is the
    /// smaller of the longest facets of both.
    pub fn new(id: EffectId, number: usize, [own, other]: [usize; 2], length: f64) -> ContactPair {
        let other = (own != other).then_some(other);
        let search = ContactSearch::new(length, 0.0, 0, 0);
        ContactPair {
            id,
            number,
            name: String::new(),
            own,
            other,
            analytical: None,
            law: 0,
            springs: false,
            of_points: 0,
            first: true,
            thickness: f64::INFINITY,
            initial_clearance: None,
            absorbed: 0.0,
            largest_release: (0.0, [0.0; 2]),
            search,
            facet_gaps: Vec::new(),
            first_key: 0,
        }
    }

    /// Creates a pair of a curve and an analytical surface.
    pub fn in_front_of(id: EffectId, number: usize, own: usize, analytical: usize, length: f64) -> ContactPair {
        ContactPair { analytical: Some(analytical), ..ContactPair::new(id, number, [own, own], length) }
    }

    /// Returns whether the pair and one of a previous contact are the same pair of the deck.
    fn continues(&self, previous: &ContactPair) -> bool {
        (self.number, self.first) == (previous.number, previous.first)
    }

    /// Returns the key of a point of the own curve; [`NONE`] for other points.
    fn key_of(&self, own: &FacetCurve, point: u32) -> u32 {
        own.own.binary_search(&point).map_or(NONE, |index| self.first_key + index as u32)
    }

    /// Returns the index of the law of an own point.
    fn law_of(&self, index: usize) -> u32 {
        (if self.springs { self.law + index } else { self.law }) as u32
    }

    /// Returns the gap at which the pressure of soft contact begins; `None` for hard contact. An initial clearance shifts
    /// the gaps of each point, so that pressure may begin at any gap.
    fn onset_gap(&self, laws: &[InteractionLaw]) -> Option<f64> {
        let law = &laws[self.law_of(0) as usize];
        let gap = if self.measures_closed_parts() { law.overclosure.onset_gap() } else { f64::INFINITY };
        law.is_soft().then_some(gap)
    }

    /// Returns whether soft contact of this pair leaves out the parts of facets without pressure.
    fn measures_closed_parts(&self) -> bool {
        self.analytical.is_none() && self.initial_clearance.is_none()
    }
}

/// Clearance that replaces the initial gaps within a range. The difference is subtracted from the gap in the whole
/// analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialClearance {
    /// Clearance that replaces the geometric gap; negative for an overlap.
    pub gap: f64,
    /// Smallest and largest geometric gap that is replaced; overlaps are negative.
    pub range: [f64; 2],
}

/// Contact of all pairs of a step.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(
    fixed: curves, pressures, gap_offsets, impulses, bodies;
    present: contact_heat, cohesion;
    derived: points, pairs, analyticals, feet, laws, dofs_of, dofs, merged, springs, means, places, active_points,
        near, listed, gaps, rows, motion, mesh;
    then: ContactConstraint::list_again
)]
#[memory(flat: analyticals, laws; inside: cohesion, contact_heat, mesh; uncounted: touched)]
pub struct ContactConstraint {
    points: Vec<SurfacePoint>,
    curves: Vec<FacetCurve>,
    pairs: Vec<ContactPair>,
    analyticals: Vec<AnalyticalSurface>,
    /// Points of analytical surfaces that rows are in contact with in this increment.
    feet: Vec<ClosestPoint>,
    laws: Vec<InteractionLaw>,
    /// Degrees of freedom of each point along r and z; [`NONE`] where it has none.
    dofs_of: Vec<[u32; 2]>,
    /// The degrees of freedom of the points, and whether their motion is prescribed.
    dofs: Vec<(Dof, bool)>,
    /// Degrees of freedom of several nodes with equal motion.
    merged: Vec<MergedContactDof>,
    /// Pressure and shear stress of each key over the previous increment.
    pressures: Vec<[f64; 2]>,
    /// Energy of each key with a soft law.
    stored_energy: StoredEnergy,
    /// Damping of frictional flutter.
    slip_damping: SlipDamping,
    /// Limit of the time increment by impacts, and the pairs that have been in contact.
    impact: ImpactLimit,
    touched: Vec<bool>,
    /// Difference that is subtracted from the gap of each key; empty if all are zero.
    gap_offsets: Vec<f64>,
    /// Index of the first law of penalty springs; all later laws are springs. `None` without springs.
    springs: Option<u32>,
    /// Bonds of surfaces; `None` without cohesive behaviour.
    cohesion: Option<Box<CohesiveSurfaces>>,
    /// Heat exchange; `None` if no temperatures are solved for.
    contact_heat: Option<Box<ContactHeat>>,
    /// Mean velocity of each degree of freedom during the impulses of the increment.
    means: Vec<f64>,
    places: Vec<[f64; 2]>,
    /// Points that may be in contact: those of exposed facets and those without elements.
    active_points: Vec<u32>,
    near: NearParts,
    /// Positions of the points when candidate lists were built; empty if there are none.
    listed: Vec<[f64; 2]>,
    gaps: GapIntegrator,
    rows: ContactRows,
    motion: ContactVelocities,
    /// Impulses on degrees of freedom along the normal and along the surface.
    impulses: Vec<[f64; 2]>,
    bodies: Vec<ContactBody>,
    /// Time over which forces last acted on velocities.
    half: f64,
    /// Share of the forces in output. It is 1/2 in the first increment, in which forces act over half of the increment,
    /// so that the integral of forces over time is the change of momentum.
    output_share: f64,
    /// Whether elements have been deleted since the previous increment.
    uncovered: bool,
    shown: ContactOutput,
    /// Continuation of contact when adaptive meshes change; `None` without such meshes.
    mesh: Option<Box<MeshContinuation>>,
}

/// A degree of freedom of nodes with equal motion, such as the nodes of a kinematic coupling. It moves with their total
/// mass.
#[derive(Clone, Debug, Memory)]
struct MergedContactDof {
    /// Index of the degree of freedom.
    dof: usize,
    nodes: MergedDofs,
}

impl MergedContactDof {
    /// Returns one over the total mass.
    fn inverse_mass(&self, dofs: &Dofs) -> f64 {
        1.0 / self.nodes.nodes.iter().map(|&n| dofs.nodes.mass[n]).sum::<f64>()
    }
}

/// A rigid body that takes part in the contact.
#[derive(Clone, Copy, Debug, Persist)]
#[persist(derived: dof, body, prescribed)]
struct ContactBody {
    /// Index of the body's degree of freedom.
    dof: usize,
    body: usize,
    prescribed: bool,
    /// Acceleration by contact in the previous increment; only of a free body.
    contact_acceleration: f64,
}

/// An overlap of two surfaces at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceOverlap {
    /// Depth, as the mean over the hat function of a point.
    pub depth: f64,
    /// Coordinates of the point.
    pub place: [f64; 2],
}

impl ContactConstraint {
    /// Creates contact of pairs of curves, and of curves with analytical surfaces.
    pub fn new(
        points: Vec<SurfacePoint>,
        curves: Vec<FacetCurve>,
        mut analyticals: Vec<AnalyticalSurface>,
        mut pairs: Vec<ContactPair>,
        laws: Vec<InteractionLaw>,
    ) -> ContactConstraint {
        let mut contact = ContactConstraint { laws, ..ContactConstraint::default() };
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
            pair.search = ContactSearch::new(pair.search.length, lift, own.facets.len(), others);
            pair.facet_gaps = vec![FacetGap::default(); own.facets.len()];
        }
        let facets: usize = pairs.iter().map(|p| p.facet_gaps.len()).sum();
        contact.pressures = vec![[0.0; 2]; keys as usize];
        if contact.laws.iter().any(|law| law.is_soft()) {
            contact.stored_energy = StoredEnergy::new(keys as usize);
        }
        if contact.laws.iter().any(|law| law.friction.damps()) {
            contact.slip_damping = SlipDamping::new(keys as usize);
        }
        contact.shown = ContactOutput::new(keys as usize, &points);
        contact.places = vec![[0.0; 2]; points.len()];
        contact.listed = Vec::with_capacity(points.len());
        contact.active_points = Vec::with_capacity(2 * points.len() + analyticals.len());
        let meets = |p: &&ContactPair| p.analytical.is_some();
        contact.feet = Vec::with_capacity(pairs.iter().filter(meets).map(|p| 2 * curves[p.own].own.len()).sum());
        contact.gaps = GapIntegrator::new(facets);
        contact.rows.reserve(keys as usize, contact.dofs.len());
        (contact.points, contact.curves, contact.pairs) = (points, curves, pairs);
        contact.analyticals = analyticals;
        contact.reserve_near();
        contact.list_points();
        contact
    }

    /// Returns the contact with penalty springs from the law with index `first` on.
    pub fn with_springs(mut self, first: usize) -> ContactConstraint {
        self.springs = Some(first as u32);
        self
    }

    /// Returns the contact in which the points of each set of nodes with equal motion have one common degree of freedom.
    /// The first node of a set is the one with the prescribed motion, if there is one; `SurfacePoint::free` of its points
    /// states whether there is.
    pub fn with_equal_motions(mut self, sets: Vec<MergedDofs>) -> ContactConstraint {
        let mut of_node: HashMap<(usize, usize), usize> = HashMap::new();
        for (set, merged) in sets.iter().enumerate() {
            of_node.extend(merged.nodes.iter().map(|&n| ((n, merged.axis), set)));
        }
        let mut dof_of_set = vec![NONE; sets.len()];
        for (dofs, point) in self.dofs_of.iter_mut().zip(&self.points) {
            let PointCarrier::Node(node) = point.carrier else { continue };
            for (axis, dof) in dofs.iter_mut().enumerate() {
                let Some(&set) = of_node.get(&(node, axis)) else { continue };
                if dof_of_set[set] == NONE {
                    dof_of_set[set] = *dof;
                    self.dofs[*dof as usize].0 = Dof::Node(sets[set].nodes[0], axis);
                }
                *dof = dof_of_set[set];
            }
        }
        let used = sets.into_iter().zip(dof_of_set).filter(|(_, dof)| *dof != NONE);
        self.merged = used.map(|(nodes, dof)| MergedContactDof { dof: dof as usize, nodes }).collect();
        self
    }

    /// Returns whether contact points belong to nodes with equal motion.
    pub fn has_equal_motions(&self) -> bool {
        !self.merged.is_empty()
    }

    /// Returns the contact with heat exchange; `has` returns whether a node has a temperature, `of_body` the node with
    /// the temperature of a rigid body.
    pub fn with_heat(
        mut self,
        has: impl Fn(usize) -> bool,
        of_body: impl Fn(usize) -> Option<usize>,
    ) -> ContactConstraint {
        let mut keys: Vec<HeatKey> = Vec::with_capacity(self.pressures.len());
        for pair in &self.pairs {
            let of = |curve: usize| self.curves[curve].own.iter().copied();
            let sink_of = |body: Option<usize>| body.and_then(&of_body).map(|node| node as u32);
            let sink = sink_of(match pair.analytical {
                Some(surface) => self.body_of_point(self.analyticals[surface].point),
                None => pair.other.and_then(|other| self.body_of_curve(other)),
            });
            keys.extend(of(pair.own).map(|point| HeatKey { point, first: pair.first, sink }));
            let loose = pair.other.filter(|o| self.curves[*o].has_single_points());
            let own = sink_of(self.body_of_curve(pair.own));
            keys.extend(loose.into_iter().flat_map(of).map(|point| HeatKey { point, first: !pair.first, sink: own }));
            // In front of re-entrant corners of analytical surfaces points have two keys.
            let twice = pair.first_key as usize + self.keys_of(pair) as usize - keys.len();
            keys.extend(of(pair.own).take(twice).map(|point| HeatKey { point, first: pair.first, sink }));
        }
        let exchange = ContactHeat::new((&self.points, &self.dofs_of), self.dofs.len(), keys, has);
        self.contact_heat = Some(Box::new(exchange));
        self
    }

    /// Returns the rigid body of a curve; `None` for a curve of a deformable body.
    fn body_of_curve(&self, curve: usize) -> Option<usize> {
        self.curves[curve].own.iter().find_map(|&point| self.body_of_point(point))
    }

    fn body_of_point(&self, point: u32) -> Option<usize> {
        match self.points[point as usize].carrier {
            PointCarrier::Body(body, _) => Some(body),
            PointCarrier::Node(_) => None,
        }
    }

    /// Measures the gaps at the start from the coordinates of the points, sets initial clearances and returns the
    /// deepest overlap of each pair.
    pub fn start(&mut self, places: &[[f64; 2]]) -> Vec<Option<SurfaceOverlap>> {
        self.places.copy_from_slice(places);
        self.search();
        self.measure(0.0);
        let mut deepest: Vec<Option<SurfaceOverlap>> = vec![None; self.pairs.len()];
        let mut fits = vec![0.0; self.pressures.len()];
        for row in &mut self.rows.rows {
            let at = pair_of(&self.pairs, row.key);
            let (pair, mut gap) = (&self.pairs[at], row.gap / row.area);
            if let Some(begins) = pair.initial_clearance.filter(|b| (b.range[0]..=b.range[1]).contains(&gap)) {
                fits[row.key as usize] = gap - begins.gap;
                gap = begins.gap;
                row.gap = gap * row.area;
            }
            let Some(&point) = self.curves[pair.own].own.get((row.key - pair.first_key) as usize) else { continue };
            if gap < deepest[at].map_or(0.0, |d: SurfaceOverlap| -d.depth) {
                deepest[at] = Some(SurfaceOverlap { depth: -gap, place: places[point as usize] });
            }
        }
        if fits.iter().any(|f| *f != 0.0) {
            self.gap_offsets = fits;
        }
        self.show_openings();
        self.update_heat_rows();
        self.bond_new_pairs();
        self.listed.clear();
        deepest
    }

    /// Numbers the degrees of freedom of the points.
    fn number(&mut self, points: &[SurfacePoint]) {
        for point in points {
            self.dofs_of.push(match point.carrier {
                PointCarrier::Node(n) => {
                    self.dofs.extend([0, 1].inline_map(|axis| (Dof::Node(n, axis), !point.free[axis])));
                    [self.dofs.len() as u32 - 2, self.dofs.len() as u32 - 1]
                }
                PointCarrier::Body(b, _) => {
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
        self.means = vec![0.0; count];
        self.motion = ContactVelocities { velocity: vec![0.0; count], inverse_mass: vec![0.0; count] };
        self.impulses = vec![[0.0; 2]; count];
    }

    fn reserve_near(&mut self) {
        let facets = self.curves.iter().map(|curve| curve.facets.len()).sum();
        self.near.reserve(facets, self.points.len(), self.dofs.len());
    }

    /// Returns the position of a point at the start of the increment.
    #[inline]
    fn place_of(&self, point: u32, dofs: &Dofs, dt: f64) -> [f64; 2] {
        match self.points[point as usize].carrier {
            PointCarrier::Node(n) => {
                let node = &dofs.nodes[n];
                [node.r - dt * node.v_r, node.z - dt * node.v_z]
            }
            PointCarrier::Body(b, [r, z]) => [r, z + dofs.bodies[b].before.displacement],
        }
    }

    /// Reads positions at the start of the increment and velocities without contact, of near points. Returns whether
    /// candidates must be searched again, because there are none or a point has moved too far; all points are then read.
    fn read_motion(&mut self, dofs: &Dofs, dt: f64) -> bool {
        let mut searches = self.listed.is_empty();
        if !searches {
            let near = std::mem::take(&mut self.near.points);
            self.read_points(&near, dofs, dt);
            self.near.points = near;
            searches = self.has_moved_far(dofs, dt);
        }
        if searches {
            let all = std::mem::take(&mut self.active_points);
            self.read_points(&all, dofs, dt);
            self.active_points = all;
        }
        self.read_merged(dofs);
        searches
    }

    fn read_points(&mut self, points: &[u32], dofs: &Dofs, dt: f64) {
        for &p in points {
            let at = p as usize;
            self.places[at] = self.place_of(p, dofs, dt);
            let [r, z] = self.dofs_of[at];
            let ContactVelocities { velocity, inverse_mass } = &mut self.motion;
            match self.points[at].carrier {
                PointCarrier::Node(n) => {
                    let (node, free) = (&dofs.nodes[n], dofs.nodes.inverse_mass[n]);
                    for (dof, v) in [(r as usize, node.v_r), (z as usize, node.v_z)] {
                        velocity[dof] = v;
                        inverse_mass[dof] = if self.dofs[dof].1 { 0.0 } else { free };
                    }
                }
                PointCarrier::Body(b, _) => {
                    velocity[z as usize] = dofs.bodies[b].velocity_half;
                    inverse_mass[z as usize] = if self.dofs[z as usize].1 { 0.0 } else { dofs.bodies[b].inverse_mass };
                }
            }
        }
    }

    fn read_merged(&mut self, dofs: &Dofs) {
        for merged in &self.merged {
            let leader = &dofs.nodes[merged.nodes.nodes[0]];
            self.motion.velocity[merged.dof] = [leader.v_r, leader.v_z][merged.nodes.axis];
            self.motion.inverse_mass[merged.dof] =
                if self.dofs[merged.dof].1 { 0.0 } else { merged.inverse_mass(dofs) };
        }
    }

    /// Lists the points of exposed facets and those without elements. Candidates must then be searched again.
    fn list_points(&mut self) {
        self.active_points.clear();
        self.active_points.extend(self.analyticals.iter().map(|a| a.point));
        for curve in &self.curves {
            let points = curve.exposed_points.iter().chain(&curve.orphans).map(|&i| curve.own[i as usize]);
            self.active_points.extend(points);
        }
        self.active_points.sort_unstable();
        self.active_points.dedup();
        self.listed.clear();
    }

    /// Returns whether a point has moved too far since candidates were searched.
    fn has_moved_far(&self, dofs: &Dofs, dt: f64) -> bool {
        let searched = self.pairs.iter().filter(|p| p.analytical.is_none());
        let slack = searched.map(|p| p.search.slack()).fold(f64::INFINITY, f64::min);
        let is_far = |a: [f64; 2], p: u32| {
            let b = self.listed[p as usize];
            let d = [a[0] - b[0], a[1] - b[1]];
            d[0] * d[0] + d[1] * d[1] > slack * slack
        };
        self.near.points.iter().any(|&p| is_far(self.places[p as usize], p))
            || self.near.others.iter().any(|&p| is_far(self.place_of(p, dofs, dt), p))
    }

    /// Searches candidates from the shapes of all exposed facets.
    fn search(&mut self) {
        self.curves.iter_mut().for_each(|c| c.shape(&self.places));
        self.listed.clear();
        self.listed.extend_from_slice(&self.places);
        for pair in self.pairs.iter_mut().filter(|p| p.analytical.is_none()) {
            pair.search.build(&self.curves[pair.own], pair.other.map(|o| &self.curves[o]), &self.places);
        }
        self.list_near();
    }

    /// Lists what is near another surface, or belongs to a pair whose bonds act at any distance.
    fn list_near(&mut self) {
        let mut near = std::mem::take(&mut self.near);
        near.begin();
        for (index, pair) in self.pairs.iter().enumerate() {
            let (own, other) = (&self.curves[pair.own], pair.other.map(|other| &self.curves[other]));
            if let Some(surface) = pair.analytical {
                near.mark_point(self.analyticals[surface].point);
            }
            if pair.analytical.is_some() || self.is_cohesive(index) {
                [Some(own), other].into_iter().flatten().for_each(|curve| near.mark_curve(curve));
            } else {
                near.mark_candidates(own, other, &pair.search);
            }
        }
        near.list(&self.curves, &self.active_points, &self.dofs_of);
        self.near = near;
    }

    /// Updates the shapes of near facets.
    fn shape_near(&mut self) {
        for &[curve, k] in &self.near.facets {
            self.curves[curve as usize].shape_one(k, &self.places);
        }
    }

    /// Measures the gaps of all pairs as rows, for an increment of length `dt`.
    fn measure(&mut self, dt: f64) {
        self.gaps.clear();
        self.rows.clear();
        self.feet.clear();
        self.shown.clear();
        self.measure_curves();
        for pair in 0..self.pairs.len() {
            self.measure_analytical(pair, dt);
        }
    }

    fn measure_curves(&mut self) {
        let ContactConstraint {
            curves,
            pairs,
            gaps,
            rows,
            dofs_of,
            gap_offsets: fits,
            places,
            pressures,
            laws,
            near,
            ..
        } = self;
        for pair in pairs.iter_mut().filter(|p| p.analytical.is_none()) {
            let own = &curves[pair.own];
            let other = pair.other.map_or(own, |o| &curves[o]);
            let (mut any, reach) = (false, pair.search.reach());
            let onset = pair.onset_gap(laws);
            let is_soft = onset.is_some();
            for (at, &k) in own.exposed.iter().enumerate() {
                let candidates = pair.search.facets.of(at);
                pair.facet_gaps[k as usize] = match candidates.is_empty() {
                    true => FacetGap::default(),
                    false => gaps.facet_gap((own, k as usize), other, candidates, reach, onset),
                };
                any |= pair.facet_gaps[k as usize].area != [0.0; 2];
            }
            if any {
                if is_soft {
                    own.exposed_points.iter().for_each(|&index| leave_out_open_facet(pair, own, index as usize, gaps));
                } else if pair.initial_clearance.is_none() {
                    own.kinks.iter().for_each(|&index| leave_out_open_side(pair, own, index as usize, gaps));
                }
                for &index in own.exposed_points.iter().filter(|i| near.has(own.own[**i as usize])) {
                    add_row(rows, pair, (own, index as usize), laws, gaps, dofs_of, fits);
                }
            }
            for (at, &index) in own.orphans.iter().enumerate() {
                let key = pair.first_key + index;
                add_point_row(
                    rows,
                    gaps,
                    (own, index, key),
                    None,
                    other,
                    pair.search.orphans.of(at),
                    (pair, places, dofs_of),
                );
            }
            // In self-contact the single points have been added above.
            let others = pair.other.map(|o| &curves[o]);
            for (at, (index, is_corner)) in others.into_iter().flat_map(|o| o.single_points()).enumerate() {
                let key = pair.first_key + own.own.len() as u32 + index;
                let candidates = pair.search.others.of(at);
                // The area that a corner covers is part of the energy of soft contact.
                if is_corner && is_soft {
                    continue;
                }
                let corner = is_corner.then(|| CornerRow { pressed: pressures[key as usize][0] > 0.0, fits });
                add_point_row(rows, gaps, (other, index, key), corner, own, candidates, (pair, places, dofs_of));
            }
        }
    }

    /// Sets the pressures of points without elements to zero: the multiplier of a single point is a force, and that of a
    /// point that has just lost its elements was a pressure.
    fn forget_pressures_of_orphans(&mut self) {
        for pair in &self.pairs {
            for &index in &self.curves[pair.own].orphans {
                self.pressures[(pair.first_key + index) as usize] = [0.0; 2];
            }
        }
    }

    /// Sums the impulses of rows on degrees of freedom, and stores the pressures.
    fn gather_impulses(&mut self) {
        let ContactConstraint { rows, impulses, pressures, half, .. } = self;
        pressures.fill([0.0; 2]);
        impulses.fill([0.0; 2]);
        for row in rows.rows.iter().filter(|row| row.acts()) {
            pressures[row.key as usize] = [row.normal_impulse / *half, row.shear_impulse / *half];
            for term in rows.terms_of(row) {
                let on = &mut impulses[term.dof as usize];
                on[0] += term.normal * row.normal_impulse;
                on[1] += term.slip * row.whole_shear();
            }
        }
    }

    /// Applies the impulses to velocities and positions, and adds their work: the impulse times the mean of the
    /// velocities before and after it. The work on a prescribed motion is external work.
    fn apply_impulses(&mut self, dofs: &mut Dofs, dt: f64) {
        let half = self.half;
        let Dofs { bodies, nodes, energies, .. } = dofs;
        let mut work = [0.0; 2];
        self.means.fill(0.0);
        for i in self.near.dofs.iter().map(|i| *i as usize) {
            let ((dof, prescribed), [normal, slip]) = (self.dofs[i], self.impulses[i]);
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
                        // Impulses of other contacts in this increment also act during the change of velocity.
                        energies.contact -= 0.5 * body.mass * so_far * change;
                    }
                    0.5 * (before + body.velocity_half)
                }
            };
            self.means[i] = mean;
            if prescribed {
                energies.external -= (normal + slip) * mean;
            }
            work[0] += normal * mean;
            work[1] += slip * mean;
        }
        for MergedContactDof { dof, nodes: MergedDofs { nodes: members, axis } } in &self.merged {
            let change = self.motion.inverse_mass[*dof] * (self.impulses[*dof][0] + self.impulses[*dof][1]);
            for &n in &members[1..] {
                let node = &mut nodes[n];
                *node.velocity(*axis) += change;
                *node.coordinate(*axis) += dt * change;
                nodes.acceleration[n][*axis] += change / half;
            }
        }
        let springs = self.add_row_work(1.0);
        if let Some(exchange) = &mut self.contact_heat {
            let (rows, means) = (&self.rows, &self.means);
            let rate =
                |row: &ContactRow| rows.terms_of(row).iter().map(|t| t.slip * means[t.dof as usize]).sum::<f64>();
            exchange.add_friction_heat(rows, &self.laws, |row| row.whole_shear() * rate(row));
        }
        energies.penalty -= springs;
        energies.contact -= work[0] - springs;
        energies.friction -= work[1];
    }

    /// Adds the impulses of half an increment to the velocities at mid-increment, and their work: the impulse times the
    /// mean of the velocities at the current instant before and after it. With the accelerations the velocities are then
    /// those at the current instant. Returns the work on free degrees of freedom, the kinetic energy that they gain.
    pub fn complete_velocities(&mut self, dofs: &mut Dofs) -> f64 {
        let (mut work, mut gained) = ([0.0; 2], 0.0);
        self.means.fill(0.0);
        let Dofs { bodies, nodes, energies, .. } = dofs;
        if self.half == 0.0 || nodes.previous_dt == 0.0 {
            return 0.0;
        }
        let part = 0.5 * nodes.previous_dt / self.half;
        for i in self.near.dofs.iter().map(|i| *i as usize) {
            let ((dof, prescribed), [normal, slip]) = (self.dofs[i], self.impulses[i].inline_map(|j| part * j));
            let change = self.motion.inverse_mass[i] * (normal + slip);
            let before = match dof {
                Dof::Node(n, axis) => {
                    let before = nodes.velocity_now(n)[axis];
                    *nodes[n].velocity(axis) += change;
                    before
                }
                Dof::Body(b) => {
                    bodies[b].velocity += change;
                    bodies[b].velocity - change
                }
            };
            let mean = before + 0.5 * change;
            self.means[i] = mean;
            if prescribed {
                energies.external -= (normal + slip) * mean;
            } else {
                gained += (normal + slip) * mean;
            }
            work[0] += normal * mean;
            work[1] += slip * mean;
        }
        for MergedContactDof { dof, nodes: MergedDofs { nodes: members, axis } } in &self.merged {
            let change = part * self.motion.inverse_mass[*dof] * (self.impulses[*dof][0] + self.impulses[*dof][1]);
            members[1..].iter().for_each(|n| *nodes[*n].velocity(*axis) += change);
        }
        let springs = self.add_row_work(part);
        let energies = &mut dofs.energies;
        energies.penalty -= springs;
        energies.contact -= work[0] - springs;
        energies.friction -= work[1];
        gained
    }

    /// Adds the work of a part of the impulse of each row to the energy of its pair. Returns the work of penalty springs.
    fn add_row_work(&mut self, part: f64) -> f64 {
        let ContactConstraint { rows, pairs, curves, places, means, springs, .. } = self;
        let mut of_springs = 0.0;
        for row in rows.rows.iter().filter(|row| row.normal_impulse > 0.0) {
            let at = pair_of(pairs, row.key);
            let rate: f64 = rows.terms_of(row).iter().map(|t| t.normal * means[t.dof as usize]).sum();
            let (pair, work) = (&mut pairs[at], part * row.normal_impulse * rate);
            pair.absorbed -= work;
            if springs.is_some_and(|first| row.law >= first) {
                of_springs += work;
            }
            if work > pair.largest_release.0 {
                let own = &curves[pair.own].own;
                let point = own[(row.key - pair.first_key) as usize % own.len()];
                pair.largest_release = (work, places[point as usize]);
            }
        }
        of_springs
    }

    /// Updates heat exchange before any row is left out.
    fn update_heat_rows(&mut self) {
        let ContactConstraint { contact_heat, rows, laws, pressures, pairs, curves, places, shown, .. } = self;
        let Some(exchange) = contact_heat else { return };
        exchange.update_rows(rows, laws, pressures);
        // Points near analytical surfaces have rows only while they approach.
        for pair in pairs.iter().filter(|pair| pair.analytical.is_some()) {
            let own = &curves[pair.own];
            for &index in &own.exposed_points {
                let (key, opening) = (pair.first_key + index, shown.opening[(pair.first_key + index) as usize]);
                if !opening.is_nan() {
                    let (law, pressure) = (&laws[pair.law_of(index as usize) as usize], pressures[key as usize][0]);
                    exchange.add_conduction(key, own.area(index as usize, places), [opening, pressure], law);
                }
            }
        }
    }

    /// Replaces the contact acceleration of free bodies with that of this increment.
    fn push_bodies(&mut self, dofs: &mut Dofs) {
        for at in 0..self.bodies.len() {
            let carried = self.bodies[at];
            if carried.prescribed {
                continue;
            }
            let body = &mut dofs.bodies[carried.body];
            body.contact -= carried.contact_acceleration;
            let acceleration = self.whole_impulse(carried.dof) * body.inverse_mass / self.half;
            self.bodies[at].contact_acceleration = acceleration;
            body.contact += acceleration;
        }
    }
}

/// Returns the index of the pair that a key belongs to.
fn pair_of(pairs: &[ContactPair], key: u32) -> usize {
    pairs.partition_point(|pair| pair.first_key <= key) - 1
}

/// Adds the row of one point from the gaps of the facets around it.
fn add_row(
    rows: &mut ContactRows,
    pair: &ContactPair,
    (own, index): (&FacetCurve, usize),
    laws: &[InteractionLaw],
    gaps: &GapIntegrator,
    dofs_of: &[[u32; 2]],
    fits: &[f64],
) {
    let mut row = ContactRow::of(pair.first_key + index as u32, pair.law_of(index));
    let facets = || own.around_own(index).iter().filter(|f| own.is_exposed[f.0 as usize]);
    for &(facet, end) in facets() {
        let (seen, end) = (&pair.facet_gaps[facet as usize], end as usize);
        row.area += seen.area[end];
        row.gap += seen.gap[end];
    }
    let law = &laws[row.law as usize];
    if row.area <= 0.0 || !law.is_soft() && row.area <= LEAST_COVER * own.hat_area(index) {
        return;
    }
    if let Some(fit) = fits.get(row.key as usize) {
        row.gap -= fit * row.area;
    }
    rows.open();
    for &(facet, end) in facets() {
        let shares = gaps.shares_of(&pair.facet_gaps[facet as usize]);
        rows.add_shares(shares.iter().map(|share| (share.point, share.of[end as usize])), dofs_of);
        for share in gaps.edges_of(&pair.facet_gaps[facet as usize]) {
            let factor = law.overclosure.change_by_cover(-row.gap / row.area, share.overlap);
            let of = share.of[end as usize].inline_map(|cover| factor * cover);
            rows.add_normal_share(dofs_of[share.point as usize], of);
        }
    }
    rows.close(row);
}

/// Leaves out the open facet of a point in soft contact if its other facet has pressure.
fn leave_out_open_facet(pair: &mut ContactPair, own: &FacetCurve, index: usize, gaps: &mut GapIntegrator) {
    let &[a, b] = own.around_own(index) else { return };
    let has_pressure = [a, b].inline_map(|(facet, end)| {
        let seen = &pair.facet_gaps[facet as usize];
        seen.is_closed && seen.area[end as usize] > 0.0 && own.is_exposed[facet as usize]
    });
    let (facet, end) = match has_pressure {
        [true, false] => b,
        [false, true] => a,
        _ => return,
    };
    gaps.leave_out(&mut pair.facet_gaps[facet as usize], end as usize);
}

/// Leaves out one facet at a kink of the own surface if the other surface follows only the other facet: the mean gap of
/// both would be open although one side overlaps. The criterion is half the opening that the kink gives to a plane
/// surface on one facet: over the hat function, a third of the facet length times the angle.
fn leave_out_open_side(pair: &mut ContactPair, own: &FacetCurve, index: usize, gaps: &mut GapIntegrator) {
    let &[a, b] = own.around_own(index) else { return };
    let sides = [a, b].inline_map(|(facet, end)| {
        let (seen, end) = (&pair.facet_gaps[facet as usize], end as usize);
        (facet as usize, end, seen.area[end], seen.gap[end] / seen.area[end])
    });
    if sides.iter().any(|(facet, _, area, _)| *area <= 0.0 || !own.is_exposed[*facet]) {
        return;
    }
    let [closed, open] = if sides[0].3 <= sides[1].3 { [0, 1] } else { [1, 0] }.inline_map(|side| sides[side]);
    let (flat, shape) = (&own.shapes[closed.0], &own.shapes[open.0]);
    let angle = (flat.normal[0] * shape.normal[1] - flat.normal[1] * shape.normal[0]).abs();
    if open.3 - closed.3 > angle * shape.length / 6.0 {
        gaps.leave_out(&mut pair.facet_gaps[open.0], open.1);
    }
}

/// Part of the area of a hat function that the other surface must cover in hard contact. A smaller part does not
/// determine the pressure: a sliver of a hundredth of a facet moves with the rest of the facet. Pressures of soft contact
/// follow from overlaps.
const LEAST_COVER: f64 = 1e-4;

/// Overlap of a corner at which its row begins to act, as a fraction of the facet length of the pair. Less is left to
/// the weighted gaps, which are equivalent where the edges of both surfaces coincide.
const CORNER_OVERLAP: f64 = 1e-9;

/// Data that the row of a corner depends on.
struct CornerRow<'a> {
    /// Whether the row had a positive pressure in the previous increment.
    pressed: bool,
    fits: &'a [f64],
}

impl CornerRow<'_> {
    /// Returns the overlap that the initial clearances of an own facet accept.
    fn accepted_overlap(&self, pair: &ContactPair, own: &FacetCurve, facet: u32) -> f64 {
        let fit = |point: u32| self.fits.get(pair.key_of(own, point) as usize).copied();
        own.facets[facet as usize].into_iter().filter_map(fit).fold(0.0, |accepted, fit| accepted.max(-fit))
    }
}

/// Adds the row of a single point: its area is one, its multiplier an impulse. `corner` is `None` for points that are
/// not corners. The row of a corner acts if it pressed in the previous increment, or if its overlap is larger than
/// [`CORNER_OVERLAP`].
fn add_point_row(
    rows: &mut ContactRows,
    gaps: &mut GapIntegrator,
    (of, index, key): (&FacetCurve, u32, u32),
    corner: Option<CornerRow<'_>>,
    against: &FacetCurve,
    candidates: &[u32],
    (pair, places, dofs_of): (&ContactPair, &[[f64; 2]], &[[u32; 2]]),
) {
    if candidates.is_empty() {
        return;
    }
    let point = of.own[index as usize];
    let normals = corner.as_ref().and_then(|_| of.normals_around(index as usize));
    if corner.is_some() && normals.is_none() {
        return;
    }
    let place = (point, places[point as usize]);
    let half = if against.is_side_of_line { of.half_thickness_around(index as usize) } else { f64::INFINITY };
    let seen = gaps.point_gap(place, (normals, half), against, candidates, pair.search.reach());
    let Some((mut seen, facet)) = seen else { return };
    let is_corner = corner.is_some();
    if let Some(corner) = corner {
        seen.gap[0] += corner.accepted_overlap(pair, against, facet);
        if !corner.pressed && seen.gap[0] > -CORNER_OVERLAP * pair.search.length {
            return;
        }
    }
    rows.open();
    rows.add_shares(gaps.shares_of(&seen).iter().map(|share| (share.point, share.of[0])), dofs_of);
    let mut row = ContactRow::of(key, pair.of_points as u32);
    (row.is_single_point, row.area, row.gap) = (true, seen.area[0], seen.gap[0]);
    if is_corner {
        rows.close_after(row, against.facets[facet as usize].inline_map(|point| pair.key_of(against, point)));
    } else {
        rows.close(row);
    }
}

impl Constraint for ContactConstraint {
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
                let pushed = known.map_or(0.0, |known| known.contact_acceleration);
                dofs.bodies[body].contact += pushed;
                self.bodies.push(ContactBody { dof: i, body, prescribed: *held, contact_acceleration: pushed });
                self.rows.bodies.extend((!*held).then_some(i as u32));
            }
        }
        let free = self.merged.iter().filter(|merged| !self.dofs[merged.dof].1);
        self.rows.bodies.extend(free.map(|merged| merged.dof as u32));
        self.rows.reserve(self.pressures.len(), self.dofs.len());
        self.reserve_near();
        self.gaps.reserve(self.pressures.len());
        if self.laws.iter().any(|law| law.is_soft()) {
            self.gaps.reserve_edges(self.pressures.len());
        }
        self.begin_cohesion(dofs);
        self.touched.resize(self.pairs.len(), false);
        self.limit_first_impacts(dofs);
    }

    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {
        if self.half == 0.0 {
            return;
        }
        for carried in self.bodies.iter().filter(|c| c.prescribed) {
            let impulse = self.whole_impulse(carried.dof);
            dofs.bodies[carried.body].reaction -= impulse / self.half * self.output_share;
        }
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>, dt: f64) {
        // On a new mesh the velocities contain the impulses of half an increment before.
        let is_first = std::mem::replace(&mut self.half, dofs.nodes.half) == 0.0;
        self.output_share = if is_first && self.half == 0.5 * dt { 0.5 } else { 1.0 };
        if self.uncovered {
            self.list_points();
        }
        let searches = self.read_motion(dofs, dt);
        if std::mem::take(&mut self.uncovered) {
            self.curves.iter_mut().for_each(|c| c.find_neighbors(&self.places));
            self.forget_pressures_of_orphans();
        }
        if searches {
            self.search();
        } else {
            self.shape_near();
        }
        self.measure(dt);
        self.show_openings();
        self.update_heat_rows();
        self.act_cohesion(dofs, dt);
        self.impact.advance(dt);
        self.limit_impacts(dt);
        let span = ContactInterval { dt, half: self.half };
        dofs.energies.initial_overlap += self.stored_energy.limit_overlaps(&mut self.rows, &self.laws);
        let given = ContactStep { laws: &self.laws, before: &self.pressures, span };
        self.slip_damping.begin();
        if let Some(reference) = self.rows.begin(&self.motion, given) {
            self.slip_damping.apply(&mut self.rows, &mut self.motion, given);
            self.rows.solve(&mut self.motion, reference, given);
            self.correct_arc_gaps(reference, span);
        }
        let pairs = &self.pairs;
        self.slip_damping.update(&self.rows, &self.motion, (&self.laws, self.half), |key| pair_of(pairs, key));
        self.stored_energy.add_work(&self.rows, &self.laws, &self.motion, span);
        self.gather_impulses();
        self.apply_impulses(dofs, dt);
        self.add_cohesive_work(dofs, dt);
        self.push_bodies(dofs);
        self.show(dt);
    }

    fn max_increment(&self, _clock: &AmplitudeClock<'_>) -> IncrementLimit {
        IncrementLimit { time: self.impact.increment, jump: false }
    }

    fn moves_nodes(&self) -> bool {
        true
    }

    fn forces(&self) -> Option<&dyn ConstraintForces> {
        Some(self)
    }
}

impl ConstraintForces for ContactConstraint {
    fn constraint_force(&self, dof: Dof) -> f64 {
        if self.half == 0.0 {
            return 0.0;
        }
        self.index_of(dof).map_or(0.0, |i| self.impulse(dof, i, self.half) / self.half * self.output_share)
    }

    fn index_of(&self, dof: Dof) -> Option<usize> {
        self.dofs.iter().position(|d| *d == (dof, true))
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

impl ContactConstraint {
    /// Informs it that elements with these corner nodes have been deleted.
    pub fn remove_elements(&mut self, deleted: &[ElementNodes]) {
        let ContactConstraint { curves, shown, uncovered, .. } = self;
        for curve in curves.iter_mut() {
            let points = deleted.iter().filter_map(|boundary| shown.points(boundary));
            if curve.remove_elements(points) {
                curve.list();
                *uncovered = true;
            }
        }
    }

    /// Returns the heat exchange across the surfaces; `None` if no temperatures are solved for.
    pub fn heat(&self) -> Option<&ContactHeat> {
        self.contact_heat.as_deref()
    }

    /// Lists are built again after reading; rows do not depend on when lists were built.
    fn list_again(&mut self, archive: &mut StateArchive<'_>) {
        if archive.reads() {
            self.list_points();
            self.check_bonds(archive);
        }
    }
}
