//! What of a scene no mesh shows, for pictures: targets that are not meshed and analytical planes.
//! Never here: what acts on them.

use serde::Serialize;

use super::types::{Model, Plane, Target};

/// Targets and planes of a deck.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Scene {
    /// `*TARGET` stacks.
    pub targets: Vec<TargetOutline>,
    /// Planes z = constant that nodes cannot pass.
    pub planes: Vec<PlaneOutline>,
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
    /// From the front on.
    pub layers: Vec<LayerOutline>,
}

/// A layer of a target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerOutline {
    /// Name of its material.
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

impl Scene {
    /// The outlines of a model.
    pub fn of(model: &Model) -> Scene {
        Scene {
            targets: model.targets.iter().map(|t| target(model, t)).collect(),
            planes: model.planes.iter().map(|(name, p)| plane(model, name, p)).collect(),
        }
    }

    /// Whether there is nothing to outline.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty() && self.planes.is_empty()
    }
}

fn target(model: &Model, target: &Target) -> TargetOutline {
    let layers = target.layers.iter().map(|layer| LayerOutline {
        material: model.materials.get(layer.material).map_or(String::new(), |m| m.name.clone()),
        thickness: Some(layer.thickness).filter(|t| t.is_finite()),
    });
    let (name, front, direction) = (target.name.clone(), target.front, target.direction);
    TargetOutline { name, front, direction, layers: layers.collect() }
}

fn plane(model: &Model, name: &str, plane: &Plane) -> PlaneOutline {
    let carried_by = plane.reference.and_then(|node| model.mesh.node_names.get(node).cloned());
    PlaneOutline { name: name.to_owned(), height: plane.height, carried_by }
}
