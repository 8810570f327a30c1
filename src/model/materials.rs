//! Materials: `*MATERIAL` and the cards below it, `*SOLID SECTION`.
//! Never here: what a material does under load.

use super::builder::Builder;
use super::names::upper;
use super::types::{
    CavityExpansion, Element, ElementKind, Expansion, Material, MaterialId, Plastic, RateDependence, SectionControls,
    SolidSection,
};
use crate::deck::table::materials as cards;
use crate::deck::{Card, DataLine, Diagnostic};
use crate::kernel::levels::NestedTable;

/// Kinds of hardening, by their place among the words of `HARDENING`.
const ISOTROPIC: usize = 0;
const KINEMATIC: usize = 1;
const USER: usize = 3;

impl Builder<'_> {
    pub(super) fn begin_material(&mut self, card: &Card) {
        if let Some(name) = self.required(card, "NAME") {
            let material = Material { name: upper(&name.text), span: card.span, ..Material::default() };
            self.model.materials.push(material);
        }
    }

    /// A card below a `*MATERIAL`; where that has no name there may be none.
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
            "DETONATION POINT" => self.detonation_points(card),
            "HYPERELASTIC" => self.hyperelastic(card),
            "CRUSHABLE FOAM" => self.crushable_foam(card),
            "CRUSHABLE FOAM HARDENING" => self.foam_hardening(card),
            "DAMPING" => self.damping(card),
            "SHEAR FAILURE" => self.shear_failure(card),
            "TENSILE FAILURE" => self.tensile_failure(card),
            "DAMAGE INITIATION" => self.damage_initiation(card),
            "DAMAGE EVOLUTION" => self.damage_evolution(card),
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
                self.last_material().thermal.expansion = Some(Expansion { rows, zero, span: card.span });
            }
            "USER MATERIAL" => self.user_material(card),
            "USER DEFINED FIELD" => self.user_fields(card),
            "CHARACTERISTIC LENGTH" => self.characteristic_length(card),
            "DEPVAR" => self.state_variables(card),
            _ => self.cavity_expansion(card),
        }
    }

    pub(super) fn last_material(&mut self) -> &mut Material {
        let last = self.model.materials.len() - 1;
        &mut self.model.materials[last]
    }

    pub(super) fn first_line<'c>(&mut self, card: &'c Card) -> Option<&'c DataLine> {
        let line = card.lines.first();
        if line.is_none() {
            let message = format!("*{} needs a data line", card.keyword.name);
            self.diagnostics.push(Diagnostic::error("M107", message).at(card.span, "no data below"));
        }
        line
    }

    fn elastic(&mut self, card: &Card) {
        let cards::Elastic { shear, fields } = self.values(card);
        if shear {
            let [modulus]: [f64; 1] = card.read_lines();
            self.last_material().shear_modulus = Some(modulus);
            return;
        }
        let rows: Vec<[f64; 2]> = card.read_lines();
        let stiffest = rows.into_iter().reduce(|stiffest, row| if row[0] > stiffest[0] { row } else { stiffest });
        if self.elastic_table(card, fields).is_some() {
            self.last_material().elastic = stiffest;
        }
    }

    /// Rows over temperature and field variables, where the moduli are not constant.
    fn elastic_table(&mut self, card: &Card, fields: usize) -> Option<()> {
        let rows = self.rows_over_fields(card, 2, fields)?;
        let over: Vec<&[f64]> = rows.iter().map(|r| &r[1..]).collect();
        if NestedTable::new(&over).is_none() {
            let message =
                "rows of moduli need temperatures that ascend, for each value of the first field variable, and so on";
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
                let message = "EXTRAPOLATION is of tables, HARDENING=ISOTROPIC";
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
                    self.last_material().plastic = Some(Plastic::Tabular(rows));
                }
            }
            KINEMATIC => self.kinematic(card),
            USER => self.user_hardening(card),
            _ => self.last_material().plastic = Some(Plastic::JohnsonCook(card.read_lines())),
        }
    }

    /// A table of the yield stress over the plastic strain, temperature and field variables.
    fn plastic_over_fields(&mut self, card: &Card, other: bool, fields: usize) {
        if other || self.last_material().extrapolates {
            let message = "DEPENDENCIES are of tables, HARDENING=ISOTROPIC without EXTRAPOLATION=LINEAR";
            return self.unsupported(card.span, message, "remove DEPENDENCIES");
        }
        let Some(rows) = self.rows_over_fields(card, 2, fields) else { return };
        let starts = |w: &[Vec<f64>]| w[0][2..] == w[1][2..] || w[1][1] == 0.0;
        if NestedTable::new(&rows).is_none() || rows[0][1] != 0.0 || !rows.windows(2).all(starts) {
            let message = "rows of the yield stress need plastic strains that begin at 0 and ascend for each temperature, \
                           temperatures that ascend for each value of the first field variable, and so on";
            return self.out_of_range(card.span, message);
        }
        self.last_material().plastic = Some(Plastic::OverFields(rows));
    }

    /// Whether plastic strains begin at zero and ascend, at each temperature; the first row that does not is told.
    fn plastic_strains_ascend(&mut self, card: &Card, rows: &[[f64; 3]]) -> bool {
        for (i, row) in rows.iter().enumerate() {
            let before =
                i.checked_sub(1).map(|k| rows[k]).filter(|b| b[2] == row[2] || b[2].is_nan() && row[2].is_nan());
            let message = match before {
                None if row[1] != 0.0 => format!("plastic strains begin at 0, not at {}", row[1]),
                Some(before) if row[1] <= before[1] => {
                    format!("plastic strains ascend: {} follows {}", row[1], before[1])
                }
                _ => continue,
            };
            let finding =
                Diagnostic::error("M103", message).at(card.lines[i.min(card.lines.len() - 1)].span, "this row");
            self.diagnostics.push(
                finding.help("a row is yield stress, plastic strain: the first gives the yield stress at strain 0"),
            );
            return false;
        }
        true
    }

    /// Linear kinematic hardening: two rows give its line, at each temperature where there are some.
    fn kinematic(&mut self, card: &Card) {
        let rows: Vec<[f64; 3]> = card.read_lines();
        let cold = rows.iter().all(|r| r[2].is_nan());
        let (pairs, rest) = rows.as_chunks::<2>();
        let matched = pairs.iter().all(|[a, b]| cold || a[2] == b[2]) && (pairs.len() == 1 || !cold);
        if pairs.is_empty() || !rest.is_empty() || !matched {
            return self.unsupported(
                card.span,
                format!("HARDENING=KINEMATIC with these {} rows is not supported", rows.len()),
                "give two rows, at each temperature: the yield stress without plastic strain, and another point of the line",
            );
        }
        let line = |[first, second]: &[[f64; 3]; 2]| {
            let slope = (second[0] - first[0]) / (second[1] - first[1]);
            let good = first[0] > 0.0 && first[1] == 0.0 && slope.is_finite() && slope >= 0.0 && second[1] > 0.0;
            good.then_some([first[0], slope, first[2]])
        };
        let lines: Option<Vec<[f64; 3]>> = pairs.iter().map(line).collect();
        match lines.filter(|l| cold || l.windows(2).all(|w| w[0][2] < w[1][2])) {
            Some(lines) => self.last_material().plastic = Some(Plastic::Kinematic(lines)),
            None => {
                let message = "the first row gives the yield stress at no plastic strain, the second one that is not below it \
                               at more; temperatures ascend";
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

    /// Rows of ratio, rate and temperature: rates ascend at each temperature, and temperatures from block to block.
    fn yield_ratios(&mut self, card: &Card, rows: Vec<[f64; 3]>) -> Option<RateDependence> {
        let cold = rows.iter().all(|r| r[2].is_nan());
        let follows = |w: &[[f64; 3]]| w[1][1] > w[0][1] && (cold || w[1][2] == w[0][2]) || w[1][2] > w[0][2];
        let complete = cold || rows.iter().all(|r| !r[2].is_nan());
        if !complete || !rows.windows(2).all(follows) {
            let message = "rows of a yield stress ratio ascend in rate, at each temperature, and then in temperature";
            return self.refuse_value(card.span, message);
        }
        Some(RateDependence::YieldRatio(rows))
    }

    fn cavity_expansion(&mut self, card: &Card) {
        let values: cards::CavityExpansion = self.values(card);
        if values.derives {
            return self.derivation(card, &values);
        }
        if self.required(card, "YIELD").is_none() {
            return;
        }
        let (yield_stress, [a, b, c]) = (values.yield_stress.unwrap_or(f64::NAN), values.values);
        self.last_material().cavity = Some(CavityExpansion { yield_stress, a, b, c, derived: None, span: card.span });
    }

    pub(super) fn solid_section(&mut self, card: &Card) {
        let Some((elements, material)) = self.section_of(card, |kind| kind != ElementKind::Sax1) else { return };
        let named = card.value("CONTROLS").cloned();
        self.controls_used.extend(named.map(|word| (self.model.sections.len(), word)));
        let (controls, span) = (SectionControls::default(), card.span);
        self.model.sections.push(SolidSection { elements, material, controls, span });
    }

    /// Elements of a section, which are of certain kinds, and the index of its material.
    pub(super) fn section_of(
        &mut self,
        card: &Card,
        fits: fn(ElementKind) -> bool,
    ) -> Option<(Vec<usize>, MaterialId)> {
        let (Some(set), Some(material)) = (self.required(card, "ELSET"), self.required(card, "MATERIAL")) else {
            return None;
        };
        // In a part the material follows later in the deck: it is looked up by name in the whole deck.
        let known = self.material_places.get(&upper(&material.text)).copied();
        let elements = self.element_members(set).unwrap_or_default();
        let Some(index) = known else {
            self.unknown("M111", "material", material, |b| b.material_places.keys().cloned().collect());
            return None;
        };
        self.claim("section", &elements, card.span);
        let mesh = &self.model.mesh;
        if let Some(&other) = elements.iter().find(|e| !fits(mesh.elements[**e].kind)) {
            let Element { name, kind, .. } = &mesh.elements[other];
            let (kind, section) = (kind.name(), card.keyword.name);
            let message = format!("element {name} is a {kind}, which no *{section} is for");
            let help = "*SOLID SECTION is of CAX3, CAX4R and CAX6M, *SHELL SECTION of SAX1";
            return self
                .diagnostics
                .refuse(Diagnostic::error("M180", message).at(card.span, "this section").help(help));
        }
        Some((elements, MaterialId::new(index)))
    }

    /// Gives sections their controls, which may stand behind them in the deck.
    pub(super) fn apply_controls(&mut self) {
        for (section, word) in std::mem::take(&mut self.controls_used) {
            match self.controls.get(&upper(&word.text)) {
                Some(controls) => self.model.sections[section].controls = controls.clone(),
                None => self.unknown("M116", "section controls", &word, |b| b.controls.keys().cloned().collect()),
            }
        }
    }
}
