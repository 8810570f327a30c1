//! All elements of a model: groups, corner forces, springs and dashpots, damping, deletion, and the stable time
//! increment.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant as Stopwatch;

use pulp::Arch;

use super::averaging::DilationAveraging;
use super::block::is_larger;
use super::cohesive::bounds::InterfaceBounds;
use super::connector::{Connectors, damped_rate};
use super::damping::RayleighDamping;
use super::distortion::DistortionControl;
use super::erosion::ErosionControl;
use super::free_nodes::FreeNodes;
use super::frequency::HighestFrequency;
use super::group::{ElementGroup, ElementPass, GroupTotals};
use super::lengths::UserLengthElements;
use super::mass_scaling::ScaledMasses;
use super::pattern::{self, FoldedElement, HourglassMotion};
use super::predefined::PredefinedFields;
use super::quiescent::ActiveNodes;
use super::removed::DeletionRecord;
use super::rings::RingFactors;
use super::tiles::{Tiles, tile_length};
use super::user_field::NodalFieldInput;
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::lists::{Memory, heap_bytes};
use crate::kernel::prefetch::PrefetchChoice;
use crate::kernel::topology::{ElementNodes, ElementTopology};
use crate::material::available::AvailableEnergy;
use crate::mesh::corner_forces::CornerForces;
use crate::mesh::gather::NodalAssembly;
use crate::routines::PointRoutines;
use crate::state::archive::{Persist, StateArchive};
use crate::state::dofs::Dofs;
use crate::state::energies::EnergyTotals;
use crate::state::halt::HaltReason;
use crate::state::magnitude::AmplitudeClock;
use crate::state::nodes::{NodeAccelerations, Nodes};
use crate::state::{EffectId, Instant};

/// Number of elements from which prefetching is tried: smaller models fit into second-level caches.
const LARGE: usize = 16_000;
/// Number of elements from which corner forces are summed in tiles: those of smaller models fit into second-level caches.
const TILED: usize = 131_072;
/// Pieces of nodes by which forces are requested before they are summed.
const AHEAD: usize = 2;

/// Deformable elements of a model, and everything that acts through them; nodes are stored separately.
#[derive(Clone, Default, Persist)]
// Characteristic lengths are stored in the groups; fields depend on the time only. Corner forces of quiescent elements
// are saved because their zeros have signs, which affect the accelerations.
#[persist(
    each: groups;
    present: connectors, damping, distortion, erosion, removed, free_nodes, masses, frequency, rings, tiles;
    derived: ids, deformed, interfaces, averagings, lengths, fields, arch, gather, prefetch, failure;
    then: Elements::check_deleted
)]
pub struct Elements {
    pub groups: Vec<Box<dyn ElementGroup>>,
    /// Ledger row of each group.
    pub ids: Vec<EffectId>,
    /// Totals of the group that limits the time increment in the last pass, and the index of the group.
    pub limit: (GroupTotals, usize),
    /// Bound of the relative increase of frequencies in that pass, if it is computed.
    pub(super) deformed: f64,
    /// Estimate of the highest frequency of the whole model; `None` if not used or not possible.
    pub frequency: Option<Box<HighestFrequency>>,
    /// Whether the current step uses the estimate.
    pub(super) uses_frequency: bool,
    /// For each group, the triangles whose dilation is averaged over their nodes; empty without such triangles.
    pub averagings: Vec<Option<DilationAveraging>>,
    /// Factors from plane sections to rings at nodes; `None` without area weighting.
    pub rings: Option<Box<RingFactors>>,
    /// Springs and dashpots; `None` without any.
    pub connectors: Option<Box<Connectors>>,
    /// Bounds of the time increment by cohesive elements; `None` without any.
    pub interfaces: Option<Box<InterfaceBounds>>,
    /// Rayleigh damping; `None` without any.
    pub damping: Option<Box<RayleighDamping>>,
    /// Elements whose characteristic length a user subroutine defines.
    pub lengths: Vec<UserLengthElements>,
    /// Temperatures and field variables prescribed at nodes; `None` without any.
    pub fields: Option<Box<PredefinedFields>>,
    /// Elements under distortion control; `None` without any.
    pub distortion: Option<Box<DistortionControl>>,
    /// Elements with deletion criteria of `*EROSION`; `None` without any.
    pub(super) erosion: Option<Box<ErosionControl>>,
    /// Masses and energies of deleted elements; `None` unless requested.
    pub removed: Option<Box<DeletionRecord>>,
    /// Nodes whose elements are all deleted; `None` if no element can be deleted.
    pub free_nodes: Option<Box<FreeNodes>>,
    /// Unscaled masses and mass factors; `None` without mass scaling.
    pub(super) masses: Option<Box<ScaledMasses>>,
    /// Instruction set of the loops over nodes.
    pub(super) arch: Arch,
    /// Corner forces and their assembly at nodes; with tiles those that are stored, and of shared nodes.
    corners: CornerForces,
    gather: NodalAssembly,
    /// Tiles in which other corner forces are summed; `None` if all are stored.
    tiles: Option<Box<Tiles>>,
    active_nodes: ActiveNodes,
    /// Whether the strains of the previous increment have not been computed yet.
    pending: bool,
    /// Boundaries of deleted elements, and the number that the loads of this step have processed.
    pub(super) deleted: (Vec<ElementNodes>, usize),
    /// Number of elements deleted from meshes that have been replaced since.
    deleted_before: usize,
    prefetch: PrefetchChoice,
    /// Failure of a user subroutine in the last update.
    pub failure: Option<HaltReason>,
}

