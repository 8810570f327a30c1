//! Python functions for studies and charts.

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use revolve::job;
use revolve::model::{self, Model};
use revolve::study::StudyError;
use revolve::study::causes;
use revolve::study::chart::{Chart, ChartSeries, SeriesForm};
use revolve::study::convergence::{self, RefinementRequest};
use revolve::study::evaluate::{SampleEvaluator, UserRoutines};
use revolve::study::inputs::RandomInputs;
use revolve::study::jitter::NoiseRequest;
use revolve::study::limit::{self as limits, LimitRequest};
use revolve::study::quantity::Quantity;
use revolve::study::record;
use revolve::study::runner::{RunSource, StudyRunner};
use revolve::study::sensitivity::{SensitivityRequest, sensitivities};
use revolve::study::settings::{self, StudyAxis};
use revolve::study::target::ErrorTarget;
use revolve::study::uncertainty::{self as uncertainties, ModelTraits, UncertaintyRequest};

use crate::deck::{Deck, ParameterSettings, User};
use crate::errors;
use crate::waiting::{self, ProgressMessage, PythonWait};

/// Name, x, y, and whether the points are drawn as separate markers.
type NamedPoints = (String, Vec<f64>, Vec<f64>, bool);

/// Draws a chart as SVG text.
#[pyfunction]
pub fn chart(py: Python<'_>, title: String, x: String, y: String, series: Vec<NamedPoints>) -> PyResult<String> {
    let series_of = |(name, x, y, marks): NamedPoints| {
        let points = x.into_iter().zip(y).filter(|p| p.1.is_finite()).collect();
        ChartSeries::new(name, if marks { SeriesForm::Marks } else { SeriesForm::Line }, points)
    };
    let series = series.into_iter().map(series_of).collect();
    Chart::new(&title, [&x, &y], series).svg().map_err(|why| errors::study(py, &why.into()))
}

/// Options of a study, as passed from Python.
struct StudyRequest {
    settings: ParameterSettings,
    refine: Vec<String>,
    quantity: String,
    exact: Option<String>,
    target: Option<String>,
    jitter: Option<usize>,
    repeat: usize,
}

/// Runs a convergence study and returns its record as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn study(
    py: Python<'_>,
    deck: &Deck,
    settings: ParameterSettings,
    refine: Vec<String>,
    quantity: String,
    exact: Option<String>,
    target: Option<String>,
    jitter: Option<usize>,
    repeat: usize,
    threads: usize,
    user: Option<&User>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let request = StudyRequest { settings, refine, quantity, exact, target, jitter, repeat };
    let waiting = PythonWait::new(progress);
    let mut receive = |message: Option<ProgressMessage>| match message {
        Some((fraction, text)) => waiting.look(fraction, &text),
        None => waiting.check_signals(),
    };
    let work = |tell: &dyn Fn(ProgressMessage)| deck.studied(&request, user, &waiting.interrupt, tell);
    let studied = py.detach(|| waiting::on_threads(threads, work, &mut receive));
    waiting.end()?;
    studied.map_err(PyOSError::new_err)?.map_err(|why| errors::study(py, &why))
}

/// Runs a deck in memory with its companion runs and returns the certificate as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn uncertainty(
    py: Python<'_>,
    deck: &Deck,
    settings: ParameterSettings,
    quantities: Vec<String>,
    budget: f64,
    distributions: Vec<String>,
    threads: usize,
    user: Option<&User>,
) -> PyResult<String> {
    let waiting = PythonWait::new(None);
    let estimate = |_: &dyn Fn(ProgressMessage)| {
        let quantities = quantities.iter().map(|text| Quantity::parse(text)).collect::<Result<Vec<_>, _>>()?;
        let inputs = RandomInputs::parse(&distributions, &[])?;
        let source = |overrides: &job::ParameterOverrides| deck.source.read(overrides);
        let request = UncertaintyRequest {
            source: RunSource {
                deck: &source,
                user: user.map(|user| &*user.compiled),
                interrupt: Some(&waiting.interrupt),
            },
            overrides: &settings,
            traits: &ModelTraits::of(&model::build(&source(&settings).0).0),
            quantities: &quantities,
            inputs: (!inputs.names.is_empty()).then_some(&inputs),
            budget,
        };
        uncertainties::run_and_estimate(&request)
    };
    let estimated = py.detach(|| waiting::on_threads(threads, estimate, &mut |_| waiting.check_signals()));
    waiting.end()?;
    let certificate = estimated.map_err(PyOSError::new_err)?.map_err(|why| errors::study(py, &why))?;
    Ok(serde_json::json!(certificate).to_string())
}

