//! Parameters that a study varies: deck parameters and settings of the model.

use super::StudyError;
use super::grid::CaseGrid;
use crate::deck::names::nearest;
use crate::deck::{MESH_SETTINGS, MeshScaling};
use crate::job::ParameterOverrides;
use crate::model::{HourglassMethod, IncrementControl, Load, LoadKind, LoadVelocity, Model, SectionControls, Step};

/// Names of the parameters that are available for every deck.
const BUILT_IN: [(&str, StudyParameter); 5] = [
    ("mesh", StudyParameter::Mesh),
    ("increment", StudyParameter::Increment),
    ("load-velocity", StudyParameter::LoadVelocity),
    ("hourglass", StudyParameter::Hourglass),
    ("estimate", StudyParameter::Estimate),
];

/// Parameter varied by an axis of a study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StudyParameter {
    /// A `*PARAMETER` of the deck.
    Parameter(String),
    /// Number of parts of each edge of the mesh.
    Mesh,
    /// Factor on the time increment.
    Increment,
    /// Velocity passed to loads: predicted or lagged.
    LoadVelocity,
    /// Type of hourglass control.
    Hourglass,
    /// Stable time increment element by element or by the global estimate.
    Estimate,
}

/// Axis of a study: a parameter with its values.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyAxis {
    /// Name of the parameter as written.
    pub name: String,
    /// Parameter that the values belong to.
    pub parameter: StudyParameter,
    /// Values from coarse to fine, as written.
    pub values: Vec<String>,
    /// Size of each value, decreasing; empty if the values are options without levels.
    pub sizes: Vec<f64>,
}

impl StudyAxis {
    /// Returns whether the values are levels of refinement.
    pub fn is_refinement(&self) -> bool {
        !self.sizes.is_empty()
    }

    /// Returns the size of a value. Values that increase from coarse to fine are numbers of elements or facets, with
    /// size 1/value; values that decrease are sizes.
    pub fn size(&self, value: f64) -> f64 {
        if self.rises() { 1.0 / value } else { value }
    }

    /// Returns the axis value that corresponds to an element size: the inverse of the size if the axis counts elements.
    pub fn value(&self, size: f64) -> f64 {
        if self.rises() { 1.0 / size } else { size }
    }

    /// Returns the run time of a value, relative to that of the deck with these parameters: a mesh with half the element
    /// size has four times the elements and twice the increments.
    pub fn relative_cost(&self, value: &str, parameters: &[(String, f64)]) -> f64 {
        let Ok(number) = value.parse::<f64>() else { return 1.0 };
        match &self.parameter {
            StudyParameter::Mesh => number.powi(3),
            StudyParameter::Increment => 1.0 / number,
            StudyParameter::Parameter(name) if self.is_refinement() => {
                let of_deck = parameters.iter().find(|(known, _)| known == name);
                of_deck.map_or(1.0, |&(_, value)| (self.size(value) / self.size(number)).powi(3))
            }
            _ => 1.0,
        }
    }

    fn rises(&self) -> bool {
        let numbers: Vec<f64> = self.values.iter().filter_map(|v| v.parse().ok()).collect();
        numbers.len() > 1 && numbers[1] > numbers[0]
    }

    /// Returns whether the values are increasing integers; further values must then be integers.
    pub fn counts(&self) -> bool {
        self.rises() && self.values.iter().all(|v| v.parse::<u64>().is_ok())
    }
}

/// Parses all `--refine NAME=v1,v2,…` for a deck with the given parameters.
pub fn axes(settings: &[String], parameters: &[String]) -> Result<Vec<StudyAxis>, StudyError> {
    read(settings, parameters).map_err(StudyError::Setting)
}

fn read(settings: &[String], parameters: &[String]) -> Result<Vec<StudyAxis>, String> {
    let grid =
        CaseGrid::read(settings).map_err(|e| e.replace("--set", "--refine").replace("the sweep", "the study"))?;
    grid.axes().iter().map(|(name, values)| axis(name, values, parameters)).collect()
}

fn axis(name: &str, values: &[String], parameters: &[String]) -> Result<StudyAxis, String> {
    let parameter = parameter(name, parameters)?;
    let values = &values.iter().map(|value| without_fraction(&parameter, value)).collect::<Vec<_>>()[..];
    let mut axis = StudyAxis { name: name.to_owned(), parameter, values: values.to_vec(), sizes: Vec::new() };
    for value in values {
        edit(&axis.parameter, value)?;
    }
    let numbers: Option<Vec<f64>> = values.iter().map(|v| v.parse().ok()).collect();
    match numbers {
        Some(numbers) => axis.sizes = sizes(name, &numbers, &axis)?,
        None if axis.parameter == StudyParameter::Increment => {
            return Err(format!("--refine {name}: expected numeric factors, for example 1,0.5,0.25"));
        }
        None => {}
    }
    Ok(axis)
}

fn parameter(name: &str, parameters: &[String]) -> Result<StudyParameter, String> {
    if parameters.iter().any(|p| p == name) {
        return Ok(StudyParameter::Parameter(name.to_owned()));
    }
    let known = BUILT_IN.into_iter().find(|known| known.0 == name);
    known.map(|known| known.1).ok_or_else(|| unknown(name, parameters))
}

