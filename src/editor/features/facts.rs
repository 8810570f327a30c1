//! Properties of a model that hovers and hints show. They are computed by the check, for decks without errors.

use std::collections::HashMap;

use crate::deck::name_kinds::NameKind;
use crate::job::PreparedJob;
use crate::model::{AmplitudeDefinition, MaterialDefinition, Model};
use crate::overview::{DeckOverview, PartOverview};

#[derive(Debug, Default)]
pub struct DeckFacts {
    /// Descriptions of names by kind and upper-case name, `INSTANCE.NAME` for names of instances.
    descriptions: HashMap<(NameKind, String), String>,
    /// Sections and rigid bodies.
    pub parts: Vec<PartOverview>,
    /// Whether the highest frequency of the whole model is estimated, which makes increments longer.
    pub has_estimate: bool,
}

impl DeckFacts {
    /// Collects the properties of a model.
    pub fn of(model: &Model, prepared: &PreparedJob) -> DeckFacts {
        let PreparedJob { plan, state, .. } = prepared;
        let (parts, has_estimate) = (DeckOverview::of(model, plan, state).parts, state.elements.estimates().is_some());
        let mut facts = DeckFacts { parts, has_estimate, ..DeckFacts::default() };
        facts.describe_sets(model);
        for material in &model.materials {
            facts.add(NameKind::Material, &material.name, material_text(material));
        }
        for amplitude in &model.amplitudes {
            facts.add(NameKind::Amplitude, &amplitude.name, amplitude_text(&amplitude.definition));
        }
        for interaction in &model.interactions {
            let normal = if interaction.law.is_soft() { "soft contact" } else { "hard contact" };
            facts.add(NameKind::Interaction, &interaction.name, normal.into());
        }
        facts
    }

    fn describe_sets(&mut self, model: &Model) {
        for (name, set) in &model.node_sets {
            let text = format!("{}{}", counted(set.members.len(), "node"), extent(model, &set.members));
            self.add(NameKind::NodeSet, name, text);
        }
        for (name, set) in &model.element_sets {
            self.add(NameKind::ElementSet, name, counted(set.members.len(), "element"));
        }
        for (name, surface) in &model.surfaces.faces {
            self.add(
                NameKind::Surface,
                name,
                format!("element-based surface, {}", counted(surface.faces.len(), "face")),
            );
        }
        for (name, nodes) in &model.surfaces.nodes {
            self.add(NameKind::Surface, name, format!("node-based surface, {}", counted(nodes.len(), "node")));
        }
        for name in model.surfaces.analytical.keys() {
            self.add(NameKind::Surface, name, "analytical rigid surface".into());
        }
    }

    fn add(&mut self, kind: NameKind, name: &str, text: String) {
        self.descriptions.insert((kind, name.to_uppercase()), text);
    }

    /// Returns the description of a name; that of an instance if only instances have it.
    pub fn description(&self, kind: NameKind, name: &str) -> Option<&str> {
        let known = self.descriptions.get(&(kind, name.to_owned()));
        let of_instance = || {
            let ends = |full: &str| full.strip_suffix(name).is_some_and(|head| head.ends_with('.'));
            let mut matches: Vec<_> =
                self.descriptions.iter().filter(|((k, full), _)| *k == kind && ends(full)).collect();
            matches.sort_by(|a, b| a.0.1.cmp(&b.0.1));
            matches.first().map(|(_, text)| *text)
        };
        known.or_else(of_instance).map(String::as_str)
    }
}

/// Returns a number with its noun.
fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Describes the range of the coordinates of nodes.
fn extent(model: &Model, nodes: &[usize]) -> String {
    let points = nodes.iter().filter_map(|node| model.mesh.points.get(*node));
    let range = points.fold(None, |range: Option<[[f64; 2]; 2]>, point| {
        let [low, high] = range.unwrap_or([*point; 2]);
        Some([[low[0].min(point[0]), low[1].min(point[1])], [high[0].max(point[0]), high[1].max(point[1])]])
    });
    range.map_or(String::new(), |[low, high]| {
        format!("; r from {} to {}, z from {} to {}", short(low[0]), short(high[0]), short(low[1]), short(high[1]))
    })
}

/// Formats a number with four significant digits.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) {
        let digits = if size == 0.0 { 0 } else { (3 - size.log10().floor() as i32).max(0) as usize };
        let text = format!("{value:.digits$}");
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    }
    format!("{value:.3e}")
}

fn material_text(material: &MaterialDefinition) -> String {
    let mut parts = Vec::new();
    parts.extend(material.density.map(|density| format!("density {}", short(density))));
    if let Some([modulus, ratio]) = material.elastic {
        parts.push(format!("Young's modulus {}, Poisson's ratio {}", short(modulus), short(ratio)));
    }
    let present = [
        (material.hyperelastic.is_some(), "hyperelastic"),
        (material.eos.is_some(), "equation of state"),
        (material.plastic.is_some(), "plastic"),
        (material.has_strength_law(), "strength that depends on pressure, porosity or direction"),
        (material.rate.is_some(), "rate-dependent"),
        (!material.failures.is_empty(), "failure"),
        (material.cavity.is_some(), "cavity expansion"),
        (material.user.material.is_some(), "user material"),
    ];
    parts.extend(present.iter().filter(|(is_present, _)| *is_present).map(|(_, text)| (*text).to_owned()));
    parts.join("; ")
}

fn amplitude_text(definition: &AmplitudeDefinition) -> String {
    let AmplitudeDefinition::Curve { points, .. } = definition else { return "user subroutine".into() };
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return "no points".into() };
    let values = points.iter().map(|point| point[1]);
    let (low, high) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
    // Trapezoidal rule between the points.
    let integral: f64 = points.windows(2).map(|two| 0.5 * (two[0][1] + two[1][1]) * (two[1][0] - two[0][0])).sum();
    format!(
        "{}, times {} to {}, values {} to {}, integral {}",
        counted(points.len(), "point"),
        short(first[0]),
        short(last[0]),
        short(low),
        short(high),
        short(integral)
    )
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(
            [0.0, 7850.0, 0.012_345, 1.5e-7, -2.1e11].map(short),
            ["0", "7850", "0.01235", "1.500e-7", "-2.100e11"]
        );
    }
}
