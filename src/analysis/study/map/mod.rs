//! Error map: the share of each region of the mesh in the discretization error of a quantity.
//!
//! Companion runs divide the edges of one region after the other of the coarsest mesh of a study into two parts, in the
//! order of the regions and in the reverse order. The changes of all regions add up to that of the uniform refinement. The
//! mean over both orders contains half of each interaction between two regions: without interactions of more regions it is
//! the mean over all orders (L. S. Shapley, in: Contributions to the Theory of Games II, Princeton 1953, 307). The factor of
//! Richardson extrapolation makes the change with half the element size the distance from the limit. Equations (15.10), (15.11). Bisections
//! of the regions for an error target: equation (15.12).

pub(super) mod base;
pub(super) mod bisection;
mod divide;
pub mod measure;
pub mod output;
pub mod picture;
pub mod regions;

use serde::Serialize;

use crate::model::Mesh;
use regions::MeshRegion;

/// Share of a region in the error of a quantity, in the units of the quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RegionShare {
    /// Name and elements.
    #[serde(flatten)]
    pub region: MeshRegion,
    /// Smallest and largest coordinates `[r, z]` of the nodes.
    pub bounds: [[f64; 2]; 2],
    /// Expected change of the quantity if this region is refined without limit; `None` if a companion run failed.
    pub share: Option<f64>,
    /// Change of the quantity if this region is refined after those before it in the list, at equal increments.
    pub forward: Option<f64>,
    /// Change of the quantity if this region is refined after those that follow in the list; absent without such runs.
    pub backward: Option<f64>,
    /// Uncertainty of the share: half the difference between both changes, and the noise; absent without both.
    pub uncertainty: Option<f64>,
    /// Why a change is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// Order of convergence by which changes are extrapolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FactorSource {
    /// The order that the levels of the study have, at most the formal one.
    Observed,
    /// The distance from the limit over the change of the first level, without a credible order.
    Limit,
    /// The formal order.
    Assumed,
}

/// Error map, the contents of `<job>_map.json`. The keys are stable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorMap {
    /// Expression of the quantity as written.
    pub quantity: String,
    /// Level whose mesh is divided into regions.
    pub setting: String,
    /// Value of the quantity on this level.
    pub value: f64,
    /// Error of this level by the uniform study: limit, or exact value, minus value.
    pub error: f64,
    /// Uncertainty of the limit.
    pub error_uncertainty: f64,
    /// Change of the quantity if all elements are refined.
    pub uniform_change: f64,
    /// Change of the quantity from the first to the second level of the study, if its size is half as large.
    pub level_change: Option<f64>,
    /// Factor from the change with half the element size to the distance from the limit: 1 / (1 - 2^-p) with the order p.
    pub factor: f64,
    /// Source of the factor.
    pub factor_source: FactorSource,
    /// Regions with their shares.
    pub regions: Vec<RegionShare>,
    /// Share of the time increment.
    pub increment: f64,
    /// Noise of a share; 0 without perturbed runs.
    pub noise: f64,
    /// Sum of all shares.
    pub sum: f64,
    /// Sum of all shares minus `error`.
    pub difference: f64,
    /// Number of companion runs.
    pub companions: usize,
    /// Element-cycles of the companion runs.
    pub element_cycles: f64,
    /// Element-cycles of the companion runs divided by those of one run of each level of the uniform study.
    pub cost: f64,
    /// Version of the program that wrote the map.
    pub version: &'static str,
}

/// Returns the smallest and largest coordinates of the nodes of elements.
fn bounds(mesh: &Mesh, elements: &[usize]) -> [[f64; 2]; 2] {
    let points = elements.iter().flat_map(|&e| mesh.elements[e].nodes.iter().map(|&node| mesh.points[node]));
    points.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], point| {
        [[0, 1].map(|i| point[i].min(low[i])), [0, 1].map(|i| point[i].max(high[i]))]
    })
}
