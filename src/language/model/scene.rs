//! Outlines of targets without mesh and of analytical surfaces, for pictures.

use serde::Serialize;

use super::types::{Model, RigidSurface, TargetStack};

/// Targets and analytical surfaces of a deck.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SceneOutline {
    /// Targets of the model, from `*TARGET`.
    pub targets: Vec<TargetOutline>,
    /// Analytical planes z = constant.
    pub planes: Vec<PlaneOutline>,
    /// Other analytical surfaces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<SurfaceOutline>,
}

/// Outline of a target without mesh: layers between planes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetOutline {
    /// Name of the target.
    pub name: String,
    /// z of the impact face, length.
    pub front: f64,
    /// Stacking direction of the layers along z: +1 or -1.
    pub direction: f64,
    /// Rotation angle of the planes about direction 3, in degrees; absent if zero.
    #[serde(skip_serializing_if = "level")]
    pub obliquity: f64,
    /// Layers, starting at the impact face.
    pub layers: Vec<LayerOutline>,
}

/// Outline of a target layer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerOutline {
    /// Name of the material; empty for a gap.
    pub material: String,
    /// Thickness, length; absent for an infinite layer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
}

/// Outline of an analytical plane z = constant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaneOutline {
    /// Name of the surface.
    pub name: String,
    /// Initial z coordinate, length.
    pub height: f64,
    /// Name of the node whose z displacement the surface follows; absent for a fixed surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carried_by: Option<String>,
}

/// Outline of an analytical surface of lines and arcs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceOutline {
    /// Name of the surface.
    pub name: String,
    /// Initial points `[r, z]` along the surface, length.
    pub points: Vec<[f64; 2]>,
    /// Name of the node whose z displacement the surface follows; absent for a fixed surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carried_by: Option<String>,
}

impl SceneOutline {
    /// Returns the outlines of the targets and rigid surfaces of a model.
    pub fn of(model: &Model) -> SceneOutline {
        SceneOutline {
            targets: model.targets.iter().map(|t| target(model, t)).collect(),
            planes: model.surfaces.analytical.iter().filter_map(|(name, s)| plane(model, name, s)).collect(),
            surfaces: model.surfaces.analytical.iter().filter_map(|(name, s)| surface(model, name, s)).collect(),
        }
    }

    /// Returns whether there is nothing to outline.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty() && self.planes.is_empty() && self.surfaces.is_empty()
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // Required by serde.
fn level(obliquity: &f64) -> bool {
    *obliquity == 0.0
}

fn target(model: &Model, target: &TargetStack) -> TargetOutline {
    let layers = target.layers.iter().map(|layer| LayerOutline {
        material: layer.material.and_then(|m| model.materials.get(m.index())).map_or(String::new(), |m| m.name.clone()),
        thickness: Some(layer.thickness).filter(|t| t.is_finite()),
    });
    let (name, front, direction) = (target.name.clone(), target.front, target.direction);
    TargetOutline { name, front, direction, obliquity: target.obliquity, layers: layers.collect() }
}

fn carrier(model: &Model, surface: &RigidSurface) -> Option<String> {
    surface.reference.and_then(|node| model.mesh.node_names.get(node).map(super::EntityName::to_string))
}

fn plane(model: &Model, name: &str, surface: &RigidSurface) -> Option<PlaneOutline> {
    let (height, carried_by) = (surface.profile.height()?, carrier(model, surface));
    Some(PlaneOutline { name: name.to_owned(), height, carried_by })
}

fn surface(model: &Model, name: &str, surface: &RigidSurface) -> Option<SurfaceOutline> {
    let (points, carried_by) = (surface.profile.outline(), carrier(model, surface));
    surface.profile.height().is_none().then(|| SurfaceOutline { name: name.to_owned(), points, carried_by })
}
