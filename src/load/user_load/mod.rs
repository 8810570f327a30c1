//! A load given by the user's routine: a pressure on a surface (`PNU` and its kin), a body force (`BRNU`, `BZNU`).
//! Never here: how the routine was made or loaded.

mod surface_map;
mod surface_view;

use std::any::Any;

use super::{
    Account, Dissipation, Forces, GeneralizedForce, Load, LoadOutput, SceneChange, SceneView, Targets, VelocityUse,
};
use crate::kernel::lists::heap_bytes;
use crate::load::fields::FacetFields;
use crate::load::stations::stations;
use crate::load::stiffness::Stiffness;
use crate::mesh::hidden::Hidden;
use crate::mesh::surface::{Face, Surface};
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist};
use crate::state::dofs::Dofs;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::state::nodes::Nodes;
use crate::user::{Locked, MAX_BLOCK};
use surface_map::{Block, SurfaceMap};

/// What is the same for all points of a load.
#[derive(Clone, Debug)]
pub struct Description {
    pub id: EffectId,
    /// Surface or element set, upper case.
    pub name: String,
    /// `jltyp`.
    pub load_type: i32,
    /// Whether the routine is shown normals that point into the body, as solids have it.
    pub inward: bool,
    /// Magnitude and amplitude; the routine applies them.
    pub magnitude: Magnitude,
    /// Whether the routine reads displacements and accelerations.
    pub reads_motion: bool,
}

/// A volume that a body force acts on.
#[derive(Clone, Debug, Default)]
pub struct Volume {
    /// Solids of rigid bodies: body, index of the element in the mesh, centre `[r, z]` and volume.
    pub rigid: Vec<(usize, usize, [f64; 2], f64)>,
    /// Corner nodes of the quadrilaterals that deformable elements consist of.
    pub cells: Vec<[u32; 4]>,
}

/// The load on its points, in blocks as the routine is shown them: those of nodes first, then body after body.
#[derive(Clone, Debug)]
pub struct UserLoad {
    load: Description,
    bodies: Vec<GeneralizedForce>,
    blocks: Vec<Block>,
    /// Blocks of the first ones that act on nodes.
    on_nodes: usize,
    /// Faces that come to lie bare, their middles at the start, and how many faces there were before them.
    hidden: Hidden,
    middles: Vec<[f64; 2]>,
    first_hidden: usize,
}

impl UserLoad {
    /// A pressure on a surface, with the degrees of freedom at the start.
    pub fn on_surface(load: Description, surface: &Surface, dofs: &Dofs) -> Self {
        let (skin, nodes) = (&surface.skin, &dofs.nodes);
        let (first_hidden, most, hidden) = (skin.faces.len(), skin.most(), skin.hidden().cloned().unwrap_or_default());
        let block = |first: usize| Block::of_faces(skin.part(first, MAX_BLOCK), (most - first).min(MAX_BLOCK), nodes);
        let mut blocks: Vec<Block> = (0..most).step_by(MAX_BLOCK).map(block).collect();
        let on_nodes = blocks.len();
        let mut bodies = Vec::new();
        for patch in &surface.patches {
            let slot = bodies.len();
            if let Some(spatial) = &dofs.bodies[patch.body].spatial {
                let all = stations(patch, spatial);
                blocks.extend(all.chunks(MAX_BLOCK).map(|part| Block::of_stations(slot, patch.body, part)));
                bodies.extend(GeneralizedForce::in_space(patch.body, Account::Work));
                continue;
            }
            blocks.extend(patch.facets.chunks(MAX_BLOCK).map(|part| Block::of_facets(&load, slot, patch.body, part)));
            bodies.push(GeneralizedForce::along_z(patch.body, Account::Work));
        }
        let middles = hidden.faces().iter().map(|&f| Face::new(f, nodes).middle()).collect();
        UserLoad { bodies, load, blocks, on_nodes, hidden, middles, first_hidden }
    }

