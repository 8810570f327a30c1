//! Cohesive elements: `*COHESIVE SECTION`, the damage of traction-separation laws, and the order of the nodes.

use std::collections::HashSet;

use super::context::Context;
use super::families::{SectionIndex, SectionReader};
use super::faults::{ValueCheck, is_non_negative, is_positive, require_line};
use super::materials;
use super::types::{
    CohesiveSection, ElementKind, InitiationMeasure, InterfaceEvolution, InterfaceInitiation, InterfaceSoftening,
    ModeDependence, ModeMixRatio, SectionControls,
};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic, Span};

/// Indices of the values of `CRITERION` in the keyword table from which on a criterion is for interfaces, is in strains,
/// and is in separations.
const TRACTIONS: usize = 2;
const STRAINS: usize = 4;
const SEPARATIONS: usize = 6;
/// Indices of the values of `SOFTENING`.
const LINEAR: usize = 0;
const TABULAR: usize = 2;
/// Indices of the values of `MIXED MODE BEHAVIOR`.
const MODE_TABLE: usize = 0;
const MODE_INDEPENDENT: usize = 1;
const POWER_LAW: usize = 2;

pub const NO_INITIATION: &str = "*DAMAGE EVOLUTION must follow a *DAMAGE INITIATION";

pub fn read_cohesive_section(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    if context.required(card, "RESPONSE").is_none() {
        return;
    }
    let Some((elements, material)) = materials::section_of(context, sections, card, ElementKind::is_cohesive) else {
        return;
    };
    let cards::CohesiveSection { geometric, values: [thickness] } = card.values();
    let named = card.value("CONTROLS").cloned();
    let section = SectionIndex::Cohesive(context.model.cohesive_sections.len());
    sections.controls_used.extend(named.map(|word| (section, word)));
    context.model.cohesive_sections.push(CohesiveSection {
        elements,
        material,
        thickness: (!geometric).then_some(thickness),
        controls: SectionControls::default(),
        span: card.span,
    });
}

/// Reads `*ELASTIC, TYPE=COUPLED TRACTION`.
pub fn coupled_traction(context: &mut Context<'_>, card: &Card) {
    let [normal, shear, _, coupling]: [f64; 4] = card.read_lines();
    if context.accepts(card, check_coupling([normal, shear], coupling)) {
        let interface = &mut context.last_material().interface;
        (interface.elastic, interface.coupling) = (Some([normal, shear]), coupling);
    }
}

/// Checks that a separation in any direction needs work. Stiffnesses out of range are reported elsewhere.
pub fn check_coupling([normal, shear]: [f64; 2], coupling: f64) -> ValueCheck {
    let is_stable = coupling * coupling < normal * shear || !(normal > 0.0 && shear > 0.0);
    let limit = (normal * shear).sqrt();
    let message = format!(
        "the coupling stiffness {coupling:e} must be less than {limit:e} in absolute value, the root of the product \
         of normal and shear stiffness"
    );
    require_line(0, is_stable, message)
}

/// Reads `*DAMAGE STABILIZATION` of a material of cohesive elements.
pub fn read_interface_stabilization(context: &mut Context<'_>, card: &Card) {
    let cards::DamageStabilization { viscosity: [viscosity] } = card.values();
    let interface = &context.last_material().interface;
    if interface.evolution.is_none() {
        if !context.missing.has_card("DAMAGE EVOLUTION") && !context.missing.has_card("DAMAGE INITIATION") {
            let message = "*DAMAGE STABILIZATION must follow the *DAMAGE EVOLUTION of cohesive elements or surfaces";
            let finding = Diagnostic::error("M105", message).at(card.span, "no such *DAMAGE EVOLUTION before");
            context.diagnostics.push(finding.help("the damage of solid elements is not delayed: remove the card"));
        }
    } else if interface.viscosity.is_some() {
        context.unsupported(card.span, "a material has one *DAMAGE STABILIZATION", "remove one of the cards");
    } else {
        context.last_material().interface.viscosity = Some((viscosity, card.span));
    }
}

