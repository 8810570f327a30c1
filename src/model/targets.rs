//! Targets that are not meshed: `*TARGET`, its layers and its free surfaces.
//! Never here: what a layer resists with (`materials`), loads.

use super::builder::Builder;
use super::names::upper;
use super::types::{FreeSurfaces, Layer, Target};
use crate::deck::{Card, DataLine, Diagnostic};
use crate::kernel::free_surface::FiniteSphere;

impl Builder<'_> {
    pub(super) fn target(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NAME") else { return };
        let front = card.value("FRONT").map_or(Some(0.0), |w| w.number(&mut self.diagnostics));
        let direction = card.value("DIRECTION").map_or(Some(-1.0), |w| w.number(&mut self.diagnostics));
        let obliquity = card.value("OBLIQUITY").map_or(Some(0.0), |w| w.number(&mut self.diagnostics));
        let (Some(front), Some(direction), Some(obliquity)) = (front, direction, obliquity) else { return };
        if obliquity.is_nan() || obliquity.abs() >= 90.0 {
            self.out_of_range(card.span, format!("OBLIQUITY lies between -90 and 90 degrees, not at {obliquity}"));
            return;
        }
        if direction.abs() != 1.0 {
            self.out_of_range(card.span, format!("DIRECTION is +1 or -1, not {direction}"));
            return;
        }
        let (Some(free_surfaces), Some(radius)) = (self.free_surfaces(card), self.positive_parameter(card, "RADIUS"))
        else {
            return;
        };
        let (Some(crater), Some(shear_strength)) =
            (self.positive_parameter(card, "CRATER"), self.positive_parameter(card, "SHEAR STRENGTH"))
        else {
            return;
        };
        if self.first_line(card).is_none() {
            return;
        }
        let radius = radius.unwrap_or(f64::INFINITY);
        let layers: Vec<Layer> = card.lines.iter().filter_map(|line| self.layer(line, radius)).collect();
        if let Some(layer) = layers.iter().rev().skip(1).find(|l| l.thickness.is_infinite()) {
            let span = layer.span;
            self.out_of_range(span, "only the last layer may be without end");
        }
        if let Some(gap) = [layers.first(), layers.last()].into_iter().flatten().find(|l| l.material.is_none()) {
            let span = gap.span;
            self.out_of_range(span, "a gap lies between two layers: the first and the last need a material");
        }
        let (Some(separation), span) = (self.separation(card), card.span) else { return };
        let name = upper(&name.text);
        self.model.targets.push(Target {
            name,
            front,
            direction,
            obliquity,
            layers,
            free_surfaces,
            crater,
            shear_strength,
            separation,
            span,
        });
    }

    fn free_surfaces(&mut self, card: &Card) -> Option<FreeSurfaces> {
        let Some(word) = card.value("FREE SURFACE") else { return Some(FreeSurfaces::Off) };
        match upper(&word.text).as_str() {
            "OFF" => Some(FreeSurfaces::Off),
            "ON" => Some(FreeSurfaces::Plates),
            "LAYERS" => Some(FreeSurfaces::Layers),
            other => {
                self.out_of_range(word.span, format!("FREE SURFACE is ON, LAYERS or OFF, not {other}"));
                None
            }
        }
    }

    fn separation(&mut self, card: &Card) -> Option<bool> {
        let Some(word) = card.value("SEPARATION") else { return Some(card.has("SEPARATION")) };
        match upper(&word.text).as_str() {
            "ON" => Some(true),
            "OFF" => Some(false),
            other => {
                self.out_of_range(word.span, format!("SEPARATION is ON or OFF, not {other}"));
                None
            }
        }
    }

    fn layer(&mut self, line: &DataLine, radius: f64) -> Option<Layer> {
        let material = match line.field(0) {
            Some(word) => Some(self.material(word)?),
            None => None,
        };
        let (thickness, radius) = (self.number_or(line, 1, f64::INFINITY)?, self.number_or(line, 2, radius)?);
        if thickness.is_nan() || thickness <= 0.0 {
            self.out_of_range(line.span, format!("a layer must be thicker than zero, not {thickness}"));
            return None;
        }
        if radius.is_nan() || radius <= 0.0 {
            self.out_of_range(line.span, format!("the radius of a layer must be above zero, not {radius}"));
            return None;
        }
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
