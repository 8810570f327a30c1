//! Which triangles average their dilation over their nodes.
//! Never here: how.

use super::Compiler;
use super::user_material::asks_at_points;
use crate::element::averaging::Averaging;
use crate::model::{Material, SolidSection};

/// Poisson's ratio above which triangles of an elastic material lock: there the bulk modulus is ten times the shear modulus.
const NEARLY_INCOMPRESSIBLE: f64 = 0.45;

impl Compiler<'_> {
    /// The triangles of a section, where they are to be averaged: where the deck says so, and without a word where they would
    /// lock.
    pub(super) fn averaging(&mut self, section: &SolidSection, corners: &[[u32; 4]]) -> Option<Averaging> {
        let material = &self.model.materials[section.material];
        let said = section.controls.averaged;
        if said == Some(false) {
            return None;
        }
        let triangles = corners.iter().filter(|c| c[2] == c[3]).count();
        let why_not = if triangles == 0 {
            Some("the section has no CAX3 elements")
        } else if section.controls.by_area {
            Some("not under WEIGHTING=AREA")
        } else if material.eos.is_some() || material.foam.shape.is_some() || asks_at_points(material) {
            Some("of linear elasticity and rubber alone")
        } else {
            None
        };
        match (why_not, said) {
            (Some(why), Some(true)) => self.unused(section.span, "AVERAGED PRESSURE", why),
            (None, _) if said.is_some() || locks(material) => {
                let detail = "dilation averaged over nodes, lest they lock".into();
                self.cause(section.span, "averaged pressure", triangles, "triangles", detail);
                return Averaging::new(corners);
            }
            _ => {}
        }
        None
    }
}

fn locks(material: &Material) -> bool {
    let stiff = material.elastic.is_some_and(|[_, poisson]| poisson > NEARLY_INCOMPRESSIBLE);
    stiff || material.plastic.is_some() || material.hyperelastic.is_some()
}
