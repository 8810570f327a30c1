//! A deck over levels of refinement: what each level gave, what the levels together say of the limit.

use super::StudyError;
use super::quantity::QuantityValue;
use super::richardson::{Level, LimitEstimate, estimate, order_of_errors};
use super::runner::{StudyRun, StudyRunner};
use super::settings::Axis;

/// The most settings of one study.
const MOST: usize = 10_000;

/// One setting.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyRow {
    /// One value for each axis.
    pub values: Vec<String>,
    /// What it gave, or why nothing.
    pub run: Result<StudyRun, StudyError>,
    /// Settings that differ in levels alone are of one family.
    pub family: usize,
    /// The quantity; for a field the relative norm of its difference from the finest of the family.
    pub value: Option<f64>,
    /// By each series the row is in: observed order and Richardson's value up to it; `None` where it has too few levels.
    pub estimates: Vec<Option<LimitEstimate>>,
    /// Order of its error and the one before, against an exact value, by series.
    pub exact_orders: Vec<Option<f64>>,
    /// Grid convergence index of all series together; `None` where one has too few levels.
    pub uncertainty: Option<f64>,
    /// Difference from the exact value or from the estimate of the limit.
    pub error: Option<f64>,
    /// What the error is below: its size against an exact value, else the distance from the finest and its uncertainty.
    pub bound: Option<f64>,
}

/// Rows whose values converge, coarse to fine.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinementSeries {
    /// What is refined.
    pub along: String,
    /// Indices of rows.
    pub rows: Vec<usize>,
    /// Size of each.
    pub sizes: Vec<f64>,
    /// What its finest levels say.
    pub estimate: Option<LimitEstimate>,
}

/// What errors are measured from.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Reference {
    /// The exact value, or the estimate of the limit.
    pub value: f64,
    /// Its uncertainty; 0 of an exact value.
    pub uncertainty: f64,
    /// The row whose series gave it; `None` for an exact value.
    pub row: Option<usize>,
}

/// Settings, what they gave and what it says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Study {
    /// Names of the axes.
    pub axes: Vec<String>,
    /// All settings.
    pub rows: Vec<StudyRow>,
    /// What converges.
    pub series: Vec<RefinementSeries>,
    /// What errors are measured from; `None` where too little came out.
    pub reference: Option<Reference>,
    /// What makes errors relative; `None` where the reference is zero.
    pub scale: Option<f64>,
}

