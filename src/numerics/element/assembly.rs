//! Corner forces of the elements, and their sums at nodes.

use std::ops::Range;

use super::group::ElementGroup;
use super::rings::RingFactors;
use super::tiles::{TilePass, Tiles};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES};
use crate::kernel::lists::Memory;
use crate::kernel::prefetch::PrefetchChoice;
use crate::mesh::corner_forces::CornerForces;
use crate::mesh::gather::NodalAssembly;
use crate::state::archive::Persist;

/// Number of elements from which prefetching is tried: smaller models fit into second-level caches.
const LARGE: usize = 16_000;
/// Pieces of nodes by which forces are requested before they are summed.
const AHEAD: usize = 2;

/// Corner forces of the elements and their assembly at nodes; with tiles those that are stored, and of shared nodes.
#[derive(Clone, Default, Persist)]
#[persist(present: rings, tiles; derived: gather, prefetch)]
pub struct ForceAssembly {
    /// Factors from plane sections to rings at nodes; `None` without area weighting.
    pub rings: Option<Box<RingFactors>>,
    corners: CornerForces,
    gather: NodalAssembly,
    /// Tiles in which other corner forces are summed; `None` if all are stored.
    tiles: Option<Box<Tiles>>,
    pub(super) prefetch: PrefetchChoice,
}

impl ForceAssembly {
    /// Creates the forces of groups; all are stored.
    pub(super) fn new(groups: &[Box<dyn ElementGroup>], gather: NodalAssembly) -> ForceAssembly {
        let blocks: usize = groups.iter().map(|g| g.force_blocks()).sum();
        let small = groups.iter().map(|g| g.len()).sum::<usize>() < LARGE;
        ForceAssembly {
            prefetch: if small { PrefetchChoice::never() } else { PrefetchChoice::default() },
            // One additional block, which stays zero.
            corners: CornerForces::new(blocks + 1),
            gather,
            ..ForceAssembly::default()
        }
    }

    /// Sums corner forces in tiles, unless too many nodes belong to several tiles. `read` are the elements, as group and
    /// index, whose corner forces are read otherwise; `length` returns the number of tasks of a tile from that of its group.
    pub fn tile_by(
        &mut self,
        groups: &[Box<dyn ElementGroup>],
        read: impl Iterator<Item = (usize, usize)>,
        length: impl Fn(usize) -> usize,
    ) {
        let read = read.flat_map(|(group, element)| self.blocks_of(groups, group, element));
        let groups = groups.iter().map(|group| (group.force_blocks(), group.properties().tiles));
        if let Some((tiles, gather)) = Tiles::new(groups, &self.gather, read, length) {
            self.corners = CornerForces::new(tiles.stored() + 1);
            (self.gather, self.tiles) = (gather, Some(Box::new(tiles)));
        }
    }

    /// Returns the stored blocks of corner forces among a range of all blocks.
    fn stored_among(&self, all: Range<usize>) -> Range<usize> {
        self.tiles.as_ref().map_or(all.clone(), |tiles| tiles.stored_among(&all))
    }

    /// Returns the stored corner forces of a group, which has the range `all` of all blocks, and its tiles.
    pub(super) fn of_group(
        &mut self,
        group: usize,
        all: Range<usize>,
    ) -> (&mut [BlockCornerForces], Option<TilePass<'_>>) {
        let stored = self.stored_among(all);
        (self.corners.slots(stored), self.tiles.as_mut().and_then(|tiles| tiles.pass(group)))
    }

    fn blocks_of(&self, groups: &[Box<dyn ElementGroup>], group: usize, element: usize) -> Range<usize> {
        let preceding: usize = groups[..group].iter().map(|g| g.force_blocks()).sum();
        let per = groups[group].topology().force_blocks();
        let first = preceding + per * (element / LANES);
        self.stored_among(first..first + per)
    }

    /// Sums the corner forces of the nodes from `first` on; with area weighting, scales them from plane sections to
    /// rings.
    #[inline(always)]
    pub fn sum(&self, first: usize, forces: &mut [[f64; 2]]) {
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

    /// Returns the sum of the corner forces of a node, without the factors of area weighting.
    pub fn node_force(&self, node: usize) -> [f64; 2] {
        let gather = (&self.gather, &self.corners);
        self.tiles.as_ref().map_or_else(|| gather.0.node_force(node, gather.1), |tiles| tiles.node_force(node, gather))
    }

    /// Returns the factors from plane sections to rings at the nodes; `None` without area weighting.
    pub fn ring_factors(&self) -> Option<&[f64]> {
        self.rings.as_ref().map(|rings| &*rings.factors)
    }

    /// Returns the force of an element on one of its nodes, counted in the order of its topology.
    pub fn corner_force(
        &self,
        groups: &[Box<dyn ElementGroup>],
        (group, element): (usize, usize),
        corner: usize,
    ) -> [f64; 2] {
        let block = self.blocks_of(groups, group, element).start + corner / 4;
        let force = self.corners.of(block, element % LANES, corner % 4);
        let Some(rings) = &self.rings else { return force };
        let node = groups[group].nodes(element)[corner] as usize;
        force.inline_map(|f| rings.factors[node] * f)
    }

    /// Sets the forces of an element to zero.
    pub(super) fn clear(&mut self, groups: &[Box<dyn ElementGroup>], group: usize, element: usize) {
        self.blocks_of(groups, group, element).for_each(|block| self.corners.clear(block, element % LANES));
    }

    /// Returns the bytes of corner forces, and of the connectivity from corners to nodes.
    pub(super) fn bytes(&self) -> usize {
        self.corners.bytes() + self.gather.bytes() + self.tiles.as_ref().map_or(0, |tiles| tiles.bytes())
    }
}
