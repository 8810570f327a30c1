//! `revolve run --uncertainty`: options, companion runs, and the certificate file.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::deck;
use crate::job::{ParameterOverrides, PreparedJob, RunSummary};
use crate::output::{self, JobFiles};
use crate::study::chosen::{self, ChosenSetting, TargetRequest};
use crate::study::inputs::RandomInputs;
use crate::study::local;
use crate::study::map::regions::MapFile;
use crate::study::quantity::Quantity;
use crate::study::record::CERTIFICATE;
use crate::study::runner::{RunSource, element_count};
use crate::study::target::ErrorTarget;
use crate::study::uncertainty::{
    DEFAULT_BUDGET, ModelTraits, PlainRun, RunCertificate, UncertaintyRequest, estimate_run, of_chosen,
};
use crate::user::compile::Compiled;
use clap::Args;
use indexmap::IndexSet;

use super::run::duration;
use super::words::print_out;

/// Largest cost of companion runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CostBudget {
    /// Fraction of the cost of the run.
    Share(f64),
    /// Wall-clock time.
    Time(Duration),
}

/// Time budget of `--target` by default.
const DEFAULT_TIME: Duration = Duration::from_secs(600);

/// Parses a budget in per cent or as a time.
fn budget(text: &str) -> Result<CostBudget, String> {
    let wrong = || "expected per cent above zero, for example 40%, or a time such as 10s, 5m or 1h".to_owned();
    match text.strip_suffix('%') {
        Some(number) => {
            let share = number.trim().parse::<f64>().ok().filter(|share| *share > 0.0 && share.is_finite());
            share.map(|share| CostBudget::Share(share / 100.0)).ok_or_else(wrong)
        }
        None => duration(text).map(CostBudget::Time).ok_or_else(wrong),
    }
}

/// Options of the uncertainty of a run.
#[derive(Args)]
pub struct UncertaintyOptions {
    /// Estimate the uncertainty of each --quantity (default: the final value of each *OUTPUT EXPRESSION) by runs on
    /// coarser meshes, with another increment, and with small perturbations.
    #[arg(long)]
    pub uncertainty: bool,
    /// Choose mesh and increment such that the error of the --quantity is below this value, for example 1%
    /// (relative) or 1e-6 (absolute), and write `<job>_certificate.json`.
    #[arg(long, value_name = "ERROR", conflicts_with_all = ["uncertainty", "mesh_refine", "resume", "resume_anyway"])]
    target: Option<String>,
    /// With --target: refine only the regions of the mesh that cause the error, found by an error map; write the refined deck as
    /// `<job>_local.inp` and run it.
    #[arg(long, requires = "target")]
    local: bool,
    /// Largest cost of --uncertainty relative to the run (default: 40%), or largest time of --target (default: 10m).
    #[arg(long, value_name = "PERCENT|TIME", value_parser = budget)]
    budget: Option<CostBudget>,
    /// Random parameter, whose effect --uncertainty adds: NAME=low..high, NAME=normal(mean, deviation) and so on, as
    /// for `scatter`; can be repeated.
    #[arg(long, value_name = "NAME=DISTRIBUTION", requires = "uncertainty")]
    distribution: Vec<String>,
    /// Error map `<job>_map.json` of `revolve study --map`: the line of its quantity names the regions with the largest shares
    /// of the mesh error.
    #[arg(long, value_name = "FILE", requires = "uncertainty")]
    map: Option<PathBuf>,
}

/// A run whose uncertainty is estimated.
pub struct EstimatedRun<'a> {
    pub deck: &'a Path,
    /// Overrides of the deck.
    pub overrides: &'a ParameterOverrides,
    /// Compiled user subroutines.
    pub user: Option<&'a Compiled>,
    /// Properties of the model.
    pub traits: &'a ModelTraits,
    pub quantities: &'a [Quantity],
}

