//! Quality of the meshes of bodies that are remeshed, and their new meshes so far.

use super::outcome::{MeshChanges, MeshShape};
use super::run_state::RunState;
use crate::element::elements::Elements;
use crate::element::group::ElementGroup;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::smallest_sine;
use crate::kernel::topology::ElementTopology;
use crate::plan::{AutomaticMeshes, FirstMesh, Plan, RemeshedBody, State};
use crate::remesh::MeshRevision;
use crate::remesh::mesher::{is_sharper, sharpest};
use crate::state::archive::Persist;
use crate::variables::Variable;

/// An angle at which a new mesh begins, times this factor, is the limit if it is smaller than that of the deck.
const WORSE: f64 = 0.5;
/// Plastic strain from which an element that limits the increment counts as squashed by plastic flow.
const SQUASHED: f64 = 1.0;
/// Number of checks of a body without a card between two searches for corners that have turned over.
const SEARCH: u64 = 10;
/// Sine of an angle above 180 degrees from which a corner has turned over.
const TURNED: f64 = 1e-6;
/// Checks without a new mesh after the first one that could not be made, in units of the interval of checks, and how often they may
/// double.
const PAUSE: u64 = 5;
const MOST_DOUBLINGS: u32 = 16;
/// Excess of increments from which the first new mesh of a body without a card is worth its cost.
const PRICE: f64 = 100.0;
/// Ratio of stable time increments from which a new mesh of a body without a card has been worth its cost.
const BETTER: f64 = 1.3;

/// Quality of the mesh of a body when it was made.
#[derive(Clone, Debug, Default, Persist)]
pub(super) struct MeshQuality {
    /// Angle below which the body is remeshed, radians.
    limit: f64,
    /// Stable time increment; 0 if it is not known yet. Without a card, the largest one so far.
    increment: f64,
    /// Increments since the last mesh beyond those that the largest stable time increment would have needed.
    excess: f64,
    /// Excess from which a new mesh is worth its cost. Without a card only.
    price: f64,
    /// Increment before which the mesh is not checked.
    next: u64,
    /// Number of new meshes, and of their elements that the mesh before did not have.
    count: u64,
    new_elements: u64,
    /// Kinetic energy that they lost.
    pub(super) lost_energy: f64,
    /// Mass of sheets that they left out.
    pub(super) removed_mass: f64,
    /// Whether the last mesh had new elements in a part of the body only, and no larger stable time increment.
    is_patch_useless: bool,
    /// Number of new meshes that could not be made since the last one.
    failures: u32,
}

impl MeshQuality {
    /// Returns whether a check is due at an increment, and sets the next one.
    fn is_due(&mut self, increment: u64, interval: u64) -> bool {
        let is_due = increment >= self.next;
        if is_due {
            self.next = increment + interval;
        }
        is_due
    }

    fn is_distorted(&mut self, body: &RemeshedBody, run: &RunState<'_>) -> bool {
        if !self.is_due(run.now.increment, body.frequency) {
            return false;
        }
        let (nodes, elements) = (&run.state.dofs.nodes, &run.state.elements);
        let stable = elements.stable_increment();
        let is_short = if body.automatic {
            self.is_collapsed(body.group, body.increment, elements)
        } else {
            if self.increment == 0.0 {
                self.increment = stable;
            }
            is_limited_by(elements, body.group) && stable < body.increment * self.increment
        };
        is_short || is_sharper(&body.quads, |n| nodes[body.nodes[n as usize]].place(), self.limit)
    }

