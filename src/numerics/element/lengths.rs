//! User-defined characteristic lengths (`*CHARACTERISTIC LENGTH, DEFINITION=USER`) of elements with a built-in
//! material. The subroutine is called once, at the start of the analysis, because damage uses the initial length.

use super::group::ElementGroup;
use crate::kernel::lanes::InlineMap;
use crate::material::user::lengths::{ShownElements, above_zero, by_default, user_number};
use crate::routines::{LengthCall, LoadFailure, MAX_MATERIAL_BLOCK, UserLengths};
use crate::state::Instant;
use crate::state::halt::HaltReason;
use crate::state::nodes::Node;

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
        for (chunk, names) in self.elements.chunks(MAX_MATERIAL_BLOCK).enumerate() {
            let first = chunk * MAX_MATERIAL_BLOCK;
            let corners: Vec<[u32; 4]> = (first..first + names.len()).flat_map(|e| group.cells(e).take(1)).collect();
            let lengths = self.block(&corners, names, nodes, now, routine).map_err(|failure| {
                let place =
                    failure.point.and_then(|i| names.get(i)).map_or(String::new(), |n| format!(" at element {n}"));
                failure.halt(&format!("the characteristic length of the material `{}`{place}", self.name), now)
            })?;
            let state = group.extensions().initial_state();
            lengths.into_iter().enumerate().for_each(|(i, length)| state.set_length(first + i, length));
        }
        Ok(())
    }

    fn block(
        &self,
        corners: &[[u32; 4]],
        names: &[String],
        nodes: &[Node],
        now: &Instant,
        routine: &mut dyn UserLengths,
    ) -> Result<Vec<f64>, LoadFailure> {
        let count = corners.len();
        let triangles = corners.iter().all(|element| element[2] == element[3]);
        let mut shown = ShownElements::new(count, if triangles { 3 } else { 4 });
        let mut lengths = Vec::with_capacity(count);
        for (i, element) in corners.iter().enumerate() {
            let places = element.inline_map(|n| nodes[n as usize].place());
            let (r, z) = (places.inline_map(|p| p[0]), places.inline_map(|p| p[1]));
            shown.set(i, r, z);
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
            corners: shown.corners,
            properties: &self.properties,
            elements: &numbers,
            coordinates: &shown.middles,
            nodes: &shown.places,
            field: &[],
            state: &[],
        };
        routine.lengths(&call, &mut lengths)?;
        above_zero(&lengths)?;
        Ok(lengths)
    }
}
