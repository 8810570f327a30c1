//! Materials: `*MATERIAL` and the cards below it, `*SOLID SECTION`.
//! Never here: what a material does under load.

use super::builder::Builder;
use super::names::upper;
use super::types::{
    CavityExpansion, Element, ElementKind, Expansion, Material, MaterialId, Plastic, RateDependence, SectionControls,
    SolidSection,
};
use crate::deck::{Card, DataLine, Diagnostic};
use crate::kernel::levels::NestedTable;

impl Builder<'_> {
    pub(super) fn material_card(&mut self, card: &Card) {
        if card.keyword.name == "MATERIAL" {
            if let Some(name) = self.required(card, "NAME") {
                let material = Material { name: upper(&name.text), span: card.span, ..Material::default() };
                self.model.materials.push(material);
            }
            return;
        }
        if self.model.materials.is_empty() {
            let message = format!("*{} belongs below a *MATERIAL", card.keyword.name);
            self.diagnostics.push(Diagnostic::error("M105", message).at(card.span, "no material above"));
            return;
        }
        match card.keyword.name {
            "DENSITY" => {
                let rows = self.over_temperature(card, "the density").unwrap_or_default();
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
                let fraction = card.lines.first().map_or(Some(0.9), |l| self.number_or(l, 0, 0.9));
                self.last_material().thermal.inelastic_heat_fraction = fraction;
            }
            "SPECIFIC HEAT" => {
                let rows = self.over_temperature(card, "the specific heat");
                self.last_material().thermal.specific_heat = rows;
            }
            "CONDUCTIVITY" => {
                let rows = self.over_temperature(card, "the conductivity");
                self.last_material().thermal.conductivity = rows.map(|rows| (rows, card.span));
            }
            "EXPANSION" => self.expansion(card),
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

    pub(super) fn positive(&mut self, card: &Card, what: &str) -> Option<f64> {
        let line = self.first_line(card)?;
        let value = self.number(line, 0, what)?;
        if value > 0.0 {
            return Some(value);
        }
        self.out_of_range(line.span, format!("{what} must be above zero, not {value}"));
        None
    }

    /// Rows of a value above zero and its temperature (NaN where the only row has none), ascending.
    fn over_temperature(&mut self, card: &Card, what: &str) -> Option<Vec<[f64; 2]>> {
        self.first_line(card)?;
        let mut rows = Vec::with_capacity(card.lines.len());
        for line in &card.lines {
            let row = [self.number(line, 0, what)?, self.number_or(line, 1, f64::NAN)?];
            if row[0] <= 0.0 {
                self.out_of_range(line.span, format!("{what} must be above zero, not {}", row[0]));
                return None;
            }
            rows.push(row);
        }
        if rows.len() > 1 && !rows.windows(2).all(|w| w[1][1] > w[0][1]) {
            self.out_of_range(card.span, format!("rows of {what} need temperatures that ascend"));
            return None;
        }
        Some(rows)
    }

    fn elastic(&mut self, card: &Card) {
        let kind = card.value("TYPE").map_or("ISOTROPIC".into(), |w| upper(&w.text));
        if kind != "SHEAR" && !kind.starts_with("ISO") {
            self.unsupported(card.span, format!("TYPE={kind} is not supported"), "ISOTROPIC and SHEAR are");
            return;
        }
        if kind == "SHEAR" {
            let shear = self.positive(card, "the shear modulus");
            self.last_material().shear_modulus = shear;
            return;
        }
        let mut stiffest: Option<[f64; 2]> = None;
        for line in &card.lines {
            let Some(row) = self.moduli(line) else { return };
            stiffest = Some(stiffest.filter(|s| s[0] >= row[0]).unwrap_or(row));
        }
        if self.first_line(card).is_some() && self.elastic_table(card).is_some() {
            self.last_material().elastic = stiffest;
        }
    }

    /// Rows over temperature and field variables, where the moduli are not constant.
    fn elastic_table(&mut self, card: &Card) -> Option<()> {
        let fields = self.dependencies(card)?;
        let rows = self.rows_over_fields(card, 2, fields)?;
        let over: Vec<&[f64]> = rows.iter().map(|r| &r[1..]).collect();
        if NestedTable::new(&over).is_none() {
            let message =
                "rows of moduli need temperatures that ascend, for each value of the first field variable, and so on";
            self.out_of_range(card.span, message);
            return None;
        }
        if rows.len() > 1 {
            self.last_material().elastic_table = rows;
        }
        Some(())
    }

    /// Young's modulus and Poisson's ratio of a line.
    fn moduli(&mut self, line: &DataLine) -> Option<[f64; 2]> {
        let (e, nu) = (self.number(line, 0, "Young's modulus")?, self.number_or(line, 1, 0.0)?);
        if e <= 0.0 {
            self.out_of_range(line.fields[0].span, format!("Young's modulus must be above zero, not {e}"));
            return None;
        }
        if nu <= -1.0 || nu >= 0.5 {
            let message = format!("Poisson's ratio must lie between -1 and 0.5, not be {nu}");
            let finding =
                Diagnostic::error("M103", message).at(line.fields.get(1).map_or(line.span, |w| w.span), "here");
            let help = "what keeps its volume has no stable increment: give 0.49 or less";
            self.diagnostics.push(if nu >= 0.5 { finding.help(help) } else { finding });
            return None;
        }
        Some([e, nu])
    }

    fn plastic(&mut self, card: &Card) {
        let hardening = card.value("HARDENING").map_or("ISOTROPIC".into(), |w| upper(&w.text).replace(' ', ""));
        let Some(extrapolates) = self.extrapolation(card, &hardening) else { return };
        self.last_material().extrapolates = extrapolates;
        let Some(fields) = self.dependencies(card) else { return };
        if fields > 0 {
            self.plastic_over_fields(card, (&hardening, extrapolates), fields);
            return;
        }
        match hardening.as_str() {
            "JOHNSONCOOK" => {
                let Some(line) = self.first_line(card) else { return };
                if let Some(values) = self.numbers::<6>(line, &[0.0; 6]) {
                    self.last_material().plastic = Some(Plastic::JohnsonCook(values));
                }
            }
            "ISOTROPIC" => {
                let rows =
                    card.lines.iter().filter_map(|l| self.numbers::<3>(l, &[0.0, 0.0, f64::NAN])).collect::<Vec<_>>();
                if self.first_line(card).is_some() && self.plastic_strains_ascend(card, &rows) {
                    self.last_material().plastic = Some(Plastic::Tabular(rows));
                }
            }
            "KINEMATIC" => self.kinematic(card),
            "USER" => self.user_hardening(card),
            other => self.unsupported(
                card.span,
                format!("HARDENING={other} is not supported"),
                "ISOTROPIC, KINEMATIC, JOHNSON COOK and USER are",
            ),
        }
    }

    /// A table of the yield stress over the plastic strain, temperature and field variables.
    fn plastic_over_fields(&mut self, card: &Card, (hardening, extrapolates): (&str, bool), fields: usize) {
        if hardening != "ISOTROPIC" || extrapolates {
            let with = if extrapolates { "EXTRAPOLATION=LINEAR".into() } else { format!("HARDENING={hardening}") };
            let message = format!("DEPENDENCIES with {with} is not supported");
            self.unsupported(card.span, message, "tables of HARDENING=ISOTROPIC depend on field variables");
            return;
        }
        let Some(rows) = self.rows_over_fields(card, 2, fields) else { return };
        let starts = |w: &[Vec<f64>]| w[0][2..] == w[1][2..] || w[1][1] == 0.0;
        if NestedTable::new(&rows).is_none() || rows[0][1] != 0.0 || !rows.windows(2).all(starts) {
            let message = "rows of the yield stress need plastic strains that begin at 0 and ascend for each temperature, \
                           temperatures that ascend for each value of the first field variable, and so on";
            self.out_of_range(card.span, message);
            return;
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

    /// Whether EXTRAPOLATION is LINEAR: of the yield stress over the plastic strain; over temperature and rate it is constant
    /// all the same (ABAQUS Keywords Reference Guide, *PLASTIC).
    fn extrapolation(&mut self, card: &Card, hardening: &str) -> Option<bool> {
        let word = match card.value("EXTRAPOLATION") {
            None => return Some(false),
            Some(word) if hardening == "ISOTROPIC" => word,
            Some(word) => {
                let message = format!("EXTRAPOLATION with HARDENING={hardening} is not supported");
                self.unsupported(word.span, message, "it is of tables, HARDENING=ISOTROPIC");
                return None;
            }
        };
        match word {
            word if word.is("CONSTANT") => Some(false),
            word if word.is("LINEAR") => Some(true),
            word => {
                self.out_of_range(word.span, format!("EXTRAPOLATION is CONSTANT or LINEAR, not {}", word.text));
                None
            }
        }
    }

    /// Linear kinematic hardening: two rows give its line, at each temperature where there are some.
    fn kinematic(&mut self, card: &Card) {
        let rows: Vec<[f64; 3]> =
            card.lines.iter().filter_map(|l| self.numbers::<3>(l, &[0.0, 0.0, f64::NAN])).collect();
        let cold = rows.iter().all(|r| r[2].is_nan());
        let (pairs, rest) = rows.as_chunks::<2>();
        let matched = pairs.iter().all(|[a, b]| cold || a[2] == b[2]) && (pairs.len() == 1 || !cold);
        if pairs.is_empty() || !rest.is_empty() || !matched {
            self.unsupported(
                card.span,
                format!("HARDENING=KINEMATIC with these {} rows is not supported", rows.len()),
                "give two rows, at each temperature: the yield stress without plastic strain, and another point of the line",
            );
            return;
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

    pub(super) fn numbers<const N: usize>(&mut self, line: &DataLine, defaults: &[f64; N]) -> Option<[f64; N]> {
        let mut values = *defaults;
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.number_or(line, i, *value)?;
        }
        Some(values)
    }

    fn rate_dependent(&mut self, card: &Card) {
        let kind = card.value("TYPE").map_or("POWERLAW".into(), |w| upper(&w.text).replace(' ', ""));
        if self.first_line(card).is_none() {
            return;
        }
        let defaults = [0.0, 1.0, f64::NAN];
        let rows: Vec<[f64; 3]> = card.lines.iter().filter_map(|l| self.numbers::<3>(l, &defaults)).collect();
        let rate = match kind.as_str() {
            "JOHNSONCOOK" => {
                self.first_line(card).zip(rows.first()).map(|(_, r)| RateDependence::JohnsonCook([r[0], r[1]]))
            }
            "POWERLAW" => self.power_law(card, rows),
            "YIELDRATIO" => self.yield_ratios(card, rows),
            other => {
                self.unsupported(
                    card.span,
                    format!("TYPE={other} is not supported"),
                    "JOHNSON COOK, POWER LAW and YIELD RATIO are",
                );
                None
            }
        };
        self.last_material().rate = rate;
    }

    /// Rows of D, n and temperature: one, or more at ascending temperatures.
    fn power_law(&mut self, card: &Card, rows: Vec<[f64; 3]>) -> Option<RateDependence> {
        let good = rows.iter().all(|r| r[0] > 0.0 && r[1] > 0.0);
        if !good || rows.len() > 1 && !rows.windows(2).all(|w| w[1][2] > w[0][2]) {
            let message = "rows give D and n above zero, and temperatures that ascend where there is more than one row";
            self.out_of_range(card.span, message);
            return None;
        }
        Some(RateDependence::PowerLaw(rows))
    }

    /// Rows of ratio, rate and temperature: rates ascend at each temperature, and temperatures from block to block.
    fn yield_ratios(&mut self, card: &Card, rows: Vec<[f64; 3]>) -> Option<RateDependence> {
        let cold = rows.iter().all(|r| r[2].is_nan());
        let follows = |w: &[[f64; 3]]| w[1][1] > w[0][1] && (cold || w[1][2] == w[0][2]) || w[1][2] > w[0][2];
        let complete = cold || rows.iter().all(|r| !r[2].is_nan());
        if !complete || !rows.windows(2).all(follows) {
            let message = "rows of a yield stress ratio ascend in rate, at each temperature, and then in temperature";
            self.out_of_range(card.span, message);
            return None;
        }
        Some(RateDependence::YieldRatio(rows))
    }

    fn cavity_expansion(&mut self, card: &Card) {
        if card.has("DERIVE") {
            return self.derivation(card);
        }
        let Some(yield_word) = self.required(card, "YIELD") else { return };
        let Some(yield_stress) = yield_word.number(&mut self.diagnostics) else { return };
        let Some(line) = self.first_line(card) else { return };
        let (Some(a), Some(b), Some(c)) =
            (self.number(line, 0, "A"), self.number(line, 1, "B"), self.number(line, 2, "C"))
        else {
            return;
        };
        if yield_stress <= 0.0 || a < 0.0 || b < 0.0 || c < 0.0 {
            self.out_of_range(line.span, "a resistance needs YIELD above zero and A, B, C not below zero");
            return;
        }
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
            let help = "*SOLID SECTION is of CAX3 and CAX4R, *SHELL SECTION of SAX1";
            self.diagnostics.push(Diagnostic::error("M180", message).at(card.span, "this section").help(help));
            return None;
        }
        Some((elements, MaterialId::new(index)))
    }

    /// `*EXPANSION`: coefficients of any sign, over temperature.
    fn expansion(&mut self, card: &Card) {
        let zero = card.value("ZERO").map_or(Some(0.0), |w| w.number(&mut self.diagnostics));
        if self.first_line(card).is_none() {
            return;
        }
        let rows: Option<Vec<[f64; 2]>> = card.lines.iter().map(|l| self.numbers::<2>(l, &[0.0, f64::NAN])).collect();
        let (Some(zero), Some(rows)) = (zero, rows) else { return };
        if rows.len() > 1 && !rows.windows(2).all(|w| w[1][1] > w[0][1]) {
            self.out_of_range(card.span, "rows of the expansion need temperatures that ascend");
            return;
        }
        self.last_material().thermal.expansion = Some(Expansion { rows, zero, span: card.span });
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