impl StudyRow {
    /// A setting that has been tried.
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

/// Values of the choices among the axes, one entry a family, and the number of levels of each refinement.
pub(super) fn families(axes: &[Axis]) -> Vec<Vec<(usize, String)>> {
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

/// Runs every combination of all axes' values; the last axis varies fastest.
pub fn grid(bench: &mut StudyRunner<'_>, axes: &[Axis], exact: Option<f64>) -> Result<Study, StudyError> {
    let count = axes.iter().try_fold(1_usize, |n, a| n.checked_mul(a.values.len())).filter(|n| *n <= MOST);
    let slip = || StudyError::Setting(format!("the study has more than {MOST} settings; that is taken for a slip"));
    let count = count.ok_or_else(slip)?;
    let levels = |mut index: usize| {
        let mut of: Vec<usize> =
            axes.iter().rev().map(|a| (index % a.values.len(), index /= a.values.len()).0).collect();
        of.reverse();
        of
    };
    let places: Vec<Vec<usize>> = (0..count).map(levels).collect();
    let choices = |place: &[usize]| -> Vec<usize> {
        axes.iter().zip(place).filter(|(a, _)| !a.is_refinement()).map(|(_, l)| *l).collect()
    };
    let mut known: Vec<Vec<usize>> = Vec::new();
    let mut study = Study { axes: axes.iter().map(|a| a.name.clone()).collect(), ..Study::default() };
    for place in &places {
        let values: Vec<String> = axes.iter().zip(place).map(|(a, l)| a.values[*l].clone()).collect();
        let own = choices(place);
        let family = known.iter().position(|k| *k == own).unwrap_or(known.len());
        if family == known.len() {
            known.push(own);
        }
        let run = bench.at(axes, &values, None);
        study.rows.push(StudyRow::new(values, run, family));
    }
    study.series = series_of(axes, &places);
    judge(&mut study, exact, bench.measure().is_norm());
    Ok(study)
}

/// Along each refinement, with all else alike.
fn series_of(axes: &[Axis], places: &[Vec<usize>]) -> Vec<RefinementSeries> {
    let mut all = Vec::new();
    for (k, axis) in axes.iter().enumerate().filter(|(_, a)| a.is_refinement()) {
        for start in places.iter().filter(|p| p[k] == 0) {
            let alike = |p: &&Vec<usize>| p.iter().zip(start).enumerate().all(|(i, (a, b))| i == k || a == b);
            let rows: Vec<usize> = (0..places.len()).filter(|&i| alike(&&places[i])).collect();
            all.push(RefinementSeries { along: axis.name.clone(), rows, sizes: axis.sizes.clone(), estimate: None });
        }
    }
    all
}

/// Works out values, orders, uncertainties, the reference and the errors from it. `norm`: the value is a relative error.
pub fn judge(study: &mut Study, exact: Option<f64>, norm: bool) {
    find_values(study);
    for row in &mut study.rows {
        (row.estimates, row.exact_orders, row.uncertainty) = (Vec::new(), Vec::new(), None);
    }
    for series in &mut study.series {
        estimate_along(&mut study.rows, series, exact);
    }
    for row in &mut study.rows {
        let each: Option<Vec<f64>> = row.estimates.iter().map(|e| e.map(|e| e.uncertainty)).collect();
        row.uncertainty = each.filter(|e| !e.is_empty()).map(|e| e.iter().sum());
    }
    study.reference = match exact {
        Some(value) => Some(Reference { value, uncertainty: 0.0, row: None }),
        None => limit(study),
    };
    study.scale = if norm { Some(1.0) } else { study.reference.map(|r| r.value.abs()).filter(|v| *v > 0.0) };
    measure_errors(study);
}

fn find_values(study: &mut Study) {
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

/// The value of a row, where fields are compared with the finest row's.
fn value_against(study: &Study, row: usize, finest: Option<usize>) -> Result<f64, StudyError> {
    let run = study.rows[row].run.as_ref().map_err(StudyError::clone)?;
    let fine = finest.and_then(|f| study.rows[f].run.as_ref().ok()).map(|r| &r.found);
    match (&run.found, fine) {
        (QuantityValue::Number(value), _) => Ok(*value),
        (QuantityValue::Field(_), _) if finest == Some(row) => Ok(0.0),
        (QuantityValue::Field(field), Some(QuantityValue::Field(fine))) => {
            field.relative_norm_against(fine).map_err(StudyError::Comparison)
        }
        (QuantityValue::Field(_), _) => Err(StudyError::Comparison("there is no finest level to compare with".into())),
    }
}

/// The row that is last in all its series among those of a family that gave something.
fn finest_of(study: &Study, family: usize) -> Option<usize> {
    let place = |i: usize| -> usize { study.series.iter().filter_map(|s| s.rows.iter().position(|r| *r == i)).sum() };
    let candidates = (0..study.rows.len()).filter(|&i| study.rows[i].family == family && study.rows[i].run.is_ok());
    let in_series = candidates.filter(|i| study.series.iter().any(|s| s.rows.contains(i)));
    in_series.max_by_key(|&i| place(i))
}

fn estimate_along(rows: &mut [StudyRow], series: &mut RefinementSeries, exact: Option<f64>) {
    let mut levels: Vec<Level> = Vec::new();
    for (&row, &size) in series.rows.iter().zip(&series.sizes) {
        let Some(value) = rows[row].value else { continue };
        levels.push(Level { size, value });
        series.estimate = estimate(&levels);
        rows[row].estimates.push(series.estimate);
        if let Some(exact) = exact {
            let error = |l: &Level| Level { size: l.size, value: l.value - exact };
            let order = match &levels[..] {
                [.., a, b] => order_of_errors(error(a), error(b)),
                _ => None,
            };
            rows[row].exact_orders.push(order);
        }
    }
}

/// A family given earlier is believed unless another is surer by more than this.
const SURER: f64 = 2.0;

/// The limit by the finest row of the first family whose uncertainty is among the least: the corrections of all its series.
fn limit(study: &Study) -> Option<Reference> {
    let families = study.rows.iter().map(|r| r.family).max()? + 1;
    let finest = (0..families).filter_map(|f| finest_of(study, f));
    let known = finest.filter_map(|i| Some((i, study.rows[i].uncertainty?, study.rows[i].value?)));
    let known: Vec<(usize, f64, f64)> = known.collect();
    let least = known.iter().fold(f64::INFINITY, |least, k| least.min(k.1));
    let (row, uncertainty, value) = known.into_iter().find(|k| k.1 <= SURER * least)?;
    let corrections: f64 = study.rows[row].estimates.iter().flatten().map(|e| e.limit - value).sum();
    Some(Reference { value: value + corrections, uncertainty, row: Some(row) })
}

fn measure_errors(study: &mut Study) {
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
