//! What loads show of the surfaces that they act on.
//! Never here: files.

use crate::load::stations::stations;
use crate::mesh::surface::{Face, Surface};
use crate::state::dofs::Dofs;
use crate::variables::Variable;

/// What a load shows of a surface in a frame, one entry a facet or face.
#[derive(Clone, Debug, Default)]
pub struct FacetFields {
    /// Index of its element in the mesh.
    pub elements: Vec<usize>,
    /// Pressure, area mean.
    pub pressure: Vec<f64>,
    /// Velocity along the outward normal.
    pub normal_velocity: Vec<f64>,
    /// Number (from 1) of the layer that takes the largest part of the area; 0 outside any.
    pub layer: Vec<f64>,
}

impl FacetFields {
    /// What a facet, by its index here, has of a variable of facets; `None` where loads do not tell it.
    pub fn value(&self, facet: usize, variable: Variable) -> Option<f64> {
        let values = match variable {
            Variable::FacetPressure => &self.pressure,
            Variable::NormalVelocity => &self.normal_velocity,
            Variable::Layer => &self.layer,
            _ => return None,
        };
        values.get(facet).copied()
    }

    /// A facet or face in no layer.
    pub fn push(&mut self, element: usize, pressure: f64, normal_velocity: f64) {
        self.elements.push(element);
        self.pressure.push(pressure);
        self.normal_velocity.push(normal_velocity);
        self.layer.push(0.0);
    }

    /// One pressure all over a surface.
    pub fn uniform(surface: &Surface, pressure: f64, dofs: &Dofs) -> FacetFields {
        let mut fields = FacetFields::default();
        for patch in &surface.patches {
            let body = &dofs.bodies[patch.body];
            match &body.spatial {
                None => patch.facets.iter().for_each(|(e, f)| fields.push(*e, pressure, body.velocity * f.normal[1])),
                Some(spatial) => {
                    let all = stations(patch, spatial);
                    all.iter().for_each(|s| fields.push(s.element, pressure, s.normal_velocity(spatial)));
                }
            }
        }
        let skin = &surface.skin;
        for ((&face, &element), &carries) in skin.faces.iter().zip(&skin.elements).zip(&skin.carries) {
            let velocity = Face::new(face, &dofs.nodes).normal_velocity(&dofs.nodes);
            fields.push(element, if carries { pressure } else { 0.0 }, velocity);
        }
        fields
    }
}