fn unknown(name: &str, parameters: &[String]) -> String {
    let built_in = BUILT_IN.map(|known| known.0);
    let known = parameters.iter().map(String::as_str).chain(built_in);
    let near = nearest(name, known).map(|n| format!("did you mean {n}? ")).unwrap_or_default();
    let deck_parameters = if parameters.is_empty() { "none".into() } else { parameters.join(", ") };
    format!(
        "--refine {name}: unknown parameter; {near}parameters of the deck: {deck_parameters}; parameters of every study: {}",
        built_in.join(", ")
    )
}

fn sizes(name: &str, numbers: &[f64], axis: &StudyAxis) -> Result<Vec<f64>, String> {
    if numbers.len() < 2 {
        return Err(format!("--refine {name}: give two or more levels, from coarse to fine"));
    }
    let rising = numbers.windows(2).all(|w| w[1] > w[0]);
    let falling = numbers.windows(2).all(|w| w[1] < w[0]);
    if !(rising || falling) || numbers.iter().any(|v| !(*v > 0.0 && v.is_finite())) {
        return Err(format!(
            "--refine {name}: levels must be above zero and go from coarse to fine: increasing for numbers (elements, \
             facets), decreasing for sizes (lengths, increments)"
        ));
    }
    if rising && axis.parameter == StudyParameter::Increment {
        return Err(format!("--refine {name}: factors on the increment must decrease from coarse to fine"));
    }
    Ok(numbers.iter().map(|v| if rising { 1.0 / v } else { *v }).collect())
}

fn refuse(why: &str) -> Result<(), StudyError> {
    Err(StudyError::Setting(why.into()))
}

/// Function that changes a model, or returns why this is not possible.
pub type ModelEdit = Box<dyn Fn(&mut Model) -> Result<(), StudyError> + Send + Sync>;

/// Returns the change of the model for a value of a parameter; `None` for values that are applied to the deck.
pub(crate) fn edit(parameter: &StudyParameter, value: &str) -> Result<Option<ModelEdit>, String> {
    match parameter {
        StudyParameter::Parameter(_) => Ok(None),
        StudyParameter::Mesh => mesh_factor(value).map(|()| None),
        StudyParameter::Increment => increment(value).map(Some),
        StudyParameter::LoadVelocity => load_velocity(value).map(Some),
        StudyParameter::Hourglass => hourglass(value).map(Some),
        StudyParameter::Estimate => stable_estimate(value).map(Some),
    }
}

/// Checks that each parameter has an effect in this model.
pub fn check(axes: &[StudyAxis], model: &Model) -> Result<(), StudyError> {
    for axis in axes {
        for value in &axis.values {
            if let Some(edit) = edit(&axis.parameter, value).map_err(StudyError::Setting)? {
                edit(&mut model.clone())?;
            }
        }
    }
    Ok(())
}

/// Returns a fraction 1/N of the setting `mesh` as a number; other values are unchanged.
fn without_fraction(parameter: &StudyParameter, value: &str) -> String {
    let parts = value.strip_prefix("1/").filter(|_| *parameter == StudyParameter::Mesh);
    let whole = parts.and_then(|n| n.parse::<u32>().ok());
    whole.map_or_else(|| value.to_owned(), |n| (1.0 / f64::from(n)).to_string())
}

fn mesh_factor(value: &str) -> Result<(), String> {
    let scaling = value.parse().ok().and_then(MeshScaling::from_factor);
    scaling.map(drop).ok_or_else(|| {
        format!(
            "--refine mesh={value}: expected a whole number of parts of each edge, or 1/2, 1/3 and so on to merge \
             elements, for example 1/2,1,2,4"
        )
    })
}

fn increment(value: &str) -> Result<ModelEdit, String> {
    let factor = value.parse::<f64>().ok().filter(|f| *f > 0.0 && f.is_finite());
    let factor = factor.ok_or_else(|| format!("--refine increment={value}: expected a factor above zero"))?;
    Ok(Box::new(move |model| {
        let deforms = deforms(model);
        model.steps.iter_mut().try_for_each(|step| scale_increment(step, factor, deforms))
    }))
}

/// Scales a fixed or stable time increment; with error control the accuracy is scaled by the square of the factor.
fn scale_increment(step: &mut Step, factor: f64, deforms: bool) -> Result<(), StudyError> {
    if let IncrementControl::Automatic { largest, .. } = &mut step.increment {
        *largest *= factor;
    }
    match &mut step.increment {
        IncrementControl::Fixed(length) => *length *= factor,
        IncrementControl::Automatic { .. } if deforms => step.scale_factor *= factor,
        IncrementControl::Automatic { accuracy, .. } => {
            *accuracy *= factor * factor;
            if !(1e-14..=0.1).contains(accuracy) {
                return Err(StudyError::Setting(format!(
                    "--refine increment={factor}: ACCURACY is scaled by the square of the factor and would be {accuracy:e}; \
                     it must be between 1e-14 and 0.1"
                )));
            }
        }
    }
    Ok(())
}

