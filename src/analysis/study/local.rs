//! Choice of a mesh for an error target that is fine only where an error map finds the error.

use std::time::Instant as Stopwatch;

use super::StudyError;
use super::chosen::{self, BisectedRegion, ChosenMesh, ChosenSetting, LocalMesh, TargetRequest};
use super::map::base::MapBase;
use super::map::bisection::{BisectionModel, bisected_deck};
use super::map::measure::{ErrorMapRun, LEAST_MESH, measure};
use super::record::CompletedStudy;
use super::refinement::RefinementStudy;
use super::runner::StudyRunner;
use super::settings::{self, StudyAxis};
use super::table::{digits, duration, short};
use super::target::ErrorTarget;
use crate::deck::{self, MESH_SETTINGS};
use crate::model;

/// Number of levels of the uniform study.
const LEVELS: usize = 3;
/// Levels finer than the mesh of the deck.
const FINER: [&str; 5] = ["2", "4", "8", "16", "32"];
/// Fraction of the target that the uncertainty of the limit should have.
const LIMIT_SHARE: f64 = 0.5;
/// Smallest distance of the finest level from the limit, as a fraction of the uncertainty of the limit.
const LEAST_DISTANCE: f64 = 1.0 / 3.0;
/// Largest number of meshes that are tried.
const TRIES: usize = 4;
/// Factor on the error bound of a mesh that does not fit into the budget.
const RELAXED: f64 = 1.5;
/// Fraction of the target for which another mesh is chosen.
const MARGIN: f64 = 0.9;

/// Studies the mesh uniformly, measures an error map of its coarsest level, and refines it where the error is. Where uniform
/// refinement is cheaper, it is chosen.
///
/// # Errors
/// If no level can be run, if a region has no share, or if the time budget is too short for the map.
pub fn choose(request: &TargetRequest<'_>) -> Result<ChosenSetting, StudyError> {
    let begin = Stopwatch::now();
    let levels = levels(request)?;
    let own = levels.iter().position(|level| level == "1").unwrap_or(0);
    let mut chosen = of_levels(request, &levels, begin);
    if own > 0 && matches!(chosen, Err(StudyError::Setting(_))) {
        // Coarser levels may have no limit, and cannot be refined in parts if the deck lists values node by node.
        (request.announce)("the levels begin with the mesh of the deck");
        chosen = of_levels(request, &levels[own..], begin);
    }
    match chosen? {
        Some(chosen) => Ok(chosen),
        None => {
            (request.announce)("uniform refinement is cheaper for this target");
            let budget = request.budget.saturating_sub(begin.elapsed());
            chosen::choose(&TargetRequest { budget, ..*request })
        }
    }
}

/// Chooses a mesh that is refined in parts from the first of some levels; `None` if a uniform mesh is cheaper.
fn of_levels(
    request: &TargetRequest<'_>,
    levels: &[String],
    begin: Stopwatch,
) -> Result<Option<ChosenSetting>, StudyError> {
    let beyond =
        FINER.into_iter().position(|finer| levels.last().is_some_and(|last| last == finer)).map_or(0, |at| at + 1);
    let more = FINER[beyond..].iter().take(LEVELS.saturating_sub(levels.len()));
    let levels: Vec<String> = levels.iter().cloned().chain(more.map(|level| (*level).to_owned())).collect();
    let axes = settings::axes(&[format!("{}={}", MESH_SETTINGS[1], levels.join(","))], &[])?;
    let ignore_progress = || {};
    let mut bench = request.runner(&ignore_progress, begin);
    let target = ErrorTarget { value: LIMIT_SHARE * request.target.value, ..request.target };
    let completed = request.study(&mut bench, &axes, Some(target))?;
    let study = &completed.study;
    let remaining = request.budget.saturating_sub(begin.elapsed());
    let expected = 3.0 * bench.spent();
    (request.announce)(&format!(
        "error map: about {} expected, {} of the budget left",
        duration(expected),
        duration(remaining.as_secs_f64())
    ));
    if expected > remaining.as_secs_f64() {
        return Err(StudyError::Comparison("the error map does not fit into the time: increase --budget".into()));
    }
    let measured = measure(&bench, &axes, study, None)?;
    let model = BisectionModel::of(&measured)
        .ok_or_else(|| StudyError::Comparison("a region of the error map has no share".into()))?;
    let allowed = request
        .target
        .bound(study)
        .ok_or_else(|| StudyError::Comparison("the limit of the quantity is zero".into()))?;
    let search = LocalSearch { bench: &bench, axes: &axes, study, measured: &measured, model };
    let found = search.mesh(allowed)?;
    found.map(|found| found.setting(request, &mut bench, &axes, &completed)).transpose()
}

