//! `*MATERIAL` with the cards that follow it, and `*SOLID SECTION`.

use super::context::Context;
use super::families::{MaterialReader, SectionIndex, SectionReader};
use super::faults::{ValueCheck, ValueFault, is_non_negative, is_positive, require};
use super::names::upper;
use super::types::{
    CavityExpansion, Element, ElementKind, InfiniteSection, MaterialDefinition, MaterialId, PlasticityModel,
    RateDependence, SectionControls, SolidSection,
};
use super::{cohesive, derive, fields, orientations, user_material};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic, Word};
use crate::kernel::laminate::Lamina;
use crate::kernel::levels::NestedTable;

/// Index of the value of `TYPE` of `*ELASTIC` in the keyword table.
const TRACTION: usize = 2;
const COUPLED_TRACTION: usize = 3;
const LAMINA: usize = 4;
/// Indices of the values of `HARDENING`, the first one also of `TYPE` of `*ELASTIC`.
const ISOTROPIC: usize = 0;
const KINEMATIC: usize = 1;
const USER: usize = 3;

pub fn read_material(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    materials.in_interaction = false;
    if let Some(name) = context.required(card, "NAME") {
        let material = MaterialDefinition { name: upper(&name.text), span: card.span, ..MaterialDefinition::default() };
        context.model.materials.push(material);
    }
}

pub fn read_density(context: &mut Context<'_>, card: &Card) {
    let cards::Density { rows } = card.values();
    let material = context.last_material();
    material.density = rows.first().map(|r| r[0]);
    material.densities = if rows.iter().any(|r| r[1].is_nan()) { Vec::new() } else { rows };
}

pub fn read_elastic(context: &mut Context<'_>, card: &Card) {
    let cards::Elastic { kind, fields } = card.values();
    match kind {
        ISOTROPIC => {}
        TRACTION => return context.last_material().interface.elastic = Some(card.read_lines()),
        COUPLED_TRACTION => return cohesive::coupled_traction(context, card),
        LAMINA => {
            let [e1, e2, ratio, g12, g13, g23]: [f64; 6] = card.read_lines();
            let lamina = Lamina { young: [e1, e2], ratio, shear: [g12, g13, g23] };
            let accepted = context.accepts(card, check_lamina(&lamina));
            return context.last_material().lamina = accepted.then_some(lamina);
        }
        _ => {
            let [modulus]: [f64; 1] = card.read_lines();
            return context.last_material().shear_modulus = Some(modulus);
        }
    }
    let rows: Vec<[f64; 2]> = card.read_lines();
    let stiffest = rows.into_iter().reduce(|stiffest, row| if row[0] > stiffest[0] { row } else { stiffest });
    if elastic_table(context, card, fields).is_some() {
        context.last_material().elastic = stiffest;
    }
}

/// Stores moduli that depend on temperature and field variables.
fn elastic_table(context: &mut Context<'_>, card: &Card, fields: usize) -> Option<()> {
    let rows = fields::rows_over_fields(context, card, 2, fields)?;
    if !context.accepts(card, check_elastic_table(&rows)) {
        return None;
    }
    if rows.len() > 1 {
        context.last_material().elastic_table = rows;
    }
    Some(())
}

/// Checks that the strain energy of a lamina is positive.
pub fn check_lamina(lamina: &Lamina) -> ValueCheck {
    let bound = (lamina.young[0] / lamina.young[1]).sqrt();
    let message =
        format!("the absolute value of nu12 must be less than the root of E1/E2, {bound}, found {}", lamina.ratio);
    require(lamina.is_stable(), message)
}

/// Checks rows of moduli over temperature and field variables.
pub fn check_elastic_table(rows: &[Vec<f64>]) -> ValueCheck {
    let over: Vec<&[f64]> = rows.iter().map(|r| r.get(1..).unwrap_or_default()).collect();
    let message = "the temperatures must ascend for each value of the first \
                   field variable, and so on for further variables";
    require(rows.is_empty() || NestedTable::new(&over).is_some(), message)
}

pub fn read_plastic(context: &mut Context<'_>, card: &Card) {
    let cards::Plastic { hardening, fields, extrapolates } = card.values();
    let extrapolates = match (extrapolates, card.value("EXTRAPOLATION")) {
        (Some(_), Some(word)) if hardening != ISOTROPIC => {
            let message = "EXTRAPOLATION requires a table with HARDENING=ISOTROPIC";
            return context.unsupported(word.span, message, "remove EXTRAPOLATION");
        }
        (extrapolates, _) => extrapolates.unwrap_or(false),
    };
    context.last_material().extrapolates = extrapolates;
    if fields > 0 {
        return plastic_over_fields(context, card, hardening != ISOTROPIC, fields);
    }
    if hardening != USER && context.first_line(card).is_none() {
        return;
    }
    match hardening {
        ISOTROPIC => {
            let table = PlasticityModel::Tabular(card.read_lines());
            if context.accepts(card, table.check()) {
                context.last_material().plastic = Some(table);
            }
        }
        KINEMATIC => kinematic(context, card),
        USER => user_material::user_hardening(context, card),
        _ => context.last_material().plastic = Some(PlasticityModel::JohnsonCook(card.read_lines())),
    }
}

