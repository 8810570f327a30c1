//! Loads computed by a user subroutine: pressures on a surface (`PNU`, `P1NU` to `P4NU`) and body forces (`BRNU`,
//! `BZNU`).

mod surface_map;
mod surface_view;

use std::any::Any;

use super::{
    EnergyAccount, GeneralizedForce, Load, LoadForces, LoadOutput, LoadTargets, SceneChange, SceneView,
    TargetDissipation, VelocityUse,
};
use crate::kernel::lists::{Memory, heap_bytes};
use crate::kernel::shape::distance;
use crate::load::fields::FacetFields;
use crate::load::stations::stations;
use crate::load::stiffness::LoadStiffness;
use crate::mesh::hidden::InteriorFaces;
use crate::mesh::surface::SurfaceGeometry;
use crate::routines::{LockedRoutines, MAX_BLOCK};
use crate::state::EffectId;
use crate::state::archive::{Persist, StateArchive};
use crate::state::dofs::Dofs;
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::Magnitude;
use surface_map::{PointBlock, SurfaceMap};

/// Data that all points of a load share.
#[derive(Clone, Debug)]
pub struct UserLoadData {
    pub id: EffectId,
    /// Name of the surface or element set, upper case.
    pub name: String,
    /// Load type of VDLOAD (`jltyp`).
    pub load_type: i32,
    /// Whether the subroutine gets normals that point into the body, as for solid elements.
    pub inward: bool,
    /// Magnitude and amplitude; the subroutine applies them.
    pub magnitude: Magnitude,
    /// Whether the subroutine reads displacements and accelerations.
    pub reads_motion: bool,
    /// Count of numbers that the load keeps for each point.
    pub memory: usize,
}

/// Solid element of a rigid body.
#[derive(Clone, Copy, Debug)]
pub struct RigidSolid {
    pub body: usize,
    /// Index of the element in the mesh.
    pub element: usize,
    /// Centre `[r, z]`.
    pub centre: [f64; 2],
    pub volume: f64,
}

/// Volume on which a body force acts.
#[derive(Clone, Debug, Default)]
pub struct LoadedVolume {
    pub rigid: Vec<RigidSolid>,
    /// Corner nodes of the quadrilaterals of the deformable elements.
    pub cells: Vec<[u32; 4]>,
}

/// A user load: its points in blocks of one call each. Blocks of nodes come first, then those of one body after the
/// other.
#[derive(Clone, Debug)]
pub struct SubroutineLoad {
    load: UserLoadData,
    bodies: Vec<GeneralizedForce>,
    blocks: Vec<PointBlock>,
    /// Number of blocks that act on nodes.
    on_nodes: usize,
    /// Faces that become exposed when elements are deleted, and the number of faces exposed from the start.
    hidden: InteriorFaces,
    first_hidden: usize,
}

impl SubroutineLoad {
    /// Creates a pressure load on a surface; `dofs` are the initial positions.
    pub fn on_surface(load: UserLoadData, surface: &SurfaceGeometry, dofs: &Dofs) -> Self {
        let skin = &surface.skin;
        let (first_hidden, face_limit, hidden) =
            (skin.faces.len(), skin.max_faces(), skin.hidden().cloned().unwrap_or_default());
        let block =
            |first: usize| PointBlock::of_faces(skin.part(first, MAX_BLOCK), (face_limit - first).min(MAX_BLOCK));
        let mut blocks: Vec<PointBlock> = (0..face_limit).step_by(MAX_BLOCK).map(block).collect();
        let on_nodes = blocks.len();
        let mut bodies = Vec::new();
        for patch in &surface.patches {
            let slot = bodies.len();
            if let Some(spatial) = &dofs.bodies[patch.body].spatial {
                let body_stations = stations(patch, spatial);
                blocks.extend(
                    body_stations.chunks(MAX_BLOCK).map(|part| PointBlock::of_stations(slot, patch.body, part)),
                );
                bodies.extend(GeneralizedForce::in_space(patch.body, EnergyAccount::Work));
                continue;
            }
            blocks.extend(
                patch.facets.chunks(MAX_BLOCK).map(|part| PointBlock::of_facets(&load, slot, patch.body, part)),
            );
            bodies.push(GeneralizedForce::along_z(patch.body, EnergyAccount::Work));
        }
        blocks.iter_mut().for_each(|block| block.reserve_memory(load.memory));
        SubroutineLoad { bodies, load, blocks, on_nodes, hidden, first_hidden }
    }

