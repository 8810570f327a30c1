//! Convergence study of a deck: the values of all levels, and the estimate of their limit.

use super::StudyError;
use super::noise::NoiseEstimate;
use super::quantity::QuantityValue;
use super::richardson::{LimitEstimate, RefinementLevel, estimate, order_of_errors};
use super::runner::{StudyRun, StudyRunner};
use super::settings::StudyAxis;

/// Largest number of settings of one study.
const MOST: usize = 10_000;

/// One setting of a study and its results.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyRow {
    /// Value of each axis, as written.
    pub values: Vec<String>,
    /// Result of the run, or the reason why the setting has none.
    pub run: Result<StudyRun, StudyError>,
    /// Index of the family; settings of a family differ only in levels of refinement.
    pub family: usize,
    /// Value of the quantity; for a field, the relative norm of its difference from the finest setting of the family.
    pub value: Option<f64>,
    /// Estimate of the limit from the levels up to this row, for each series that contains it; `None` with too few
    /// levels.
    pub estimates: Vec<Option<LimitEstimate>>,
    /// Order of convergence from the errors of this and the previous level against an exact value, by series.
    pub exact_orders: Vec<Option<f64>>,
    /// Sum of the grid convergence indices of all series, at least the noise; `None` if one has too few levels.
    pub uncertainty: Option<f64>,
    /// Difference from the exact value or from the estimated limit.
    pub error: Option<f64>,
    /// Bound of the absolute error: the error against an exact value; otherwise the distance from the finest value plus
    /// its uncertainty.
    pub bound: Option<f64>,
}

/// Series of rows from coarse to fine.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinementSeries {
    /// Name of the refined parameter, or names joined by "and".
    pub along: String,
    /// Indices of the rows in [`RefinementStudy::rows`], coarse to fine.
    pub rows: Vec<usize>,
    /// Size of each level, decreasing.
    pub sizes: Vec<f64>,
    /// Estimate of the limit from the finest levels.
    pub estimate: Option<LimitEstimate>,
}

/// Reference value of the errors of a study.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ErrorReference {
    /// Exact value or estimated limit.
    pub value: f64,
    /// Uncertainty; 0 for an exact value.
    pub uncertainty: f64,
    /// Row that the limit is estimated from; `None` for an exact value.
    pub row: Option<usize>,
}

/// Settings of a study with their results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RefinementStudy {
    /// Names of the axes, in the order of `StudyRow::values`.
    pub axes: Vec<String>,
    /// Settings with their results.
    pub rows: Vec<StudyRow>,
    /// Series of settings that differ only in the level of refinement along one axis.
    pub series: Vec<RefinementSeries>,
    /// Reference value from which errors are measured; `None` in a study with too few results.
    pub reference: Option<ErrorReference>,
    /// Value by which errors are divided to make them relative; `None` if the reference is zero.
    pub scale: Option<f64>,
    /// Scatter of the quantity under small perturbations; uncertainties are not below it.
    pub noise: Option<NoiseEstimate>,
    /// Properties of the model that can limit the order of convergence.
    pub causes: Vec<&'static str>,
}

impl StudyRow {
    /// Creates the row of a setting that has been run.
    pub fn new(values: Vec<String>, run: Result<StudyRun, StudyError>, family: usize) -> StudyRow {
        StudyRow {
            values,
            run,
            family,
            value: None,
            estimates: Vec::new(),
            exact_orders: Vec::new(),
            uncertainty: None,
            error: None,
            bound: None,
        }
    }
}

impl RefinementStudy {
    /// Returns a sentence for each series whose finest level has fewer elements than its coarsest one: numbers of
    /// elements that were given from fine to coarse.
    pub fn reversed_series(&self) -> Vec<String> {
        let sentence = |series: &RefinementSeries| {
            let (coarsest, finest) = (&self.rows[*series.rows.first()?], &self.rows[*series.rows.last()?]);
            let [many, few] = [coarsest, finest].map(|row| row.run.as_ref().map_or(0, |run| run.elements));
            let axis = self.axes.iter().position(|axis| *axis == series.along)?;
            (0 < few && few < many).then(|| {
                format!(
                    "{0} = {1} is taken as the finest level, because the values decrease as sizes do; it has {few} elements \
                     and facets, {0} = {2} has {many}. Give numbers of elements from small to large",
                    series.along, finest.values[axis], coarsest.values[axis]
                )
            })
        };
        self.series.iter().filter_map(sentence).collect()
    }

