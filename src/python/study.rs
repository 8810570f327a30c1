//! Studies and charts.
//! Never here: how they look on a page.

use pyo3::prelude::*;
use revolve::study::StudyError;
use revolve::study::chart::{Chart, Form, Series};
use revolve::study::convergence;
use revolve::study::quantity::Quantity;
use revolve::study::record;
use revolve::study::runner::StudyRunner;
use revolve::study::settings::{self, Axis};
use revolve::study::target::Target;
use revolve::{job, model};

use crate::deck::{Deck, Settings, User};
use crate::errors;
use crate::waiting::Waiting;

/// Named points `(x, y)`, and whether each stands by itself.
type Points = (String, Vec<f64>, Vec<f64>, bool);

/// A chart as SVG.
#[pyfunction]
pub fn chart(py: Python<'_>, title: String, x: String, y: String, series: Vec<Points>) -> PyResult<String> {
    let of = |(name, x, y, marks): Points| {
        let points = x.into_iter().zip(y).filter(|p| p.1.is_finite()).collect();
        Series::new(name, if marks { Form::Marks } else { Form::Line }, points)
    };
    let series = series.into_iter().map(of).collect();
    Chart::new(&title, [&x, &y], series).svg().map_err(|why| errors::study(py, &why))
}

/// What a study is asked for.
struct StudyRequest {
    settings: Settings,
    refine: Vec<String>,
    quantity: String,
    exact: Option<String>,
    target: Option<String>,
    repeat: usize,
}

/// Refines a deck; gives the record as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn study(
    py: Python<'_>,
    deck: &Deck,
    settings: Settings,
    refine: Vec<String>,
    quantity: String,
    exact: Option<String>,
    target: Option<String>,
    repeat: usize,
    user: Option<&User>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let request = StudyRequest { settings, refine, quantity, exact, target, repeat };
    let waiting = Waiting::new(progress);
    let studied = py.detach(|| deck.studied(&request, user, &waiting));
    waiting.end()?;
    studied.map_err(|why| errors::study(py, &why))
}

impl Deck {
    fn studied(&self, request: &StudyRequest, user: Option<&User>, waiting: &Waiting) -> Result<String, StudyError> {
        let quantity = Quantity::parse(&request.quantity)?;
        let exact = convergence::exact(request.exact.as_deref(), &quantity)?;
        let target = request.target.as_deref().map(Target::parse).transpose()?;
        let (axes, runs) = self.axes(request, user, &quantity)?;
        if exact.is_none() && !axes.iter().any(Axis::is_refinement) {
            return Err(StudyError::Setting("choices alone show no error: give exact=, or refine= with levels".into()));
        }
        let source = |overrides: &job::Overrides| self.source.read(overrides);
        let done = std::cell::Cell::new(0_usize);
        let count = || {
            done.set(done.get() + 1);
            waiting.look((done.get() as f64 / runs as f64).min(1.0), &format!("{} runs", done.get()));
        };
        let compiled = user.map(|user| &*user.compiled);
        let mut bench = StudyRunner::new(&source, &request.settings, compiled, &quantity, request.repeat, &count);
        bench.interrupted_by(&waiting.interrupt);
        let (results, met, timing) = convergence::refine(&mut bench, &axes, exact, target)?;
        let table = record::table(&results, true);
        let drawn = |chart: Chart| chart.svg().unwrap_or_default();
        let text = serde_json::json!({
            "header": table.header,
            "rows": table.rows,
            "conclusions": record::conclusions(&results, met.as_ref()),
            "reference": results.reference,
            "price_chart": drawn(record::price_chart(&results, &request.quantity)),
            "order_chart": drawn(record::order_chart(&results, &request.quantity)),
            "met": met.as_ref().map(|met| met.run.is_some()),
            "record": record::record(&quantity.text, exact, &results, met.clone(), timing),
        });
        Ok(text.to_string())
    }

    /// What is refined, and how many runs that takes.
    fn axes(
        &self,
        request: &StudyRequest,
        user: Option<&User>,
        quantity: &Quantity,
    ) -> Result<(Vec<Axis>, usize), StudyError> {
        let routines = revolve::user::compile::Compiled::open_any(user.map(|user| &*user.compiled))?;
        let first = job::prepare_edited(self.source.read(&request.settings), &mut |_| {}, &routines);
        if first.diagnostics.has_errors() {
            return Err(StudyError::refused(&first));
        }
        let parameters: Vec<String> = first.deck.parameters.iter().map(|p| p.0.clone()).collect();
        let axes = settings::axes(&request.refine, &parameters)?;
        if axes.is_empty() {
            return Err(StudyError::Setting("what is to be refined? give refine={\"NAME\": [v1, v2, …]}".into()));
        }
        settings::check(&axes, &model::build(&self.source.read(&request.settings).0).0)?;
        quantity.check(&first.plan)?;
        let runs = axes.iter().map(|a| a.values.len()).product::<usize>() * request.repeat;
        Ok((axes, runs))
    }
}
