//! Pressure of a blast wave in air on a surface (`*INCIDENT WAVE INTERACTION, CONWEP`).

use super::TargetDissipation;
use super::fields::FacetFields;
use super::pressure::add_pressure;
use super::{Load, LoadForces, LoadOutput, LoadTargets, SceneChange, SceneView};
use crate::kernel::blast_wave::{BlastWave, BurstShape, has_arrived};
use crate::kernel::facet::Facet;
use crate::kernel::lists::{Memory, heap_bytes};
use crate::mesh::surface::{CurrentFace, SurfaceGeometry};
use crate::platform::PortableMath as _;
use crate::routines::LockedRoutines;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::nodes::Nodes;

/// Fraction of the shortest positive phase that an increment may have while the blast acts, for decay coefficients up to
/// [`SLOW_DECAY`]. It is smaller for faster decay, so that the pressure falls by at most a tenth in an increment.
const SHARE_OF_PHASE: f64 = 0.01;
const SLOW_DECAY: f64 = 10.0;

/// A charge of TNT on the axis, and the units of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlastSource {
    pub shape: BurstShape,
    /// Mass of TNT, kg.
    pub mass: f64,
    /// Coordinate z of the charge.
    pub height: f64,
    /// Total time of the detonation.
    pub detonation: f64,
    /// Factors from the units of the model to metres, seconds and pascals.
    pub units: [f64; 3],
    /// Factor on the pressures.
    pub scale: f64,
}

impl BlastSource {
    /// Returns the scaled distance of a point, m/kg^(1/3).
    pub fn scaled_distance(&self, place: [f64; 2]) -> f64 {
        self.distance(place) / libm::cbrt(self.mass)
    }

    fn distance(&self, [r, z]: [f64; 2]) -> f64 {
        self.units[0] * r.portable_hypot(z - self.height)
    }

    fn wave(&self, place: [f64; 2]) -> Option<BlastWave> {
        BlastWave::at(self.shape, self.mass, self.distance(place))
    }

    /// Returns the pressure of a wave at a place with this normal.
    fn pressure(&self, wave: Option<BlastWave>, place: [f64; 2], normal: [f64; 2], total_time: f64) -> f64 {
        let Some(wave) = wave else { return 0.0 };
        let (dr, dz) = (-place[0], self.height - place[1]);
        let cosine = (dr * normal[0] + dz * normal[1]) / dr.portable_hypot(dz);
        let time = self.units[1] * (total_time - self.detonation);
        self.scale * wave.pressure(time, cosine) / self.units[2]
    }
}

/// Blast on a surface of rigid bodies that move along z and of deformable bodies. Distances are those at the start of
/// the analysis; angles are current.
#[derive(Clone, Debug, Persist)]
#[persist(derived: id, source, waves, of_bodies, arrivals)]
pub struct BlastLoad {
    id: EffectId,
    surface: SurfaceGeometry,
    source: BlastSource,
    /// Waves at the faces of deformable bodies; faces that become exposed follow.
    waves: Vec<Option<BlastWave>>,
    /// Waves at the facets of rigid bodies.
    of_bodies: Vec<Option<BlastWave>>,
    /// Times of arrival at the facets of rigid bodies, ascending, in seconds from the detonation.
    arrivals: Vec<f64>,
    /// First arrival, last end of a positive phase, and shortest phase, in seconds from the detonation.
    times: [f64; 3],
    /// Total time of the last evaluation.
    time: f64,
}

impl BlastLoad {
    pub fn new(id: EffectId, surface: SurfaceGeometry, source: BlastSource, nodes: &Nodes) -> Self {
        let mut waves = Vec::with_capacity(surface.skin.max_faces());
        waves.extend(surface.skin.faces.iter().map(|&face| source.wave(initial_middle(face, nodes))));
        let facets = surface.patches.iter().flat_map(|patch| &patch.facets);
        let of_bodies: Vec<Option<BlastWave>> = facets.map(|(_, facet)| source.wave(facet.middle())).collect();
        let times = [f64::INFINITY, 0.0, f64::INFINITY];
        let times = waves.iter().chain(&of_bodies).flatten().fold(times, with_wave);
        let mut arrivals: Vec<f64> = of_bodies.iter().flatten().map(|wave| wave.arrival).collect();
        arrivals.sort_by(f64::total_cmp);
        arrivals.dedup();
        BlastLoad { id, surface, source, waves, of_bodies, arrivals, times, time: f64::NEG_INFINITY }
    }

    /// Adds the waves at faces that have become exposed.
    fn add_waves(&mut self, nodes: &Nodes) {
        for &face in &self.surface.skin.faces[self.waves.len()..] {
            let wave = self.source.wave(initial_middle(face, nodes));
            self.times = wave.iter().fold(self.times, with_wave);
            self.waves.push(wave);
        }
    }

