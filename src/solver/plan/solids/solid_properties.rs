//! What the selection of the law of a solid section depends on, and the rate factors that several laws have.

use crate::deck::Span;
use crate::element::constants::ElementConstants;
use crate::element::solid_groups::Connectivity;
use crate::kernel::shape::quad_area;
use crate::material::returns::characteristic_length;
use crate::model::MaterialDefinition;
use crate::state::nodes::Node;

/// Properties of a solid section that the selection of its law takes into account.
pub struct SolidProperties<'a> {
    pub material: &'a MaterialDefinition,
    /// Span of the section.
    pub span: Span,
    pub constants: ElementConstants,
    pub connectivity: &'a Connectivity,
    pub nodes: &'a [Node],
    pub density: f64,
    pub heats: bool,
    /// 1 - MAX DEGRADATION: remaining stiffness fraction at which an element is deleted.
    pub deletion_margin: f64,
    /// Whether failed elements are kept.
    pub keep_elements: bool,
    /// Absolute zero on the temperature scale of the model.
    pub absolute_zero: f64,
}

impl SolidProperties<'_> {
    /// Returns the largest characteristic length of the elements.
    pub fn longest_element(&self) -> f64 {
        let length = |cell: [u32; 4]| {
            let places = cell.map(|n| self.nodes[n as usize].place());
            characteristic_length(quad_area(places), [0, 1].map(|i| places.map(|place| place[i])))
        };
        self.connectivity.cells().into_iter().map(length).fold(0.0, f64::max)
    }
}