    /// Returns whether a body that no card names has collapsed on the mesh of the deck.
    fn has_collapsed(&mut self, (group, trigger): (usize, FirstMesh), run: &RunState<'_>) -> bool {
        if !self.is_due(run.now.increment, AutomaticMeshes::INTERVAL) {
            return false;
        }
        let elements = &run.state.elements;
        match trigger {
            FirstMesh::Squashed(fraction) => {
                let searches = run.now.increment % (SEARCH * AutomaticMeshes::INTERVAL) < AutomaticMeshes::INTERVAL;
                let is_folded = searches && has_folded(run, group);
                self.is_collapsed(group, fraction, elements) || is_folded
            }
            FirstMesh::Sharp(limit) => {
                let smallest = smallest_sines(&*elements.groups[group], &run.state).fold(1.0, f64::min);
                if self.limit == 0.0 {
                    self.limit = limit.min(WORSE * libm::asin(smallest));
                }
                self.increment = self.increment.max(elements.undisturbed_increment());
                let is_short = elements.stable_increment() < AutomaticMeshes::COLLAPSED_ADAPTIVE * self.increment;
                smallest < if is_short { libm::sin(self.limit) } else { 0.0 }
            }
        }
    }

    /// Returns whether the elements of a group, squashed by plastic flow, have cost enough increments for a new mesh.
    fn is_collapsed(&mut self, group: usize, limit: f64, elements: &Elements) -> bool {
        let stable = elements.stable_increment();
        self.increment = self.increment.max(elements.undisturbed_increment());
        self.excess += AutomaticMeshes::INTERVAL as f64 * (1.0 - stable / self.increment);
        let is_short = is_limited_by(elements, group) && stable < limit * self.increment;
        is_short && self.excess > self.price && is_squashed(elements)
    }

    /// Sets the next check after a new mesh could not be made at an increment. The body keeps its mesh twice as long each time, so that
    /// attempts do not cost more than the run.
    pub(super) fn pause(&mut self, increment: u64, frequency: u64) {
        let checks = PAUSE << self.failures.min(MOST_DOUBLINGS);
        self.next = increment.saturating_add(frequency.saturating_mul(checks));
        self.failures += 1;
    }

    /// Begins a new mesh. `stable` are the stable time increments on the old and the new mesh.
    pub(super) fn begin_mesh(&mut self, body: &RemeshedBody, revision: &MeshRevision, stable: [f64; 2]) {
        let mesh = &revision.mesh;
        let angle = sharpest(&mesh.quads, |n| mesh.points[n as usize]);
        self.limit = body.angle.min(WORSE * angle);
        self.count += 1;
        self.failures = 0;
        self.new_elements += (mesh.quads.len() - revision.unchanged) as u64;
        if body.automatic {
            let is_better = stable[1] > BETTER * stable[0];
            self.excess = 0.0;
            self.price = if is_better { PRICE } else { 2.0 * self.price };
            self.is_patch_useless = revision.unchanged > 0 && !is_better;
        } else {
            self.increment = 0.0;
        }
    }

    /// Returns whether the next mesh may have new elements in a part of the body only.
    pub(super) fn allows_patch(&self) -> bool {
        !self.is_patch_useless
    }

    /// Returns whether this is the first new mesh of its body.
    pub(super) fn is_first(&self) -> bool {
        self.count == 1
    }
}

/// Returns whether plastic flow has squashed the element that limits the increment.
pub(super) fn is_squashed(elements: &Elements) -> bool {
    let strain =
        |(group, element): (usize, usize)| elements.groups[group].value(element, Variable::PlasticStrain.into());
    elements.limiting().and_then(strain).is_some_and(|strain| strain > SQUASHED)
}

/// Returns whether plastic flow has turned over a corner of an element of a group.
pub(super) fn has_folded(run: &RunState<'_>, group: usize) -> bool {
    let elements = &*run.state.elements.groups[group];
    let strain = |element: usize| elements.value(element, Variable::PlasticStrain.into()).unwrap_or(0.0);
    let mut turned = (0..elements.len()).filter(|element| has_turned_corner(elements, *element, &run.state));
    turned.any(|element| strain(element) > SQUASHED)
}

/// Returns whether an element of a group limits the increment.
fn is_limited_by(elements: &Elements, group: usize) -> bool {
    elements.limiting().is_some_and(|limiting| limiting.0 == group)
}

