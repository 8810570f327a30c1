//! Elements that conduct heat: capacities, heat rates at their corners, and the rate that limits the time increment.

use crate::kernel::lanes::InlineMap;
use rayon::prelude::*;

use crate::element::elements::Elements;
use crate::kernel::conduction::{conductance, highest_rate};
use crate::kernel::hardening::LinearTable;
use crate::kernel::quad;
use crate::state::nodes::{Node, Nodes};

/// Number of elements above which parallel updates are faster.
const PARALLEL: usize = 2000;
/// Number of elements per task of a thread.
const CHUNK: usize = 256;

/// Conductivity and specific heat of a material.
#[derive(Clone, Debug)]
pub struct ConductionProperties {
    /// Conductivity (heat per time, length and temperature) over temperature.
    pub conductivity: LinearTable,
    /// Specific heat (heat per mass and temperature) over temperature.
    pub capacity: LinearTable,
}

/// Elements of a group, all of which conduct.
#[derive(Clone, Debug)]
pub struct ConductorGroup {
    pub group: usize,
    /// Start and end of the group's range in the list of all conducting elements.
    pub first: usize,
    pub end: usize,
    pub properties: ConductionProperties,
}

/// Returns a property at a temperature; a single row needs no search.
#[inline]
pub(super) fn at(table: &LinearTable, temperature: f64) -> f64 {
    match table.rows.as_slice() {
        [[value, _]] => *value,
        _ => table.value(temperature),
    }
}

/// An element that conducts heat.
#[derive(Clone, Copy, Debug)]
pub struct ConductingElement {
    /// Corner nodes, counter-clockwise; for a triangle the last two are equal.
    pub nodes: [u32; 4],
    /// Corner masses from the density of the material, without mass scaling.
    pub masses: [f64; 4],
}

impl ConductingElement {
    fn corners(&self, nodes: &[Node]) -> [[f64; 2]; 4] {
        self.nodes.inline_map(|n| nodes[n as usize].place())
    }

    pub(super) fn temperatures(&self, nodal: &[f64]) -> [f64; 4] {
        self.nodes.inline_map(|n| nodal[n as usize])
    }

    /// Returns the volume mean of the temperature, weighted with the corner masses, so that uniform heating remains
    /// uniform, also on the axis.
    pub fn mean(&self, nodal: &[f64]) -> f64 {
        let (t, m) = (self.temperatures(nodal), self.masses);
        ((m[0] * t[0] + m[1] * t[1]) + (m[2] * t[2] + m[3] * t[3])) / self.mass()
    }

    /// Returns the mass of the element, the sum over its corners.
    pub fn mass(&self) -> f64 {
        let m = self.masses;
        (m[0] + m[1]) + (m[2] + m[3])
    }

    pub(super) fn volume(&self, nodes: &Nodes) -> f64 {
        quad::volume(self.corners(nodes.as_slice()))
    }

    /// Returns the heat flux at the centre: minus the conductivity times the mean temperature gradient.
    pub(super) fn flux(&self, nodal: &[f64], nodes: &Nodes, properties: &ConductionProperties) -> [f64; 2] {
        let corners = self.corners(nodes.as_slice());
        let (g, t) =
            (quad::gradient(corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1])), self.temperatures(nodal));
        let per = -at(&properties.conductivity, self.mean(nodal)) / g.volume;
        [g.r, g.z].inline_map(|g| per * ((g[0] * t[0] + g[1] * t[1]) + (g[2] * t[2] + g[3] * t[3])))
    }

    /// Returns the heat rates into the corners, and the highest rate of temperature equalization.
    fn conduct(&self, nodal: &[f64], nodes: &[Node], properties: &ConductionProperties) -> ([f64; 4], f64) {
        let t = self.temperatures(nodal);
        let k = conductance(self.corners(nodes), t, |t| at(&properties.conductivity, t));
        let heat =
            [0, 1, 2, 3].inline_map(|i| -((k[i][0] * t[0] + k[i][1] * t[1]) + (k[i][2] * t[2] + k[i][3] * t[3])));
        let capacities = [0, 1, 2, 3].inline_map(|i| self.masses[i] * at(&properties.capacity, t[i]));
        (heat, highest_rate(&k, capacities, self.nodes[2] == self.nodes[3]))
    }
}

/// All conducting elements, with the connectivity from their corners to nodes.
#[derive(Clone, Debug)]
pub struct ConductingElements {
    /// Groups of elements with the same conductivity and heat capacity.
    pub parts: Vec<ConductorGroup>,
    /// Elements, group by group.
    pub list: Vec<ConductingElement>,
    /// Start of the corners of each node in `slots`; entries of `slots` are four times the element plus the corner.
    starts: Vec<u32>,
    slots: Vec<u32>,
}

/// Largest rate of a chunk, and its element.
pub(super) type LargestRate = (f64, usize);

impl ConductingElements {
    pub fn new(parts: Vec<ConductorGroup>, list: Vec<ConductingElement>, nodes: usize) -> Self {
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
        ConductingElements { parts, list, starts, slots }
    }

    /// Returns the number of chunks of [`ConductingElements::conduct`].
    pub(super) fn chunks(&self) -> usize {
        self.list.len().div_ceil(CHUNK)
    }

    /// Returns a conducting element by group and index in the group; `None` if the group does not conduct.
    pub fn find(&self, group: usize, element: usize) -> Option<(&ConductingElement, &ConductorGroup)> {
        let part = self.parts.iter().find(|p| p.group == group)?;
        Some((&self.list[part.first + element], part))
    }

    fn part_of(&self, index: usize) -> &ConductorGroup {
        &self.parts[self.parts.partition_point(|p| p.end <= index)]
    }

    /// Computes the heat rates into all corners; deleted elements do not conduct. Returns the largest rate with its
    /// element.
    pub(super) fn conduct(
        &self,
        nodal: &[f64],
        elements: &Elements,
        nodes: &Nodes,
        corners: &mut [[f64; 4]],
        largest: &mut [LargestRate],
        threads: bool,
    ) -> LargestRate {
        let of_chunk = |(index, (corners, largest)): (usize, (&mut [[f64; 4]], &mut LargestRate))| {
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

    /// Adds corner values to the nodes, in a fixed order.
    pub(super) fn gather(&self, corners: &[[f64; 4]], nodes: &mut [f64]) {
        let corners = corners.as_flattened();
        for (node, ends) in nodes.iter_mut().zip(self.starts.windows(2)) {
            for &slot in &self.slots[ends[0] as usize..ends[1] as usize] {
                *node += corners[slot as usize];
            }
        }
    }

    /// Returns group and element index of a conducting element.
    pub(super) fn place(&self, index: usize) -> (usize, usize) {
        let part = self.part_of(index);
        (part.group, index - part.first)
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.list) + size_of::<u32>() * (self.starts.capacity() + self.slots.capacity())
    }
}
