//! User-defined characteristic lengths (`*CHARACTERISTIC LENGTH, DEFINITION=USER`) of elements with a built-in
//! material. The subroutine is called once, at the start of the analysis, because damage uses the initial length.

use super::group::ElementGroup;
use crate::kernel::lanes::InlineMap;
use crate::kernel::six_node_triangle;
use crate::kernel::topology::{ElementNodes, ElementTopology};
use crate::material::user::lengths::{ShownElements, above_zero, by_default, middle, user_number};
use crate::routines::{LengthCall, LoadFailure, MAX_MATERIAL_BLOCK, UserLengths};
use crate::state::Instant;
use crate::state::halt::HaltReason;
use crate::state::nodes::Node;

/// Nodes of an element, and the corners of its part around an integration point.
type ElementPart = (ElementNodes, [u32; 4]);

/// Elements of a group whose characteristic length a user subroutine defines.
#[derive(Clone, Debug)]
pub struct UserLengthElements {
    pub group: usize,
    /// Name of the material, upper case.
    pub name: String,
    pub properties: Vec<f64>,
    pub elements: Vec<String>,
}

impl UserLengthElements {
    pub fn bytes(&self) -> usize {
        let names: usize = self.elements.iter().map(|n| size_of_val(n) + n.capacity()).sum();
        size_of_val(self) + names + self.name.capacity() + size_of_val(&*self.properties)
    }

    /// Calls the subroutine for the lengths of all elements in the initial configuration, and sets them in the group.
    ///
    /// # Errors
    /// The failure of the subroutine, or a length that is not positive.
    pub fn ask(
        &self,
        group: &mut dyn ElementGroup,
        nodes: &[Node],
        now: &Instant,
        routine: &mut dyn UserLengths,
    ) -> Result<(), HaltReason> {
        let points = match group.topology() {
            ElementTopology::SixNodeTriangle => six_node_triangle::POINTS,
            _ => 1,
        };
        for (chunk, names) in self.elements.chunks(MAX_MATERIAL_BLOCK).enumerate() {
            let first = chunk * MAX_MATERIAL_BLOCK;
            for point in 0..points {
                let part = |e: usize| Some((group.nodes(e), group.cells(e).nth(point)?));
                let parts: Vec<ElementPart> = (first..first + names.len()).filter_map(part).collect();
                let lengths = self.block((&parts, point), names, nodes, now, routine).map_err(|failure| {
                    let element = failure.point.and_then(|i| names.get(i));
                    let place = element.map_or(String::new(), |n| format!(" at element {n}"));
                    let what = format!("the characteristic length of the material `{}`{place}", self.name);
                    let halt = failure.halt(&what, now);
                    match element {
                        Some(name) => halt.at_element(name),
                        None => halt,
                    }
                })?;
                let state = group.extensions().initial_state();
                lengths.into_iter().enumerate().for_each(|(i, length)| state.set_length(first + i, point, length));
            }
        }
        Ok(())
    }

    fn block(
        &self,
        (parts, point): (&[ElementPart], usize),
        names: &[String],
        nodes: &[Node],
        now: &Instant,
        routine: &mut dyn UserLengths,
    ) -> Result<Vec<f64>, LoadFailure> {
        let count = parts.len();
        let most = parts.iter().map(|(nodes, _)| nodes.len()).max().unwrap_or(4);
        let triangles = most == 4 && parts.iter().all(|(nodes, _)| nodes[2] == nodes[3]);
        let mut shown = ShownElements::new(count, if triangles { 3 } else { most });
        let (mut lengths, mut coordinates) = (Vec::with_capacity(count), vec![0.0; 2 * count]);
        for (i, (around, corners)) in parts.iter().enumerate() {
            let places = corners.inline_map(|n| nodes[n as usize].place());
            let (r, z) = (places.inline_map(|p| p[0]), places.inline_map(|p| p[1]));
            shown.set(i, &around.map(|n| nodes[n as usize].place()));
            [coordinates[i], coordinates[count + i]] = middle(r, z);
            lengths.push(by_default(r, z));
        }
        let numbers: Vec<i32> = names.iter().map(|name| user_number(name)).collect();
        let call = LengthCall {
            name: &self.name,
            now: *now,
            dt: 0.0,
            count,
            variables: 0,
            fields: 0,
            integration_point: point + 1,
            corners: shown.nodes,
            properties: &self.properties,
            elements: &numbers,
            coordinates: &coordinates,
            nodes: &shown.places,
            field: &[],
            state: &[],
        };
        routine.lengths(&call, &mut lengths)?;
        above_zero(&lengths)?;
        Ok(lengths)
    }
}