/// Failure of an element: its group and index, and its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollapsedElement {
    pub group: usize,
    pub element: usize,
    pub volume: f64,
}

/// Records of the element groups that are updated.
#[derive(Default)]
pub struct GroupTiming<'a> {
    /// Wall-clock seconds by ledger row; `None` if they are not measured.
    pub seconds: Option<&'a mut [f64]>,
    /// Ledger row of the group that is updated, for other threads.
    pub mark: Option<&'a AtomicUsize>,
}

impl GroupTiming<'_> {
    /// Records that a row is evaluated. Returns the start time, if times are measured.
    pub(super) fn start(&self, row: EffectId) -> Option<Stopwatch> {
        if let Some(mark) = self.mark {
            mark.store(row, Relaxed);
        }
        self.seconds.as_ref().map(|_| Stopwatch::now())
    }

    /// Adds the time since `started` to a row.
    pub(super) fn stop(&mut self, started: Option<Stopwatch>, row: EffectId) {
        if let (Some(started), Some(seconds)) = (started, &mut self.seconds) {
            seconds[row] += started.elapsed().as_secs_f64();
        }
    }
}

impl Elements {
    /// Creates the elements from groups with their ledger rows, for nodes in the initial configuration.
    pub fn new(groups: Vec<Box<dyn ElementGroup>>, ids: Vec<EffectId>, gather: NodalAssembly, nodes: usize) -> Self {
        let blocks: usize = groups.iter().map(|g| g.force_blocks()).sum();
        let small = groups.iter().map(|g| g.len()).sum::<usize>() < LARGE;
        let mut elements = Elements {
            prefetch: if small { PrefetchChoice::never() } else { PrefetchChoice::default() },
            active_nodes: ActiveNodes::new(nodes, &groups),
            // One additional block, which stays zero.
            corners: CornerForces::new(blocks + 1),
            groups,
            ids,
            gather,
            pending: true,
            ..Elements::default()
        };
        elements.reserve_deletions();
        elements
    }

    /// Reserves memory for all elements that may be deleted, so that nothing allocates inside an increment.
    pub(super) fn reserve_deletions(&mut self) {
        let fragile: usize = self.groups.iter().filter(|g| g.properties().deletable).map(|g| g.len()).sum();
        self.deleted.0.reserve_exact(fragile.saturating_sub(self.deleted.0.len()));
        if let Some(removed) = &mut self.removed {
            removed.make_room();
        }
        if fragile > 0 {
            self.free_nodes.get_or_insert_with(|| Box::new(FreeNodes::new(&self.groups))).make_room();
        }
    }

