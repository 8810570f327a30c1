//! How often the elements of each region of an error map are bisected for an error target, and the deck with this mesh.

use super::base::{MapBase, listed};
use super::measure::ErrorMapRun;
use crate::deck;
use crate::kernel::sorted_boxes::{SortedBoxes, box_of};
use crate::model::{self, Mesh};
use crate::study::StudyError;

/// Largest number of bisections of an element.
const MOST: u32 = 6;
/// Number of further bisections of the smallest elements with which a cheaper choice is searched.
const FINER: u32 = 2;
/// Fraction of the magnitudes of the remaining shares that is added to their sum: shares that cancel are uncertain.
const SAFETY: f64 = 0.25;

/// Error and cost of meshes whose regions are bisected different numbers of times, by the shares of an error map.
pub struct BisectionModel {
    /// Share and number of elements of each region.
    regions: Vec<(f64, f64)>,
    /// Share of the time increment.
    increment: f64,
    /// Order of convergence.
    pub order: f64,
    /// Value on the mesh without bisections.
    value: f64,
}

impl BisectionModel {
    /// Returns the model of a map; `None` if a region has no share.
    pub fn of(run: &ErrorMapRun) -> Option<BisectionModel> {
        let map = &run.map;
        let region = |(share, elements): (Option<f64>, &Vec<usize>)| Some((share?, elements.len() as f64));
        let shares = map.regions.iter().map(|region| region.share);
        Some(BisectionModel {
            regions: shares.zip(&run.patches).map(region).collect::<Option<_>>()?,
            increment: map.increment,
            order: -libm::log2(1.0 - 1.0 / map.factor),
            value: map.value,
        })
    }

    /// Returns the remaining error with its sign, and an upper bound of its magnitude. Equation (15.12).
    fn remaining(&self, bisections: &[u32]) -> [f64; 2] {
        let finest = bisections.iter().copied().max().unwrap_or(0);
        let increment = self.increment * libm::exp2(-f64::from(finest));
        let of_region = |((share, _), count): (&(f64, f64), &u32)| share * libm::exp2(-self.order * f64::from(*count));
        let (mut sum, mut magnitudes) = (increment, increment.abs());
        for share in self.regions.iter().zip(bisections).map(of_region) {
            sum += share;
            magnitudes += share.abs();
        }
        [sum, sum.abs() + SAFETY * magnitudes]
    }

    /// Returns an upper bound of the remaining error, and the value that the model predicts.
    pub fn expected(&self, bisections: &[u32]) -> (f64, f64) {
        let [before, _] = self.remaining(&vec![0; bisections.len()]);
        let [after, bound] = self.remaining(bisections);
        (bound, self.value + before - after)
    }

    fn bound(&self, bisections: &[u32]) -> f64 {
        self.remaining(bisections)[1]
    }

    /// Returns the element-cycles relative to those without bisections; transitions are neglected.
    pub fn cost(&self, bisections: &[u32]) -> f64 {
        let finest = bisections.iter().copied().max().unwrap_or(0);
        let elements = |((_, elements), count): (&(f64, f64), &u32)| elements * f64::from(1_u32 << (2 * count));
        let all: f64 = self.regions.iter().map(|region| region.1).sum();
        self.regions.iter().zip(bisections).map(elements).sum::<f64>() / all * f64::from(1_u32 << finest)
    }

    /// Returns the cheapest numbers of bisections whose error bound is at most `allowed`; `None` if there are none.
    ///
    /// For each number of bisections of the smallest elements, the other regions are made coarser while the bound allows
    /// it, those first where this saves the most elements for its error.
    pub fn cheapest(&self, allowed: f64) -> Option<Vec<u32>> {
        let uniform = |count: u32| vec![count; self.regions.len()];
        let first = (0..=MOST).find(|count| self.bound(&uniform(*count)) <= allowed)?;
        let choices = (first..=(first + FINER).min(MOST)).map(|finest| self.coarsened(uniform(finest), allowed));
        choices.min_by(|a, b| self.cost(a).total_cmp(&self.cost(b)))
    }

    /// Removes bisections of one region after the other.
    fn coarsened(&self, mut bisections: Vec<u32>, allowed: f64) -> Vec<u32> {
        loop {
            let (cost, bound) = (self.cost(&bisections), self.bound(&bisections));
            let mut best: Option<(f64, Vec<u32>)> = None;
            for region in 0..bisections.len() {
                let mut coarser = bisections.clone();
                let Some(fewer) = coarser[region].checked_sub(1) else { continue };
                coarser[region] = fewer;
                let larger = self.bound(&coarser);
                let gain = (cost - self.cost(&coarser)) / (larger - bound).max(1e-6 * allowed);
                if larger <= allowed && best.as_ref().is_none_or(|(most, _)| gain > *most) {
                    best = Some((gain, coarser));
                }
            }
            match best {
                Some((_, coarser)) => bisections = coarser,
                None => return bisections,
            }
        }
    }
}