/// Reads `*DAMAGE INITIATION` with a criterion of cohesive elements. Returns whether it has one.
pub fn interface_initiation(context: &mut Context<'_>, card: &Card, criterion: usize) -> bool {
    let Some(initiation) = initiation_of(card, criterion) else { return false };
    if initiation.measure == InitiationMeasure::Separation {
        let message = "MAXU and QUADU apply only to cohesive surfaces";
        context.unsupported(card.span, message, "give MAXE or QUADE: the separation over the constitutive thickness");
    } else if context.last_material().interface.initiation.is_some() {
        let message = "a material of cohesive elements has one *DAMAGE INITIATION";
        context.unsupported(card.span, message, "remove one of the criteria");
    } else {
        context.last_material().interface.initiation = Some(initiation);
    }
    true
}

/// Reads `*DAMAGE EVOLUTION` after a criterion of cohesive elements.
pub fn interface_evolution(context: &mut Context<'_>, card: &Card) {
    if context.last_material().interface.evolution.is_some() {
        return context.misplaced(card, NO_INITIATION, "DAMAGE INITIATION");
    }
    if let Some(softening) = softening(context, card) {
        context.last_material().interface.evolution = Some(InterfaceEvolution { softening, span: card.span });
    }
}

/// Reports parameters of `*DAMAGE EVOLUTION` that are for cohesive elements only. Returns whether there is none.
pub fn is_bulk_evolution(context: &mut Context<'_>, card: &Card) -> bool {
    let names = ["SOFTENING", "MIXED MODE BEHAVIOR", "MODE MIX RATIO", "POWER"];
    let linear = |name: &str| name == "SOFTENING" && card.value(name).is_some_and(|word| word.is("LINEAR"));
    let Some(name) = names.into_iter().find(|name| card.has(name) && !linear(name)) else { return true };
    let span = card.value(name).map_or(card.span, |word| word.span);
    let message = format!("{name} applies only to cohesive elements");
    context.unsupported(span, message, "give MAXS, QUADS, MAXE or QUADE on *DAMAGE INITIATION, or remove it");
    false
}

/// Returns the softening of `*DAMAGE EVOLUTION`. Unsupported combinations are reported.
pub fn softening(context: &mut Context<'_>, card: &Card) -> Option<InterfaceSoftening> {
    let values = &card.values::<cards::DamageEvolution>();
    check_mode_parameters(context, card, values)?;
    if values.softening == TABULAR {
        return softening_table(context, card, values);
    }
    let exponential = values.softening != LINEAR;
    let exponent = exponential && !values.energy && !is_closed(values);
    let mode = mode_dependence(context, card, values, if exponent { 2 } else { 1 })?;
    if !exponent {
        return Some(match (values.energy, exponential) {
            (false, _) => InterfaceSoftening::Displacement(mode),
            (true, false) => InterfaceSoftening::Energy(mode),
            (true, true) => InterfaceSoftening::ExponentialEnergy(mode),
        });
    }
    let rate = values.rows.first().map_or(f64::NAN, |row| row[1]);
    if !(rate > 0.0 && values.rows.iter().all(|row| row[1] == rate)) {
        let message = "SOFTENING=EXPONENTIAL with TYPE=DISPLACEMENT requires a positive exponent as second value, \
                       the same in all rows";
        return context.refuse_value(line_span(card), message);
    }
    Some(InterfaceSoftening::ExponentialDisplacement(mode, rate))
}

