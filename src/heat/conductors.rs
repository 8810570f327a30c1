//! Elements that conduct: their capacities, the heat that flows between their corners, and the rate that bounds the increment.
//! Never here: temperatures of nodes over time, sources.

use crate::kernel::lanes::InlineMap;
use rayon::prelude::*;

use crate::element::elements::Elements;
use crate::kernel::conduction::{conductance, highest_rate};
use crate::kernel::hardening::Table;
use crate::kernel::quad;
use crate::state::nodes::{Node, Nodes};

/// Elements from which on it pays to wake other threads every increment.
const PARALLEL: usize = 2000;
/// Elements that a thread takes at once.
const CHUNK: usize = 256;

/// How a material takes heat up and passes it on.
#[derive(Clone, Debug)]
pub struct Properties {
    /// Heat a time, length and temperature, over temperature.
    pub conductivity: Table,
    /// Heat a mass and temperature, over temperature.
    pub capacity: Table,
}

/// The elements of a group, which all conduct.
#[derive(Clone, Debug)]
pub struct Part {
    pub group: usize,
    /// Its first element among all that conduct, and one behind its last.
    pub first: usize,
    pub end: usize,
    pub properties: Properties,
}

/// A property at a temperature; one row needs no search.
#[inline]
pub(super) fn at(table: &Table, temperature: f64) -> f64 {
    match table.rows.as_slice() {
        [[value, _]] => *value,
        _ => table.value(temperature),
    }
}

/// One element.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    /// Nodes at its corners, counter-clockwise; of a triangle the last two are the same.
    pub nodes: [u32; 4],
    /// Masses of the corners by the density of the material, which mass scaling leaves alone.
    pub masses: [f64; 4],
}

impl Conductor {
    fn corners(&self, nodes: &[Node]) -> [[f64; 2]; 4] {
        self.nodes.inline_map(|n| nodes[n as usize].place())
    }

    pub(super) fn temperatures(&self, nodal: &[f64]) -> [f64; 4] {
        self.nodes.inline_map(|n| nodal[n as usize])
    }

    /// Mean over the volume: with the shares of the corners in it, so that what heats evenly stays even, also on the axis.
    pub fn mean(&self, nodal: &[f64]) -> f64 {
        let (t, m) = (self.temperatures(nodal), self.masses);
        ((m[0] * t[0] + m[1] * t[1]) + (m[2] * t[2] + m[3] * t[3])) / self.mass()
    }

    pub fn mass(&self) -> f64 {
        let m = self.masses;
        (m[0] + m[1]) + (m[2] + m[3])
    }

    pub(super) fn volume(&self, nodes: &Nodes) -> f64 {
        quad::volume(self.corners(nodes.as_slice()))
    }

    /// Heat flux in the middle: the conductivity times the mean slope of the temperature, downwards.
    pub(super) fn flux(&self, nodal: &[f64], nodes: &Nodes, properties: &Properties) -> [f64; 2] {
        let corners = self.corners(nodes.as_slice());
        let (g, t) =
            (quad::gradient(corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1])), self.temperatures(nodal));
        let per = -at(&properties.conductivity, self.mean(nodal)) / g.volume;
        [g.r, g.z].inline_map(|g| per * ((g[0] * t[0] + g[1] * t[1]) + (g[2] * t[2] + g[3] * t[3])))
    }

    /// Heat a time into the corners, and the highest rate.
    fn conduct(&self, nodal: &[f64], nodes: &[Node], properties: &Properties) -> ([f64; 4], f64) {
        let t = self.temperatures(nodal);
        let k = conductance(self.corners(nodes), t, |t| at(&properties.conductivity, t));
        let heat =
            [0, 1, 2, 3].inline_map(|i| -((k[i][0] * t[0] + k[i][1] * t[1]) + (k[i][2] * t[2] + k[i][3] * t[3])));
        let capacities = [0, 1, 2, 3].inline_map(|i| self.masses[i] * at(&properties.capacity, t[i]));
        (heat, highest_rate(&k, capacities, self.nodes[2] == self.nodes[3]))
    }
}