/// Reads a yield stress table over plastic strain, temperature and field variables.
fn plastic_over_fields(context: &mut Context<'_>, card: &Card, other: bool, fields: usize) {
    if other || context.last_material().extrapolates {
        let message = "DEPENDENCIES requires HARDENING=ISOTROPIC without EXTRAPOLATION=LINEAR";
        return context.unsupported(card.span, message, "remove DEPENDENCIES");
    }
    let Some(rows) = fields::rows_over_fields(context, card, 2, fields) else { return };
    let table = PlasticityModel::OverFields(rows);
    if context.accepts(card, table.check()) {
        context.last_material().plastic = Some(table);
    }
}

impl PlasticityModel {
    /// Checks the order of tables, and values that no range of the keyword table limits.
    pub fn check(&self) -> ValueCheck {
        let is_finite = |values: &[f64]| require(values.iter().all(|v| v.is_finite()), "the constants must be finite");
        match self {
            PlasticityModel::JohnsonCook(values) => is_finite(values),
            PlasticityModel::User(constants) => is_finite(constants),
            PlasticityModel::Tabular(rows) => check_plastic_strains(rows),
            PlasticityModel::OverFields(rows) => {
                let is_table = rows.iter().all(|r| r.len() > 2) && NestedTable::new(rows).is_some();
                let starts = |w: &[Vec<f64>]| w[0][2..] == w[1][2..] || w[1][1] == 0.0;
                let message = "the plastic strains must start at 0 and ascend for each temperature, and the \
                               temperatures must ascend for each value of the first field variable, and so on";
                require(is_table && rows[0][1] == 0.0 && rows.windows(2).all(starts), message)
            }
            PlasticityModel::Kinematic(lines) => {
                let hardens = lines.iter().all(|line| is_positive(line[0]) && is_non_negative(line[1]));
                let message =
                    "the yield stresses must be positive and their slopes not negative; temperatures must ascend";
                require(hardens && !lines.is_empty() && lines.windows(2).all(|w| w[0][2] < w[1][2]), message)
            }
        }
    }
}

/// Checks that plastic strains start at zero and ascend at each temperature.
fn check_plastic_strains(rows: &[[f64; 3]]) -> ValueCheck {
    for (line, row) in rows.iter().enumerate() {
        let previous =
            line.checked_sub(1).map(|k| rows[k]).filter(|b| b[2] == row[2] || b[2].is_nan() && row[2].is_nan());
        let message = match previous {
            None if row[1] != 0.0 => format!("plastic strains must start at 0, found {}", row[1]),
            Some(previous) if row[1] <= previous[1] => {
                format!("plastic strains must ascend, found {} after {}", row[1], previous[1])
            }
            _ if !(row[0].is_finite() && row[1].is_finite()) => {
                format!("yield stress and plastic strain must be finite, found {} and {}", row[0], row[1])
            }
            _ => continue,
        };
        let help = "a row is `yield stress, plastic strain`; the first row is the yield stress at strain 0";
        return Err(ValueFault { line: Some(line), message, label: "this row", help });
    }
    Ok(())
}

/// Reads linear kinematic hardening: two rows per temperature define a line.
fn kinematic(context: &mut Context<'_>, card: &Card) {
    let rows: Vec<[f64; 3]> = card.read_lines();
    let cold = rows.iter().all(|r| r[2].is_nan());
    let (pairs, unpaired) = rows.as_chunks::<2>();
    let matched = pairs.iter().all(|[a, b]| cold || a[2] == b[2]) && (pairs.len() == 1 || !cold);
    if pairs.is_empty() || !unpaired.is_empty() || !matched {
        let help = "give two rows per temperature: the yield stress at plastic strain 0, and another point of the line";
        let message = format!("HARDENING=KINEMATIC with {} rows is not supported", rows.len());
        return context.unsupported(card.span, message, help);
    }
    let line = |[first, second]: &[[f64; 3]; 2]| {
        let slope = (second[0] - first[0]) / (second[1] - first[1]);
        let is_valid = first[0] > 0.0 && first[1] == 0.0 && slope.is_finite() && slope >= 0.0 && second[1] > 0.0;
        is_valid.then_some([first[0], slope, first[2]])
    };
    let lines: Option<Vec<[f64; 3]>> = pairs.iter().map(line).collect();
    match lines.filter(|l| cold || l.windows(2).all(|w| w[0][2] < w[1][2])) {
        Some(lines) => context.last_material().plastic = Some(PlasticityModel::Kinematic(lines)),
        None => {
            let message = "the first row must have plastic strain 0, the second a larger strain and a yield \
                           stress that is not smaller; temperatures must ascend";
            context.out_of_range(card.span, message);
        }
    }
}

pub fn read_rate_dependent(context: &mut Context<'_>, card: &Card) {
    let cards::RateDependent { kind } = card.values();
    let rate = match kind {
        0 => RateDependence::PowerLaw(card.read_lines()),
        1 => RateDependence::YieldRatio(card.read_lines()),
        _ => RateDependence::JohnsonCook(card.read_lines()),
    };
    context.last_material().rate = context.accepts(card, rate.check()).then_some(rate);
}