impl UncertaintyOptions {
    /// Returns the quantities, each once: those given or, with `--uncertainty`, the final values of the expressions of the
    /// deck.
    pub fn quantities(&self, given: &[String], traits: &ModelTraits) -> Result<Vec<Quantity>, Box<dyn Error>> {
        let default = || traits.expressions.iter().map(|name| format!("final({name})")).collect();
        let texts: Vec<String> = if given.is_empty() && self.uncertainty { default() } else { given.to_vec() };
        if self.uncertainty && texts.is_empty() {
            return Err("--uncertainty needs a --quantity, or an *OUTPUT EXPRESSION in the deck".into());
        }
        let texts: IndexSet<String> = texts.into_iter().collect();
        Ok(texts.iter().map(|text| Quantity::parse(text)).collect::<Result<_, _>>()?)
    }

    /// Parses the distributions; `None` without any.
    pub fn inputs(&self) -> Result<Option<RandomInputs>, Box<dyn Error>> {
        match (self.budget, self.uncertainty, &self.target) {
            (None, _, _) | (Some(CostBudget::Share(_)), true, _) | (Some(CostBudget::Time(_)), _, Some(_)) => {}
            _ => return Err("--budget needs --uncertainty (per cent) or --target (a time)".into()),
        }
        let inputs = RandomInputs::parse(&self.distribution, &[])?;
        Ok((!inputs.names.is_empty()).then_some(inputs))
    }

    /// Returns whether a certificate is requested.
    pub fn is_requested(&self) -> bool {
        self.uncertainty || self.target.is_some()
    }

    /// Chooses the setting for `--target`; `None` without the option.
    pub fn chosen(&self, run: &EstimatedRun<'_>, quiet: bool) -> Result<Option<ChosenSetting>, Box<dyn Error>> {
        let Some(target) = self.target.as_deref().map(ErrorTarget::parse).transpose()? else { return Ok(None) };
        let [quantity] = run.quantities else { return Err("--target needs exactly one --quantity".into()) };
        let source = |overrides: &ParameterOverrides| deck::read(run.deck, overrides);
        let request = TargetRequest {
            source: RunSource { deck: &source, user: run.user, interrupt: None },
            overrides: run.overrides,
            quantity,
            target,
            budget: if let Some(CostBudget::Time(time)) = self.budget { time } else { DEFAULT_TIME },
            announce: &|line| {
                if !quiet {
                    print_out!("{line}");
                }
            },
        };
        let chosen = if self.local { local::choose(&request)? } else { chosen::choose(&request)? };
        if !quiet {
            chosen.conclusions.iter().for_each(|line| print_out!("{line}"));
        }
        Ok(Some(chosen))
    }

    /// Runs the companion runs and writes the certificate.
    pub fn estimate(
        &self,
        run: &EstimatedRun<'_>,
        inputs: Option<&RandomInputs>,
        chosen: Option<ChosenSetting>,
        prepared: &PreparedJob,
        (summary, values): (&RunSummary, Vec<Option<f64>>),
        job: &JobFiles,
    ) -> Result<RunCertificate, Box<dyn Error>> {
        let source = |overrides: &ParameterOverrides| deck::read(run.deck, overrides);
        let budget = if let Some(CostBudget::Share(share)) = self.budget { share } else { DEFAULT_BUDGET };
        let request = UncertaintyRequest {
            source: RunSource { deck: &source, user: run.user, interrupt: None },
            overrides: run.overrides,
            traits: run.traits,
            quantities: run.quantities,
            inputs,
            budget,
        };
        let plain_run = PlainRun {
            values,
            elements: element_count(prepared),
            increments: summary.timing.increments,
            energies: [summary.energy.kinetic, summary.energy.internal],
        };
        let (deck, digest) = (prepared.identity("").deck, summary.digest.clone());
        let mut certificate = match chosen {
            Some(chosen) => of_chosen(chosen, &plain_run, deck, digest),
            None => estimate_run(&request, &plain_run, deck, digest),
        };
        if let Some(path) = &self.map {
            let map = MapFile::read(path)?;
            if !certificate.add_regions(&map.quantity, &map.shares()) {
                return Err(
                    format!("--map {}: its quantity {} is not a --quantity", path.display(), map.quantity).into()
                );
            }
        }
        let text = serde_json::to_string_pretty(&certificate)? + "\n";
        output::write_with_sums(job, &[(CERTIFICATE.into(), text.into_bytes())], "_certificate.sfv")?;
        Ok(certificate)
    }
}
