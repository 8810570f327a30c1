//! All elements of a model: groups, corner forces, springs and dashpots, damping, deletion, and the stable time
//! increment.

use pulp::Arch;

use super::assembly::ForceAssembly;
use super::averaging::DilationAveraging;
use super::cohesive::bounds::InterfaceBounds;
use super::connector::Connectors;
use super::damping::RayleighDamping;
use super::deletions::Deletions;
use super::distortion::DistortionControl;
use super::erosion::ErosionControl;
use super::frequency::{ConstrainedNodes, HighestFrequency};
use super::group::{ElementGroup, ElementPass, GroupSetting, GroupTotals};
use super::lengths::UserLengthElements;
use super::mass_scaling::{MassScaling, StepMassScaling};
use super::pattern::{self, FoldedElement, HourglassMotion};
use super::predefined::PredefinedFields;
use super::quiescent::ActiveNodes;
use super::stable_limit::StableLimit;
use super::tiles::tile_length;
use super::timing::GroupTiming;
use super::user_field::NodalFieldInput;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementTopology;
use crate::material::available::AvailableEnergy;
use crate::mesh::gather::NodalAssembly;
use crate::routines::PointRoutines;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::energies::EnergyTotals;
use crate::state::halt::HaltReason;
use crate::state::magnitude::AmplitudeClock;
use crate::state::nodes::{NodeAccelerations, Nodes};
use crate::state::{EffectId, Instant};

/// Number of elements from which corner forces are summed in tiles: those of smaller models fit into second-level caches.
const TILED: usize = 131_072;

/// Deformable elements of a model, and everything that acts through them; nodes are stored separately.
#[derive(Clone, Default, Persist)]
// Characteristic lengths are stored in the groups; fields depend on the time only. Corner forces of quiescent elements
// are saved because their zeros have signs, which affect the accelerations.
#[persist(
    each: groups;
    present: connectors, damping, distortion, erosion, frequency;
    derived: ids, deformed, interfaces, averagings, lengths, fields, arch, failure
)]
pub struct Elements {
    pub groups: Vec<Box<dyn ElementGroup>>,
    /// Ledger row of each group.
    pub ids: Vec<EffectId>,
    /// Limit of the time increment by the last pass.
    pub limit: StableLimit,
    /// Bound of the relative increase of frequencies in that pass, if it is computed.
    deformed: f64,
    /// Estimate of the highest frequency of the whole model; `None` if not used or not possible.
    pub frequency: Option<Box<HighestFrequency>>,
    /// Whether the current step uses the estimate.
    uses_frequency: bool,
    /// For each group, the triangles whose dilation is averaged over their nodes; empty without such triangles.
    pub averagings: Vec<Option<DilationAveraging>>,
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
    erosion: Option<Box<ErosionControl>>,
    pub deletions: Deletions,
    pub mass_scaling: MassScaling,
    /// Instruction set of the loops over nodes.
    arch: Arch,
    pub assembly: ForceAssembly,
    active_nodes: ActiveNodes,
    /// Whether the strains of the previous increment have not been computed yet.
    pending: bool,
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

impl Elements {
    /// Creates the elements from groups with their ledger rows, for nodes in the initial configuration.
    pub fn new(groups: Vec<Box<dyn ElementGroup>>, ids: Vec<EffectId>, gather: NodalAssembly, nodes: usize) -> Self {
        let mut elements = Elements {
            active_nodes: ActiveNodes::new(nodes, &groups),
            assembly: ForceAssembly::new(&groups, gather),
            groups,
            ids,
            pending: true,
            ..Elements::default()
        };
        elements.deletions.reserve(&elements.groups);
        elements
    }

    /// Selects an instruction set for all groups and for the loops over nodes.
    pub fn use_arch(&mut self, arch: Arch) {
        self.arch = arch;
        self.groups.iter_mut().for_each(|group| group.configure(GroupSetting::Instructions(arch)));
    }