/// Reports combinations of parameters that have no meaning.
fn check_mode_parameters(context: &mut Context<'_>, card: &Card, values: &cards::DamageEvolution) -> Option<()> {
    let closed = is_closed(values);
    let fault = if closed && !values.energy {
        Some(("MIXED MODE BEHAVIOR", "POWER LAW and BK require TYPE=ENERGY"))
    } else if closed && values.softening == TABULAR {
        Some(("MIXED MODE BEHAVIOR", "POWER LAW and BK require SOFTENING=LINEAR or EXPONENTIAL"))
    } else if closed && values.power.is_none() {
        Some(("MIXED MODE BEHAVIOR", "POWER LAW and BK require POWER"))
    } else if !closed && values.power.is_some() {
        Some(("POWER", "POWER requires MIXED MODE BEHAVIOR=POWER LAW or BK"))
    } else if closed && values.ratio == Some(1) {
        Some(("MODE MIX RATIO", "POWER LAW and BK are laws of energies: MODE MIX RATIO must be ENERGY"))
    } else if values.ratio.is_some() && (values.mixed_mode == MODE_INDEPENDENT || values.softening == TABULAR) {
        Some(("MODE MIX RATIO", "MODE MIX RATIO requires a table over the mode mix"))
    } else {
        None
    };
    let Some((name, message)) = fault else { return Some(()) };
    let span = card.value(name).map_or(card.span, |word| word.span);
    context.refuse_value(span, message)
}

/// Returns the values at failure; `column` is that of the mode mix in tables.
fn mode_dependence(
    context: &mut Context<'_>,
    card: &Card,
    values: &cards::DamageEvolution,
    column: usize,
) -> Option<ModeDependence> {
    let first = values.rows.first().copied()?;
    if values.energy && !values.rows.iter().all(|row| row[0] > 0.0) {
        return context.refuse_value(line_span(card), "the fracture energy of an interface must be positive");
    }
    if is_closed(values) {
        let power = values.power.unwrap_or(f64::NAN);
        let energies = [first[0], first[1]];
        return Some(if values.mixed_mode == POWER_LAW {
            ModeDependence::PowerLaw(energies, power)
        } else {
            ModeDependence::BenzeggaghKenane(energies, power)
        });
    }
    let Some(ratio) = values.ratio else {
        let unused = values.softening != LINEAR && values.rows.iter().any(|row| row[column].is_finite());
        if values.rows.len() > 1 || unused {
            let message = "values that depend on the mode mix require MODE MIX RATIO";
            return context.refuse_value(line_span(card), message);
        }
        return Some(ModeDependence::Independent(first[0]));
    };
    let rows: Vec<[f64; 2]> = values.rows.iter().map(|row| [row[0], row[column]]).collect();
    let mode = ModeDependence::Table([ModeMixRatio::Energy, ModeMixRatio::Traction][ratio.min(1)], rows);
    context.accepts(card, check_mode_dependence(&mode)).then_some(mode)
}

fn softening_table(
    context: &mut Context<'_>,
    card: &Card,
    values: &cards::DamageEvolution,
) -> Option<InterfaceSoftening> {
    if values.energy {
        let span = card.value("SOFTENING").map_or(card.span, |word| word.span);
        return context.refuse_value(span, "SOFTENING=TABULAR requires TYPE=DISPLACEMENT");
    }
    let table = InterfaceSoftening::Tabular(values.rows.iter().map(|row| [row[0], row[1]]).collect());
    context.accepts(card, check_softening(&table)).then_some(table)
}

/// Checks the values at failure, and the order of a table.
fn check_mode_dependence(mode: &ModeDependence) -> ValueCheck {
    match mode {
        ModeDependence::Independent(value) => {
            require_line(0, is_non_negative(*value), format!("the value must not be negative, found {value}"))
        }
        ModeDependence::Table(_, rows) => {
            let within = rows.iter().all(|row| (0.0..=1.0).contains(&row[1]));
            let ascends = rows.windows(2).all(|pair| pair[0][1] < pair[1][1]);
            let message = "the mode mix ratios must ascend from row to row, from 0 (normal) to at most 1 (shear)";
            require_line(0, within && ascends && !rows.is_empty(), message)?;
            require_line(0, rows.iter().all(|row| is_non_negative(row[0])), "the values must not be negative")
        }
        ModeDependence::PowerLaw(energies, power) | ModeDependence::BenzeggaghKenane(energies, power) => {
            let is_valid = energies.iter().chain([power]).all(|value| is_positive(*value));
            require_line(0, is_valid, format!("energies and power must be positive, found {energies:?} and {power}"))
        }
    }
}