    /// Creates a study without settings.
    pub(super) fn empty(axes: &[StudyAxis]) -> RefinementStudy {
        RefinementStudy { axes: axes.iter().map(|a| a.name.clone()).collect(), ..RefinementStudy::default() }
    }
}

/// Returns the families of a study: for each, the axis index and value of every axis without levels.
pub(super) fn families(axes: &[StudyAxis]) -> Vec<Vec<(usize, String)>> {
    let mut families = vec![Vec::new()];
    for (index, axis) in axes.iter().enumerate().filter(|(_, a)| !a.is_refinement()) {
        let widen = |family: &Vec<(usize, String)>| {
            let with = |value: &String| {
                let mut wider = family.clone();
                wider.push((index, value.clone()));
                wider
            };
            axis.values.iter().map(with).collect::<Vec<_>>()
        };
        families = families.iter().flat_map(widen).collect();
    }
    families
}

/// Runs all combinations of the values of all axes; the last axis varies fastest.
pub fn grid(
    bench: &mut StudyRunner<'_>,
    axes: &[StudyAxis],
    exact: Option<f64>,
) -> Result<RefinementStudy, StudyError> {
    let count = axes.iter().try_fold(1_usize, |n, a| n.checked_mul(a.values.len())).filter(|n| *n <= MOST);
    let slip = || StudyError::Setting(format!("the study has more than {MOST} settings; reduce the number of values"));
    let count = count.ok_or_else(slip)?;
    let levels = |mut index: usize| {
        let mut indices: Vec<usize> =
            axes.iter().rev().map(|a| (index % a.values.len(), index /= a.values.len()).0).collect();
        indices.reverse();
        indices
    };
    let places: Vec<Vec<usize>> = (0..count).map(levels).collect();
    let choices = |place: &[usize]| -> Vec<usize> {
        axes.iter().zip(place).filter(|(a, _)| !a.is_refinement()).map(|(_, l)| *l).collect()
    };
    let mut known: Vec<Vec<usize>> = Vec::new();
    let mut study = RefinementStudy::empty(axes);
    for place in &places {
        let values: Vec<String> = axes.iter().zip(place).map(|(a, l)| a.values[*l].clone()).collect();
        let choice = choices(place);
        let family = known.iter().position(|k| *k == choice).unwrap_or(known.len());
        if family == known.len() {
            known.push(choice);
        }
        let run = bench.at(axes, &values, None);
        study.rows.push(StudyRow::new(values, run, family));
    }
    study.series = series_of(axes, &places);
    evaluate_errors(&mut study, exact, bench.measure().is_norm());
    Ok(study)
}

/// Returns the series of refinement: rows that differ in the level of one axis only.
fn series_of(axes: &[StudyAxis], places: &[Vec<usize>]) -> Vec<RefinementSeries> {
    let mut series_list = Vec::new();
    for (k, axis) in axes.iter().enumerate().filter(|(_, a)| a.is_refinement()) {
        for start in places.iter().filter(|p| p[k] == 0) {
            let alike = |p: &&Vec<usize>| p.iter().zip(start).enumerate().all(|(i, (a, b))| i == k || a == b);
            let rows: Vec<usize> = (0..places.len()).filter(|&i| alike(&&places[i])).collect();
            series_list.push(RefinementSeries {
                along: axis.name.clone(),
                rows,
                sizes: axis.sizes.clone(),
                estimate: None,
            });
        }
    }
    series_list
}

/// Computes values, orders, uncertainties, the reference and the errors. `norm` states that values are relative errors.
pub fn evaluate_errors(study: &mut RefinementStudy, exact: Option<f64>, norm: bool) {
    find_values(study);
    for row in &mut study.rows {
        (row.estimates, row.exact_orders, row.uncertainty) = (Vec::new(), Vec::new(), None);
    }
    for series in &mut study.series {
        estimate_along(&mut study.rows, series, exact);
    }
    for row in &mut study.rows {
        let each: Option<Vec<f64>> = row.estimates.iter().map(|e| e.map(|e| e.uncertainty)).collect();
        let noise = study.noise.as_ref().map_or(0.0, |noise| noise.uncertainty);
        row.uncertainty = each.filter(|e| !e.is_empty()).map(|e| e.iter().sum::<f64>().max(noise));
    }
    study.reference = match exact {
        Some(value) => Some(ErrorReference { value, uncertainty: 0.0, row: None }),
        None => limit(study),
    };
    study.scale = if norm { Some(1.0) } else { study.reference.map(|r| r.value.abs()).filter(|v| *v > 0.0) };
    measure_errors(study);
}