    /// Creates a body force (force per volume).
    pub fn on_volume(load: UserLoadData, volume: &LoadedVolume) -> Self {
        let parts = volume.cells.chunks(MAX_BLOCK);
        let mut blocks: Vec<PointBlock> = parts.map(|elements| PointBlock::of_elements(&load, elements)).collect();
        let on_nodes = blocks.len();
        let mut bodies = Vec::new();
        for of_body in volume.rigid.chunk_by(|a, b| a.body == b.body) {
            blocks.extend(of_body.chunks(MAX_BLOCK).map(|part| PointBlock::of_solids(&load, bodies.len(), part)));
            bodies.push(GeneralizedForce::along_z(of_body[0].body, EnergyAccount::Work));
        }
        blocks.iter_mut().for_each(|block| block.reserve_memory(load.memory));
        SubroutineLoad { load, bodies, blocks, on_nodes, hidden: InteriorFaces::default(), first_hidden: 0 }
    }

    /// Appends a face that has become exposed.
    fn add_face(&mut self, at: usize) {
        let face = self.hidden.exposed_face(at);
        self.blocks[(self.first_hidden + at) / MAX_BLOCK].add_face((face.nodes, face.element));
    }

    fn on_nodes(
        &mut self,
        scene: &SceneView<'_>,
        user: &mut LockedRoutines,
        forces: &mut [[f64; 2]],
    ) -> Result<(), HaltReason> {
        let Some(routine) = user.load.as_deref_mut() else { return Ok(()) };
        for (i, block) in self.blocks[..self.on_nodes].iter_mut().enumerate() {
            block.on_nodes(&self.load, scene, routine, i * MAX_BLOCK, forces)?;
        }
        Ok(())
    }

    #[inline]
    fn on_bodies(
        &mut self,
        scene: &SceneView<'_>,
        user: &mut LockedRoutines,
        out: &mut [f64],
    ) -> Result<(), HaltReason> {
        out.fill(0.0);
        let Some(routine) = user.load.as_deref_mut() else { return Ok(()) };
        let (mut first, mut body) = (0, usize::MAX);
        for i in self.on_nodes..self.blocks.len() {
            let block = &mut self.blocks[i];
            let slot = block.slot();
            first = if slot == body { first + MAX_BLOCK } else { 0 };
            body = slot;
            let force = match &scene.dofs.bodies[block.body()].spatial {
                None => block.on_body(&self.load, scene, routine, first).map(|force| out[slot] += force),
                Some(body) => block.on_stations(&self.load, scene, routine, (first, body)).map(|wrench| {
                    let components = out[slot..].iter_mut().zip(wrench.components());
                    components.for_each(|(sum, force)| *sum += force);
                }),
            };
            match force {
                Ok(()) => {}
                Err(halt) => {
                    // Frames show the last pressures of an increment in which all blocks were accepted.
                    self.blocks[self.on_nodes..=i].iter_mut().for_each(PointBlock::swap_pressures);
                    return Err(halt);
                }
            }
        }
        Ok(())
    }
}

/// Returns list and position of the point nearest to a place.
fn nearest(lists: &[Vec<[f64; 2]>], place: [f64; 2]) -> Option<[usize; 2]> {
    let all = lists.iter().enumerate().flat_map(|(list, points)| points.iter().enumerate().map(move |p| (list, p)));
    let distances = all.map(|(list, (at, point))| ([list, at], distance(*point, place)));
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
}

impl Load for SubroutineLoad {
    fn effect(&self) -> EffectId {
        self.load.id
    }

    fn targets(&self) -> LoadTargets {
        LoadTargets { bodies: self.bodies.clone(), nodes: self.on_nodes > 0 }
    }

    fn velocity_use(&self) -> VelocityUse {
        VelocityUse::Reads
    }

    /// Increments are not repeated for a load with memory, which counts its calls.
    fn may_begin_suddenly(&self) -> bool {
        !self.bodies.is_empty() && self.load.memory == 0
    }

