//! Targets that are not meshed: `*TARGET`, its layers and its free surfaces.
//! Never here: what a layer resists with (`materials`), loads.

use super::builder::Builder;
use super::types::{FreeSurfaces, Layer, Target};
use crate::deck::read::FromValue;
use crate::deck::table::constraints as cards;
use crate::deck::{Card, Diagnostic};
use crate::kernel::free_surface::FiniteSphere;

impl Builder<'_> {
    pub(super) fn target(&mut self, card: &Card) {
        let values: cards::Target = self.values(card);
        if values.direction.abs() != 1.0 {
            return self.out_of_range(card.span, format!("DIRECTION must be 1 or -1, found {}", values.direction));
        }
        if self.first_line(card).is_none() {
            return;
        }
        let radius = values.radius.unwrap_or(f64::INFINITY);
        let layers: Vec<Layer> = (0..card.lines.len()).filter_map(|at| self.layer(card, at, radius)).collect();
        if let Some(layer) = layers.iter().rev().skip(1).find(|l| l.thickness.is_infinite()) {
            let span = layer.span;
            self.out_of_range(span, "only the last layer may be without end");
        }
        if let Some(gap) = [layers.first(), layers.last()].into_iter().flatten().find(|l| l.material.is_none()) {
            let span = gap.span;
            self.out_of_range(span, "a gap lies between two layers: the first and the last need a material");
        }
        let free_surfaces = [FreeSurfaces::Off, FreeSurfaces::Plates, FreeSurfaces::Layers][values.free_surface];
        self.model.targets.push(Target {
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

    fn layer(&mut self, card: &Card, at: usize, radius: f64) -> Option<Layer> {
        let line = &card.lines[at];
        let material = match line.field(0) {
            Some(word) => Some(self.material(word)?),
            None => None,
        };
        let given = |field| Option::<f64>::from_value(card.given_field(at, field));
        let (thickness, radius) = (given(1).unwrap_or(f64::INFINITY), given(2).unwrap_or(radius));
        if let Some(properties) = material.map(|m| &self.model.materials[m])
            && (properties.cavity.is_none() || properties.density.is_none())
        {
            let message =
                format!("material {} has no resistance: a layer needs *DENSITY and *CAVITY EXPANSION", properties.name);
            let finding =
                Diagnostic::error("M101", message).at(line.span, "this layer").at(properties.span, "the material");
            self.diagnostics.push(finding);
        }
        Some(Layer { material, thickness, radius, span: line.span })
    }

    /// Once all cards are read: the factor of a free surface follows from Young's modulus and the yield stress of the resistance.
    pub(super) fn check_free_surfaces(&mut self) {
        let free = self.model.targets.iter().filter(|t| t.free_surfaces != FreeSurfaces::Off);
        let layers: Vec<Layer> = free.flat_map(|t| t.layers.iter().copied()).collect();
        layers.iter().for_each(|layer| self.must_be_elastic(layer));
    }

    fn must_be_elastic(&mut self, layer: &Layer) {
        let Some(properties) = layer.material.map(|m| &self.model.materials[m]) else { return };
        // One that could not be derived has been told.
        let Some(cavity) = properties.cavity.filter(|law| law.yield_stress > 0.0) else { return };
        let fault = match properties.elastic {
            None => "has no *ELASTIC",
            Some([young, _]) if FiniteSphere::new(young, cavity.yield_stress).is_none() => {
                "yields in *CAVITY EXPANSION at no less than 2E/3"
            }
            Some(_) => return,
        };
        let message =
            format!("FREE SURFACE needs Young's modulus and a yield stress, but material {} {fault}", properties.name);
        let finding =
            Diagnostic::error("M181", message).at(layer.span, "this layer").at(properties.span, "the material");
        self.diagnostics.push(finding);
    }
}
