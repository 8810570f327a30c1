//! Parts of a target's resistance left out: layers, the entry, terms of the law.

use super::{Ablation, Omission};
use crate::model::{FreeSurfaces, LoadKind, Material, Model, Sides, Target, TargetId};

pub(super) const LIST: &[Ablation] = &[
    Ablation::new(
        "entry phase",
        "the target reaches back over all loaded surfaces from the start",
        |model| entering(model).next().is_some(),
        embed,
    ),
    Ablation::new(
        "resistance linear in velocity",
        "B = 0",
        |model| loaded(model).any(|t| laws(model, t).any(|m| m.cavity.is_some_and(|c| c.b != 0.0))),
        |model| model.materials.iter_mut().filter_map(|m| m.cavity.as_mut()).for_each(|c| c.b = 0.0),
    ),
    Ablation::new(
        "resistance quadratic in velocity",
        "C = 0",
        |model| loaded(model).any(|t| laws(model, t).any(|m| m.cavity.is_some_and(|c| c.c != 0.0))),
        |model| model.materials.iter_mut().filter_map(|m| m.cavity.as_mut()).for_each(|c| c.c = 0.0),
    ),
    Ablation::new(
        "free surfaces",
        "layers as strong as a body without end",
        |model| any(model, |t| t.free_surfaces != FreeSurfaces::Off),
        |model| model.targets.iter_mut().for_each(|t| t.free_surfaces = FreeSurfaces::Off),
    ),
    Ablation::new(
        "crater",
        "the full resistance from the face on",
        |model| any(model, |t| t.crater.is_some()),
        |model| model.targets.iter_mut().for_each(|t| t.crater = None),
    ),
    Ablation::new(
        "plugging",
        "the cavity is opened all the way",
        |model| any(model, |t| t.shear_strength.is_some()),
        |model| model.targets.iter_mut().for_each(|t| t.shear_strength = None),
    ),
    Ablation::new(
        "separation",
        "whatever moves outwards or ahead bears, inside the tunnel too",
        |model| any(model, |t| t.separation),
        |model| model.targets.iter_mut().for_each(|t| t.separation = false),
    ),
];

/// Whether this is so of a target that some load drives a surface into.
fn any(model: &Model, is_so: impl Fn(&Target) -> bool) -> bool {
    loaded(model).any(|t| is_so(&model.targets[t]))
}

/// Targets that some load drives a surface into.
fn loaded(model: &Model) -> impl Iterator<Item = TargetId> + '_ {
    (0..model.targets.len()).map(TargetId::new).filter(|t| sides_into(model, *t).next().is_some())
}

fn sides_into(model: &Model, wanted: TargetId) -> impl Iterator<Item = &Sides> {
    model.steps.iter().flat_map(|s| &s.loads).filter_map(move |load| match &load.kind {
        LoadKind::Cavity { sides, target, .. } if *target == wanted => Some(sides),
        _ => None,
    })
}

fn laws(model: &Model, target: TargetId) -> impl Iterator<Item = &Material> {
    model.targets[target].layers.iter().filter_map(|l| Some(&model.materials[l.material?]))
}

/// Target and layer of each layer whose neighbour is of another material.
fn layers(model: &Model) -> Vec<(TargetId, usize)> {
    let of = |t: TargetId| {
        let layers = &model.targets[t].layers;
        // Nothing could take the place of a layer beside a gap: the next is not of one plate with it.
        let instead = move |l: usize| layers[neighbour(l)].material.filter(|m| Some(*m) != layers[l].material);
        let differs = move |l: &usize| layers.len() > 1 && instead(*l).is_some();
        (0..layers.len()).filter(differs).map(move |l| (t, l))
    };
    loaded(model).flat_map(of).collect()
}

fn neighbour(layer: usize) -> usize {
    if layer == 0 { 1 } else { layer - 1 }
}

/// Each layer made of its neighbour's material.
pub(super) fn layers_left_out(model: &Model) -> impl Iterator<Item = Omission> + '_ {
    layers(model).into_iter().map(|(target, layer)| Omission {
        name: format!("layer {} of {}", layer + 1, model.targets[target].name),
        instead: "material of the layer before it, of the first that of the second",
        edit: Box::new(move |model| {
            let layers = &mut model.targets[target].layers;
            layers[layer].material = layers[neighbour(layer)].material;
        }),
    })
}

/// Targets that the loaded surfaces touch at the start, and how far these reach out of them.
fn entering(model: &Model) -> impl Iterator<Item = (TargetId, f64)> + '_ {
    loaded(model).filter_map(|t| {
        let target = &model.targets[t];
        let [near, far] = reach(model, target, t)?;
        let extent = far - near;
        (far > 0.0 && near <= 1e-6 * extent).then_some((t, far))
    })
}

/// Least and greatest distance of the loaded surfaces before the face, against the way of the layers.
fn reach(model: &Model, target: &Target, id: TargetId) -> Option<[f64; 2]> {
    let faces = sides_into(model, id).flat_map(|s| &s.faces);
    let nodes = faces.filter_map(|&(element, side)| model.mesh.ends(element, side)).flatten();
    let before = nodes.map(|n| (target.front - model.mesh.points[n][1]) * target.direction);
    before.fold(None, |range: Option<[f64; 2]>, d| {
        let [low, high] = range.unwrap_or([d, d]);
        Some([low.min(d), high.max(d)])
    })
}

fn embed(model: &mut Model) {
    let list: Vec<(TargetId, f64)> = entering(model).collect();
    for (target, far) in list {
        let target = &mut model.targets[target];
        // A little more, so that rounding leaves nothing outside.
        let back = far * (1.0 + 1e-9);
        target.front -= target.direction * back;
        if let Some(first) = target.layers.first_mut() {
            first.thickness += back;
        }
    }
}