fn find_values(study: &mut RefinementStudy) {
    let finest: Vec<Option<usize>> = (0..study.rows.len()).map(|i| finest_of(study, study.rows[i].family)).collect();
    for (i, finest) in finest.into_iter().enumerate() {
        let value = value_against(study, i, finest);
        let row = &mut study.rows[i];
        row.value = value.as_ref().ok().copied();
        if let (Err(reason), Ok(_)) = (value, &row.run) {
            row.run = Err(reason);
        }
    }
}

/// Returns the value of a row; a field is compared with that of the finest row.
fn value_against(study: &RefinementStudy, row: usize, finest: Option<usize>) -> Result<f64, StudyError> {
    let run = study.rows[row].run.as_ref().map_err(StudyError::clone)?;
    let fine = finest.and_then(|f| study.rows[f].run.as_ref().ok()).map(|r| &r.found);
    match (&run.found, fine) {
        (QuantityValue::Number(value), _) => Ok(*value),
        (QuantityValue::Field(_), _) if finest == Some(row) => Ok(0.0),
        (QuantityValue::Field(field), Some(QuantityValue::Field(fine))) => {
            field.relative_norm_against(fine).map_err(StudyError::Comparison)
        }
        (QuantityValue::Field(_), _) => {
            Err(StudyError::Comparison("the finest level has no result to compare with".into()))
        }
    }
}

/// Returns the finest row of a family that has a result.
fn finest_of(study: &RefinementStudy, family: usize) -> Option<usize> {
    let depth = |i: usize| -> usize { study.series.iter().filter_map(|s| s.rows.iter().position(|r| *r == i)).sum() };
    let candidates = (0..study.rows.len()).filter(|&i| study.rows[i].family == family && study.rows[i].run.is_ok());
    let in_series = candidates.filter(|i| study.series.iter().any(|s| s.rows.contains(i)));
    in_series.max_by_key(|&i| depth(i))
}

fn estimate_along(rows: &mut [StudyRow], series: &mut RefinementSeries, exact: Option<f64>) {
    let mut levels: Vec<RefinementLevel> = Vec::new();
    for (&row, &size) in series.rows.iter().zip(&series.sizes) {
        let Some(value) = rows[row].value else { continue };
        levels.push(RefinementLevel { size, value });
        series.estimate = estimate(&levels);
        rows[row].estimates.push(series.estimate);
        if let Some(exact) = exact {
            let error = |l: &RefinementLevel| RefinementLevel { size: l.size, value: l.value - exact };
            let order = match &levels[..] {
                [.., a, b] => order_of_errors(error(a), error(b)),
                _ => None,
            };
            rows[row].exact_orders.push(order);
        }
    }
}

/// The first family gives the reference unless its uncertainty is larger than the smallest one by more than this
/// factor.
const UNCERTAINTY_RATIO: f64 = 2.0;

/// Estimates the limit from the finest row of the first family with a sufficiently small uncertainty, with the
/// corrections of all its series.
fn limit(study: &RefinementStudy) -> Option<ErrorReference> {
    let families = study.rows.iter().map(|r| r.family).max()? + 1;
    let finest = (0..families).filter_map(|f| finest_of(study, f));
    let known = finest.filter_map(|i| Some((i, study.rows[i].uncertainty?, study.rows[i].value?)));
    let known: Vec<(usize, f64, f64)> = known.collect();
    let least = known.iter().fold(f64::INFINITY, |least, k| least.min(k.1));
    let (row, uncertainty, value) = known.into_iter().find(|k| k.1 <= UNCERTAINTY_RATIO * least)?;
    let corrections: f64 = study.rows[row].estimates.iter().flatten().map(|e| e.limit - value).sum();
    Some(ErrorReference { value: value + corrections, uncertainty, row: Some(row) })
}

fn measure_errors(study: &mut RefinementStudy) {
    let Some(reference) = study.reference else { return };
    let fine = reference.row.and_then(|r| study.rows[r].value);
    for (i, row) in study.rows.iter_mut().enumerate() {
        row.error = row.value.map(|v| v - reference.value);
        row.bound = match fine {
            None => row.error.map(f64::abs),
            Some(_) if reference.row == Some(i) => Some(reference.uncertainty),
            Some(fine) => row.value.map(|v| (v - fine).abs() + reference.uncertainty),
        };
    }
}