/// Returns the text of the deck with its elements bisected; `bisections` has one number for each element of its mesh.
///
/// # Errors
/// If a mesh cannot be listed or read.
pub fn bisected_deck(base: &MapBase<'_>, mesh: &Mesh, bisections: &[u32]) -> Result<String, StudyError> {
    let parents = ParentSearch::of(mesh);
    let mut deck = base.read().0;
    let mut text: Option<String> = None;
    for level in 1..=bisections.iter().copied().max().unwrap_or(0) {
        if let Some(text) = &text {
            let (listed_deck, diagnostics) = deck::read_text("local.inp", text, &base.overrides_of_listed_mesh());
            if diagnostics.has_errors() {
                return Err(StudyError::Setting(diagnostics.render(&listed_deck.sources)));
            }
            deck = listed_deck;
        }
        let finer = model::build(&deck).0.mesh;
        let is_refined = |element| parents.parent(&finer, element).is_some_and(|parent| bisections[parent] >= level);
        deck.refine_elements((0..finer.elements.len()).map(is_refined).collect());
        text = Some(listed(&deck)?);
    }
    text.map_or_else(|| listed(&deck), Ok)
}

/// Search of the element of a mesh that contains an element of a finer one.
struct ParentSearch<'a> {
    mesh: &'a Mesh,
    boxes: SortedBoxes,
    longest: f64,
}

impl<'a> ParentSearch<'a> {
    fn of(mesh: &'a Mesh) -> ParentSearch<'a> {
        let mut boxes = SortedBoxes::with_capacity(mesh.elements.len());
        let all: Vec<_> = (0..mesh.elements.len()).map(|element| box_of(&corners(mesh, element))).collect();
        let length = |[low, high]: &[[f64; 2]; 2]| (high[0] - low[0]).max(high[1] - low[1]);
        let longest = all.iter().map(length).fold(0.0, f64::max);
        boxes.sort(all.into_iter().zip(0..));
        ParentSearch { mesh, boxes, longest }
    }

    /// Returns the element that contains the centre of an element; where edges are curved, that with the nearest centre.
    fn parent(&self, finer: &Mesh, element: usize) -> Option<usize> {
        let own = corners(finer, element);
        let place = centre(&own);
        let (mut inside, mut nearest) = (None, (f64::INFINITY, None));
        for margin in [0.0, self.longest] {
            self.boxes.near([place; 2], margin, |candidate| {
                let candidate = candidate as usize;
                let outline = corners(self.mesh, candidate);
                if (outline.len() > 2) != (own.len() > 2) {
                    return;
                }
                if outline.len() > 2 && contains(&outline, place) {
                    inside = inside.or(Some(candidate));
                }
                let middle = centre(&outline);
                let distance = (middle[0] - place[0]).powi(2) + (middle[1] - place[1]).powi(2);
                if distance < nearest.0 {
                    nearest = (distance, Some(candidate));
                }
            });
            if inside.is_some() {
                return inside;
            }
        }
        nearest.1
    }
}

/// Returns the corners of an element: of six-node triangles the first three nodes.
fn corners(mesh: &Mesh, element: usize) -> Vec<[f64; 2]> {
    let nodes = &mesh.elements[element].nodes;
    let count = if nodes.len() == 6 { 3 } else { nodes.len() };
    nodes[..count].iter().map(|&node| mesh.points[node]).collect()
}

fn centre(corners: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|i| corners.iter().map(|corner| corner[i]).sum::<f64>() / corners.len() as f64)
}

/// Returns whether a point is inside a convex outline in counterclockwise order.
fn contains(outline: &[[f64; 2]], [r, z]: [f64; 2]) -> bool {
    (0..outline.len()).all(|at| {
        let ([r1, z1], [r2, z2]) = (outline[at], outline[(at + 1) % outline.len()]);
        (r2 - r1) * (z - z1) - (z2 - z1) * (r - r1) >= 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(regions: &[(f64, f64)]) -> BisectionModel {
        BisectionModel { regions: regions.to_vec(), increment: 0.0, order: 2.0, value: 1.0 }
    }

    #[test]
    fn only_the_region_with_the_error_is_bisected() {
        let model = model(&[(0.16, 10.0), (0.0, 90.0)]);
        let chosen = model.cheapest(0.0126).expect("a choice");
        assert_eq!(chosen, [2, 0]);
        assert!((model.expected(&chosen).1 - 1.15).abs() < 1e-12);
        assert_eq!(model.cost(&chosen), 4.0 * 0.1 * (16.0 + 9.0));
    }

    #[test]
    fn an_even_distribution_is_bisected_uniformly_and_shares_that_cancel_keep_a_bound() {
        let even = model(&[(0.05, 50.0), (0.05, 50.0)]);
        assert_eq!(even.cheapest(0.0313), Some(vec![1, 1]));
        let cancelling = model(&[(0.1, 50.0), (-0.1, 50.0)]);
        assert_eq!(cancelling.bound(&[0, 0]), 0.05);
        assert!(cancelling.cheapest(1e-9).is_none());
    }
}
