//! Plugging of plates: the failure mode with the smallest force.

use std::f64::consts::PI;
use std::ops::Range;

use super::stack::LayerStack;
use crate::kernel::facet::Facet;

/// A nose with its facets in descending order of radius.
#[derive(Clone, Copy)]
pub(super) struct PluggingNose<'a> {
    pub(super) facets: &'a [Facet],
    pub(super) order: &'a [usize],
    /// Displacement along z, and direction of motion.
    pub(super) shift: f64,
    pub(super) direction: f64,
}

/// Returns the axial forces of cavity expansion and of friction with coefficient 1, on a nose that may shear plugs out
/// of plates. Inside some radius r the material ahead is sheared out with the force 2 pi r h tau over the remaining
/// thickness h; outside, the cavity is opened. The radius with the smallest total force is used. This is an upper
/// bound, like those of Recht and Ipson (1963) and Bai and Johnson (1982), without the inertia of the plug. `cavity`
/// returns both forces on a facet in a range of layers.
pub(super) fn least_forces(
    stack: &LayerStack,
    shear_strength: f64,
    nose: PluggingNose<'_>,
    cavity: impl Fn(&Facet, &Range<usize>) -> [f64; 2],
) -> [f64; 2] {
    plates(stack).fold([0.0; 2], |total, plate| plus(total, plate_force(stack, &plate, shear_strength, nose, &cavity)))
}

/// Returns the sum of two pairs of forces.
#[inline]
pub(super) fn plus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Returns the plates: ranges of consecutive layers between gaps.
fn plates(stack: &LayerStack) -> impl Iterator<Item = Range<usize>> + '_ {
    let count = stack.laws.len();
    let solid = move |layer: usize| layer < count && !stack.is_gap(layer);
    let firsts = (0..count).filter(move |&l| solid(l) && (l == 0 || !solid(l - 1)));
    firsts.map(move |first| first..(first..).find(|&l| !solid(l)).unwrap_or(count))
}

/// Equation (3.3).
fn plate_force(
    stack: &LayerStack,
    plate: &Range<usize>,
    shear_strength: f64,
    nose: PluggingNose<'_>,
    cavity: &impl Fn(&Facet, &Range<usize>) -> [f64; 2],
) -> [f64; 2] {
    let faces = [stack.planes[plate.start], stack.planes[plate.end]];
    let (mut outside, mut least) = ([0.0; 2], [f64::INFINITY; 2]);
    for &index in nose.order {
        let facet = &nose.facets[index];
        let edge = if facet.low[0] > facet.high[0] { facet.low } else { facet.high };
        let plug = 2.0 * PI * edge[0] * shear_strength * ahead(edge[1] + nose.shift, faces, nose.direction);
        if outside[0] + plug < least[0] {
            least = [outside[0] + plug, outside[1]];
        }
        outside = plus(outside, cavity(facet, plate));
    }
    if outside[0] <= least[0] { outside } else { least }
}

/// Returns the thickness of a plate ahead of a point.
fn ahead(z: f64, [low, high]: [f64; 2], direction: f64) -> f64 {
    let from = z.clamp(low, high);
    if direction > 0.0 { high - from } else { from - low }
}