    fn of_face(&self, index: usize, face: &CurrentFace) -> f64 {
        let wave = self.waves.get(index).copied().flatten();
        self.source.pressure(wave, face.middle(), face.normal, self.time)
    }

    fn of_facet(&self, index: usize, facet: &Facet) -> f64 {
        self.source.pressure(self.of_bodies[index], facet.middle(), facet.normal, self.time)
    }

    fn on_nodes(&mut self, scene: &SceneView<'_>, forces: &mut [[f64; 2]]) {
        self.add_waves(&scene.dofs.nodes);
        let skin = &self.surface.skin;
        for (i, &nodes) in skin.faces.iter().enumerate().filter(|(i, _)| skin.is_active[*i]) {
            let face = CurrentFace::new(nodes, &scene.dofs.nodes);
            let shell = skin.shells.get(i).copied().unwrap_or(false);
            add_pressure(&face, shell, self.of_face(i, &face), scene.rings, forces);
        }
    }

    fn on_bodies(&self, forces: &mut [f64]) {
        let mut index = 0;
        for (force, patch) in forces.iter_mut().zip(&self.surface.patches) {
            *force = 0.0;
            for (_, facet) in &patch.facets {
                *force -= self.of_facet(index, facet) * facet.area * facet.normal[1];
                index += 1;
            }
        }
    }
}

fn with_wave([first, last, shortest]: [f64; 3], wave: &BlastWave) -> [f64; 3] {
    let decay = wave.decay[0].max(wave.decay[1]).max(SLOW_DECAY);
    let resolved = wave.duration * (SLOW_DECAY / decay);
    [first.min(wave.arrival), last.max(wave.arrival + wave.duration), shortest.min(resolved)]
}

fn initial_middle([a, b]: [usize; 2], nodes: &Nodes) -> [f64; 2] {
    let [from, to] = [nodes.start[a], nodes.start[b]];
    [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])]
}

impl Load for BlastLoad {
    fn effect(&self) -> EffectId {
        self.id
    }

    fn targets(&self) -> LoadTargets {
        LoadTargets::along_z(&self.surface)
    }

    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        _: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason> {
        self.time = scene.clock.now.total_time;
        match forces {
            LoadForces::OnNodes(forces) => self.on_nodes(scene, forces),
            LoadForces::OnBodies(forces) => self.on_bodies(forces),
        }
        Ok(TargetDissipation::default())
    }

    /// Ends increments at each arrival at a rigid facet, and resolves the positive phases, which may be shorter than an
    /// increment. At the faces of deformable bodies, increments are shorter than the waves take to pass an element.
    fn max_increment(&self, scene: &SceneView<'_>) -> IncrementLimit {
        let [first, last, shortest] = self.times;
        let now = self.source.units[1] * (scene.clock.now.total_time - self.source.detonation);
        let limit = if !has_arrived(now, first) {
            IncrementLimit { time: first - now, jump: true }
        } else if now < last {
            IncrementLimit { time: SHARE_OF_PHASE * shortest, jump: false }
        } else {
            return IncrementLimit::NONE;
        };
        let next = self.arrivals.partition_point(|&arrival| has_arrived(now, arrival));
        let arrival = self.arrivals.get(next).map_or(f64::INFINITY, |arrival| arrival - now);
        let limit = limit.earlier(IncrementLimit { time: arrival, jump: true });
        IncrementLimit { time: limit.time / self.source.units[1], ..limit }
    }

    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        change.remove_faces(&mut self.surface);
    }
}

impl LoadOutput for BlastLoad {
    fn fields(&self, dofs: &Dofs) -> Option<FacetFields> {
        let mut fields = FacetFields::default();
        let mut index = 0;
        for patch in &self.surface.patches {
            let velocity = dofs.bodies[patch.body].velocity;
            for (element, facet) in &patch.facets {
                fields.push(*element, self.of_facet(index, facet), velocity * facet.normal[1]);
                index += 1;
            }
        }
        let skin = &self.surface.skin;
        for (i, (&nodes, &element)) in skin.faces.iter().zip(&skin.elements).enumerate() {
            let face = CurrentFace::new(nodes, &dofs.nodes);
            let pressure = if skin.is_active[i] { self.of_face(i, &face) } else { 0.0 };
            fields.push(element, pressure, face.normal_velocity(&dofs.nodes));
        }
        Some(fields)
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let waves = heap_bytes(&self.waves) + heap_bytes(&self.of_bodies) + heap_bytes(&self.arrivals);
        vec![("surface", self.surface.bytes()), ("waves", waves)]
    }
}