/// All of them, with the way from their corners to nodes.
#[derive(Clone, Debug)]
pub struct Conductors {
    /// Groups.
    pub parts: Vec<Part>,
    /// Elements, part by part.
    pub list: Vec<Conductor>,
    /// Where the corners of each node begin in `slots`, and these: four times the element, plus the corner.
    starts: Vec<u32>,
    slots: Vec<u32>,
}

/// The largest rate of a chunk, and its element.
pub(super) type Largest = (f64, usize);

impl Conductors {
    pub fn new(parts: Vec<Part>, list: Vec<Conductor>, nodes: usize) -> Self {
        let mut starts = vec![0_u32; nodes + 1];
        let corners = || list.iter().flat_map(|c| c.nodes).enumerate();
        corners().for_each(|(_, n)| starts[n as usize + 1] += 1);
        (0..nodes).for_each(|n| starts[n + 1] += starts[n]);
        let mut next = starts.clone();
        let mut slots = vec![0_u32; 4 * list.len()];
        for (slot, n) in corners() {
            slots[next[n as usize] as usize] = slot as u32;
            next[n as usize] += 1;
        }
        Conductors { parts, list, starts, slots }
    }

    /// Chunks for which [`Conductors::conduct`] needs room.
    pub(super) fn chunks(&self) -> usize {
        self.list.len().div_ceil(CHUNK)
    }

    pub fn find(&self, group: usize, element: usize) -> Option<(&Conductor, &Part)> {
        let part = self.parts.iter().find(|p| p.group == group)?;
        Some((&self.list[part.first + element], part))
    }

    fn part_of(&self, index: usize) -> &Part {
        &self.parts[self.parts.partition_point(|p| p.end <= index)]
    }

    /// Heat a time into all corners; the largest rate with its element. Nothing flows through elements that are deleted.
    pub(super) fn conduct(
        &self,
        nodal: &[f64],
        elements: &Elements,
        nodes: &Nodes,
        corners: &mut [[f64; 4]],
        largest: &mut [Largest],
        threads: bool,
    ) -> Largest {
        let of_chunk = |(index, (corners, largest)): (usize, (&mut [[f64; 4]], &mut Largest))| {
            *largest = (0.0, 0);
            for (i, corner) in corners.iter_mut().enumerate() {
                let e = index * CHUNK + i;
                let part = self.part_of(e);
                let group = &elements.groups[part.group];
                if group.properties().deletable && group.is_deleted(e - part.first) {
                    *corner = [0.0; 4];
                    continue;
                }
                let (heat, rate) = self.list[e].conduct(nodal, nodes.as_slice(), &part.properties);
                *corner = heat;
                if rate > largest.0 || rate.is_nan() {
                    *largest = (rate, e);
                }
            }
        };
        if threads && self.list.len() >= PARALLEL {
            corners.par_chunks_mut(CHUNK).zip(&mut *largest).enumerate().for_each(of_chunk);
        } else {
            corners.chunks_mut(CHUNK).zip(&mut *largest).enumerate().for_each(of_chunk);
        }
        largest.iter().fold((0.0, 0), |best, l| if l.0 > best.0 || l.0.is_nan() { *l } else { best })
    }

    /// Adds what corners have to their nodes, in a fixed order.
    pub(super) fn gather(&self, corners: &[[f64; 4]], nodes: &mut [f64]) {
        let corners = corners.as_flattened();
        for (node, ends) in nodes.iter_mut().zip(self.starts.windows(2)) {
            for &slot in &self.slots[ends[0] as usize..ends[1] as usize] {
                *node += corners[slot as usize];
            }
        }
    }

    /// Group and element of one that conducts.
    pub(super) fn place(&self, index: usize) -> (usize, usize) {
        let part = self.part_of(index);
        (part.group, index - part.first)
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.list) + size_of::<u32>() * (self.starts.capacity() + self.slots.capacity())
    }
}
