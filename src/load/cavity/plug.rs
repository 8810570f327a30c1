//! Plugging: of all ways through a plate the one that takes the least force.
//! Never here: the forces of opening the cavity.

use std::f64::consts::PI;
use std::ops::Range;

use super::stack::Stack;
use crate::kernel::facet::Facet;

/// A nose as plugging sees it: its facets from the widest inwards.
#[derive(Clone, Copy)]
pub(super) struct Inwards<'a> {
    pub(super) facets: &'a [Facet],
    pub(super) order: &'a [usize],
    /// How far it has moved along z, and which way it moves.
    pub(super) shift: f64,
    pub(super) direction: f64,
}

/// Axial force of opening the cavity, and of friction with coefficient 1, on a nose for which plates may fail by a plug: within some
/// radius what is ahead is sheared out by 2 pi r h tau over the way h to the back of the plate, outside it the cavity is opened. The
/// radius that takes the least force is the one that counts: an upper bound, as those of Recht and Ipson (1963) and Bai and Johnson
/// (1982) are, without the inertia of the plug. `cavity` gives both forces on a facet in some layers.
pub(super) fn least_forces(
    stack: &Stack,
    shear_strength: f64,
    nose: Inwards<'_>,
    cavity: impl Fn(&Facet, &Range<usize>) -> [f64; 2],
) -> [f64; 2] {
    plates(stack).fold([0.0; 2], |total, plate| plus(total, through(stack, &plate, shear_strength, nose, &cavity)))
}

/// The sum of two pairs of forces.
#[inline]
pub(super) fn plus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// The layers between gaps.
fn plates(stack: &Stack) -> impl Iterator<Item = Range<usize>> + '_ {
    let count = stack.laws.len();
    let solid = move |layer: usize| layer < count && !stack.is_gap(layer);
    let firsts = (0..count).filter(move |&l| solid(l) && (l == 0 || !solid(l - 1)));
    firsts.map(move |first| first..(first..).find(|&l| !solid(l)).unwrap_or(count))
}

fn through(
    stack: &Stack,
    plate: &Range<usize>,
    shear_strength: f64,
    nose: Inwards<'_>,
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

/// Thickness of a plate ahead of a place.
fn ahead(z: f64, [low, high]: [f64; 2], direction: f64) -> f64 {
    let from = z.clamp(low, high);
    if direction > 0.0 { high - from } else { from - low }
}