    #[inline]
    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        user: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason> {
        match forces {
            LoadForces::OnNodes(forces) => self.on_nodes(scene, user, forces)?,
            LoadForces::OnBodies(forces) => self.on_bodies(scene, user, forces)?,
        }
        Ok(TargetDissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> IncrementLimit {
        self.load.magnitude.limit(&scene.clock)
    }

    /// Appends faces exposed by deleted elements. The subroutine is still called for faces of deleted elements, but
    /// their pressures are ignored.
    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        let SceneChange::DeletedElements(deleted) = change else { return };
        for block in &mut self.blocks {
            if let SurfaceMap::Faces { skin, .. } = &mut block.map {
                skin.remove_elements(deleted);
            }
        }
        self.hidden.remove_elements(deleted).for_each(|at| self.add_face(at));
    }
}

impl LoadOutput for SubroutineLoad {
    fn continue_from(&mut self, previous: &dyn Load) {
        let Some(previous) = (previous as &dyn Any).downcast_ref::<SubroutineLoad>() else { return };
        let (of_nodes, of_bodies) = self.blocks.split_at_mut(self.on_nodes);
        for block in of_nodes {
            previous.blocks[..previous.on_nodes].iter().for_each(|known| block.continue_from(known));
        }
        let known_bodies = &previous.blocks[previous.on_nodes..];
        of_bodies.iter_mut().zip(known_bodies).for_each(|(block, known)| block.continue_points(known));
    }

    /// Copies the memory of the points of rigid bodies, and that of the nearest point of the previous mesh.
    fn follow_new_mesh(&mut self, previous: &dyn Load, [dofs, previous_dofs]: [&Dofs; 2]) {
        let Some(previous) = (previous as &dyn Any).downcast_ref::<SubroutineLoad>() else { return };
        if (&self.load.name, self.load.load_type) != (&previous.load.name, previous.load.load_type) {
            return;
        }
        let stiffest = previous.stiffness();
        let (of_nodes, of_bodies) = self.blocks.split_at_mut(self.on_nodes);
        of_nodes.iter_mut().take(1).for_each(|block| block.keep_stiffness(stiffest));
        of_bodies.iter_mut().zip(&previous.blocks[previous.on_nodes..]).for_each(|(own, b)| own.continue_points(b));
        if self.load.memory == 0 {
            return;
        }
        let known_blocks = &previous.blocks[..previous.on_nodes];
        let points_of = |block: &PointBlock| block.middles(&previous_dofs.nodes);
        let known: Vec<Vec<[f64; 2]>> = known_blocks.iter().map(points_of).collect();
        for block in of_nodes {
            for (i, place) in block.middles(&dofs.nodes).into_iter().enumerate() {
                if let Some([b, point]) = nearest(&known, place) {
                    block.continue_point(i, &known_blocks[b], point);
                }
            }
        }
    }

    fn stiffness(&self) -> Option<&LoadStiffness> {
        let stiffnesses = self.blocks[..self.on_nodes].iter().filter_map(PointBlock::stiffness);
        stiffnesses.reduce(|largest, other| if other.squared > largest.squared { other } else { largest })
    }

    fn fields(&self, dofs: &Dofs) -> Option<FacetFields> {
        if self.load.load_type == 1 || self.load.load_type == 2 {
            return None;
        }
        let mut fields = FacetFields::default();
        self.blocks.iter().for_each(|block| block.show_fields(dofs, &mut fields));
        Some(fields)
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let mut arrays = vec![("points", heap_bytes(&self.blocks) + self.load.magnitude.bytes())];
        arrays[0].1 += self.hidden.bytes();
        for block in &self.blocks {
            arrays[0].1 += block.map.bytes();
            for (name, bytes) in block.arrays() {
                match arrays.iter_mut().find(|a| a.0 == name) {
                    Some(array) => array.1 += bytes,
                    None => arrays.push((name, bytes)),
                }
            }
        }
        arrays
    }
}

impl Persist for SubroutineLoad {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        self.hidden.persist(archive);
        if archive.reads() && !self.hidden.is_empty() {
            let first = |i: usize| self.first_hidden.saturating_sub(i * MAX_BLOCK).min(MAX_BLOCK);
            self.blocks[..self.on_nodes].iter_mut().enumerate().for_each(|(i, block)| block.cut(first(i)));
            (0..self.hidden.exposed_count()).for_each(|at| self.add_face(at));
        }
        let SubroutineLoad { load: _, bodies: _, blocks, on_nodes: _, hidden: _, first_hidden: _ } = self;
        blocks.as_mut_slice().persist(archive);
    }
}