/// Checks the values at failure, and the order of a table.
pub fn check_softening(softening: &InterfaceSoftening) -> ValueCheck {
    match softening {
        InterfaceSoftening::Displacement(mode)
        | InterfaceSoftening::Energy(mode)
        | InterfaceSoftening::ExponentialEnergy(mode) => check_mode_dependence(mode),
        InterfaceSoftening::ExponentialDisplacement(mode, rate) => {
            check_mode_dependence(mode)?;
            require_line(0, is_positive(*rate), format!("the exponent must be positive, found {rate}"))
        }
        InterfaceSoftening::Tabular(rows) => {
            let ascends = |pair: &[[f64; 2]]| pair[0][1] < pair[1][1] && pair[0][0] <= pair[1][0];
            let is_valid = rows.len() > 1 && rows[0] == [0.0; 2] && rows.windows(2).all(ascends);
            let message = "a softening table begins with damage 0 at displacement 0; displacements must ascend, and \
                           damage must not decrease";
            require_line(0, is_valid, message)?;
            require_line(0, rows.iter().all(|row| row[0] <= 1.0), "the damage must be at most 1")
        }
    }
}

/// Reports a cohesive element whose faces are exchanged, which its zero thickness hides: the solid element at its
/// bottom face is above it, or the one at its top face below.
pub fn report_exchanged_faces(context: &mut Context<'_>) {
    let mesh = &context.model.mesh;
    if !mesh.elements.iter().any(|e| e.kind.is_cohesive()) {
        return;
    }
    let solids = mesh.elements.iter().filter(|e| e.kind.is_solid());
    let sides: HashSet<[usize; 2]> =
        solids.flat_map(|e| (0..e.nodes.len()).map(|i| [e.nodes[i], e.nodes[(i + 1) % e.nodes.len()]])).collect();
    let is_exchanged = |nodes: &[usize]| sides.contains(&[nodes[0], nodes[1]]) || sides.contains(&[nodes[2], nodes[3]]);
    let Some(element) = mesh.elements.iter().find(|e| e.kind.is_cohesive() && is_exchanged(&e.nodes)) else {
        return;
    };
    let message = format!("element {} (COHAX4) has its top face below its bottom face", element.name);
    let diagnostic = Diagnostic::error("M123", message).at(element.span, "this element");
    context.diagnostics.push(diagnostic.help(
        "the nodes 1 and 2 must be on the lower body, seen with the direction from node 1 to node 2 to the right: \
         list the nodes as 2, 1, 4, 3",
    ));
    context.missing.bodies = true;
}

/// Returns a criterion of interfaces; `None` for the criteria of solids. `criterion` is the index of the value in the
/// keyword table.
pub fn initiation_of(card: &Card, criterion: usize) -> Option<InterfaceInitiation> {
    let measure = if criterion < TRACTIONS {
        return None;
    } else if criterion < STRAINS {
        InitiationMeasure::Stress
    } else if criterion < SEPARATIONS {
        InitiationMeasure::Strain
    } else {
        InitiationMeasure::Separation
    };
    Some(InterfaceInitiation { measure, quadratic: criterion % 2 == 1, limits: card.read_lines(), span: card.span })
}

/// Returns whether the mode dependence is the power law or that of Benzeggagh and Kenane.
fn is_closed(values: &cards::DamageEvolution) -> bool {
    !matches!(values.mixed_mode, MODE_TABLE | MODE_INDEPENDENT)
}

/// Returns the position of the first data line, or of the card.
fn line_span(card: &Card) -> Span {
    card.lines.first().map_or(card.span, |line| line.span)
}
