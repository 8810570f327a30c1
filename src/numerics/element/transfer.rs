//! Variables of elements that move through a mesh that does not follow the material: read from all elements of an
//! adaptive mesh domain, and written back after the transport.

use super::block::ElementBlock;
use super::group::{ArrivedElements, ElementTransfer};
use super::lane_sums::TASK;
use super::quad::QuadGroup;
use super::solid::lanes_of;
use crate::kernel::lanes::{InlineMap, LANES, Lanes, PACK, Pack, column};
use crate::material::Material;
use crate::material::carried::{ArrivedElement, CarriedState};

/// Whether a variable is a value per mass, or a sum over the element.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Extent {
    PerMass,
    Total,
}

impl<M: Material> QuadGroup<M> {
    /// Passes all carried variables of a block to `visit`.
    fn carry(&mut self, block: usize, visit: &mut dyn FnMut(&mut Lanes, Extent)) {
        let ElementBlock { nodes: _, stress, mass: _, inverse_mass: _, state } = &mut self.blocks[block];
        let each = &mut |list: &mut Lanes| visit(list, Extent::PerMass);
        stress.carry(each);
        state.carry(each);
        let (task, index) = (&mut self.tasks[block / TASK].task, block % TASK);
        if let Some(controls) = task.controls.get_mut(index) {
            controls.carry(each);
        }
        if let Some(enhanced) = task.enhanced.get_mut(index) {
            enhanced.carry(each);
        }
        if let Some(record) = task.records.get_mut(index) {
            let (values, energies) = record.carried();
            values.into_iter().for_each(|list| visit(list, Extent::PerMass));
            energies.iter_mut().for_each(|list| visit(list, Extent::Total));
        }
    }
}

/// Calls `each` with every block of selected elements, and the range of elements in this block.
fn by_block(elements: &[u32], selected: &[bool], mut each: impl FnMut(usize, std::ops::Range<usize>)) {
    let mut first = 0;
    for part in elements.chunk_by(|a, b| *a as usize / LANES == *b as usize / LANES) {
        let range = first..first + part.len();
        if selected[range.clone()].contains(&true) {
            each(part[0] as usize / LANES, range);
        }
        first += part.len();
    }
}

impl<M: Material> ElementTransfer for QuadGroup<M> {
    fn variables(&mut self) -> usize {
        let mut count = 0;
        self.carry(0, &mut |_, _| count += 1);
        count
    }

    fn prepare(&mut self) {
        self.blocks.iter_mut().for_each(|block| self.material.prepare_transport(&mut block.state));
    }

    fn read(&mut self, (elements, selected): (&[u32], &[bool]), packs: &mut [Vec<Pack>]) {
        by_block(elements, selected, |block, range| {
            let (mass, mut variable) = (self.blocks[block].mass, 0);
            self.carry(block, &mut |list, extent| {
                let (pack, slot) = (&mut packs[variable / PACK][range.clone()], variable % PACK);
                for (values, element) in pack.iter_mut().zip(&elements[range.clone()]) {
                    let lane = *element as usize % LANES;
                    let per = if extent == Extent::Total { 1.0 / mass[lane] } else { 1.0 };
                    values.0[slot] = per * list[lane];
                }
                variable += 1;
            });
        });
    }

    fn write(&mut self, (elements, selected): (&[u32], &[bool]), packs: &[Vec<Pack>], arrived: ArrivedElements<'_>) {
        let count = self.count;
        by_block(elements, selected, |block, range| {
            self.wake(block / TASK);
            for i in range.clone().filter(|i| selected[*i]) {
                let masses = arrived.masses[i];
                lanes_of(elements[i] as usize, count)
                    .for_each(|lane| self.blocks[block].set_corner_masses(lane, masses));
            }
            let (mass, mut variable) = (self.blocks[block].mass, 0);
            self.carry(block, &mut |list, extent| {
                let (pack, slot) = (&packs[variable / PACK], variable % PACK);
                for i in range.clone().filter(|i| selected[*i]) {
                    let lanes = lanes_of(elements[i] as usize, count);
                    let factor = if extent == Extent::Total { mass[lanes.start] } else { 1.0 };
                    list[lanes].fill(factor * pack[i].0[slot]);
                }
                variable += 1;
            });
            let ElementBlock { stress, state, .. } = &mut self.blocks[block];
            for i in range.filter(|i| selected[*i]) {
                let lanes = lanes_of(elements[i] as usize, count);
                let corners = arrived.corners[i].inline_map(|n| arrived.places[n as usize]);
                let (mass, stress) = (mass[lanes.start], column(stress, lanes.start));
                let element = ArrivedElement { corners, mass, stress };
                lanes.for_each(|lane| self.material.arrive(state, lane, &element));
            }
        });
    }

    fn visit_elements(&mut self, elements: &[u32], visit: &mut dyn FnMut(&mut f64)) {
        for &element in elements {
            let (block, lanes) = (element as usize / LANES, lanes_of(element as usize, self.count));
            let mut visit_lanes = |list: &mut Lanes| {
                let lanes = &mut list[lanes.clone()];
                visit(&mut lanes[0]);
                let value = lanes[0];
                lanes.fill(value);
            };
            self.wake(block / TASK);
            self.carry(block, &mut |list, _| visit_lanes(list));
            let ElementBlock { nodes: _, stress: _, mass, inverse_mass, state: _ } = &mut self.blocks[block];
            visit_lanes(mass);
            inverse_mass.iter_mut().for_each(&mut visit_lanes);
        }
    }

    fn volume_ratio(&self, element: u32) -> Option<f64> {
        let (block, lane) = (element as usize / LANES, element as usize % LANES);
        self.material.volume_ratio(&self.blocks[block].state, lane)
    }
}
