//! Ranges in which the constants of materials hold (`*MATERIAL RANGE`).

use crate::model::ValidityRange;
use crate::plan::{Report, Scene};
use crate::state::EffectId;

/// Range of a quantity in the element groups of a material.
#[derive(Clone, Debug)]
pub struct PlannedRange {
    /// The quantity and its limits.
    pub range: ValidityRange,
    /// Name of the material.
    pub material: String,
    /// Element groups of the material.
    pub groups: Vec<usize>,
    /// Ledger row.
    pub row: EffectId,
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
        let planned = |range: &ValidityRange| PlannedRange {
            range: *range,
            material: material.name.clone(),
            groups: groups.clone(),
            row,
        };
        ranges.extend(material.ranges.iter().map(planned));
    }
    ranges
}