/// Returns the levels up to the mesh of the deck with enough elements for an error map, or the first finer one.
fn levels(request: &TargetRequest<'_>) -> Result<Vec<String>, StudyError> {
    let axes = chosen::mesh_axes(request.source.deck, request.overrides)?;
    let is_large = |level: &String| {
        let deck = (request.source.deck)(&settings::with_mesh(request.overrides, level)).0;
        model::build(&deck).0.mesh.elements.len() >= LEAST_MESH
    };
    let large: Vec<String> = axes[0].values.iter().filter(|level| is_large(level)).cloned().collect();
    if !large.is_empty() {
        return Ok(large);
    }
    let finer = FINER.into_iter().map(str::to_owned).find(is_large);
    finer.map(|level| vec![level]).ok_or_else(|| {
        StudyError::Setting(format!("--local: the mesh has fewer than {LEAST_MESH} elements: give a finer one"))
    })
}

/// Search of a mesh.
struct LocalSearch<'a, 'b> {
    bench: &'a StudyRunner<'b>,
    axes: &'a [StudyAxis],
    study: &'a RefinementStudy,
    measured: &'a ErrorMapRun,
    model: BisectionModel,
}

/// A mesh that was run.
struct FoundMesh {
    local: LocalMesh,
    value: f64,
    /// Bound of its error: the distance from the limit, at least the remaining error of the model, and the uncertainty of the
    /// limit.
    bound: f64,
    increments: u64,
    /// Element-cycles of the map and of all meshes.
    spent: f64,
}

impl LocalSearch<'_, '_> {
    /// Returns the first mesh whose error is below `allowed`, or the last one tried; `None` if a uniform mesh is cheaper.
    fn mesh(&self, allowed: f64) -> Result<Option<FoundMesh>, StudyError> {
        let row = self.study.series[0].rows[0];
        let base = MapBase::of(self.bench, self.axes, &self.study.rows[row].values)?;
        let map = &self.measured.map;
        let (mut wanted, mut spent) = (allowed - map.error_uncertainty, map.element_cycles);
        if wanted <= 0.0 {
            return Ok(None);
        }
        let mut best: Option<FoundMesh> = None;
        for _ in 0..TRIES {
            let Some(bisections) = self.affordable(wanted) else { break };
            let next = self.run(&base, &bisections)?;
            spent += next.local.element_cycles;
            let uncertainty = map.error_uncertainty;
            let excess = (next.bound - uncertainty) / (allowed - uncertainty);
            wanted = MARGIN * self.model.expected(&bisections).0 / excess.max(1.0);
            let is_reached = next.bound <= allowed;
            if best.as_ref().is_none_or(|best| next.bound < best.bound) {
                best = Some(next);
            }
            if is_reached {
                break;
            }
        }
        let uniform = self.uniform_cycles(allowed);
        let is_cheaper = |found: &FoundMesh| uniform.is_none_or(|cycles| found.local.element_cycles < cycles);
        Ok(best.map(|best| FoundMesh { spent, ..best }).filter(is_cheaper))
    }

    /// Returns the element-cycles of a uniform mesh with an error bound, by the distance of the finest level from the limit and
    /// the order of the model.
    fn uniform_cycles(&self, bound: f64) -> Option<f64> {
        let row = &self.study.rows[*self.study.series[0].rows.last()?];
        let limit = self.study.reference?;
        let distance = (row.value? - limit.value).abs().max(LEAST_DISTANCE * limit.uncertainty);
        let ratio = distance / (bound - limit.uncertainty).max(0.0);
        Some(row.run.as_ref().ok()?.element_cycles() * libm::pow(ratio, 3.0 / self.model.order))
    }

