//! `*MATERIAL` with the cards that follow it, and `*SOLID SECTION`.

use super::builder::{ModelBuilder, SectionIndex};
use super::names::upper;
use super::types::{
    CavityExpansion, Element, ElementKind, MaterialDefinition, MaterialId, PlasticityModel, RateDependence,
    SectionControls, SolidSection, ThermalExpansion,
};
use crate::deck::table::materials as cards;
use crate::deck::{Card, DataLine, Diagnostic};
use crate::kernel::levels::NestedTable;

/// Index of the value of `TYPE` of `*ELASTIC` in the keyword table.
const TRACTION: usize = 2;
const COUPLED_TRACTION: usize = 3;
/// Indices of the values of `HARDENING`, the first one also of `TYPE` of `*ELASTIC`.
const ISOTROPIC: usize = 0;
const KINEMATIC: usize = 1;
const USER: usize = 3;

impl ModelBuilder<'_> {
    pub(super) fn begin_material(&mut self, card: &Card) {
        self.in_interaction = false;
        if let Some(name) = self.required(card, "NAME") {
            let material =
                MaterialDefinition { name: upper(&name.text), span: card.span, ..MaterialDefinition::default() };
            self.model.materials.push(material);
        }
    }

    /// Reads a card of the current material; does nothing if the material has no name.
    pub(super) fn material_card(&mut self, card: &Card) {
        if self.model.materials.is_empty() {
            return;
        }
        match card.keyword.name {
            "DENSITY" => {
                let cards::Density { rows } = self.values(card);
                let material = self.last_material();
                material.density = rows.first().map(|r| r[0]);
                material.densities = if rows.iter().any(|r| r[1].is_nan()) { Vec::new() } else { rows };
            }
            "ELASTIC" => self.elastic(card),
            "EOS" => self.eos(card),
            "VISCOSITY" => {
                let cards::Viscosity { viscosity: [viscosity] } = self.values(card);
                self.last_material().viscosity = Some((viscosity, card.span));
            }
            "DETONATION POINT" => self.detonation_points(card),
            "HYPERELASTIC" => self.hyperelastic(card),
            "CRUSHABLE FOAM" => self.crushable_foam(card),
            "CRUSHABLE FOAM HARDENING" => self.foam_hardening(card),
            "DAMPING" => self.damping(card),
            "SHEAR FAILURE" => self.shear_failure(card),
            "TENSILE FAILURE" => self.tensile_failure(card),
            "DAMAGE INITIATION" => self.damage_initiation(card),
            "DAMAGE EVOLUTION" => self.damage_evolution(card),
            "DAMAGE STABILIZATION" => self.interface_stabilization(card),
            "PLASTIC" => self.plastic(card),
            "RATE DEPENDENT" => self.rate_dependent(card),
            "INELASTIC HEAT FRACTION" => {
                let cards::InelasticHeatFraction { fraction: [fraction] } = self.values(card);
                self.last_material().thermal.inelastic_heat_fraction = Some(fraction);
            }
            "SPECIFIC HEAT" => {
                let cards::SpecificHeat { rows } = self.values(card);
                self.last_material().thermal.specific_heat = Some(rows);
            }
            "CONDUCTIVITY" => {
                let cards::Conductivity { rows } = self.values(card);
                self.last_material().thermal.conductivity = Some((rows, card.span));
            }
            "EXPANSION" => {
                let cards::Expansion { zero, rows } = self.values(card);
                self.last_material().thermal.expansion = Some(ThermalExpansion { rows, zero, span: card.span });
            }
            "USER MATERIAL" => self.user_material(card),
            "USER DEFINED FIELD" => self.user_fields(card),
            "CHARACTERISTIC LENGTH" => self.characteristic_length(card),
            "DEPVAR" => self.state_variables(card),
            _ => self.cavity_expansion(card),
        }
    }

    pub(super) fn last_material(&mut self) -> &mut MaterialDefinition {
        let last = self.model.materials.len() - 1;
        &mut self.model.materials[last]
    }

    pub(super) fn first_line<'c>(&mut self, card: &'c Card) -> Option<&'c DataLine> {
        let line = card.lines.first();
        if line.is_none() {
            let message = format!("*{} requires a data line", card.keyword.name);
            self.diagnostics.push(Diagnostic::error("M107", message).at(card.span, "data line missing"));
        }
        line
    }

    fn elastic(&mut self, card: &Card) {
        let cards::Elastic { kind, fields } = self.values(card);
        match kind {
            ISOTROPIC => {}
            TRACTION => return self.last_material().interface.elastic = Some(card.read_lines()),
            COUPLED_TRACTION => return self.coupled_traction(card),
            _ => {
                let [modulus]: [f64; 1] = card.read_lines();
                return self.last_material().shear_modulus = Some(modulus);
            }
        }
        let rows: Vec<[f64; 2]> = card.read_lines();
        let stiffest = rows.into_iter().reduce(|stiffest, row| if row[0] > stiffest[0] { row } else { stiffest });
        if self.elastic_table(card, fields).is_some() {
            self.last_material().elastic = stiffest;
        }
    }

    /// Stores moduli that depend on temperature and field variables.
    fn elastic_table(&mut self, card: &Card, fields: usize) -> Option<()> {
        let rows = self.rows_over_fields(card, 2, fields)?;
        let over: Vec<&[f64]> = rows.iter().map(|r| &r[1..]).collect();
        if NestedTable::new(&over).is_none() {
            let message = "the temperatures must ascend for each value of the first \
                 field variable, and so on for further variables";
            return self.refuse_value(card.span, message);
        }
        if rows.len() > 1 {
            self.last_material().elastic_table = rows;
        }
        Some(())
    }

    fn plastic(&mut self, card: &Card) {
        let cards::Plastic { hardening, fields, extrapolates } = self.values(card);
        let extrapolates = match (extrapolates, card.value("EXTRAPOLATION")) {
            (Some(_), Some(word)) if hardening != ISOTROPIC => {
                let message = "EXTRAPOLATION requires a table with HARDENING=ISOTROPIC";
                return self.unsupported(word.span, message, "remove EXTRAPOLATION");
            }
            (extrapolates, _) => extrapolates.unwrap_or(false),
        };
        self.last_material().extrapolates = extrapolates;
        if fields > 0 {
            return self.plastic_over_fields(card, hardening != ISOTROPIC, fields);
        }
        if hardening != USER && self.first_line(card).is_none() {
            return;
        }
        match hardening {
            ISOTROPIC => {
                let rows: Vec<[f64; 3]> = card.read_lines();
                if self.plastic_strains_ascend(card, &rows) {
                    self.last_material().plastic = Some(PlasticityModel::Tabular(rows));
                }
            }
            KINEMATIC => self.kinematic(card),
            USER => self.user_hardening(card),
            _ => self.last_material().plastic = Some(PlasticityModel::JohnsonCook(card.read_lines())),
        }
    }

    /// Reads a yield stress table over plastic strain, temperature and field variables.
    fn plastic_over_fields(&mut self, card: &Card, other: bool, fields: usize) {
        if other || self.last_material().extrapolates {
            let message = "DEPENDENCIES requires HARDENING=ISOTROPIC without EXTRAPOLATION=LINEAR";
            return self.unsupported(card.span, message, "remove DEPENDENCIES");
        }
        let Some(rows) = self.rows_over_fields(card, 2, fields) else { return };
        let starts = |w: &[Vec<f64>]| w[0][2..] == w[1][2..] || w[1][1] == 0.0;
        if NestedTable::new(&rows).is_none() || rows[0][1] != 0.0 || !rows.windows(2).all(starts) {
            let message = "the plastic strains must start at 0 and ascend for each temperature, and the \
                           temperatures must ascend for each value of the first field variable, and so on";
            return self.out_of_range(card.span, message);
        }
        self.last_material().plastic = Some(PlasticityModel::OverFields(rows));
    }

    /// Returns whether plastic strains start at zero and ascend at each temperature; reports the first row that does
    /// not.
    fn plastic_strains_ascend(&mut self, card: &Card, rows: &[[f64; 3]]) -> bool {
        for (i, row) in rows.iter().enumerate() {
            let before =
                i.checked_sub(1).map(|k| rows[k]).filter(|b| b[2] == row[2] || b[2].is_nan() && row[2].is_nan());
            let message = match before {
                None if row[1] != 0.0 => format!("plastic strains must start at 0, found {}", row[1]),
                Some(before) if row[1] <= before[1] => {
                    format!("plastic strains must ascend, found {} after {}", row[1], before[1])
                }
                _ => continue,
            };
            let diagnostic =
                Diagnostic::error("M103", message).at(card.lines[i.min(card.lines.len() - 1)].span, "this row");
            self.diagnostics.push(
                diagnostic
                    .help("a row is `yield stress, plastic strain`; the first row is the yield stress at strain 0"),
            );
            return false;
        }
        true
    }

    /// Reads linear kinematic hardening: two rows per temperature define a line.
    fn kinematic(&mut self, card: &Card) {
        let rows: Vec<[f64; 3]> = card.read_lines();
        let cold = rows.iter().all(|r| r[2].is_nan());
        let (pairs, rest) = rows.as_chunks::<2>();
        let matched = pairs.iter().all(|[a, b]| cold || a[2] == b[2]) && (pairs.len() == 1 || !cold);
        if pairs.is_empty() || !rest.is_empty() || !matched {
            return self.unsupported(
                card.span,
                format!("HARDENING=KINEMATIC with {} rows is not supported", rows.len()),
                "give two rows per temperature: the yield stress at plastic strain 0, and another point of the line",
            );
        }
        let line = |[first, second]: &[[f64; 3]; 2]| {
            let slope = (second[0] - first[0]) / (second[1] - first[1]);
            let good = first[0] > 0.0 && first[1] == 0.0 && slope.is_finite() && slope >= 0.0 && second[1] > 0.0;
            good.then_some([first[0], slope, first[2]])
        };
        let lines: Option<Vec<[f64; 3]>> = pairs.iter().map(line).collect();
        match lines.filter(|l| cold || l.windows(2).all(|w| w[0][2] < w[1][2])) {
            Some(lines) => self.last_material().plastic = Some(PlasticityModel::Kinematic(lines)),
            None => {
                let message = "the first row must have plastic strain 0, the second a larger strain and a yield \
                               stress that is not smaller; temperatures must ascend";
                self.out_of_range(card.span, message);
            }
        }
    }

    fn rate_dependent(&mut self, card: &Card) {
        let cards::RateDependent { kind } = self.values(card);
        let rate = match kind {
            0 => Some(RateDependence::PowerLaw(card.read_lines())),
            1 => self.yield_ratios(card, card.read_lines()),
            _ => Some(RateDependence::JohnsonCook(card.read_lines())),
        };
        self.last_material().rate = rate;
    }

    /// Returns rows of ratio, strain rate and temperature: rates ascend at each temperature, then temperatures ascend.
    fn yield_ratios(&mut self, card: &Card, rows: Vec<[f64; 3]>) -> Option<RateDependence> {
        let cold = rows.iter().all(|r| r[2].is_nan());
        let follows = |w: &[[f64; 3]]| w[1][1] > w[0][1] && (cold || w[1][2] == w[0][2]) || w[1][2] > w[0][2];
        let complete = cold || rows.iter().all(|r| !r[2].is_nan());
        if !complete || !rows.windows(2).all(follows) {
            let message = "the strain rates must ascend at each temperature, and the temperatures must ascend";
            return self.refuse_value(card.span, message);
        }
        Some(RateDependence::YieldRatio(rows))
    }

    fn cavity_expansion(&mut self, card: &Card) {
        let values: cards::CavityExpansion = self.values(card);
        if values.derives {
            return self.derivation(card, &values);
        }
        if let Some(word) = card.value("TYPE") {
            return self.out_of_range(word.span, "TYPE is used with DERIVE only; remove it, or derive A, B and C");
        }
        if self.required(card, "YIELD").is_none() {
            return;
        }
        let (yield_stress, [a, b, c]) = (values.yield_stress.unwrap_or(f64::NAN), values.values);
        self.last_material().cavity = Some(CavityExpansion { yield_stress, a, b, c, derived: None, span: card.span });
    }

    pub(super) fn solid_section(&mut self, card: &Card) {
        let Some((elements, material)) = self.section_of(card, ElementKind::is_solid) else { return };
        let named = card.value("CONTROLS").cloned();
        self.controls_used.extend(named.map(|word| (SectionIndex::Solid(self.model.sections.len()), word)));
        let (controls, span) = (SectionControls::default(), card.span);
        self.model.sections.push(SolidSection { elements, material, controls, span });
    }

    /// Returns the elements of a section, checked for their types, and the material.
    pub(super) fn section_of(
        &mut self,
        card: &Card,
        fits: fn(ElementKind) -> bool,
    ) -> Option<(Vec<usize>, MaterialId)> {
        let (Some(set), Some(material)) = (self.required(card, "ELSET"), self.required(card, "MATERIAL")) else {
            return None;
        };
        // A section in a part may precede its material: the name is looked up in the whole deck.
        let known = self.material_places.get(&upper(&material.text)).copied();
        let elements = self.element_members(set).unwrap_or_default();
        let Some(index) = known else {
            self.unknown("M111", "material", material, |b| b.material_places.keys().cloned().collect());
            return None;
        };
        self.assign_property("section", &elements, card.span);
        let mesh = &self.model.mesh;
        if let Some(&other) = elements.iter().find(|e| !fits(mesh.elements[**e].kind)) {
            let Element { name, kind, .. } = &mesh.elements[other];
            let (kind, section) = (kind.name(), card.keyword.name);
            let message = format!("element {name} of type {kind} cannot have a *{section}");
            let help =
                "*SOLID SECTION is for CAX3, CAX4R and CAX6M, *SHELL SECTION for SAX1, *COHESIVE SECTION for COHAX4";
            return self
                .diagnostics
                .refuse(Diagnostic::error("M180", message).at(card.span, "this section").help(help));
        }
        Some((elements, MaterialId::new(index)))
    }

    /// Assigns section controls to sections; the controls may be defined after the section.
    pub(super) fn apply_controls(&mut self) {
        for (section, word) in std::mem::take(&mut self.controls_used) {
            match self.controls.get(&upper(&word.text)) {
                Some(controls) => match section {
                    SectionIndex::Solid(at) => self.model.sections[at].controls = controls.clone(),
                    SectionIndex::Cohesive(at) => self.model.cohesive_sections[at].controls = controls.clone(),
                },
                None => self.unknown("M116", "section controls", &word, |b| b.controls.keys().cloned().collect()),
            }
        }
    }
}