impl RateDependence {
    /// Checks rows of ratio, strain rate and temperature: rates ascend at each temperature, then temperatures ascend.
    pub fn check(&self) -> ValueCheck {
        let RateDependence::YieldRatio(rows) = self else { return Ok(()) };
        let cold = rows.iter().all(|r| r[2].is_nan());
        let follows = |w: &[[f64; 3]]| w[1][1] > w[0][1] && (cold || w[1][2] == w[0][2]) || w[1][2] > w[0][2];
        let complete = cold || rows.iter().all(|r| !r[2].is_nan());
        let message = "the strain rates must ascend at each temperature, and the temperatures must ascend";
        require(complete && rows.windows(2).all(follows), message)
    }
}

pub fn read_cavity_expansion(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    let values: cards::CavityExpansion = card.values();
    if values.derives {
        return derive::derivation(context, materials, card);
    }
    if let Some(word) = card.value("TYPE") {
        return context.out_of_range(word.span, "TYPE is used with DERIVE only; remove it, or derive A, B and C");
    }
    if context.required(card, "YIELD").is_none() {
        return;
    }
    let (yield_stress, [a, b, c]) = (values.yield_stress.unwrap_or(f64::NAN), values.values);
    context.last_material().cavity = Some(CavityExpansion { yield_stress, a, b, c, derived: None, span: card.span });
}

pub fn read_solid_section(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    let fits = |kind: ElementKind| kind.is_solid() || kind == ElementKind::Cinax4;
    let Some((elements, material)) = section_of(context, sections, card, fits) else { return };
    let is_infinite = |e: &usize| context.model.mesh.elements[*e].kind == ElementKind::Cinax4;
    let (infinite, elements): (Vec<usize>, Vec<usize>) = elements.into_iter().partition(is_infinite);
    if !infinite.is_empty() {
        context.model.discrete.infinite.push(InfiniteSection { elements: infinite, material, span: card.span });
        if elements.is_empty() {
            return;
        }
    }
    let named = card.value("CONTROLS").cloned();
    sections.controls_used.extend(named.map(|word| (SectionIndex::Solid(context.model.sections.len()), word)));
    let Some(fibres) = orientations::section_fibres(context, card) else { return };
    let (controls, span) = (SectionControls::default(), card.span);
    context.model.sections.push(SolidSection { elements, material, controls, fibres, span });
}

/// Returns the elements of a section, checked for their types, and the material.
pub fn section_of(
    context: &mut Context<'_>,
    sections: &mut SectionReader,
    card: &Card,
    fits: fn(ElementKind) -> bool,
) -> Option<(Vec<usize>, MaterialId)> {
    let word = context.required(card, "MATERIAL")?;
    let material = material_named(context, word)?;
    Some((elements_of_section(context, sections, card, fits)?, material))
}

/// Returns the material with a name. A section in a part may precede its material: the name is looked up in the whole deck.
pub fn material_named(context: &mut Context<'_>, word: &Word) -> Option<MaterialId> {
    let known = context.names.materials.get(&upper(&word.text)).copied();
    if known.is_none() {
        context.unknown("M111", "material", word, |b| b.names.materials.keys().cloned().collect());
    }
    known.map(MaterialId::new)
}

/// Returns the elements of a section, checked for their types.
pub fn elements_of_section(
    context: &mut Context<'_>,
    sections: &mut SectionReader,
    card: &Card,
    fits: fn(ElementKind) -> bool,
) -> Option<Vec<usize>> {
    let set = context.required(card, "ELSET")?;
    let elements = context.element_members(set).unwrap_or_default();
    sections.assign_property(context, "section", &elements, card.span);
    let mesh = &context.model.mesh;
    if let Some(&other) = elements.iter().find(|e| !fits(mesh.elements[**e].kind)) {
        let Element { name, kind, .. } = &mesh.elements[other];
        let (kind, section) = (kind.name(), card.keyword.name);
        let message = format!("element {name} of type {kind} cannot have a *{section}");
        let help = "*SOLID SECTION is for CAX3, CAX4R, CAX6M and CINAX4, *SHELL SECTION for SAX1, *COHESIVE SECTION for COHAX4";
        return context.diagnostics.refuse(Diagnostic::error("M180", message).at(card.span, "this section").help(help));
    }
    Some(elements)
}

/// Assigns section controls to sections; the controls may be defined after the section.
pub fn apply_controls(context: &mut Context<'_>, sections: &mut SectionReader) {
    for (section, word) in std::mem::take(&mut sections.controls_used) {
        match sections.controls.get(&upper(&word.text)) {
            Some(controls) => match section {
                SectionIndex::Solid(at) => context.model.sections[at].controls = controls.clone(),
                SectionIndex::Cohesive(at) => context.model.cohesive_sections[at].controls = controls.clone(),
            },
            None => context.unknown("M116", "section controls", &word, |_| sections.controls.keys().cloned().collect()),
        }
    }
}
