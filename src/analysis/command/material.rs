//! The command `revolve material`: stress-strain curves of the materials of a deck.

use std::error::Error;
use std::path::PathBuf;

use clap::Args;

use super::options::{OutputOptions, ResultOptions, SetOption};
use super::words::{print_err, print_out};
use super::{CommandStatus, PictureFormat, UserFiles, print_table, print_unit_warnings, read_model, write_results};
use crate::deck::names::nearest;
use crate::job;
use crate::model::{HyperelasticLaw, MaterialId, Model};
use crate::output;
use crate::study::material::{self, TensionCurve, TensionRequest};
use crate::study::rubber;
use crate::study::strength::{self, StrengthCurves, StrengthRequest};
use crate::user::Routines;

/// Compute the true stress over the true strain of the materials of a deck in uniaxial tension, with one element.
#[derive(Args)]
pub struct MaterialCommand {
    /// Deck that defines the materials.
    #[arg(value_parser = super::options::deck_parser())]
    deck: PathBuf,
    /// Material name (default: all materials of the deck).
    #[arg(short, long, value_name = "NAME")]
    material: Option<String>,
    /// True strain rates, in 1/time of the deck.
    #[arg(long, value_name = "RATES", value_delimiter = ',', default_value = "1e-3,1,1e3")]
    rates: Vec<f64>,
    /// Initial temperatures (default: those of the deck).
    #[arg(long, value_name = "TEMPERATURES", value_delimiter = ',', allow_negative_numbers = true)]
    temperatures: Vec<f64>,
    /// True strain at the end.
    #[arg(long, value_name = "STRAIN", default_value_t = 0.5)]
    strain: f64,
    /// Neglect heating by plastic work (default: as in the steps of the deck).
    #[arg(long)]
    isothermal: bool,
    /// Element length for damage evolution and cracks of concrete (default: mean length of the elements of the material).
    #[arg(long, value_name = "LENGTH")]
    length: Option<f64>,
    /// Confining pressures of triaxial compression, for laws with a strength over pressure (default: 0, 0.5 and 2 times the
    /// strength in uniaxial compression).
    #[arg(long, value_name = "PRESSURES", value_delimiter = ',')]
    confinements: Vec<f64>,
    /// Write the picture of one material also to this file, .png or .svg.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    results: ResultOptions,
    #[command(flatten)]
    output: OutputOptions,
    #[command(flatten)]
    set: SetOption,
    #[command(flatten)]
    user: UserFiles,
}

/// Curves of a material, with its name.
type NamedCurves = (String, Vec<TensionCurve>);

