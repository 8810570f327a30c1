//! Heat sources: fluxes into nodes, faces and volumes, films, and prescribed temperatures.

use super::conductors::ConductingElements;
use crate::kernel::lists::{Memory, heap_bytes};
use crate::kernel::topology::ElementNodes;
use crate::mesh::surface::{CurrentFace, DeformableFaces};
use crate::state::EffectId;
use crate::state::archive::{Persist, StateArchive};
use crate::state::dofs::Dofs;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::{AmplitudeClock, Magnitude};

/// A heat source of a step, with its ledger row.
#[derive(Clone, Debug)]
pub struct HeatSource {
    pub id: EffectId,
    pub kind: HeatSourceKind,
    /// Heat per time into a node, through an area or into a volume; for a film, the temperature of the fluid.
    pub magnitude: Magnitude,
}

/// Region and type of a heat source.
#[derive(Clone, Debug)]
pub enum HeatSourceKind {
    /// Concentrated flux into each listed node (`*CFLUX`).
    Nodes(Vec<usize>),
    /// Through faces (`*DFLUX S`, `*DSFLUX`), positive into the body.
    Faces(DeformableFaces),
    /// Body flux into the volumes of the listed elements (`*DFLUX BF`).
    Volumes(Vec<usize>),
    /// Through faces: film coefficient times the temperature difference from the face to the fluid (`*FILM`, `*SFILM`).
    Film(DeformableFaces, Magnitude),
}

/// Returns the areas of a face, a full ring, that belong to its two nodes: `int N_I dA`.
fn shares(face: [usize; 2], dofs: &Dofs) -> [f64; 2] {
    let [a, b] = CurrentFace::new(face, &dofs.nodes).ends;
    let (dr, dz) = (b[0] - a[0], b[1] - a[1]);
    let third = std::f64::consts::PI / 3.0 * (dr * dr + dz * dz).sqrt();
    [third * (2.0 * a[0] + b[0]), third * (a[0] + 2.0 * b[0])]
}

impl HeatSource {
    /// Adds the heat rates of the source to the nodes, and the conductance of a film to `exchange`. Returns the total
    /// heat rate.
    pub(super) fn add_heat(
        &self,
        (conductors, dofs): (&ConductingElements, &Dofs),
        nodal: &[f64],
        clock: &AmplitudeClock<'_>,
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
            HeatSourceKind::Nodes(nodes) => nodes.iter().for_each(|&n| add(n, value)),
            HeatSourceKind::Faces(skin) => {
                for face in skin.active_faces() {
                    face.into_iter().zip(shares(face, dofs)).for_each(|(n, area)| add(n, area * value));
                }
            }
            HeatSourceKind::Volumes(list) => {
                for conductor in list.iter().map(|&i| &conductors.list[i]) {
                    let heat = value * conductor.volume(&dofs.nodes) / conductor.mass();
                    conductor.nodes.iter().zip(conductor.masses).for_each(|(&n, m)| add(n as usize, heat * m));
                }
            }
            HeatSourceKind::Film(skin, coefficient) => {
                let coefficient = coefficient.at(clock);
                for face in skin.active_faces() {
                    for (n, area) in face.into_iter().zip(shares(face, dofs)) {
                        add(n, coefficient * area * (value - nodal[n]));
                        exchange[n] += coefficient * area;
                    }
                }
            }
        }
        sum
    }

    /// Returns whether it is a film, which limits the time increment.
    pub(super) fn is_film(&self) -> bool {
        matches!(self.kind, HeatSourceKind::Film(..))
    }

    pub(super) fn limit(&self, clock: &AmplitudeClock<'_>) -> IncrementLimit {
        let limit = self.magnitude.limit(clock);
        if let HeatSourceKind::Film(_, coefficient) = &self.kind {
            limit.earlier(coefficient.limit(clock))
        } else {
            limit
        }
    }

    /// Removes the faces of deleted elements, given by their boundaries.
    pub(super) fn release(&mut self, deleted: &[ElementNodes]) {
        if let HeatSourceKind::Faces(skin) | HeatSourceKind::Film(skin, _) = &mut self.kind {
            skin.remove_elements(deleted);
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.magnitude.bytes()
            + match &self.kind {
                HeatSourceKind::Nodes(list) | HeatSourceKind::Volumes(list) => heap_bytes(list),
                HeatSourceKind::Faces(skin) | HeatSourceKind::Film(skin, _) => skin.bytes(),
            }
    }
}

/// Prescribed temperatures (`*BOUNDARY` on degree of freedom 11).
#[derive(Clone, Debug, Persist)]
#[persist(fixed: nodes; derived: id, magnitude)]
pub struct PrescribedTemperature {
    pub id: EffectId,
    /// Temperature over time.
    pub magnitude: Magnitude,
    pub nodes: Vec<TemperatureNode>,
}

/// A node with prescribed temperature.
#[derive(Clone, Copy, Debug, Default, Persist)]
#[persist(derived: node)]
pub struct TemperatureNode {
    pub node: usize,
    /// Heat by plastic work at the node since the start of the increment.
    pub(super) made: f64,
    /// Reaction heat rate in the previous increment, positive into the body.
    pub(super) reaction: f64,
}

impl TemperatureNode {
    pub fn new(node: usize) -> Self {
        TemperatureNode { node, ..TemperatureNode::default() }
    }
}

impl Persist for HeatSource {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let HeatSource { id: _, kind, magnitude: _ } = self;
        if let HeatSourceKind::Faces(skin) | HeatSourceKind::Film(skin, _) = kind {
            skin.persist(archive);
        }
    }
}
