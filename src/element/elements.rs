//! All elements of a scene: their groups, the forces on their corners, springs and dashpots, and what bounds the increment.
//! Never here: the motion of nodes, loads, deck words.

use std::ops::Range;

use super::averaging::Averaging;
use super::block::is_larger;
use super::connector::Connectors;
use super::damping::Damping;
use super::distortion::DistortionControl;
use super::erosion::Erosion;
use super::frequency::HighestFrequency;
use super::group::{ElementGroup, Pass, Totals};
use super::lengths::AskedLengths;
use super::mass_scaling::Masses;
use super::pattern::{self, Folded, Trembling};
use super::predefined::PredefinedFields;
use super::quiescent::ActiveNodes;
use super::removed::Removed;
use super::rings::Rings;
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::ElementNodes;
use crate::mesh::corner_forces::CornerForces;
use crate::mesh::gather::Gather;
use crate::state::archive::{Archive, persist_struct};
use crate::state::dofs::Dofs;
use crate::state::energies::Energies;
use crate::state::halt::Halt;
use crate::state::magnitude::Clock;
use crate::state::nodes::{Accelerated, Nodes};
use crate::state::{EffectId, Instant};
use crate::user::AtPoints;

/// Everything that deforms, but for its nodes.
#[derive(Clone, Default)]
pub struct Elements {
    pub groups: Vec<Box<dyn ElementGroup>>,
    /// The row of the ledger of each group.
    pub ids: Vec<EffectId>,
    /// What the last pass over the elements came to, and the group that limits the increment.
    pub limit: (Totals, usize),
    /// By how much that pass can have raised a frequency, where it is followed.
    pub(super) deformed: f64,
    /// Estimate of the highest frequency of the whole; `None` where none is wanted or none can be made.
    pub frequency: Option<Box<HighestFrequency>>,
    /// Whether this step wants it.
    pub(super) frequency_asked: bool,
    /// Of each group, the triangles whose dilation is averaged over their nodes; empty without any.
    pub averagings: Vec<Option<Averaging>>,
    /// Rings of nodes under area weighting.
    pub rings: Option<Box<Rings>>,
    /// Springs and dashpots; `None` without any.
    pub connectors: Option<Box<Connectors>>,
    /// Mass proportional damping; `None` without any.
    pub damping: Option<Box<Damping>>,
    /// Elements whose characteristic length a routine of the user gives at the start; none without the card.
    pub lengths: Vec<AskedLengths>,
    /// Field variables prescribed at nodes; `None` without any.
    pub fields: Option<Box<PredefinedFields>>,
    /// Elements under distortion control; `None` without any.
    pub distortion: Option<Box<DistortionControl>>,
    /// Elements that are deleted by more than their material; `None` without any.
    pub(super) erosion: Option<Box<Erosion>>,
    /// Books of what deletion took away; `None` unless they are kept.
    pub removed: Option<Box<Removed>>,
    /// Masses without scaling; `None` unless the deck scales masses.
    pub(super) masses: Option<Box<Masses>>,
    corners: CornerForces,
    gather: Gather,
    awake: ActiveNodes,
    /// Whether the strains of the increment behind are still to come.
    pending: bool,
    /// Boundaries of deleted elements, and how many of them the loads of this step have been told.
    pub(super) deleted: (Vec<ElementNodes>, usize),
    /// Why a routine of the user gave no stress in the last update.
    pub failure: Option<Halt>,
}

/// Why the elements give no forces: the group and element to blame, and its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collapsed {
    pub group: usize,
    pub element: usize,
    pub volume: f64,
}

impl Elements {
    /// Groups with their rows of the ledger, on nodes at the start.
    pub fn new(groups: Vec<Box<dyn ElementGroup>>, ids: Vec<EffectId>, gather: Gather, nodes: usize) -> Self {
        let blocks: usize = groups.iter().map(|g| g.force_blocks()).sum();
        let mut elements = Elements {
            awake: ActiveNodes::new(nodes, &groups),
            // One block more, which stays zero.
            corners: CornerForces::new(blocks + 1, groups.iter().all(|g| g.properties().single)),
            groups,
            ids,
            gather,
            pending: true,
            ..Elements::default()
        };
        elements.make_room_for_deletions();
        elements
    }

    /// Room for all that may be deleted: nothing allocates inside an increment.
    pub(super) fn make_room_for_deletions(&mut self) {
        let fragile: usize = self.groups.iter().filter(|g| g.properties().deletable).map(|g| g.len()).sum();
        self.deleted.0.reserve_exact(fragile.saturating_sub(self.deleted.0.len()));
        if let Some(removed) = &mut self.removed {
            removed.make_room();
        }
    }

    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    pub fn count(&self) -> usize {
        self.groups.iter().map(|g| g.len()).sum()
    }