/// Differentiates quantities by parameters, with their values in `settings` or in the deck, and returns the results as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn sensitivity(
    py: Python<'_>,
    deck: &Deck,
    settings: ParameterSettings,
    quantities: Vec<String>,
    parameters: Vec<String>,
    steps: Vec<Option<f64>>,
    jitter: Option<usize>,
    threads: usize,
    user: Option<&User>,
) -> PyResult<String> {
    let waiting = PythonWait::new(None);
    let differentiate = |_: &dyn Fn(ProgressMessage)| {
        let quantities = quantities.iter().map(|text| Quantity::parse(text)).collect::<Result<Vec<_>, _>>()?;
        let request = SensitivityRequest {
            deck: &deck.source,
            settings: &settings,
            user: user.map(|user| &user.compiled),
            quantities: &quantities,
            names: &parameters,
            steps: &steps,
            jitter,
            log: None,
            in_increments: false,
            threads,
            interrupt: &waiting.interrupt,
        };
        sensitivities(&request, &mut |_| {})
    };
    let differentiated = py.detach(|| waiting::on_threads(threads, differentiate, &mut |_| waiting.check_signals()));
    waiting.end()?;
    let results = differentiated.map_err(PyOSError::new_err)?.map_err(|why| errors::study(py, &why))?;
    Ok(serde_json::json!(results).to_string())
}

/// Finds a ballistic limit and returns its record as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn limit(
    py: Python<'_>,
    deck: &Deck,
    settings: ParameterSettings,
    velocity: String,
    between: String,
    tolerance: f64,
    residual: Option<String>,
    least: Option<f64>,
    shots: usize,
    threads: usize,
    user: Option<&User>,
) -> PyResult<String> {
    let find = || {
        let request = LimitRequest::new(&between, tolerance, least, shots)?;
        let residual = residual.iter().map(|text| Quantity::parse(text)).collect::<Result<_, _>>()?;
        let routines = user.map_or(UserRoutines::Absent, |user| UserRoutines::Files(Arc::clone(&user.compiled)));
        let evaluator = SampleEvaluator::new(deck.source.clone(), settings, vec![velocity], residual, routines)?;
        let evaluator = evaluator.of_shots(least);
        limits::find(&request, &mut |velocities| limits::fire(&request, &evaluator, velocities, &[], threads))
    };
    py.detach(find).map(|found| found.record().to_string()).map_err(|why| errors::study(py, &why))
}

impl Deck {
    fn studied(
        &self,
        request: &StudyRequest,
        user: Option<&User>,
        interrupt: &AtomicUsize,
        tell: &dyn Fn(ProgressMessage),
    ) -> Result<String, StudyError> {
        let quantity = Quantity::parse(&request.quantity)?;
        let exact = convergence::exact(request.exact.as_deref(), &quantity)?;
        let target = request.target.as_deref().map(ErrorTarget::parse).transpose()?;
        let model = model::build(&self.source.read(&request.settings).0).0;
        let axes = self.axes(request, user, &quantity, &model)?;
        let runs = axes.iter().map(|a| a.values.len()).product::<usize>() * request.repeat;
        if exact.is_none() && !axes.iter().any(StudyAxis::is_refinement) {
            return Err(StudyError::Setting(
                "no error can be estimated from options without levels: give exact=, or refine= with numeric levels"
                    .into(),
            ));
        }
        let source = |overrides: &job::ParameterOverrides| self.source.read(overrides);
        let finished_runs = std::cell::Cell::new(0_usize);
        let count = || {
            finished_runs.set(finished_runs.get() + 1);
            tell(((finished_runs.get() as f64 / runs as f64).min(1.0), format!("{} runs", finished_runs.get())));
        };
        let compiled = user.map(|user| &*user.compiled);
        let mut bench = StudyRunner::new(&source, &request.settings, compiled, &quantity, request.repeat, &count);
        bench.interrupted_by(interrupt);
        let request = RefinementRequest {
            axes: &axes,
            exact,
            target,
            noise: NoiseRequest::new(request.jitter, &model),
            causes: causes::limits_of_order(&model),
            announce: &|line| tell((1.0, line.to_owned())),
            around: false,
        };
        let completed = convergence::refine(&mut bench, &request)?;
        let results = &completed.study;
        let table = record::table(results, true);
        let drawn = |chart: Chart| chart.svg().unwrap_or_default();
        let text = serde_json::json!({
            "header": table.header,
            "rows": table.rows,
            "conclusions": record::conclusions(&completed, &quantity.text),
            "reference": results.reference,
            "price_chart": drawn(record::price_chart(results, &quantity.text)),
            "order_chart": drawn(record::order_chart(results, &quantity.text)),
            "met": completed.target.as_ref().map(|met| met.run.is_some()),
            "record": record::record(&quantity.text, exact, &completed),
        });
        Ok(text.to_string())
    }

    /// Returns the axes of the study.
    fn axes(
        &self,
        request: &StudyRequest,
        user: Option<&User>,
        quantity: &Quantity,
        model: &Model,
    ) -> Result<Vec<StudyAxis>, StudyError> {
        let routines = revolve::user::compile::Compiled::open_any(user.map(|user| &*user.compiled))?;
        let first = job::prepare_read(self.source.read(&request.settings), &routines);
        if first.diagnostics.has_errors() {
            return Err(StudyError::refused(&first));
        }
        let parameters: Vec<String> = first.deck.parameters.iter().map(|p| p.0.clone()).collect();
        let axes = settings::axes(&request.refine, &parameters)?;
        if axes.is_empty() {
            return Err(StudyError::Setting("no parameter to refine: give refine={\"NAME\": [v1, v2, …]}".into()));
        }
        settings::check(&axes, model)?;
        quantity.check(&first.plan)?;
        Ok(axes)
    }
}