    /// Sums corner forces in tiles, if the model is large and no element can be deleted by `*EROSION`, which reads corner
    /// forces. `read` are the elements, as group and index, whose corner forces are read otherwise. Called when the model
    /// is complete.
    pub fn tile(&mut self, read: impl Iterator<Item = (usize, usize)>) {
        if self.count() >= TILED && self.erosion.is_none() {
            self.assembly.tile_by(&self.groups, read, tile_length);
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
        self.deletions.begin(&self.groups);
    }

    /// Makes all nodes active for the rest of the run.
    pub fn wake(&mut self) {
        self.active_nodes.wake();
    }

    /// Continues connectors, damping and distortion control from the elements before a new mesh, with the current masses.
    pub fn follow_new_mesh(&mut self, previous: &Elements, nodes: &Nodes) {
        if let (Some(connectors), Some(previous)) = (&mut self.connectors, &previous.connectors) {
            connectors.follow_new_mesh(previous, nodes);
        }
        if let (Some(distortion), Some(previous)) = (&mut self.distortion, &previous.distortion) {
            distortion.follow_new_mesh(previous);
        }
        if let Some(damping) = &mut self.damping {
            damping.update_masses(&self.groups);
        }
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
        user: PointRoutines<'_>,
        mut timing: GroupTiming<'_>,
    ) {
        if !std::mem::take(&mut self.pending) {
            return;
        }
        let Elements { groups, assembly, deletions, erosion, .. } = self;
        if let Some(erosion) = erosion {
            erosion.erode(groups, assembly, deletions, dofs, threads, &mut timing);
        }
        self.update_groups(dofs, now, threads, user, &mut timing);
        self.deletions
            .count_pass(&self.groups, |group, element| self.mass_scaling.factor(group, element).unwrap_or(1.0));
        if let Some(rings) = &mut self.assembly.rings {
            rings.measure(&self.groups, &dofs.nodes);
        }
        if let Some(frequency) = self.frequency.as_mut().filter(|_| self.uses_frequency) {
            frequency.follow_pass(&mut self.groups, &mut self.limit, self.deformed, &dofs.nodes, self.arch);
        }
    }

    fn update_groups(
        &mut self,
        dofs: &mut Dofs,
        now: &Instant,
        threads: bool,
        mut user: PointRoutines<'_>,
        timing: &mut GroupTiming<'_>,
    ) {
        let Elements { groups, ids, averagings, assembly, deletions, .. } = self;
        let (mut bodies, mut interfaces) = (StableLimit::default(), StableLimit::default());
        let mut first = 0;
        self.deformed = 0.0;
        let prefetch_started = assembly.prefetch.start();
        let prefetches = assembly.prefetch.is_on();
        for (i, group) in groups.iter_mut().enumerate() {
            let started = timing.start(ids[i]);
            let blocks = group.force_blocks();
            let (corners, tiles) = assembly.of_group(i, first..first + blocks);
            let averaging = averagings.get_mut(i).and_then(Option::as_mut);
            let dilation_correction = averaging.map(|a| a.measure(&**group, &dofs.nodes));
            let totals = group.update(ElementPass {
                nodes: dofs.nodes.as_slice(),
                dt: dofs.nodes.previous_dt,
                before: NodeAccelerations { accelerations: &dofs.nodes.acceleration, half: dofs.nodes.half },
                now,
                threads,
                user: user.lend(),
                corners,
                tiles,
                dilation_correction,
                prefetches,
            });
            first += blocks;
            group.newly_deleted(&mut deletions.boundaries);
            if totals.rate.is_nan() {
                self.failure = group.user().and_then(|user| user.failure());
            }
            self.deformed = self.deformed.max(totals.deformed);
            add(&totals, &mut dofs.energies);
            let is_interface = group.topology() == ElementTopology::Cohesive;
            let limit = if is_interface { &mut interfaces } else { &mut bodies };
            limit.take_stricter(totals, i);
            timing.stop(started, ids[i]);
        }
        assembly.prefetch.stop(prefetch_started);
        bodies.add_interface(interfaces);
        self.limit = bodies;
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

    /// Sets the deletion criteria of elements; nodes are in the initial configuration.
    pub fn watch(&mut self, erosion: ErosionControl, nodes: &Nodes) {
        for group in erosion.groups() {
            self.groups[group].configure(GroupSetting::Deletion);
        }
        self.erosion = Some(Box::new(erosion));
        self.deletions.reserve(&self.groups);
        self.deletions.start_record(&mut self.groups, nodes.len());
    }

    /// Takes the deletions of a model in which a group had another mesh; `node` returns the node that one of that model has
    /// become.
    pub fn follow_deletions(&mut self, previous: &Elements, group: usize, node: impl Fn(u32) -> Option<u32>) {
        self.deletions.follow_new_mesh(&previous.deletions, group, node);
        if let (Some(erosion), Some(previous)) = (&mut self.erosion, &previous.erosion) {
            erosion.follow_new_mesh(previous, group);
        }
    }

    /// Scales the masses if due, before the forces of this instant are computed. Calls `changed` for every node whose
    /// mass changes, with the increase of its kinetic energy along r and z. Returns whether masses may have changed.
    pub fn scale_masses(
        &mut self,
        step: &mut StepMassScaling,
        now: &Instant,
        dofs: &mut Dofs,
        changed: &mut dyn FnMut(usize, [f64; 2]),
    ) -> bool {
        let Some(starts) = self.mass_scaling.scale(&mut self.groups, step, now, dofs, changed) else { return false };
        if let Some(connectors) = &mut self.connectors {
            connectors.bound(&dofs.nodes);
        }
        self.bound_interfaces(&dofs.nodes);
        if let Some(damping) = &mut self.damping {
            damping.update_masses(&self.groups);
        }
        if starts {
            self.mass_scaling.raise_limit(&self.groups, &mut self.limit, &dofs.nodes);
        }
        true
    }

    /// Returns whether connectors, damping or distortion control add forces to nodes.
    pub fn has_links(&self) -> bool {
        self.connectors.is_some() || self.damping.is_some() || self.distortion.is_some()
    }

    /// Begins a step; `use_estimate` selects the global estimate of the stable time increment.
    pub fn begin_frequency(&mut self, use_estimate: bool, nodes: &Nodes, held: &ConstrainedNodes<'_>) {
        self.uses_frequency = use_estimate;
        let Elements { groups, frequency, arch, .. } = self;
        let estimate =
            |frequency: &mut Box<HighestFrequency>| frequency.begin_step(use_estimate, groups, nodes, held, *arch);
        let cap = frequency.as_mut().map_or(f64::INFINITY, estimate);
        groups.iter_mut().for_each(|g| g.configure(GroupSetting::HighestFrequency(cap)));
    }

    /// Returns the number of estimates of the highest frequency so far; `None` without the estimate.
    pub fn estimates(&self) -> Option<u64> {
        self.frequency.as_ref().map(|f| f.state.count)
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
            distortion.add_forces(dofs, alive, &mut self.limit.totals.rate);
        }
        self.active_nodes.update(&self.groups, &dofs.nodes.forces[0]);
    }

    /// Checks that the last pass gave finite forces.
    ///
    /// # Errors
    /// The element with a rate that is not finite.
    pub fn check(&self, nodes: &Nodes) -> Result<(), CollapsedElement> {
        let StableLimit { totals, group } = self.limit;
        if totals.rate.is_finite() {
            return Ok(());
        }
        let element = totals.limiting;
        Err(CollapsedElement { group, element, volume: self.groups[group].volume(element, nodes.as_slice()) })
    }

    /// Returns the quadrilateral with the largest hourglass displacement.
    pub fn most_folded(&self, nodes: &Nodes) -> Option<FoldedElement> {
        pattern::most_folded(&self.groups, nodes)
    }

    /// Returns the kinetic energy in the hourglass pattern.
    pub fn hourglass_motion(&self, nodes: &Nodes) -> HourglassMotion {
        pattern::hourglass_motion(&self.groups, nodes)
    }

    /// Returns whether any of the [`crate::kernel::chunks::FEW`] nodes from `first` on needs an update.
    #[inline(always)]
    pub fn has_work(&self, first: usize) -> bool {
        self.active_nodes.has_work(first)
    }

    /// Returns group and element that limit the time increment; `None` without elements.
    pub fn limiting(&self) -> Option<(usize, usize)> {
        (!self.is_empty()).then_some((self.limit.group, self.limit.totals.limiting))
    }

    /// Returns the smallest stable time increment of all elements, springs and dashpots, from the last pass; infinity if
    /// there are none.
    pub fn stable_increment(&self) -> f64 {
        let elements = self.limit.totals.rate;
        let linked = self.connectors.as_ref().map_or(elements, |c| c.rate(elements));
        1.0 / self.damping.as_ref().map_or(linked, |d| d.rate(linked))
    }

    /// Returns the stable time increment that the mesh would have without deformation: where a step has begun without the
    /// global estimate, as if the elements were squares, which it helps by sqrt(2).
    pub fn undisturbed_increment(&self) -> f64 {
        let waits = self.frequency.as_ref().is_some_and(|frequency| frequency.state.waits);
        self.stable_increment() * if waits { std::f64::consts::SQRT_2 } else { 1.0 }
    }

    /// Returns the largest ratio of the coefficients of dashpots to the masses at their ends; 0 without dashpots.
    pub fn damping_rate(&self) -> f64 {
        self.connectors.as_ref().map_or(0.0, |connectors| connectors.damping_rate())
    }

    /// Returns the bytes that belong to no single group: corner forces, and the connectivity from corners to nodes.
    pub fn bytes_of_gather(&self) -> usize {
        self.assembly.bytes() + self.active_nodes.bytes() + self.deletions.bytes_of_boundaries()
    }

    /// Returns the bytes of the lists of deletion criteria.
    pub fn bytes_of_erosion(&self) -> usize {
        self.erosion.as_ref().map_or(0, |e| e.memory().used)
    }
}

fn add(totals: &GroupTotals, energies: &mut EnergyTotals) {
    energies.internal += totals.internal;
    energies.plastic += totals.plastic;
    energies.damaged += totals.damaged;
    energies.viscous += totals.viscous;
    energies.artificial += totals.artificial;
}