    /// The analysis begins: asks what only the user's routine can tell.
    ///
    /// # Errors
    /// Why it could not.
    pub fn probe(&mut self, nodes: &Nodes, now: &Instant, mut user: AtPoints<'_>) -> Result<(), Halt> {
        if let Some(routine) = user.lend().lengths {
            for asked in &self.lengths {
                asked.ask(&mut *self.groups[asked.group], nodes.as_slice(), now, routine)?;
            }
        }
        let mut calling = self.groups.iter_mut().filter_map(|group| group.extensions().user());
        calling.try_for_each(|group| group.probe(nodes.as_slice(), now, user.lend()))
    }

    /// A step begins; `moved_otherwise` says whether constraints move nodes behind the passes over them.
    pub fn begin(&mut self, moved_otherwise: bool) {
        if moved_otherwise {
            self.awake.wake();
        }
        self.deleted.1 = 0;
        // A copy of a state has no room to spare.
        self.make_room_for_deletions();
    }

    /// Whether links between nodes push them, beside loads.
    pub fn has_links(&self) -> bool {
        self.connectors.is_some() || self.damping.is_some() || self.distortion.is_some()
    }

    /// An increment has been made: its strains are to come.
    pub fn moved(&mut self) {
        self.pending = true;
    }

    /// Gives elements the field variables that are prescribed at this instant.
    pub fn give_fields(&mut self, clock: &Clock<'_>) {
        if let Some(fields) = &mut self.fields {
            fields.give(&mut self.groups, clock);
        }
    }

    /// Whether the strains of the increment behind are still to come.
    pub fn is_pending(&self) -> bool {
        self.pending
    }

    /// Stresses and corner forces at this instant. `timed` is told the seconds of each group by its row of the ledger.
    pub fn update(
        &mut self,
        dofs: &mut Dofs,
        now: &Instant,
        threads: bool,
        mut user: AtPoints<'_>,
        timed: Option<&mut [f64]>,
    ) {
        if !std::mem::take(&mut self.pending) {
            return;
        }
        if self.erosion.is_some() {
            self.erode(dofs, threads);
        }
        let mut first = 0;
        self.limit = (Totals::default(), 0);
        self.deformed = 0.0;
        let mut seconds = timed;
        for (i, group) in self.groups.iter_mut().enumerate() {
            let clock = seconds.as_ref().map(|_| std::time::Instant::now());
            let blocks = group.force_blocks();
            let corners = self.corners.slots(first..first + blocks);
            let nodes = dofs.nodes.as_slice();
            let user = user.lend();
            let before = Accelerated { accelerations: &dofs.nodes.acceleration, half: dofs.nodes.half };
            let averaging = self.averagings.get_mut(i).and_then(Option::as_mut);
            let lacking = averaging.map(|a| a.measure(&**group, &dofs.nodes));
            let totals =
                group.update(Pass { nodes, dt: dofs.nodes.behind, before, now, threads, user, corners, lacking });
            first += blocks;
            group.extensions().deletion().newly_deleted(&mut self.deleted.0);
            if totals.rate.is_nan() {
                self.failure = group.extensions().user().and_then(|user| user.failure());
            }
            self.deformed = self.deformed.max(totals.deformed);
            add(&totals, &mut dofs.energies);
            if is_larger(totals.rate, self.limit.0.rate) {
                self.limit = (totals, i);
            }
            if let (Some(clock), Some(seconds)) = (clock, &mut seconds) {
                seconds[self.ids[i]] += clock.elapsed().as_secs_f64();
            }
        }
        self.count_removed();
        if let Some(rings) = &mut self.rings {
            rings.measure(&self.groups, &dofs.nodes);
        }
        self.bound_frequency(&dofs.nodes);
    }

    /// How many elements have been deleted.
    pub fn deleted(&self) -> usize {
        self.deleted.0.len()
    }

    /// Boundaries of elements that have been deleted since the loads of the step were told last.
    pub fn newly_deleted(&mut self) -> &[ElementNodes] {
        let told = std::mem::replace(&mut self.deleted.1, self.deleted.0.len());
        &self.deleted.0[told..]
    }

    /// Adds the forces of links between nodes, then decides which nodes have work in this increment.
    pub fn link(&mut self, dofs: &mut Dofs) {
        if let Some(connectors) = &mut self.connectors {
            connectors.add_forces(dofs);
        }
        if let Some(damping) = &mut self.damping {
            damping.add_forces(dofs);
        }
        if let Some(distortion) = &mut self.distortion {
            let alive = |(group, element): (usize, usize)| !self.groups[group].is_deleted(element);
            distortion.resist(dofs, alive, &mut self.limit.0.rate);
        }
        self.awake.update(&self.groups, &dofs.nodes.forces[0]);
    }

