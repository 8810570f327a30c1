//! Nodal temperatures: heat conduction, heat sources, and the effects of temperature on elements.
//!
//! As in ABAQUS/Explicit (Analysis User's Guide 6.5.3, "Fully coupled thermal-stress analysis"): forward differences
//! with lumped capacities, `C dT/dt = P - K T`, parallel to the central differences of the motion. These data exist
//! only if a step solves for temperatures or elements expand.

mod conduction_times;
pub mod conductors;
pub mod expansion;
pub mod field;
pub mod sources;

use crate::element::elements::Elements;
use crate::kernel::lists::Memory;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::magnitude::AmplitudeClock;
use expansion::ThermalStrains;
use field::TemperatureField;

/// Temperatures and thermal strains of a model; at least one of both exists.
#[derive(Clone, Persist)]
#[persist(present: heat, expansion)]
pub struct ThermalState {
    /// Nodal temperatures; `None` if each element has its own temperature.
    pub heat: Option<TemperatureField>,
    /// Thermal strains; `None` without expansion.
    pub expansion: Option<ThermalStrains>,
}

impl ThermalState {
    /// Sets the current temperatures of elements and applies their thermal strains, before the element update.
    pub fn prepare_elements(&mut self, elements: &mut Elements, dofs: &mut Dofs, clock: &AmplitudeClock<'_>) {
        if let Some(heat) = &mut self.heat {
            heat.apply_prescribed(clock);
            heat.set_element_temperatures(elements);
        }
        if let Some(expansion) = &mut self.expansion {
            expansion.apply(self.heat.as_ref(), elements, dofs);
        }
    }

    pub fn bytes(&self) -> [usize; 2] {
        [
            self.heat.as_ref().map_or(0, TemperatureField::bytes),
            self.expansion.as_ref().map_or(0, ThermalStrains::bytes),
        ]
    }
}
