//! What of a scene no mesh shows, for pictures: targets that are not meshed and analytical surfaces.
//! Never here: what acts on them.

use serde::Serialize;

use super::types::{Model, RigidSurface, Target};

/// Targets and analytical surfaces of a deck.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Scene {
    /// `*TARGET` stacks.
    pub targets: Vec<TargetOutline>,
    /// Planes z = constant that nodes cannot pass.
    pub planes: Vec<PlaneOutline>,
    /// Other analytical surfaces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<SurfaceOutline>,
}

/// A target that is not meshed: layers between planes z = constant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetOutline {
    /// Name.
    pub name: String,
    /// z of the impact face, length.
    pub front: f64,
    /// +1 or -1: the way the layers follow each other along z.
    pub direction: f64,
    /// Angle in degrees by which its planes are turned about direction 3; absent where they are level.
    #[serde(skip_serializing_if = "level")]
    pub obliquity: f64,
    /// From the front on.
    pub layers: Vec<LayerOutline>,
}

/// A layer of a target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerOutline {
    /// Name of its material; empty for a gap.
    pub material: String,
    /// Thickness, length; absent where the layer has no end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
}

/// An analytical plane.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaneOutline {
    /// Name of the surface.
    pub name: String,
    /// z at the start, length.
    pub height: f64,
    /// Node whose displacement along z it follows, if it can move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carried_by: Option<String>,
}

/// An analytical surface of lines and arcs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceOutline {
    /// Name of the surface.
    pub name: String,
    /// Points `[r, z]` along it at the start, length.
    pub points: Vec<[f64; 2]>,
    /// Node whose displacement along z it follows, if it can move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carried_by: Option<String>,
}

impl Scene {
    /// The outlines of a model.
    pub fn of(model: &Model) -> Scene {
        Scene {
            targets: model.targets.iter().map(|t| target(model, t)).collect(),
            planes: model.surfaces.analytical.iter().filter_map(|(name, s)| plane(model, name, s)).collect(),
            surfaces: model.surfaces.analytical.iter().filter_map(|(name, s)| surface(model, name, s)).collect(),
        }
    }

    /// Whether there is nothing to outline.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty() && self.planes.is_empty() && self.surfaces.is_empty()
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // As serde asks.
fn level(obliquity: &f64) -> bool {
    *obliquity == 0.0
}

fn target(model: &Model, target: &Target) -> TargetOutline {
    let layers = target.layers.iter().map(|layer| LayerOutline {
        material: layer.material.and_then(|m| model.materials.get(m.index())).map_or(String::new(), |m| m.name.clone()),
        thickness: Some(layer.thickness).filter(|t| t.is_finite()),
    });
    let (name, front, direction) = (target.name.clone(), target.front, target.direction);
    TargetOutline { name, front, direction, obliquity: target.obliquity, layers: layers.collect() }
}

fn carrier(model: &Model, surface: &RigidSurface) -> Option<String> {
    surface.reference.and_then(|node| model.mesh.node_names.get(node).map(super::Name::to_string))
}

fn plane(model: &Model, name: &str, surface: &RigidSurface) -> Option<PlaneOutline> {
    let (height, carried_by) = (surface.profile.height()?, carrier(model, surface));
    Some(PlaneOutline { name: name.to_owned(), height, carried_by })
}

fn surface(model: &Model, name: &str, surface: &RigidSurface) -> Option<SurfaceOutline> {
    let (points, carried_by) = (surface.profile.outline(), carrier(model, surface));
    surface.profile.height().is_none().then(|| SurfaceOutline { name: name.to_owned(), points, carried_by })
}