/// Returns whether a load depends on velocity: resistance of a target or a user load.
fn reads_velocity(model: &Model) -> bool {
    let reads = |l: &Load| l.kind.is_user() || matches!(l.kind, LoadKind::Cavity { .. });
    model.steps.iter().any(|s| s.loads.iter().any(reads))
}

/// Returns whether the model has deformable elements: elements of a section that belong to no rigid body.
pub fn deforms(model: &Model) -> bool {
    let rigid = |e: &usize| model.rigid_bodies.iter().any(|b| b.elements.contains(e));
    model.material_regions().any(|(_, elements)| elements.iter().any(|e| !rigid(e)))
}

fn load_velocity(value: &str) -> Result<ModelEdit, String> {
    let scheme = match value {
        "predicted" => LoadVelocity::Predicted,
        "lagged" => LoadVelocity::Lagged,
        _ => return Err(format!("--refine load-velocity={value}: expected predicted or lagged")),
    };
    Ok(Box::new(move |model| {
        if !reads_velocity(model) || !model.rigid_bodies.iter().any(|b| !b.elements.is_empty()) {
            return refuse(
                "--refine load-velocity: the model has no load that depends on the velocity of a rigid body",
            );
        }
        model.steps.iter_mut().for_each(|s| s.load_velocity = scheme);
        Ok(())
    }))
}

fn hourglass(value: &str) -> Result<ModelEdit, String> {
    let kind = match value {
        "relax-stiffness" => HourglassMethod::RelaxStiffness,
        "stiffness" => HourglassMethod::Stiffness,
        "viscous" => HourglassMethod::Viscous,
        "combined" => HourglassMethod::Combined(0.5),
        "enhanced" => HourglassMethod::Enhanced,
        _ => {
            return Err(format!(
                "--refine hourglass={value}: expected relax-stiffness, stiffness, viscous, combined or enhanced"
            ));
        }
    };
    Ok(Box::new(move |model| {
        if !deforms(model) {
            return refuse("--refine hourglass: the model has no deformable elements");
        }
        control_hourglass(model, kind, 1.0);
        Ok(())
    }))
}

/// Sets type and factor of the hourglass control of all sections; other section controls are unchanged.
pub fn control_hourglass(model: &mut Model, hourglass: HourglassMethod, factor: f64) {
    control(model, |controls| (controls.hourglass, controls.factor) = (Some(hourglass), factor));
}

/// Changes the section controls of all sections.
pub fn control(model: &mut Model, change: impl Fn(&mut SectionControls)) {
    model.sections.iter_mut().for_each(|section| change(&mut section.controls));
}

fn stable_estimate(value: &str) -> Result<ModelEdit, String> {
    let each = match value {
        "element" => true,
        "global" => false,
        _ => return Err(format!("--refine estimate={value}: expected element or global")),
    };
    Ok(Box::new(move |model| {
        if !deforms(model) {
            return refuse("--refine estimate: the model has no deformable elements");
        }
        if model.steps.iter().all(|s| s.increment.is_fixed()) {
            return refuse("--refine estimate: the increment is fixed by DIRECT USER CONTROL");
        }
        for step in &mut model.steps {
            if let IncrementControl::Automatic { element_by_element, .. } = &mut step.increment {
                *element_by_element = each;
            }
        }
        Ok(())
    }))
}

/// Returns overrides of a deck with a number of parts of each edge of the mesh.
pub fn with_mesh(overrides: &ParameterOverrides, parts: &str) -> Vec<(String, String)> {
    [overrides, &[(MESH_SETTINGS[1].to_owned(), parts.to_owned())]].concat()
}

/// Returns overrides of a deck without those of the mesh.
pub fn without_mesh(overrides: &ParameterOverrides) -> Vec<(String, String)> {
    overrides.iter().filter(|(name, _)| !MESH_SETTINGS.contains(&name.as_str())).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_must_be_monotonic_and_names_known() {
        let parsed = |text: &str| axes(&[text.to_owned()], &["n".to_owned(), "dt".to_owned()]);
        let n = &parsed("n=10,20,40").expect("levels")[0];
        assert_eq!((n.sizes.clone(), n.counts()), (vec![0.1, 0.05, 0.025], true));
        let dt = &parsed("dt=1e-6,5e-7").expect("levels")[0];
        assert_eq!((dt.sizes.clone(), dt.counts()), (vec![1e-6, 5e-7], false));
        assert!(!parsed("load-velocity=predicted,lagged").expect("choices")[0].is_refinement());
        for wrong in [
            "n=10",
            "n=10,10",
            "n=10,40,20",
            "n=0,1",
            "m=1,2",
            "increment=1,2",
            "increment=a,b",
            "hourglass=no",
            "mesh=1,1.5",
        ] {
            assert!(parsed(wrong).is_err(), "{wrong}");
        }
        assert!(parsed("N=1,2").is_err_and(|e| e.to_string().contains("did you mean n?")));
    }
}
