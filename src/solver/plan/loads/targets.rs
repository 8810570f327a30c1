//! Targets without a mesh: layers with their resistance laws, free surfaces, and ledger rows.

use crate::deck::Diagnostic;
use crate::kernel::cavity::CavityResistance;
use crate::kernel::free_surface::FiniteSphere;
use crate::load::cavity::{CavityExpansion, EntryCrater, LayerBounds, LayerStack, StackBounds, StackTilt};
use crate::mesh::surface::{RigidFacets, SurfaceGeometry};
use crate::model::{
    DEFAULT_ACCURACY, FreeSurfaces, Load, MaterialId, Model, SideSelection, TargetId, TargetLayer, TargetStack,
};
use crate::plan::loads::{LoadEffect, LoadInput};
use crate::plan::meshes::surfaces::load_surface;
use crate::plan::{Bodies, Report};

pub fn cavity_load(
    input: &LoadInput,
    sides: &SideSelection,
    target: TargetId,
    friction: f64,
    report: &mut Report,
) -> LoadEffect {
    let LoadInput { scene, load, step, state, .. } = *input;
    let mut surface = load_surface(scene, sides, load.span, report);
    let target = &scene.model.targets[target];
    if !surface.skin.shells.is_empty() {
        return refuse_resistance(load, "CAVITY loads on shells are not supported", report);
    }
    if target.shear_strength.is_some() && !surface.skin.faces.is_empty() {
        let message = "SHEAR STRENGTH of the target (plugging) is supported for rigid bodies, not for deformable faces";
        return refuse_resistance(load, message, report);
    }
    if target.obliquity != 0.0 && !surface.skin.faces.is_empty() {
        let message = format!(
            "target {} is inclined: deformable bodies, which are bodies of revolution, cannot hit it",
            target.name
        );
        let finding = Diagnostic::error("P132", message).at(load.span, "here").at(target.span, "its OBLIQUITY");
        return report.refuse(finding.help("use a rigid body with an inclined target"));
    }
    let count = surface.count();
    let oblique = take_oblique(scene.bodies, &mut surface);
    if !oblique.is_empty() && (target.separation || target.shear_strength.is_some()) {
        let message = "SEPARATION and SHEAR STRENGTH of a target are supported for normal impact, not for bodies with six degrees of freedom";
        return refuse_resistance(load, message, report);
    }
    let stack = layer_stack(scene.model, target)?;
    let detail = format!("{} into {}", sides.name, target.name);
    let id = report.ledger_row(load.span, "cavity expansion", count, "facets", detail);
    if friction > 0.0 {
        report.ledger_row(load.span, "friction", count, "facets", format!("Coulomb, coefficient {friction}"));
    }
    target_rows(scene.model, target, report);
    let travel = step.increment.travel();
    let mut effect = CavityExpansion::new(id, friction, stack, surface, travel);
    if target.separation {
        effect = effect.separating(&state.dofs.nodes);
    }
    // Fixed time increments have no accuracy: the default one applies.
    let travel = travel.min(DEFAULT_ACCURACY.sqrt());
    for patch in oblique {
        let tilt = StackTilt::new(target.front, target.obliquity.to_radians());
        let Some(body) = &state.dofs.bodies[patch.body].spatial else { continue };
        effect = effect.with_oblique(&patch, body, (tilt, target.direction), travel);
    }
    Some(Box::new(effect))
}

fn refuse_resistance(load: &Load, message: &str, report: &mut Report) -> LoadEffect {
    report.refuse(Diagnostic::error("P015", message).at(load.span, "here"))
}

/// Removes the patches of oblique bodies from a surface and returns them.
fn take_oblique(bodies: &Bodies, surface: &mut SurfaceGeometry) -> Vec<RigidFacets> {
    let (oblique, along_z): (Vec<RigidFacets>, Vec<RigidFacets>) =
        std::mem::take(&mut surface.patches).into_iter().partition(|p| bodies.list[p.body].spatial);
    surface.patches = along_z;
    oblique
}

