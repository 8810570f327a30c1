//! Parts of old elements that are moved between adjacent new elements, so that the volume of the material in each new
//! element is close to the volume of the element.

use super::BodyMesh;
use super::overlap::CommonPart;
use super::transfer::neighbours;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad;
use crate::kernel::volume_balance::VolumeBalance;

/// Largest share of its material that a new element passes on in one pass.
const LARGEST_SHARE: f64 = 0.5;
/// Accuracy of the flows, relative to the largest missing volume.
const ACCURACY: f64 = 1e-4;
/// Largest number of passes.
const MOST_PASSES: usize = 8;

/// Returns the parts with small flows between adjacent new elements. A new outline is a chord of the old one: volume
/// outside the chord is in the other parts of its old element, and added volume is empty. `volumes` are those of the material in
/// the old elements. The first new elements, of the number `unchanged`, have no flows.
pub fn balanced_parts(
    mut parts: Vec<CommonPart>,
    volumes: &[f64],
    (new, unchanged): (&BodyMesh, usize),
) -> Vec<CommonPart> {
    let sizes: Vec<f64> = new.quads.iter().map(|quad| quad::volume(new.corners(quad))).collect();
    let beside = neighbours(new);
    let pairs = (0..).zip(&beside).flat_map(|(a, list)| list.iter().map(move |b| [a, *b as usize]));
    let links: Vec<[usize; 2]> = pairs.filter(|[a, b]| a < b && *a >= unchanged).collect();
    let mut balance = VolumeBalance::new(sizes.len(), ACCURACY);
    for _ in 0..MOST_PASSES {
        let mut content = vec![0.0; sizes.len()];
        for part in &parts {
            content[part.new as usize] += part.share * volumes[part.old as usize];
        }
        let mut missing: Vec<f64> = sizes.iter().zip(&content).map(|(size, content)| size - content).collect();
        missing[..unchanged].fill(0.0);
        if !balance.solve(links.iter().copied(), |e| sizes[e], &missing) {
            break;
        }
        let mut leaving: Vec<Vec<(u32, f64)>> = vec![Vec::new(); sizes.len()];
        for &[a, b] in &links {
            let flow = balance.flow([a, b], |e| sizes[e]);
            let (from, receiver) = if flow > 0.0 { (b, a) } else { (a, b) };
            if flow != 0.0 && content[from] > 0.0 {
                leaving[from].push((receiver as u32, flow.abs() / content[from]));
            }
        }
        let is_limited = limit(&mut leaving);
        parts = moved(&parts, &leaving);
        if !is_limited {
            break;
        }
    }
    parts
}

/// Limits the shares that leave each element. Returns whether one was too large.
fn limit(leaving: &mut [Vec<(u32, f64)>]) -> bool {
    let mut is_limited = false;
    for list in leaving {
        let sum: f64 = list.iter().map(|(_, share)| share).sum();
        if sum > LARGEST_SHARE {
            list.iter_mut().for_each(|(_, share)| *share *= LARGEST_SHARE / sum);
            is_limited = true;
        }
    }
    is_limited
}

/// Moves shares of all parts of each new element to others. Returns the parts by old element.
fn moved(parts: &[CommonPart], leaving: &[Vec<(u32, f64)>]) -> Vec<CommonPart> {
    let mut divided = Vec::with_capacity(2 * parts.len());
    for part in parts {
        let list = &leaving[part.new as usize];
        let share_leaving: f64 = list.iter().map(|(_, share)| share).sum();
        divided.push(CommonPart { share: part.share * (1.0 - share_leaving), ..*part });
        divided.extend(list.iter().map(|(new, share)| CommonPart { new: *new, share: part.share * share, ..*part }));
    }
    divided.sort_by_key(|part| (part.old, part.new));
    divided.chunk_by(|a, b| (a.old, a.new) == (b.old, b.new)).map(joined).collect()
}

/// Returns the sum of parts of the same pair of elements.
fn joined(parts: &[CommonPart]) -> CommonPart {
    let [first, rest @ ..] = parts else { return CommonPart::default() };
    rest.iter().fold(*first, |sum, part| {
        let share = sum.share + part.share;
        let mean = |i: usize| (sum.share * sum.centre[i] + part.share * part.centre[i]) / share;
        if share > 0.0 { CommonPart { share, centre: [0, 1].inline_map(mean), ..sum } } else { sum }
    })
}