    /// A force a volume.
    pub fn on_volume(load: Description, volume: &Volume, nodes: &Nodes) -> Self {
        let parts = volume.cells.chunks(MAX_BLOCK);
        let mut blocks: Vec<Block> = parts.map(|elements| Block::of_elements(&load, elements, nodes)).collect();
        let on_nodes = blocks.len();
        let mut bodies = Vec::new();
        for of_body in volume.rigid.chunk_by(|a, b| a.0 == b.0) {
            blocks.extend(of_body.chunks(MAX_BLOCK).map(|part| Block::of_solids(&load, bodies.len(), part)));
            bodies.push(GeneralizedForce::along_z(of_body[0].0, Account::Work));
        }
        let (hidden, middles) = (Hidden::default(), Vec::new());
        UserLoad { load, bodies, blocks, on_nodes, hidden, middles, first_hidden: 0 }
    }

    /// Adds a face that has come to lie bare behind those there are.
    fn add_face(&mut self, at: usize) {
        let (i, face, element) = self.hidden.came(at);
        self.blocks[(self.first_hidden + at) / MAX_BLOCK].add_face((face, element), self.middles[i]);
    }

    fn on_nodes(&mut self, scene: &SceneView<'_>, user: &mut Locked<'_>, forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let Some(routine) = user.load.as_deref_mut() else { return Ok(()) };
        for (i, block) in self.blocks[..self.on_nodes].iter_mut().enumerate() {
            block.on_nodes(&self.load, scene, routine, i * MAX_BLOCK, forces)?;
        }
        Ok(())
    }

    #[inline]
    fn on_bodies(&mut self, scene: &SceneView<'_>, user: &mut Locked<'_>, out: &mut [f64]) -> Result<(), Halt> {
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
                    // Frames show the last pressures that all were accepted.
                    self.blocks[self.on_nodes..=i].iter_mut().for_each(Block::swap_pressures);
                    return Err(halt);
                }
            }
        }
        Ok(())
    }
}

impl Load for UserLoad {
    fn effect(&self) -> EffectId {
        self.load.id
    }

    fn targets(&self) -> Targets {
        Targets { bodies: self.bodies.clone(), nodes: self.on_nodes > 0 }
    }

    fn velocity_use(&self) -> VelocityUse {
        VelocityUse::Reads
    }

    #[inline]
    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        user: &mut Locked<'_>,
        forces: &mut Forces<'_>,
    ) -> Result<Dissipation, Halt> {
        match forces {
            Forces::OnNodes(forces) => self.on_nodes(scene, user, forces)?,
            Forces::OnBodies(forces) => self.on_bodies(scene, user, forces)?,
        }
        Ok(Dissipation::default())
    }

    fn max_increment(&self, scene: &SceneView<'_>) -> Limit {
        self.load.magnitude.limit(&scene.clock)
    }

    /// The routine goes on to be shown a face that went; its answer no longer counts. Faces that come follow all others.
    fn scene_changed(&mut self, change: &SceneChange<'_>) {
        let SceneChange::DeletedElements(deleted) = change else { return };
        for block in &mut self.blocks {
            if let SurfaceMap::Faces { skin, .. } = &mut block.map {
                skin.release(deleted);
            }
        }
        self.hidden.release(deleted).for_each(|at| self.add_face(at));
    }
}

impl LoadOutput for UserLoad {
    fn continue_from(&mut self, previous: &dyn Load) {
        let Some(previous) = (previous as &dyn Any).downcast_ref::<UserLoad>() else { return };
        for block in &mut self.blocks[..self.on_nodes] {
            previous.blocks[..previous.on_nodes].iter().for_each(|known| block.continue_from(known));
        }
    }

    fn stiffness(&self) -> Option<&Stiffness> {
        let found = self.blocks[..self.on_nodes].iter().filter_map(Block::stiffness);
        found.reduce(|most, other| if other.squared > most.squared { other } else { most })
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
        arrays[0].1 += self.hidden.bytes() + heap_bytes(&self.middles);
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

impl Persist for UserLoad {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.hidden.persist(archive);
        if archive.reads() && !self.hidden.is_empty() {
            let first = |i: usize| self.first_hidden.saturating_sub(i * MAX_BLOCK).min(MAX_BLOCK);
            self.blocks[..self.on_nodes].iter_mut().enumerate().for_each(|(i, block)| block.cut(first(i)));
            (0..self.hidden.bare()).for_each(|at| self.add_face(at));
        }
        let UserLoad { load: _, bodies: _, blocks, on_nodes: _, hidden: _, middles: _, first_hidden: _ } = self;
        blocks.as_mut_slice().persist(archive);
    }
}
