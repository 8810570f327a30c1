//! Targets without mesh (`*TARGET`): layers and free surfaces.

use super::context::Context;
use super::types::{FreeSurfaces, MaterialDefinition, TargetLayer, TargetStack};
use crate::deck::read::FromValue;
use crate::deck::table::constraints as cards;
use crate::deck::{Card, Diagnostic};
use crate::kernel::free_surface::FiniteSphere;

pub fn read_target(context: &mut Context<'_>, card: &Card) {
    let values: cards::Target = card.values();
    if values.direction.abs() != 1.0 {
        return context.out_of_range(card.span, format!("DIRECTION must be 1 or -1, found {}", values.direction));
    }
    if context.first_line(card).is_none() {
        return;
    }
    let radius = values.radius.unwrap_or(f64::INFINITY);
    let layers: Vec<TargetLayer> = (0..card.lines.len()).filter_map(|at| layer(context, card, at, radius)).collect();
    if let Some(layer) = layers.iter().rev().skip(1).find(|l| l.thickness.is_infinite()) {
        context.out_of_range(layer.span, "only the last layer may have infinite thickness");
    }
    if let Some(gap) = [layers.first(), layers.last()].into_iter().flatten().find(|l| l.material.is_none()) {
        let message = "the first and the last layer require a material; gaps are allowed between layers only";
        context.out_of_range(gap.span, message);
    }
    let free_surfaces = [FreeSurfaces::Off, FreeSurfaces::Plates, FreeSurfaces::Layers][values.free_surface];
    context.model.targets.push(TargetStack {
        name: values.name,
        front: values.front,
        direction: values.direction,
        obliquity: values.obliquity,
        layers,
        free_surfaces,
        crater: values.crater,
        shear_strength: values.shear_strength,
        separation: values.separation,
        span: card.span,
    });
}

fn layer(context: &mut Context<'_>, card: &Card, at: usize, radius: f64) -> Option<TargetLayer> {
    let line = &card.lines[at];
    let material = context.optional(line.field(0), Context::material)?;
    let field_value = |field| Option::<f64>::from_value(card.given_field(at, field));
    let (thickness, radius) = (field_value(1).unwrap_or(f64::INFINITY), field_value(2).unwrap_or(radius));
    if let Some(word) = line.field(2).filter(|_| material.is_none()) {
        context.report_surplus(word, "a gap between plates has no radius");
    }
    let line = &card.lines[at];
    if let Some(properties) = material.map(|m| &context.model.materials[m])
        && (properties.cavity.is_none() || properties.density.is_none())
    {
        let diagnostic = Diagnostic::error("M101", no_resistance(properties))
            .at(line.span, "this layer")
            .at(properties.span, "the material");
        context.diagnostics.push(diagnostic);
    }
    Some(TargetLayer { material, thickness, radius, span: line.span })
}

/// Checks the layers of targets with free surfaces, whose effect depends on Young's modulus and the yield stress Y.
pub fn check_free_surfaces(context: &mut Context<'_>) {
    let free = context.model.targets.iter().filter(|t| t.free_surfaces != FreeSurfaces::Off);
    let layers: Vec<TargetLayer> = free.flat_map(|t| t.layers.iter().copied()).collect();
    layers.iter().for_each(|layer| check_elasticity(context, layer));
}

fn check_elasticity(context: &mut Context<'_>, layer: &TargetLayer) {
    let Some(properties) = layer.material.map(|m| &context.model.materials[m]) else { return };
    // Constants that could not be derived are reported already.
    let Some(cavity) = properties.cavity.filter(|law| law.yield_stress > 0.0) else { return };
    let fault = match properties.elastic {
        None => "has no *ELASTIC",
        Some([young, _]) if FiniteSphere::new(young, cavity.yield_stress).is_none() => {
            "has a yield stress Y of 2E/3 or more in *CAVITY EXPANSION"
        }
        Some(_) => return,
    };
    let message =
        format!("FREE SURFACE requires Young's modulus and a yield stress, but material {} {fault}", properties.name);
    let diagnostic =
        Diagnostic::error("M181", message).at(layer.span, "this layer").at(properties.span, "the material");
    context.diagnostics.push(diagnostic);
}

/// Returns the message about a material of a layer that lacks density or resistance.
pub fn no_resistance(material: &MaterialDefinition) -> String {
    let name = &material.name;
    format!("material {name} has no resistance: a target layer requires *DENSITY and *CAVITY EXPANSION")
}