impl MaterialCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let format = self.plot.as_deref().map(PictureFormat::of).transpose()?;
        self.check()?;
        let (routines, _) = self.user.routines(self.output.is_silent(), false)?;
        let model = self.model()?;
        let chosen = self.chosen(&model)?;
        if format.is_some() && chosen.len() > 1 {
            let names = names(&model).join(", ");
            return Err(format!("--plot draws one material: give --material with one of {names}").into());
        }
        self.results.threads.start()?;
        let named = self.all_curves(&model, &chosen, &routines);
        if named.is_empty() {
            return Err("no material of the deck has a stress-strain curve".into());
        }
        let strengths = self.strengths(&model, &chosen);
        self.write(&model, &named, &strengths, format)
    }

    /// Computes yield surfaces and paths of compression.
    fn strengths(&self, model: &Model, chosen: &[MaterialId]) -> Vec<StrengthCurves> {
        let curves = |&id: &MaterialId| {
            let (confinements, length) = (self.confinements.clone(), self.length(model, id));
            let request = StrengthRequest { confinements, strain: self.strain, length };
            strength::curves(&model.materials[id], &request)
        };
        chosen.iter().filter_map(curves).collect()
    }

    fn check(&self) -> Result<(), String> {
        if let Some(rate) = self.rates.iter().find(|r| !(**r > 0.0 && r.is_finite())) {
            return Err(format!("--rates {rate}: expected numbers above zero, for example 1e-3,1,1e3"));
        }
        if let Some(temperature) = self.temperatures.iter().find(|t| !t.is_finite()) {
            return Err(format!("--temperatures {temperature}: expected numbers, for example 298,600"));
        }
        if let Some(pressure) = self.confinements.iter().find(|p| !(**p >= 0.0 && p.is_finite())) {
            return Err(format!(
                "--confinements {pressure}: expected pressures of at least zero, for example 0,10e6,50e6"
            ));
        }
        if !(self.strain > 0.0 && self.strain <= 3.0) {
            return Err(format!("--strain {}: expected a true strain above 0, at most 3", self.strain));
        }
        match self.length.filter(|length| !(*length > 0.0 && length.is_finite())) {
            Some(length) => Err(format!("--length {length}: expected a length above zero")),
            None => Ok(()),
        }
    }

    fn model(&self) -> Result<Model, Box<dyn Error>> {
        let (deck, model) = read_model(&self.deck, &self.set.pairs()?)?;
        if !self.output.is_silent() {
            print_unit_warnings(&model.materials, model.settings.units.as_ref(), &deck.sources);
        }
        Ok(model)
    }

    /// Returns the materials to compute.
    fn chosen(&self, model: &Model) -> Result<Vec<MaterialId>, String> {
        let material_ids = || (0..model.materials.len()).map(MaterialId::new);
        let Some(name) = &self.material else { return Ok(material_ids().collect()) };
        let chosen: Vec<MaterialId> =
            material_ids().filter(|&id| model.materials[id].name.eq_ignore_ascii_case(name.trim())).collect();
        if !chosen.is_empty() {
            return Ok(chosen);
        }
        let names = names(model);
        Err(match nearest(name, names.iter().copied()) {
            Some(near) => format!("--material {name}: no such material; did you mean {near}?"),
            None => format!("--material {name}: no such material; the deck defines {}", names.join(", ")),
        })
    }

    /// Computes the curves of the chosen materials, and prints the reason for each material without curves.
    fn all_curves(&self, model: &Model, chosen: &[MaterialId], routines: &Routines) -> Vec<NamedCurves> {
        let mut named = Vec::new();
        for &id in chosen {
            let material = &model.materials[id];
            let computed = match material::obstacle(material) {
                Some(reason) => Err(reason.to_owned()),
                None => material::curves(model, id, &self.request(model, id), routines).map_err(|e| e.to_string()),
            };
            match computed {
                Ok(curves) => named.push((material.name.clone(), curves)),
                Err(_) if self.output.is_silent() => {}
                Err(reason) => print_err!("note: material {} has no curve: {reason}", material.name),
            }
        }
        named
    }

    /// Returns the characteristic length of elements.
    fn length(&self, model: &Model, id: MaterialId) -> f64 {
        self.length.or_else(|| material::element_length(model, id)).unwrap_or(1.0)
    }

    fn request(&self, model: &Model, id: MaterialId) -> TensionRequest {
        let temperatures = match &self.temperatures[..] {
            [] => material::initial_temperatures(model, id),
            given => given.iter().copied().map(Some).collect(),
        };
        let length = self.length(model, id);
        if material::takes_length(&model.materials[id]) && !self.output.is_silent() {
            print_out!("{}: damage with the element length {length}", model.materials[id].name);
        }
        TensionRequest {
            rates: self.rates.clone(),
            temperatures,
            strain: self.strain,
            adiabatic: self.heats(model),
            length,
        }
    }

    /// Returns whether plastic work heats the material.
    fn heats(&self, model: &Model) -> bool {
        !self.isothermal && model.steps.iter().any(|step| step.adiabatic || step.coupled)
    }

    fn write(
        &self,
        model: &Model,
        named: &[NamedCurves],
        strengths: &[StrengthCurves],
        format: Option<PictureFormat>,
    ) -> Result<CommandStatus, Box<dyn Error>> {
        let units = model.settings.units.as_ref();
        let ending = |name: &str| if named.len() == 1 { String::new() } else { format!("_{}", file_word(name)) };
        let mut charts: Vec<_> =
            named.iter().map(|(name, curves)| (ending(name), material::chart(name, curves, units))).collect();
        let (job, _lock) = self.results.lock_job(&self.deck)?;
        job::make_folder(&job)?;
        let labels = self.results.labels.checked(material::AXES)?;
        let fitted = fitted_laws(model, named);
        for (name, law) in &fitted {
            let pictures = rubber::charts(name, law, units);
            charts.extend(pictures.into_iter().map(|(kind, chart)| (format!("{}{kind}", ending(name)), chart)));
        }
        let mut tables = Vec::new();
        if !strengths.is_empty() {
            for curves in strengths {
                let pictures = strength::charts(curves, units);
                charts.extend(pictures.map(|(kind, chart)| (format!("{}{kind}", ending(&curves.name)), chart)));
            }
            tables.push(("_material_strength.csv".to_owned(), strength::point_table(strengths).csv().into_bytes()));
        }
        write_results(&job, "material", &material::point_table(named), tables, &charts, &labels)?;
        if let (Some(path), Some(format), Some((_, chart))) = (&self.plot, format, charts.first()) {
            output::write_whole(path, &format.bytes(&labels.applied(chart.clone()).drawing()?)?)?;
        }
        self.output.print_json(&material::record(named, strengths))?;
        if self.output.is_silent() {
            return Ok(super::output_status());
        }
        print_table(&material::table(named, self.strain, units));
        if !fitted.is_empty() {
            print_table(&rubber::table(&fitted));
        }
        if !strengths.is_empty() {
            print_table(&strength::table(strengths, units));
        }
        for (name, curves) in named {
            for (curve, reason) in curves.iter().filter_map(|c| Some((c, c.halt.as_ref()?))) {
                print_err!("warning: {name}, {}: the run halted: {reason}", curve.label(units));
            }
        }
        print_out!(
            "true stress in uniaxial tension, {}",
            if self.heats(model) { "with heating" } else { "isothermal" }
        );
        print_out!("curves {}", job.path("_material.csv").display());
        if !strengths.is_empty() {
            print_out!("yield surfaces and paths {}", job.path("_material_strength.csv").display());
        }
        for (ending, _) in &charts {
            print_out!("picture {}", job.path(&format!("_material{ending}.png")).display());
        }
        self.plot.iter().for_each(|path| print_out!("picture {}", path.display()));
        Ok(super::output_status())
    }
}

/// Returns the chosen materials whose constants are fitted to test data.
fn fitted_laws<'a>(model: &'a Model, named: &[NamedCurves]) -> Vec<(String, &'a HyperelasticLaw)> {
    let is_chosen = |name: &str| named.iter().any(|(chosen, _)| chosen == name);
    let laws = model.materials.iter().filter_map(|m| Some((m.name.clone(), m.hyperelastic.as_ref()?)));
    laws.filter(|(name, law)| is_chosen(name) && !law.test_data.is_empty()).collect()
}

fn names(model: &Model) -> Vec<&str> {
    model.materials.iter().map(|m| m.name.as_str()).collect()
}

/// Returns a name with `_` in place of characters that file names should not contain.
fn file_word(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '-' { c } else { '_' }).collect()
}