/// Returns the smallest sine of a corner of each quadrilateral or triangle of a group that is not deleted.
fn smallest_sines<'a>(group: &'a dyn ElementGroup, state: &'a State) -> impl Iterator<Item = f64> + 'a {
    (0..group.len()).filter(|e| !group.is_deleted(*e)).map(|e| smallest_sine_of(group, e, state))
}

/// Returns the smallest sine of a corner of a quadrilateral or triangle; negative for an angle above 180 degrees.
fn smallest_sine_of(group: &dyn ElementGroup, element: usize, state: &State) -> f64 {
    let nodes = group.nodes(element);
    smallest_sine(&[0, 1, 2, 3].inline_map(|i: usize| nodes[i]), |n| state.dofs.nodes[n as usize].place())
}

/// Returns whether a corner of a quadrilateral or triangle has turned over: an angle is above 180 degrees by more than rounding.
pub(super) fn has_turned_corner(group: &dyn ElementGroup, element: usize, state: &State) -> bool {
    smallest_sine_of(group, element, state) < -TURNED
}

/// Returns the shapes of the quadrilaterals and triangles that are not deleted; `None` without any.
pub(super) fn shape_of(state: &State) -> Option<MeshShape> {
    let groups = state.elements.groups.iter().filter(|group| group.topology() == ElementTopology::Quadrilateral);
    let sines = groups.flat_map(|group| smallest_sines(&**group, state));
    let (mut smallest, mut turned_corners, mut count) = (1.0_f64, 0, 0);
    for sine in sines {
        smallest = smallest.min(sine);
        turned_corners += usize::from(sine < 0.0);
        count += 1;
    }
    (count > 0).then(|| MeshShape { smallest_angle: libm::asin(smallest).to_degrees(), turned_corners })
}

/// New meshes of a run.
#[derive(Debug, Default, Persist)]
#[persist(derived: revisions)]
pub(super) struct RemeshMonitor {
    /// All new meshes, in their order. They are in the header of a checkpoint.
    pub(super) revisions: Vec<MeshRevision>,
    pub(super) bodies: Vec<MeshQuality>,
    /// Whether a mesh that could not be made has been reported.
    pub(super) reported: bool,
}

impl RemeshMonitor {
    pub(super) fn new(plan: &Plan) -> RemeshMonitor {
        let bodies = plan.remesh.iter().flat_map(|remesh| &remesh.bodies).map(|body| body.angle);
        let waiting = plan.automatic_meshes.iter().flat_map(AutomaticMeshes::groups).map(|_| 0.0);
        let quality = |limit| MeshQuality { limit, price: PRICE, ..MeshQuality::default() };
        RemeshMonitor { bodies: bodies.chain(waiting).map(quality).collect(), ..RemeshMonitor::default() }
    }

    /// Returns a body whose mesh is to be replaced at this instant.
    #[inline]
    pub(super) fn body_to_mesh(&mut self, run: &RunState<'_>) -> Option<usize> {
        if let Some(waiting) = &run.plan.automatic_meshes {
            return waiting
                .triggers()
                .zip(&mut self.bodies)
                .position(|(body, quality)| quality.has_collapsed(body, run));
        }
        let bodies = &run.plan.remesh.as_ref()?.bodies;
        bodies.iter().zip(&mut self.bodies).position(|(body, quality)| quality.is_distorted(body, run))
    }

    /// Returns the number of new meshes of each ledger row.
    pub(super) fn counts(&self, plan: &Plan) -> Vec<MeshChanges> {
        let bodies = plan.remesh.iter().flat_map(|remesh| &remesh.bodies).zip(&self.bodies);
        let changes = |(body, quality): (&RemeshedBody, &MeshQuality)| {
            let MeshQuality { count, new_elements, lost_energy, removed_mass, .. } = *quality;
            Some(MeshChanges { row: body.id?, count, new_elements, lost_energy, removed_mass })
        };
        bodies.filter_map(changes).collect()
    }
}