    /// Sums corner forces in tiles, if the model is large and no element can be deleted by `*EROSION`, which reads corner
    /// forces. `read` are the elements, as group and index, whose corner forces are read otherwise. Called when the model
    /// is complete.
    pub fn tile(&mut self, read: impl Iterator<Item = (usize, usize)>) {
        if self.count() >= TILED && self.erosion.is_none() {
            self.tile_by(read, tile_length);
        }
    }

    /// Sums corner forces in tiles, unless too many nodes belong to several tiles; `length` returns the number of tasks of a
    /// tile from that of its group.
    pub fn tile_by(&mut self, read: impl Iterator<Item = (usize, usize)>, length: impl Fn(usize) -> usize) {
        let read = read.flat_map(|(group, element)| self.blocks_of(group, element));
        let groups = self.groups.iter().map(|group| (group.force_blocks(), group.properties().tiles));
        let tiles = Tiles::new(groups, &self.gather, read, length);
        if let Some((tiles, gather)) = tiles {
            self.corners = CornerForces::new(tiles.stored() + 1);
            (self.gather, self.tiles) = (gather, Some(Box::new(tiles)));
        }
    }

    /// Returns whether there are no elements. A model of masses, springs and dashpots has none, but has nodes.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    pub fn count(&self) -> usize {
        self.groups.iter().map(|g| g.len()).sum()
    }

    /// Calls the user subroutines that are needed at the start of the analysis: characteristic lengths and moduli.
    ///
    /// # Errors
    /// The failure of a subroutine.
    pub fn probe(&mut self, nodes: &Nodes, now: &Instant, mut user: PointRoutines<'_>) -> Result<(), HaltReason> {
        if let Some(routine) = user.lend().lengths {
            for entry in &self.lengths {
                entry.ask(&mut *self.groups[entry.group], nodes.as_slice(), now, routine)?;
            }
        }
        let mut calling = self.groups.iter_mut().filter_map(|group| group.user());
        calling.try_for_each(|group| group.probe(nodes.as_slice(), now, user.lend()))
    }

    /// Returns the energies that the elements can release from their initial state, with the masses of the elements.
    pub fn available_energies(&self, nodes: &Nodes) -> impl Iterator<Item = (AvailableEnergy, f64)> {
        self.groups.iter().flat_map(|group| {
            let of_element = |e| (group.available_energy(e, nodes.as_slice()), group.masses(e).iter().sum());
            (0..group.len()).map(of_element)
        })
    }

    /// Begins a step. `moved_otherwise`: constraints move nodes outside the nodal update, so that no node may be
    /// skipped.
    pub fn begin(&mut self, moved_otherwise: bool) {
        if moved_otherwise {
            self.active_nodes.wake();
        }
        self.deleted.1 = 0;
        // A cloned state has no reserved memory.
        self.reserve_deletions();
    }

    /// Makes all nodes active for the rest of the run.
    pub fn wake(&mut self) {
        self.active_nodes.wake();
    }

    /// Continues connectors and damping from the elements before a new mesh, with the current masses.
    pub fn follow_new_mesh(&mut self, previous: &Elements, nodes: &Nodes) {
        if let (Some(connectors), Some(previous)) = (&mut self.connectors, &previous.connectors) {
            connectors.follow_new_mesh(previous, nodes);
        }
        if let Some(damping) = &mut self.damping {
            damping.update_masses(&self.groups);
        }
    }

    /// Returns whether connectors, damping or distortion control add forces to nodes.
    pub fn has_links(&self) -> bool {
        self.connectors.is_some() || self.damping.is_some() || self.distortion.is_some()
    }

    /// Marks that the nodes have moved and strains must be updated.
    pub fn mark_moved(&mut self) {
        self.pending = true;
    }

    /// Sets the temperatures and field variables prescribed at this instant.
    ///
    /// # Errors
    /// If a user subroutine for field variables fails; the run halts.
    pub fn give_fields(&mut self, clock: &AmplitudeClock<'_>, input: NodalFieldInput<'_>) -> Result<(), HaltReason> {
        let Some(fields) = &mut self.fields else { return Ok(()) };
        fields.give(&mut self.groups, clock, input)
    }

    /// Returns the prescribed temperature of an element; `None` if it has none.
    pub fn prescribed_temperature(&self, group: usize, element: usize) -> Option<f64> {
        Some(self.fields.as_ref()?.temperatures_of(group)?[element])
    }

    /// Returns whether the strains of the previous increment have not been computed yet.
    pub fn is_pending(&self) -> bool {
        self.pending
    }

    /// Updates stresses and corner forces to this instant, and records the run time of each group.
    pub fn update(
        &mut self,
        dofs: &mut Dofs,
        now: &Instant,
        threads: bool,
        mut user: PointRoutines<'_>,
        mut timing: GroupTiming<'_>,
    ) {
        if !std::mem::take(&mut self.pending) {
            return;
        }
        if self.erosion.is_some() {
            self.erode(dofs, threads, &mut timing);
        }
        let mut first = 0;
        self.limit = (GroupTotals::default(), 0);
        let mut interface = (GroupTotals::default(), 0);
        self.deformed = 0.0;
        let prefetch_started = self.prefetch.start();
        for (i, group) in self.groups.iter_mut().enumerate() {
            let started = timing.start(self.ids[i]);
            let blocks = group.force_blocks();
            let all_blocks = first..first + blocks;
            let corners = self.corners.slots(stored_among(self.tiles.as_deref(), all_blocks));
            let nodes = dofs.nodes.as_slice();
            let user = user.lend();
            let averaging = self.averagings.get_mut(i).and_then(Option::as_mut);
            let dilation_correction = averaging.map(|a| a.measure(&**group, &dofs.nodes));
            let totals = group.update(ElementPass {
                nodes,
                dt: dofs.nodes.previous_dt,
                before: NodeAccelerations { accelerations: &dofs.nodes.acceleration, half: dofs.nodes.half },
                now,
                threads,
                user,
                corners,
                tiles: self.tiles.as_mut().and_then(|tiles| tiles.pass(i)),
                dilation_correction,
                prefetches: self.prefetch.is_on(),
            });
            first += blocks;
            group.newly_deleted(&mut self.deleted.0);
            if totals.rate.is_nan() {
                self.failure = group.user().and_then(|user| user.failure());
            }
            self.deformed = self.deformed.max(totals.deformed);
            add(&totals, &mut dofs.energies);
            let limit = if group.topology() == ElementTopology::Cohesive { &mut interface } else { &mut self.limit };
            if is_larger(totals.rate, limit.0.rate) {
                *limit = (totals, i);
            }
            timing.stop(started, self.ids[i]);
        }
        self.prefetch.stop(prefetch_started);
        self.add_interface_limit(interface);
        self.count_removed();
        if let Some(free) = &mut self.free_nodes {
            free.count(&self.deleted.0);
        }
        if let Some(rings) = &mut self.rings {
            rings.measure(&self.groups, &dofs.nodes);
        }
        self.bound_frequency(&dofs.nodes);
    }

    /// Adds the limit of cohesive elements to that of the bodies which they join: the squares of both frequencies add
    /// (Rayleigh).
    fn add_interface_limit(&mut self, interface: (GroupTotals, usize)) {
        let (bodies, rate) = (self.limit.0.rate, interface.0.rate);
        if rate == 0.0 {
            return;
        }
        if is_larger(rate, bodies) {
            self.limit = interface;
        }
        self.limit.0.rate = damped_rate(bodies, 4.0 * rate * rate, 0.0);
    }

    /// Sets the bounds of the time increment by cohesive elements for the current masses.
    pub fn bound_interfaces(&mut self, nodes: &Nodes) {
        if let Some(interfaces) = &self.interfaces {
            interfaces.apply(&mut self.groups, nodes);
        }
    }

    /// Returns the selected instruction set.
    pub fn arch(&self) -> Arch {
        self.arch
    }

    /// Returns the number of deleted elements.
    pub fn deleted(&self) -> usize {
        self.deleted_before + self.deleted.0.len()
    }

    /// Takes the deleted elements of a model in which a group had another mesh; `node` returns the node that one of that
    /// model has become. The boundaries of deleted elements of this group are no longer known.
    pub fn follow_deletions(&mut self, previous: &Elements, group: usize, node: impl Fn(u32) -> Option<u32>) {
        let moved = |boundary: &ElementNodes| {
            let mut moved = *boundary;
            for n in moved.iter_mut() {
                *n = node(*n)?;
            }
            Some(moved)
        };
        self.deleted.0.clear();
        self.deleted.0.extend(previous.deleted.0.iter().filter_map(moved));
        self.deleted.1 = self.deleted.0.len();
        self.deleted_before = previous.deleted() - self.deleted.0.len();
        if let (Some(erosion), Some(previous)) = (&mut self.erosion, &previous.erosion) {
            erosion.follow_new_mesh(previous, group);
        }
        if let (Some(free), Some(previous)) = (&mut self.free_nodes, &previous.free_nodes) {
            free.follow_new_mesh(previous, &node);
        }
        if let (Some(removed), Some(previous)) = (&mut self.removed, &previous.removed) {
            removed.follow_new_mesh(previous, (group, self.deleted.0.len()), node);
        }
    }

    /// Returns the boundaries of the deleted elements.
    pub fn deleted_boundaries(&self) -> &[ElementNodes] {
        &self.deleted.0
    }

    /// Returns the boundaries of elements deleted since the last call in this step.
    pub fn newly_deleted(&mut self) -> &[ElementNodes] {
        let processed = std::mem::replace(&mut self.deleted.1, self.deleted.0.len());
        &self.deleted.0[processed..]
    }

    /// Adds the forces of connectors, damping and distortion control, then determines the nodes that need an update in
    /// this increment.
    pub fn add_link_forces(&mut self, dofs: &mut Dofs) {
        let alive = |(group, element): (usize, usize)| !self.groups[group].is_deleted(element);
        if let Some(connectors) = &mut self.connectors {
            connectors.add_forces(dofs);
        }
        if let Some(damping) = &mut self.damping {
            damping.add_forces(dofs, alive);
        }
        if let Some(distortion) = &mut self.distortion {
            distortion.add_forces(dofs, alive, &mut self.limit.0.rate);
        }
        self.active_nodes.update(&self.groups, &dofs.nodes.forces[0]);
    }

    /// Checks that the last pass gave finite forces.
    ///
    /// # Errors
    /// The element with a rate that is not finite.
    pub fn check(&self, nodes: &Nodes) -> Result<(), CollapsedElement> {
        let (totals, group) = self.limit;
        if totals.rate.is_finite() {
            return Ok(());
        }
        let element = totals.limiting;
        Err(CollapsedElement { group, element, volume: self.groups[group].volume(element, nodes.as_slice()) })
    }

    /// Sums the corner forces of the nodes from `first` on; with area weighting, scales them from plane sections to
    /// rings.
    #[inline(always)]
    pub fn nodal_forces(&self, first: usize, forces: &mut [[f64; 2]]) {
        if let Some(tiles) = &self.tiles {
            tiles.sum(first, (&self.gather, &self.corners), forces);
        } else {
            if self.prefetch.is_on() {
                self.gather.prefetch(first + AHEAD * forces.len(), forces.len(), &self.corners);
            }
            self.gather.sum(first, &self.corners, forces);
        }
        if let Some(rings) = &self.rings {
            for (force, ring) in forces.iter_mut().zip(&rings.factors[first..]) {
                *force = [ring * force[0], ring * force[1]];
            }
        }
    }

    /// Returns the quadrilateral with the largest hourglass displacement.
    pub fn most_folded(&self, nodes: &Nodes) -> Option<FoldedElement> {
        pattern::most_folded(&self.groups, nodes)
    }

    /// Returns the kinetic energy in the hourglass pattern.
    pub fn hourglass_motion(&self, nodes: &Nodes) -> HourglassMotion {
        pattern::hourglass_motion(&self.groups, nodes)
    }

    /// Returns the factors from plane sections to rings at the nodes; `None` without area weighting.
    pub fn ring_factors(&self) -> Option<&[f64]> {
        self.rings.as_ref().map(|rings| &*rings.factors)
    }

    fn blocks_of(&self, group: usize, element: usize) -> Range<usize> {
        let preceding: usize = self.groups[..group].iter().map(|g| g.force_blocks()).sum();
        let per = self.groups[group].topology().force_blocks();
        let first = preceding + per * (element / LANES);
        stored_among(self.tiles.as_deref(), first..first + per)
    }

    /// Returns the force of an element on one of its nodes, counted in the order of its topology.
    pub fn corner_force(&self, group: usize, element: usize, corner: usize) -> [f64; 2] {
        let block = self.blocks_of(group, element).start + corner / 4;
        let force = self.corners.of(block, element % LANES, corner % 4);
        let Some(rings) = &self.rings else { return force };
        let node = self.groups[group].nodes(element)[corner] as usize;
        force.inline_map(|f| rings.factors[node] * f)
    }

    /// Sets the forces of an element to zero.
    pub(super) fn clear_corners(&mut self, group: usize, element: usize) {
        self.blocks_of(group, element).for_each(|block| self.corners.clear(block, element % LANES));
    }

    /// Returns the sum of the corner forces of a node, without the factors of area weighting.
    pub fn nodal_force(&self, node: usize) -> [f64; 2] {
        let gather = (&self.gather, &self.corners);
        self.tiles.as_ref().map_or_else(|| gather.0.node_force(node, gather.1), |tiles| tiles.node_force(node, gather))
    }

    /// Returns whether any of the [`crate::kernel::chunks::FEW`] nodes from `first` on needs an update.
    #[inline(always)]
    pub fn has_work(&self, first: usize) -> bool {
        self.active_nodes.has_work(first)
    }

    /// Limits the time increment by the rate of an element, until the next update.
    pub(super) fn raise_limit(&mut self, group: usize, element: usize, rate: f64) {
        if rate > self.limit.0.rate {
            (self.limit.0.rate, self.limit.0.limiting, self.limit.1) = (rate, element, group);
        }
    }

    /// Returns group and element that limit the time increment; `None` without elements.
    pub fn limiting(&self) -> Option<(usize, usize)> {
        (!self.is_empty()).then_some((self.limit.1, self.limit.0.limiting))
    }

    /// Returns the smallest stable time increment of all elements, springs and dashpots, from the last pass; infinity if
    /// there are none.
    pub fn stable_increment(&self) -> f64 {
        let elements = self.limit.0.rate;
        let linked = self.connectors.as_ref().map_or(elements, |c| c.rate(elements));
        1.0 / self.damping.as_ref().map_or(linked, |d| d.rate(linked))
    }

    /// Returns the largest ratio of the coefficients of dashpots to the masses at their ends; 0 without dashpots.
    pub fn damping_rate(&self) -> f64 {
        self.connectors.as_ref().map_or(0.0, |connectors| connectors.damping_rate())
    }

    /// Returns the bytes of the lists of deletion criteria.
    pub fn bytes_of_erosion(&self) -> usize {
        self.erosion.as_ref().map_or(0, |e| e.memory().used)
    }

    /// Returns the bytes of the lists of mass scaling.
    pub fn bytes_of_masses(&self) -> usize {
        self.masses.as_ref().map_or(0, |m| m.bytes())
    }

    /// Returns the bytes that belong to no single group: corner forces, and the connectivity from corners to nodes.
    pub fn bytes_of_gather(&self) -> usize {
        let deleted = heap_bytes(&self.deleted.0);
        let tiles = self.tiles.as_ref().map_or(0, |tiles| tiles.bytes());
        self.corners.bytes() + self.gather.bytes() + self.active_nodes.bytes() + deleted + tiles
    }
}

/// Returns the stored blocks of corner forces among a range of all blocks.
fn stored_among(tiles: Option<&Tiles>, all: Range<usize>) -> Range<usize> {
    tiles.map_or(all.clone(), |tiles| tiles.stored_among(&all))
}

fn add(totals: &GroupTotals, energies: &mut EnergyTotals) {
    energies.internal += totals.internal;
    energies.plastic += totals.plastic;
    energies.damaged += totals.damaged;
    energies.viscous += totals.viscous;
    energies.artificial += totals.artificial;
}

impl Elements {
    fn check_deleted(&mut self, archive: &mut StateArchive<'_>) {
        if self.deleted.1 > self.deleted.0.len() {
            archive.reject(|| "more deleted elements are marked as processed than exist".into());
        }
    }
}
