//! What points through the thickness keep, and the strain increment at one of them.
//! Never here: elements.

use super::section::Section;
use crate::kernel::plane_stress::PlaneReturn;
use crate::state::archive::persist_struct;

/// What flows at a point keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Flow {
    /// Equivalent plastic strain.
    pub strain: f64,
    pub temperature: f64,
}

/// What an increment made of a point.
pub(super) struct Step {
    pub returned: PlaneReturn,
    /// Strain through the thickness.
    pub thinning: f64,
}

/// A strain increment along meridian and hoop at one point; its stress and what flows follow.
pub(super) fn advance(
    section: &Section,
    stress: &mut [f64; 2],
    flow: Option<&mut Flow>,
    strain: [f64; 2],
    dt: f64,
) -> Step {
    let elastic = &section.elastic;
    let trial = elastic.trial(*stress, strain);
    let returned = match (&section.flowing, flow) {
        (Some(flowing), Some(flow)) => {
            let returned = elastic.returned(&flowing.law, trial, [flow.strain, flow.temperature], dt);
            flow.strain += returned.flow;
            flow.temperature += flowing.heating.rise(flow.temperature, [returned.mises, returned.flow]);
            returned
        }
        _ => PlaneReturn { stress: trial, ..PlaneReturn::default() },
    };
    let change = [returned.stress[0] - stress[0], returned.stress[1] - stress[1]];
    let thinning = elastic.thinning(change) - (returned.plastic[0] + returned.plastic[1]);
    *stress = returned.stress;
    Step { returned, thinning }
}

persist_struct!(Flow { strain, temperature });
