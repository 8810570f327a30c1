//! What gives heat and takes it: fluxes into nodes, faces and volumes, exchange with a fluid, temperatures that are held.
//! Never here: conduction.

use super::conductors::Conductors;
use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::ElementNodes;
use crate::mesh::surface::{Face, Skin};
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_struct};
use crate::state::dofs::Dofs;
use crate::state::limit::Limit;
use crate::state::magnitude::{Clock, Magnitude};

#[derive(Clone, Debug)]
pub struct Source {
    pub id: EffectId,
    pub kind: Kind,
    /// Heat a time into a node, through an area or into a volume; of a film the temperature of the fluid.
    pub magnitude: Magnitude,
}

/// Where a source acts.
#[derive(Clone, Debug)]
pub enum Kind {
    /// Into each of these nodes (`*CFLUX`).
    Nodes(Vec<usize>),
    /// Through faces (`*DFLUX S`, `*DSFLUX`), positive into the body.
    Faces(Skin),
    /// Into the volumes of these conductors (`*DFLUX BF`).
    Volumes(Vec<usize>),
    /// Through faces, by a film coefficient times the difference from the fluid to the face (`*FILM`, `*SFILM`).
    Film(Skin, Magnitude),
}

/// Shares of the area of a face, a full ring, that go to its two nodes: `int N_I dA`.
fn shares(face: [usize; 2], dofs: &Dofs) -> [f64; 2] {
    let [a, b] = Face::new(face, &dofs.nodes).ends;
    let (dr, dz) = (b[0] - a[0], b[1] - a[1]);
    let third = std::f64::consts::PI / 3.0 * (dr * dr + dz * dz).sqrt();
    [third * (2.0 * a[0] + b[0]), third * (a[0] + 2.0 * b[0])]
}

impl Source {
    /// Adds heat a time to nodes, and to `exchange` what a film takes a temperature; returns the sum of what it gives.
    pub(super) fn give(
        &self,
        (conductors, dofs, nodal): (&Conductors, &Dofs, &[f64]),
        clock: &Clock<'_>,
        power: &mut [f64],
        exchange: &mut [f64],
    ) -> f64 {
        let value = self.magnitude.at(clock);
        let mut sum = 0.0;
        let mut add = |node: usize, heat: f64| {
            power[node] += heat;
            sum += heat;
        };
        match &self.kind {
            Kind::Nodes(nodes) => nodes.iter().for_each(|&n| add(n, value)),
            Kind::Faces(skin) => {
                for face in skin.carrying() {
                    face.into_iter().zip(shares(face, dofs)).for_each(|(n, area)| add(n, area * value));
                }
            }
            Kind::Volumes(list) => {
                for conductor in list.iter().map(|&i| &conductors.list[i]) {
                    let heat = value * conductor.volume(&dofs.nodes) / conductor.mass();
                    conductor.nodes.iter().zip(conductor.masses).for_each(|(&n, m)| add(n as usize, heat * m));
                }
            }
            Kind::Film(skin, coefficient) => {
                let coefficient = coefficient.at(clock);
                for face in skin.carrying() {
                    for (n, area) in face.into_iter().zip(shares(face, dofs)) {
                        add(n, coefficient * area * (value - nodal[n]));
                        exchange[n] += coefficient * area;
                    }
                }
            }
        }
        sum
    }

    /// Whether it is a film, which bounds the increment.
    pub(super) fn exchanges(&self) -> bool {
        matches!(self.kind, Kind::Film(..))
    }

    pub(super) fn limit(&self, clock: &Clock<'_>) -> Limit {
        let limit = self.magnitude.limit(clock);
        if let Kind::Film(_, coefficient) = &self.kind { limit.nearer(coefficient.limit(clock)) } else { limit }
    }

    /// Elements with these boundaries are deleted.
    pub(super) fn release(&mut self, deleted: &[ElementNodes]) {
        if let Kind::Faces(skin) | Kind::Film(skin, _) = &mut self.kind {
            skin.release(deleted);
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.magnitude.bytes()
            + match &self.kind {
                Kind::Nodes(list) | Kind::Volumes(list) => heap_bytes(list),
                Kind::Faces(skin) | Kind::Film(skin, _) => skin.bytes(),
            }
    }
}

/// Temperatures that are held (`*BOUNDARY` on degree of freedom 11).
#[derive(Clone, Debug)]
pub struct Held {
    pub id: EffectId,
    /// The temperature.
    pub magnitude: Magnitude,
    pub nodes: Vec<HeldNode>,
}

/// A node whose temperature is held.
#[derive(Clone, Copy, Debug, Default)]
pub struct HeldNode {
    pub node: usize,
    /// Heat that plastic work made there since the increment began.
    pub(super) made: f64,
    /// Heat a time that holding it took in the increment behind, positive into the body.
    pub(super) reaction: f64,
}

impl HeldNode {
    pub fn new(node: usize) -> Self {
        HeldNode { node, ..HeldNode::default() }
    }
}

impl Persist for Source {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Source { id: _, kind, magnitude: _ } = self;
        if let Kind::Faces(skin) | Kind::Film(skin, _) = kind {
            skin.persist(archive);
        }
    }
}

persist_struct!(Held { nodes: fixed } derived { id, magnitude });

persist_struct!(HeldNode { made, reaction } derived { node });