fn target_rows(model: &Model, target: &TargetStack, report: &mut Report) {
    let name = |l: &TargetLayer| l.material.map_or("gap", |m| model.materials[m].name.as_str());
    let names: Vec<_> = target.layers.iter().take(4).map(name).collect();
    let more = if target.layers.len() > 4 { ", …" } else { "" };
    let tilt = if target.obliquity == 0.0 { String::new() } else { format!(", inclined by {} deg", target.obliquity) };
    let detail = format!("{}: {}{more}; front at z = {}{tilt}", target.name, names.join(", "), target.front);
    report.ledger_row(target.span, "target", target.layers.len(), "layers", detail);
    target.layers.iter().filter_map(|layer| layer.material).for_each(|material| derived_row(model, material, report));
    let mut row = |effect, detail: String| {
        report.ledger_row(target.span, effect, target.layers.len(), "layers", format!("{}: {detail}", target.name));
    };
    match target.free_surfaces {
        FreeSurfaces::Off => {}
        FreeSurfaces::Plates => row("free surfaces", "outer faces and faces at gaps".into()),
        FreeSurfaces::Layers => row("free surfaces", "faces of every layer".into()),
    }
    if let Some(depth) = target.crater {
        row("crater", format!("{depth} deep"));
    }
    if let Some(strength) = target.shear_strength {
        row("plugging", format!("shear strength {strength}"));
    }
    if target.separation {
        row("separation", "the tunnel keeps its largest radius".into());
    }
}

fn derived_row(model: &Model, material: MaterialId, report: &mut Report) {
    let material = &model.materials[material];
    let Some(law) = material.cavity else { return };
    let Some(from) = law.derived else { return };
    let detail = format!(
        "{}: Y = {}, A = {}, B = {}, C = {} over velocities {} to {}; residual {:.2e} Y, maximum deviation {:.2} % (at {}); quasi-static {}{}",
        material.name,
        law.yield_stress,
        law.a,
        law.b,
        law.c,
        from.range[0],
        from.range[1],
        from.residual,
        100.0 * from.worst[0],
        from.worst[1],
        if from.still.is_nan() { "not defined".to_owned() } else { format!("{:.4}", from.still) },
        from.shape.ledger_note()
    );
    report.ledger_row(law.span, "derived resistance", 3, "constants", detail);
}

fn layer_stack(model: &Model, target: &TargetStack) -> Option<LayerStack> {
    let law = |layer: &TargetLayer| {
        let Some(material) = layer.material.map(|m| &model.materials[m]) else {
            return Some(CavityResistance::NONE);
        };
        let law = material.cavity?;
        Some(CavityResistance::new(law.yield_stress, material.density?, [law.a, law.b, law.c]))
    };
    let layers = target.layers.iter().map(|l| Some((l.thickness, law(l)?))).collect::<Option<Vec<_>>>()?;
    let stack = LayerStack::new(target.front, target.direction, &layers);
    let bounded = target.free_surfaces != FreeSurfaces::Off
        || target.crater.is_some()
        || target.shear_strength.is_some()
        || target.layers.iter().any(|l| l.radius.is_finite());
    if !bounded {
        return Some(stack);
    }
    let finite = StackBounds {
        layers: stack_bounds(model, target, &stack.planes),
        crater: target.crater.map(|depth| EntryCrater { front: target.front, direction: target.direction, depth }),
        shear_strength: target.shear_strength,
    };
    Some(stack.with_bounds(finite))
}

/// Returns the free surfaces of the layers, in ascending order of z.
fn stack_bounds(model: &Model, target: &TargetStack, planes: &[f64]) -> Vec<LayerBounds> {
    let mut layers: Vec<&TargetLayer> = target.layers.iter().collect();
    if target.direction < 0.0 {
        layers.reverse();
    }
    let holds = |a: usize, b: usize| {
        let solid = |at: usize| layers.get(at).is_some_and(|l| l.material.is_some());
        target.free_surfaces != FreeSurfaces::Layers && solid(a) && solid(b)
    };
    let bounds = layers.iter().enumerate().map(|(at, layer)| {
        let (mut low, mut high) = (at, at);
        while low > 0 && holds(low - 1, low) {
            low -= 1;
        }
        while holds(high, high + 1) {
            high += 1;
        }
        let decay = layer.material.filter(|_| target.free_surfaces != FreeSurfaces::Off).and_then(|material| {
            let material = &model.materials[material];
            FiniteSphere::new(material.elastic?[0], material.cavity?.yield_stress)
        });
        LayerBounds { radius: layer.radius, faces: [planes[low], planes[high + 1]], decay }
    });
    bounds.collect()
}
