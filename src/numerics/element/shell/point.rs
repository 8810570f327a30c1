//! State of points through the thickness, and their update by a strain increment.

use super::section::ShellProperties;
use crate::kernel::plane_stress::PlaneReturn;
use crate::state::archive::persist_struct;

/// Plastic state of a section point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ShellPointState {
    /// Equivalent plastic strain.
    pub strain: f64,
    pub temperature: f64,
}

/// Result of the update of a section point: return to the yield surface and thickness strain.
pub(super) struct ShellPointResult {
    pub returned: PlaneReturn,
    /// Plastic work per volume: that of the mean of previous and new stress.
    pub work: f64,
    /// Strain through the thickness.
    pub thinning: f64,
}

/// Updates stress and plastic state of a point for a strain increment along meridian and hoop.
pub(super) fn advance(
    section: &ShellProperties,
    stress: &mut [f64; 2],
    flow: Option<&mut ShellPointState>,
    strain: [f64; 2],
    dt: f64,
) -> ShellPointResult {
    let elastic = &section.elastic;
    let trial = elastic.trial(*stress, strain);
    let mut work = 0.0;
    let returned = match (&section.flowing, flow) {
        (Some(flowing), Some(flow)) => {
            let returned = elastic.returned(&flowing.law, trial, [flow.strain, flow.temperature], dt);
            flow.strain += returned.flow;
            let half = |i: usize| 0.5 * (stress[i] + returned.stress[i]) * returned.plastic[i];
            work = half(0) + half(1);
            flow.temperature += flowing.heating.rise(flow.temperature, [work]);
            returned
        }
        _ => PlaneReturn { stress: trial, ..PlaneReturn::default() },
    };
    let change = [returned.stress[0] - stress[0], returned.stress[1] - stress[1]];
    let thinning = elastic.thinning(change) - (returned.plastic[0] + returned.plastic[1]);
    *stress = returned.stress;
    ShellPointResult { returned, work, thinning }
}

persist_struct!(ShellPointState { strain, temperature });
