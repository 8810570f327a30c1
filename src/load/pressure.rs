//! A prescribed pressure on a surface (`P`).
//! Never here: pressures that depend on motion.

use super::{Account, Load, Slot, View};
use crate::kernel::facet::{ring_pressure, section_pressure, shell_pressure};
use crate::kernel::topology::ElementNodes;
use crate::load::fields::FacetFields;
use crate::mesh::surface::{Face, Surface};
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::dofs::Dofs;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::user::Locked;

/// A pressure; positive pushes against the outward normal. On a body that only shifts along z the facets enter by the sum of
/// their axial areas alone.
#[derive(Clone, Debug)]
pub struct Pressure {
    id: EffectId,
    surface: Surface,
    /// Of each patch, the sum of area times n_z.
    axial_areas: Vec<f64>,
    magnitude: Magnitude,
    /// Pressure at the last evaluation, for frames.
    current: f64,
}

impl Pressure {
    /// A pressure on a surface.
    pub fn new(id: EffectId, surface: Surface, magnitude: Magnitude) -> Self {
        let axial =
            |facets: &[(usize, crate::kernel::facet::Facet)]| facets.iter().map(|(_, f)| f.area * f.normal[1]).sum();
        let axial_areas = surface.patches.iter().map(|p| axial(&p.facets)).collect();
        Pressure { id, surface, axial_areas, magnitude, current: 0.0 }
    }
}

impl Load for Pressure {
    fn id(&self) -> EffectId {
        self.id
    }

    fn slots(&self) -> Vec<Slot> {
        self.surface.patches.iter().map(|p| Slot { body: p.body, account: Account::Work }).collect()
    }

    fn acts_on_nodes(&self) -> bool {
        self.surface.skin.most() > 0
    }

    fn on_nodes(&mut self, view: &View<'_>, _: &mut Locked<'_>, forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        self.current = self.magnitude.at(&view.clock);
        for (face, shell) in self.surface.skin.carrying_shells() {
            push(&Face::new(face, &view.dofs.nodes), shell, self.current, view.rings, forces);
        }
        Ok(())
    }

    fn on_bodies(&mut self, view: &View<'_>, _: &mut Locked<'_>, out: &mut [f64]) -> Result<(), Halt> {
        self.current = self.magnitude.at(&view.clock);
        for (force, area) in out.iter_mut().zip(&self.axial_areas) {
            *force = -self.current * area;
        }
        Ok(())
    }

    fn limit(&self, view: &View<'_>) -> Limit {
        self.magnitude.limit(&view.clock)
    }

    fn release(&mut self, deleted: &[ElementNodes]) {
        self.surface.skin.release(deleted);
    }

    fn fields(&self, dofs: &Dofs) -> Option<FacetFields> {
        Some(FacetFields::uniform(&self.surface, self.current, dofs))
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        vec![("surface", self.surface.bytes()), ("amplitude", self.magnitude.bytes())]
    }

    fn copy(&self) -> Box<dyn Load> {
        Box::new(self.clone())
    }
}

/// Adds a pressure on a face of a solid or of a shell.
#[inline]
pub(super) fn push(face: &Face, shell: bool, pressure: f64, rings: Option<&[f64]>, forces: &mut [[f64; 2]]) {
    for (node, force) in face.nodes.into_iter().zip(on_ends(face, shell, pressure, rings)) {
        forces[node] = [forces[node][0] + force[0], forces[node][1] + force[1]];
    }
}

/// Forces of a pressure on the nodes of a face of a solid or of a shell.
#[inline]
pub(super) fn on_ends(face: &Face, shell: bool, pressure: f64, rings: Option<&[f64]>) -> [[f64; 2]; 2] {
    if shell { shell_pressure(face.ends, pressure) } else { on_solid(face, pressure, rings) }
}

/// Forces of a pressure on the nodes of a face of a solid. Of one weighted by area, `rings` brings what acts on the plane
/// section to the rings of its nodes.
#[inline]
pub(super) fn on_solid(face: &Face, pressure: f64, rings: Option<&[f64]>) -> [[f64; 2]; 2] {
    let Some(rings) = rings else { return ring_pressure(face.ends, pressure) };
    let half = section_pressure(face.ends, pressure);
    face.nodes.map(|node| half.map(|f| rings[node] * f))
}

impl Persist for Pressure {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Pressure { id: _, surface, axial_areas: _, magnitude: _, current } = self;
        persist_fields!(archive; &mut surface.skin, current);
    }
}