    /// Returns the cheapest bisections whose error bound is at most `wanted`, or the smallest larger bound that is within the
    /// time budget.
    fn affordable(&self, mut wanted: f64) -> Option<Vec<u32>> {
        let base = self.study.rows[self.study.series[0].rows[0]].run.as_ref().ok()?;
        loop {
            let bisections = self.model.cheapest(wanted)?;
            let cycles = self.model.cost(&bisections) * base.element_cycles();
            if bisections.iter().all(|count| *count == 0) || self.bench.affords(Some(base), "local mesh", Some(cycles))
            {
                return Some(bisections);
            }
            wanted *= RELAXED;
        }
    }

    fn run(&self, base: &MapBase<'_>, bisections: &[u32]) -> Result<FoundMesh, StudyError> {
        let ErrorMapRun { map, mesh, patches } = self.measured;
        let mut of_element = vec![0; mesh.elements.len()];
        for (elements, count) in patches.iter().zip(bisections) {
            elements.iter().for_each(|&element| of_element[element] = *count);
        }
        let text = bisected_deck(base, mesh, &of_element)?;
        let overrides = base.overrides_of_listed_mesh();
        let run = base.run_deck(&|_| deck::read_text("local.inp", &text, &overrides), &[])?;
        let value = run.found.number().ok_or_else(|| StudyError::Comparison("the quantity is no number".into()))?;
        let (remaining, predicted) = self.model.expected(bisections);
        // A value can agree with the limit by chance, while shares cancel.
        let bound = remaining.max((value - map.value - map.error).abs()) + map.error_uncertainty;
        let region = |(region, count): (&super::map::RegionShare, &u32)| BisectedRegion {
            name: region.region.name.clone(),
            share: region.share.unwrap_or_default(),
            bisections: *count,
        };
        let local = LocalMesh {
            regions: map.regions.iter().zip(bisections).map(region).collect(),
            predicted,
            elements: run.elements,
            element_cycles: run.element_cycles(),
            uniform_element_cycles: self.uniform_cycles(bound),
            text,
        };
        Ok(FoundMesh { local, value, bound, increments: run.increments, spent: 0.0 })
    }
}

impl FoundMesh {
    /// Returns the setting with the uncertainties of the quantity.
    fn setting(
        self,
        request: &TargetRequest<'_>,
        bench: &mut StudyRunner<'_>,
        axes: &[StudyAxis],
        completed: &CompletedStudy,
    ) -> Result<ChosenSetting, StudyError> {
        let mesh = ChosenMesh {
            name: axes[0].values[0].clone(),
            reached: request.target.bound(&completed.study).is_some_and(|allowed| self.bound <= allowed),
            value: Some(self.value),
            bound: Some(self.bound),
            increments: self.increments,
        };
        let mut setting = request.setting(bench, axes, completed, mesh)?;
        setting.conclusions.push(self.local.sentence(self.bound));
        setting.element_cycles += self.spent;
        setting.local = Some(self.local);
        Ok(setting)
    }
}

impl LocalMesh {
    fn sentence(&self, bound: f64) -> String {
        let bisected = |count: u32| {
            let regions = self.regions.iter().filter(|region| region.bisections == count);
            let names: Vec<&str> = regions.map(|region| region.name.as_str()).collect();
            (!names.is_empty()).then(|| format!("{count} in {}", names.join(", ")))
        };
        let finest = self.regions.iter().map(|region| region.bisections).max().unwrap_or(0);
        let counts: Vec<String> = (0..=finest).rev().filter_map(bisected).collect();
        let uniform = match self.uniform_element_cycles {
            Some(cycles) => format!(
                "a uniform mesh would need about {} element-cycles, {} times as many",
                short(cycles),
                short(cycles / self.element_cycles)
            ),
            None => "the cost of a uniform mesh is not known".into(),
        };
        format!(
            "bisections: {}; {} elements, {} element-cycles; error below {} (predicted value {}); {uniform}",
            counts.join("; "),
            self.elements,
            short(self.element_cycles),
            short(bound),
            digits(self.predicted, 7)
        )
    }
}
