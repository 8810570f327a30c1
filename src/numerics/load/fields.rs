//! Facet output of the loads that act on a surface.

use crate::load::stations::stations;
use crate::mesh::surface::{CurrentFace, SurfaceGeometry};
use crate::state::dofs::Dofs;
use crate::variables::Variable;

/// Output of a load on a surface in one frame; each list has one entry per facet or face.
#[derive(Clone, Debug, Default)]
pub struct FacetFields {
    /// Index of the element in the mesh.
    pub elements: Vec<usize>,
    /// Pressure, averaged over the area.
    pub pressure: Vec<f64>,
    /// Velocity along the outward normal.
    pub normal_velocity: Vec<f64>,
    /// Weight in the mean over the values of an element: the area of a station, 1 for a facet or face.
    pub weight: Vec<f64>,
    /// Number (from 1) of the target layer that contains the largest part of the area; 0 outside all layers.
    pub layer: Vec<f64>,
}

impl FacetFields {
    /// Returns a facet variable of the facet with this index; `None` if loads do not provide the variable.
    pub fn value(&self, facet: usize, variable: Variable) -> Option<f64> {
        let values = match variable {
            Variable::FacetPressure => &self.pressure,
            Variable::NormalVelocity => &self.normal_velocity,
            Variable::Layer => &self.layer,
            _ => return None,
        };
        values.get(facet).copied()
    }

    /// Adds a facet or face outside all layers.
    pub fn push(&mut self, element: usize, pressure: f64, normal_velocity: f64) {
        self.push_station(element, 1.0, [pressure, normal_velocity]);
    }

    /// Adds a station of a facet with its area.
    pub fn push_station(&mut self, element: usize, area: f64, [pressure, normal_velocity]: [f64; 2]) {
        self.elements.push(element);
        self.weight.push(area);
        self.pressure.push(pressure);
        self.normal_velocity.push(normal_velocity);
        self.layer.push(0.0);
    }

    /// Returns the output for a uniform pressure on a surface.
    pub fn uniform(surface: &SurfaceGeometry, pressure: f64, dofs: &Dofs) -> FacetFields {
        let mut fields = FacetFields::default();
        for patch in &surface.patches {
            let body = &dofs.bodies[patch.body];
            match &body.spatial {
                None => patch.facets.iter().for_each(|(e, f)| fields.push(*e, pressure, body.velocity * f.normal[1])),
                Some(spatial) => {
                    let list = stations(patch, spatial);
                    list.iter()
                        .for_each(|s| fields.push_station(s.element, s.area, [pressure, s.normal_velocity(spatial)]));
                }
            }
        }
        let skin = &surface.skin;
        for ((&face, &element), &carries) in skin.faces.iter().zip(&skin.elements).zip(&skin.is_active) {
            let velocity = CurrentFace::new(face, &dofs.nodes).normal_velocity(&dofs.nodes);
            fields.push(element, if carries { pressure } else { 0.0 }, velocity);
        }
        fields
    }
}