    /// Whether the pass behind came to finite forces.
    ///
    /// # Errors
    /// The element to blame.
    pub fn check(&self, nodes: &Nodes) -> Result<(), Collapsed> {
        let (totals, group) = self.limit;
        if totals.rate.is_finite() {
            return Ok(());
        }
        let element = totals.limiting;
        Err(Collapsed { group, element, volume: self.groups[group].volume(element, nodes.as_slice()) })
    }

    /// Sums of corner forces of nodes from `first` on, brought from plane sections to rings under area weighting.
    #[inline(always)]
    pub fn nodal_forces(&self, first: usize, forces: &mut [[f64; 2]]) {
        self.gather.sum(first, &self.corners, forces);
        if let Some(rings) = &self.rings {
            for (force, ring) in forces.iter_mut().zip(&rings.factors[first..]) {
                *force = [ring * force[0], ring * force[1]];
            }
        }
    }

    /// The quadrilateral that is folded most into its hourglass pattern.
    pub fn most_folded(&self, nodes: &Nodes) -> Option<Folded> {
        pattern::strongest(&self.groups, nodes)
    }

    /// What moves in the hourglass pattern now.
    pub fn trembling(&self, nodes: &Nodes) -> Trembling {
        pattern::trembling(&self.groups, nodes)
    }

    /// What brings forces on plane sections to the rings of the nodes under area weighting.
    pub fn ring_factors(&self) -> Option<&[f64]> {
        self.rings.as_ref().map(|rings| &*rings.factors)
    }

    fn blocks_of(&self, group: usize, element: usize) -> Range<usize> {
        let before: usize = self.groups[..group].iter().map(|g| g.force_blocks()).sum();
        let per = self.groups[group].topology().force_blocks();
        let first = before + per * (element / LANES);
        first..first + per
    }

    /// Force of one element on one of its nodes, counted in the order of its topology.
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

    pub fn nodal_force(&self, node: usize) -> [f64; 2] {
        self.gather.one(node, &self.corners)
    }

    /// Whether the few nodes from `first` on ([`super::quiescent::FEW`]) have work.
    #[inline(always)]
    pub fn has_work(&self, first: usize) -> bool {
        self.awake.has_work(first)
    }

    /// Lets an element limit the increment, until elements are updated next.
    pub(super) fn raise_limit(&mut self, group: usize, element: usize, rate: f64) {
        if rate > self.limit.0.rate {
            (self.limit.0.rate, self.limit.0.limiting, self.limit.1) = (rate, element, group);
        }
    }

    /// Group and element that limit the increment.
    pub fn limiting(&self) -> (usize, usize) {
        (self.limit.1, self.limit.0.limiting)
    }

    /// The largest increment that is stable.
    pub fn stable_increment(&self) -> f64 {
        let elements = self.limit.0.rate;
        let linked = self.connectors.as_ref().map_or(elements, |c| c.rate(elements));
        1.0 / self.damping.as_ref().map_or(linked, |d| d.rate(linked))
    }

    /// Bytes of the lists of elements under criteria of erosion.
    pub fn bytes_of_erosion(&self) -> usize {
        self.erosion.as_ref().map_or(0, |e| e.bytes())
    }

    /// Bytes of what mass scaling remembers.
    pub fn bytes_of_masses(&self) -> usize {
        self.masses.as_ref().map_or(0, |m| m.bytes())
    }

    /// Bytes that belong to no single group: corner forces, and the way from corners to nodes.
    pub fn bytes_of_gather(&self) -> usize {
        let deleted = heap_bytes(&self.deleted.0);
        self.corners.bytes() + self.gather.bytes() + self.awake.bytes() + deleted
    }
}

fn add(totals: &Totals, energies: &mut Energies) {
    energies.internal += totals.internal;
    energies.plastic += totals.plastic;
    energies.viscous += totals.viscous;
    energies.artificial += totals.artificial;
}

// Lengths are asked once at the start; what came of them is the groups'. Fields follow from the clock. Corner forces of elements that are
// quiescent are zero, but zeros have signs, which reach the accelerations.
persist_struct!(Elements {
    limit, awake, pending, deleted, frequency_asked, connectors: present, damping: present, distortion: present, erosion: present,
    removed: present, masses: present, frequency: present, rings: present, groups: each, corners
} derived { ids, deformed, averagings, lengths, fields, gather, failure } then Elements::check_deleted);

impl Elements {
    fn check_deleted(&mut self, archive: &mut Archive<'_>) {
        if self.deleted.1 > self.deleted.0.len() {
            archive.refuse(|| "more deleted elements have been told than there are".into());
        }
    }
}
