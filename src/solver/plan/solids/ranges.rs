//! Ranges in which the constants of materials hold (`*MATERIAL RANGE`).

use super::solid_material::yield_stress;
use crate::kernel::hardening::{FlowStress, YieldStress};
use crate::model::{MaterialDefinition, RangedQuantity, ValidityRange};
use crate::plan::{Report, Scene};
use crate::state::EffectId;

/// Change of the flow stress per natural logarithm of the strain rate that is assumed beyond the range at least. It is the
/// median of the Johnson-Cook constants C of the ten ready materials with this law (0.001 to 0.06).
const TYPICAL_RATE_SENSITIVITY: f64 = 0.015;

/// Change of the flow stress per kelvin that is assumed beyond the range at least: one over the median difference of
/// melting and transition temperature of the ready materials with thermal softening (480 to 1580 K).
const TYPICAL_THERMAL_SENSITIVITY: f64 = 7e-4;

/// Range of a quantity in the element groups of a material.
#[derive(Clone, Debug)]
pub struct PlannedRange {
    /// The quantity and its limits.
    pub range: ValidityRange,
    /// Name of the material.
    pub material: String,
    /// Element groups of the material.
    pub groups: Vec<usize>,
    /// Flow stress of the material, for rates and temperatures; `None` if it has another law.
    pub flow_stress: Option<FlowStress>,
    /// Ledger row.
    pub row: EffectId,
}

impl PlannedRange {
    /// Returns the change of the flow stress by extrapolation, relative to the flow stress at the limit of the range; 0 within
    /// the range, and for pressure and plastic strain. `temperature` may be NaN for a law without it. Equation (6.25).
    pub fn change_of_flow_stress(&self, value: f64, plastic_strain: f64, temperature: f64) -> f64 {
        let limit = value.clamp(self.range.low, self.range.high);
        let (typical, at_limit, extrapolated) = match self.range.quantity {
            RangedQuantity::StrainRate => (
                TYPICAL_RATE_SENSITIVITY * libm::log(value / limit).abs(),
                self.flow_stress_at(plastic_strain, limit, temperature),
                self.flow_stress_at(plastic_strain, value, temperature),
            ),
            RangedQuantity::Temperature => (
                TYPICAL_THERMAL_SENSITIVITY * (value - limit).abs(),
                self.flow_stress_at(plastic_strain, 0.0, limit),
                self.flow_stress_at(plastic_strain, 0.0, value),
            ),
            RangedQuantity::Pressure | RangedQuantity::PlasticStrain => return 0.0,
        };
        let by_law = if at_limit > 0.0 { (extrapolated / at_limit - 1.0).abs() } else { 0.0 };
        by_law.max(typical)
    }

    /// Returns the flow stress by the law; 0 without one.
    fn flow_stress_at(&self, plastic_strain: f64, rate: f64, temperature: f64) -> f64 {
        self.flow_stress.as_ref().map_or(0.0, |law| law.at(plastic_strain, rate, temperature))
    }
}

/// Returns the ranges of all materials of deformable elements.
pub fn plan(scene: Scene<'_>, report: &mut Report) -> Vec<PlannedRange> {
    let mut ranges = Vec::new();
    for (index, material) in scene.model.materials.iter().enumerate().filter(|(_, m)| !m.ranges.is_empty()) {
        let regions = scene.model.material_regions().filter(|(id, _)| id.index() == index);
        let places = regions.flat_map(|(_, elements)| elements).filter_map(|e| scene.places.elements.get(e));
        let mut groups: Vec<usize> = places.map(|place| place.0).collect();
        let span = material.ranges[0].span;
        if groups.is_empty() {
            report.add_unused_card(span, "*MATERIAL RANGE", "no deformable element has the material");
            continue;
        }
        let limits = material.ranges.iter().map(|range| format!("{} {}", range.quantity.name(), range.limits()));
        let detail = format!("material {}, {}", material.name, limits.collect::<Vec<_>>().join(", "));
        let row = report.ledger_row(span, "range of constants", groups.len(), "elements", detail);
        groups.sort_unstable();
        groups.dedup();
        let flow_stress = flow_stress(material, scene, report);
        let planned = |range: &ValidityRange| PlannedRange {
            range: *range,
            material: material.name.clone(),
            groups: groups.clone(),
            flow_stress: flow_stress.clone(),
            row,
        };
        ranges.extend(material.ranges.iter().map(planned));
    }
    ranges
}

/// Returns the flow stress of a material with isotropic hardening. Errors of its tables are those of the sections.
fn flow_stress(material: &MaterialDefinition, scene: Scene<'_>, report: &Report<'_>) -> Option<FlowStress> {
    let mut errors = Report::new(scene.model, report.routines);
    yield_stress(material.plastic.as_ref()?, material, material.span, &mut errors)
}
