//! Temperatures of nodes: heat that is conducted, given and taken, and what temperatures do to elements.
//! Never here: stresses, motion; deck words (an effect carries an opaque id that only the ledger reads).
//!
//! As ABAQUS/Explicit solves them (Analysis User's Guide 6.5.3, "Fully coupled thermal-stress analysis"): forward differences
//! of lumped capacities, `C dT/dt = P - K T`, side by side with the central differences of the motion. Without a step that
//! solves for temperatures nothing of this exists.

pub mod conductors;
pub mod expansion;
pub mod field;
pub mod sources;

use crate::element::elements::Elements;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;
use crate::state::magnitude::Clock;
use expansion::Expansion;
use field::Heat;

/// What temperatures bring into a scene; at least one of the two is there.
#[derive(Clone)]
pub struct Thermal {
    /// Temperatures of nodes; `None` where they stay with elements.
    pub heat: Option<Heat>,
    /// Thermal strains; `None` where nothing expands.
    pub expansion: Option<Expansion>,
}

impl Thermal {
    /// Before elements are updated: gives them the temperatures of this instant and takes their thermal strains off.
    pub fn before(&mut self, elements: &mut Elements, dofs: &mut Dofs, clock: &Clock<'_>) {
        if let Some(heat) = &mut self.heat {
            heat.hold(clock);
            heat.warm(elements);
        }
        if let Some(expansion) = &mut self.expansion {
            expansion.apply(self.heat.as_ref(), elements, dofs);
        }
    }

    pub fn bytes(&self) -> [usize; 2] {
        [self.heat.as_ref().map_or(0, Heat::bytes), self.expansion.as_ref().map_or(0, Expansion::bytes)]
    }
}

persist_struct!(Thermal { heat: present, expansion: present });
