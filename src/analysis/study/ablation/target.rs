//! Ablations of parts of a target's resistance: layers, entry phase, terms of the law.

use super::{EffectRemoval, ReducedModel};
use crate::model::{FreeSurfaces, LoadKind, MaterialDefinition, Model, SideSelection, TargetId, TargetStack};

pub(super) const LIST: &[EffectRemoval] = &[
    EffectRemoval::new(
        "entry phase",
        "target extended over all loaded surfaces from the start",
        |model| entering(model).next().is_some(),
        embed,
    ),
    EffectRemoval::new(
        "resistance linear in velocity",
        "B = 0",
        |model| loaded(model).any(|t| laws(model, t).any(|m| m.cavity.is_some_and(|c| c.b != 0.0))),
        |model| model.materials.iter_mut().filter_map(|m| m.cavity.as_mut()).for_each(|c| c.b = 0.0),
    ),
    EffectRemoval::new(
        "resistance quadratic in velocity",
        "C = 0",
        |model| loaded(model).any(|t| laws(model, t).any(|m| m.cavity.is_some_and(|c| c.c != 0.0))),
        |model| model.materials.iter_mut().filter_map(|m| m.cavity.as_mut()).for_each(|c| c.c = 0.0),
    ),
    EffectRemoval::new(
        "free surfaces",
        "layers of an unbounded target",
        |model| any(model, |t| t.free_surfaces != FreeSurfaces::Off),
        |model| model.targets.iter_mut().for_each(|t| t.free_surfaces = FreeSurfaces::Off),
    ),
    EffectRemoval::new(
        "crater",
        "full resistance from the front face",
        |model| any(model, |t| t.crater.is_some()),
        |model| model.targets.iter_mut().for_each(|t| t.crater = None),
    ),
    EffectRemoval::new(
        "plugging",
        "cavity expansion through the whole target",
        |model| any(model, |t| t.shear_strength.is_some()),
        |model| model.targets.iter_mut().for_each(|t| t.shear_strength = None),
    ),
    EffectRemoval::new(
        "separation",
        "resistance on all surfaces that move outwards or forwards, also inside the tunnel",
        |model| any(model, |t| t.separation),
        |model| model.targets.iter_mut().for_each(|t| t.separation = false),
    ),
];

/// Returns whether a loaded target has the given property.
fn any(model: &Model, is_so: impl Fn(&TargetStack) -> bool) -> bool {
    loaded(model).any(|t| is_so(&model.targets[t]))
}

/// Returns the targets that act on at least one surface.
fn loaded(model: &Model) -> impl Iterator<Item = TargetId> + '_ {
    (0..model.targets.len()).map(TargetId::new).filter(|t| sides_into(model, *t).next().is_some())
}

fn sides_into(model: &Model, wanted: TargetId) -> impl Iterator<Item = &SideSelection> {
    model.steps.iter().flat_map(|s| &s.loads).filter_map(move |load| match &load.kind {
        LoadKind::Cavity { sides, target, .. } if *target == wanted => Some(sides),
        _ => None,
    })
}

fn laws(model: &Model, target: TargetId) -> impl Iterator<Item = &MaterialDefinition> {
    model.targets[target].layers.iter().filter_map(|l| Some(&model.materials[l.material?]))
}

/// Returns target and index of each layer whose neighbour has a different material.
fn layers(model: &Model) -> Vec<(TargetId, usize)> {
    let replaceable_layers = |t: TargetId| {
        let layers = &model.targets[t].layers;
        // A layer next to a gap is not replaced: the layer beyond the gap belongs to a different plate.
        let instead = move |l: usize| layers[neighbour(l)].material.filter(|m| Some(*m) != layers[l].material);
        let differs = move |l: &usize| layers.len() > 1 && instead(*l).is_some();
        (0..layers.len()).filter(differs).map(move |l| (t, l))
    };
    loaded(model).flat_map(replaceable_layers).collect()
}

fn neighbour(layer: usize) -> usize {
    if layer == 0 { 1 } else { layer - 1 }
}

/// Returns one removal per layer that gives the layer the material of its neighbour.
pub(super) fn layers_left_out(model: &Model) -> impl Iterator<Item = ReducedModel> + '_ {
    layers(model).into_iter().map(|(target, layer)| ReducedModel {
        name: format!("layer {} of {}", layer + 1, model.targets[target].name),
        instead: "material of the previous layer (of the second layer for the first one)",
        edit: Box::new(move |model| {
            let layers = &mut model.targets[target].layers;
            layers[layer].material = layers[neighbour(layer)].material;
        }),
    })
}

/// Returns the targets that the loaded surfaces touch at the start, with the largest distance of these surfaces from
/// the front face.
fn entering(model: &Model) -> impl Iterator<Item = (TargetId, f64)> + '_ {
    loaded(model).filter_map(|t| {
        let target = &model.targets[t];
        let [near, far] = surface_distances(model, target, t)?;
        let extent = far - near;
        (far > 0.0 && near <= 1e-6 * extent).then_some((t, far))
    })
}

/// Returns the smallest and largest initial distance of the loaded surfaces in front of the target face.
fn surface_distances(model: &Model, target: &TargetStack, id: TargetId) -> Option<[f64; 2]> {
    let faces = sides_into(model, id).flat_map(|s| &s.faces);
    let nodes = faces.filter_map(|&(element, side)| model.mesh.side_nodes(element, side)).flatten();
    let distances = nodes.map(|n| (target.front - model.mesh.points[n][1]) * target.direction);
    distances.fold(None, |range: Option<[f64; 2]>, d| {
        let [low, high] = range.unwrap_or([d, d]);
        Some([low.min(d), high.max(d)])
    })
}

fn embed(model: &mut Model) {
    let list: Vec<(TargetId, f64)> = entering(model).collect();
    for (target, far) in list {
        let target = &mut model.targets[target];
        // Slightly more, so that rounding leaves no node outside.
        let back = far * (1.0 + 1e-9);
        target.front -= target.direction * back;
        if let Some(first) = target.layers.first_mut() {
            first.thickness += back;
        }
    }
}
