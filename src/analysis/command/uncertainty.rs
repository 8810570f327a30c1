//! `revolve run --uncertainty`: options, companion runs, and the certificate file.

use std::error::Error;
use std::path::Path;

use crate::deck;
use crate::job::{ParameterOverrides, PreparedJob, RunSummary};
use crate::output::{self, JobFiles};
use crate::study::inputs::RandomInputs;
use crate::study::quantity::Quantity;
use crate::study::record::CERTIFICATE;
use crate::study::runner::RunSource;
use crate::study::uncertainty::{
    DEFAULT_BUDGET, ModelTraits, PlainRun, RunCertificate, UncertaintyRequest, estimate_run,
};
use crate::user::compile::Compiled;
use clap::Args;

/// Options of the uncertainty of a run.
#[derive(Args)]
pub struct UncertaintyOptions {
    /// Estimate the uncertainty of each --quantity (default: the final value of each *OUTPUT EXPRESSION) by runs on
    /// coarser meshes, with another increment and precision, and with small perturbations.
    #[arg(long)]
    pub uncertainty: bool,
    /// Largest cost of the companion runs of --uncertainty in per cent of that of the run.
    #[arg(long, value_name = "PERCENT", requires = "uncertainty", default_value_t = 100.0 * DEFAULT_BUDGET)]
    budget: f64,
    /// Random parameter, whose effect --uncertainty adds: NAME=low..high, NAME=normal(mean, deviation) and so on, as
    /// for `scatter`; can be repeated.
    #[arg(long, value_name = "NAME=DISTRIBUTION", requires = "uncertainty")]
    distribution: Vec<String>,
}

/// A run whose uncertainty is estimated.
pub struct EstimatedRun<'a> {
    /// Path of the deck.
    pub deck: &'a Path,
    /// Overrides of the deck.
    pub overrides: &'a ParameterOverrides,
    /// Compiled user subroutines.
    pub user: Option<&'a Compiled>,
    /// Properties of the model.
    pub traits: &'a ModelTraits,
    /// Quantities of the run.
    pub quantities: &'a [Quantity],
}

impl UncertaintyOptions {
    /// Returns the quantities: those given or, with `--uncertainty`, the final values of the expressions of the deck.
    pub fn quantities(&self, given: &[String], traits: &ModelTraits) -> Result<Vec<Quantity>, Box<dyn Error>> {
        let default = || traits.expressions.iter().map(|name| format!("final({name})")).collect();
        let texts: Vec<String> = if given.is_empty() && self.uncertainty { default() } else { given.to_vec() };
        if self.uncertainty && texts.is_empty() {
            return Err("--uncertainty needs a --quantity, or an *OUTPUT EXPRESSION in the deck".into());
        }
        Ok(texts.iter().map(|text| Quantity::parse(text)).collect::<Result<_, _>>()?)
    }

    /// Parses the distributions; `None` without any.
    pub fn inputs(&self) -> Result<Option<RandomInputs>, Box<dyn Error>> {
        if !(self.budget > 0.0 && self.budget.is_finite()) {
            return Err(format!("--budget {}: expected per cent above zero, for example 40", self.budget).into());
        }
        let inputs = RandomInputs::parse(&self.distribution, &[])?;
        Ok((!inputs.names.is_empty()).then_some(inputs))
    }

    /// Runs the companion runs and writes the certificate.
    pub fn estimate(
        &self,
        run: &EstimatedRun<'_>,
        inputs: Option<&RandomInputs>,
        prepared: &PreparedJob,
        (summary, values): (&RunSummary, Vec<Option<f64>>),
        job: &JobFiles,
    ) -> Result<RunCertificate, Box<dyn Error>> {
        let source = |overrides: &ParameterOverrides| deck::read(run.deck, overrides);
        let request = UncertaintyRequest {
            source: RunSource { deck: &source, user: run.user, interrupt: None },
            overrides: run.overrides,
            traits: run.traits,
            quantities: run.quantities,
            inputs,
            budget: self.budget / 100.0,
        };
        let elements = prepared.plan.mesh.elements.iter().filter(|e| !e.kind.is_discrete()).count();
        let plain = PlainRun { values, elements, increments: summary.timing.increments };
        let certificate = estimate_run(&request, &plain, prepared.identity("").deck, summary.digest.clone());
        let text = serde_json::to_string_pretty(&certificate)? + "\n";
        output::write_with_sums(job, &[(CERTIFICATE.into(), text.into_bytes())], "_certificate.sfv")?;
        Ok(certificate)
    }
}
