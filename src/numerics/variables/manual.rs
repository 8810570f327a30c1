//! Text of `docs/variables.md` and of `revolve explain` for output variables, generated from the table.

use super::request::{FAMILIES, NOT_SIMULATED, UnsimulatedVariable, VariableFamily, VariableRequest};
use super::{PreselectRule, Variable, VariablePlace};

const HEAD: &str = "# Output variables\n\nGenerated from the table of variables; do not edit by hand \
    (`REVOLVE_BLESS=1 cargo test --test deck` updates it). Variables that a model does not have are omitted from its files and \
    listed as unused. Directions: 1 is r, 2 is z, 3 is the hoop direction.\n";

const REACTIONS: &str = "\nHistories of RF and RM are means over the interval since the previous row, as the forces of contact pairs. The integral \
    over time is the impulse of the constraint for any interval: the change of momentum by the velocities of the rows. Frames \
    show the value at their time.\n";

const SETS: &str = "\n## Statistics of sets, and expressions\n\n`STATISTICS=` on `*NODE OUTPUT` and `*ELEMENT OUTPUT` of a history \
    writes one column `<VARIABLE>_<STATISTIC>@<SET>` instead of one for each member. For example, `RF2_SUM@FOOT` is the total \
    reaction force of fixed nodes.\n\n\
    - MEAN is weighted by the current volumes of elements for variables at integration points. It is not weighted for nodes and \
    whole elements.\n\
    - Deleted elements are excluded, except for STATUS. If no element remains, MIN, MAX and MEAN are NaN.\n\
    - RF of a rigid body counts once, for any number of its nodes in the set.\n\n\
    `*OUTPUT EXPRESSION` computes a column from other columns, row by row: `SHORTENING = -1000*(U2@TOP - U2@FOOT)`.\n";

/// Chapters in their order: location of the variables, title, and how they are requested.
const CHAPTERS: &[(VariablePlace, &str, &str)] = &[
    (VariablePlace::Node, "At nodes", "`*NODE OUTPUT`: on points of frames; histories with NSET"),
    (
        VariablePlace::Point,
        "At the integration point of elements",
        "`*ELEMENT OUTPUT`: on cells of frames, or with POSITION=NODES on points as the mean over the adjacent elements; histories \
         with ELSET",
    ),
    (VariablePlace::Element, "For whole elements", "`*ELEMENT OUTPUT`: on cells of frames; histories with ELSET"),
    (VariablePlace::Facet, "On facets of loaded surfaces", "On cells of every frame that contains a loaded surface"),
    (VariablePlace::Section, "Integrated over surfaces", "`*INTEGRATED OUTPUT`: histories"),
    (
        VariablePlace::Pair,
        "For contact pairs",
        "`*CONTACT OUTPUT`: histories, one column for each pair. Forces are means over the interval since the previous row, so that their \
     integral over time is the impulse for any interval; magnitudes are those of the means. CAREA is the value at the time of the row",
    ),
    (
        VariablePlace::Part,
        "For parts",
        "`*ENERGY OUTPUT, ELSET=`: histories, one column for each set. A node contributes the part of its mass that belongs to the \
         active elements of the set: without deleted elements the sum over all parts is the value of the model. So ALLIE is the sum of PARTIE and \
         EROIE, without connector elements. A rigid body counts with its whole mass if one of its elements is in the set",
    ),
    (VariablePlace::Energy, "Energies of the whole model", "`*ENERGY OUTPUT`: histories"),
    (VariablePlace::Increment, "For increments", "`*INCREMENTATION OUTPUT`: histories"),
];

/// Returns the text of `docs/variables.md`.
pub fn variable_manual() -> String {
    let mut text = String::from(HEAD);
    for (place, title, about) in CHAPTERS {
        text += &format!("\n## {title}\n\n{about}.\n\n");
        text += "| name | components | meaning | by default |\n|---|---|---|---|\n";
        text.extend(Variable::ALL.iter().filter(|v| v.place() == *place).map(|v| line(*v)));
        if *place == VariablePlace::Node {
            text += REACTIONS;
        }
    }
    text += SETS;
    text += "\n## Names of several variables\n\n";
    text.extend(FAMILIES.iter().map(|f| format!("- `{}`: {} ({})\n", f.name, f.words, members(f))));
    text += "\n## ABAQUS variables that are not simulated\n\nA request for such a variable is listed as unused.\n\n";
    text.extend(NOT_SIMULATED.iter().map(|k| format!("- `{}`: {}\n", k.name, k.words)));
    text
}

fn line(variable: Variable) -> String {
    let row = variable.row();
    let mark = if row.extension { " (extension)" } else { "" };
    format!("| `{}`{mark} | {} | {} | {} |\n", row.name, components(variable), row.words, by_default(variable))
}

fn components(variable: Variable) -> String {
    let row = variable.row();
    match row.labels {
        [] if row.numbered => format!("{}n", row.name),
        labels => labels.join(", "),
    }
}

/// Returns the condition under which the variable is written without a request by name.
fn by_default(variable: Variable) -> &'static str {
    match (variable.place(), variable.row().preselected, variable.row().deforming) {
        (VariablePlace::Energy, PreselectRule::ElementDeletion, _) => "with *EROSION",
        (VariablePlace::Facet, ..) | (VariablePlace::Energy, _, false) | (_, PreselectRule::Always, _) => "yes",
        (_, PreselectRule::PenaltyContact, _) => "with penalty contact",
        (_, PreselectRule::MassScaling, _) => "with mass scaling",
        (_, PreselectRule::AdaptiveMesh, _) => "with adaptive meshes",
        (_, PreselectRule::EulerianBoundary, _) => "with Eulerian boundaries",
        (_, PreselectRule::Damage, _) => "with a material that can be damaged or fail",
        (_, PreselectRule::HeatConduction, _) => "preselected if temperatures are solved for",
        (VariablePlace::Energy, _, true) => "with deformable bodies, springs or masses",
        (_, PreselectRule::Deformable, _) => "with deformable bodies",
        (_, PreselectRule::ElementDeletion, _) => "if elements can be deleted",
        (_, PreselectRule::Never, _) => "",
        (_, PreselectRule::SurfaceContact, _) => "with contact",
        (_, PreselectRule::CohesiveContact, _) => "with cohesive surfaces",
        (_, PreselectRule::SixDofBody, _) => "histories of bodies with six degrees of freedom",
    }
}

fn members(family: &VariableFamily) -> String {
    family.members.iter().map(|v| v.name()).collect::<Vec<_>>().join(", ")
}

/// Returns the names of all output variables.
pub fn variable_names() -> impl Iterator<Item = &'static str> {
    Variable::ALL.iter().map(|variable| variable.name())
}

/// Returns the description of a variable (case-insensitive); `None` if there is no such name.
pub fn explain_variable(word: &str) -> Option<String> {
    match VariableRequest::parse(&word.trim().to_ascii_uppercase())? {
        VariableRequest::Whole(variable) => Some(explain(variable, variable.name())),
        VariableRequest::One(part) => Some(explain(part.variable, &part.label())),
        VariableRequest::VariableFamily(family) => {
            Some(format!("{}: {}.\nName of several variables: {}.\n", family.name, family.words, members(family)))
        }
        VariableRequest::NotSimulated(UnsimulatedVariable { name, words, .. }) => Some(format!(
            "{name}: {words}.\nAn output variable of ABAQUS that is not simulated: a request is listed as unused.\n"
        )),
        VariableRequest::Preselect | VariableRequest::All => None,
    }
}

fn explain(variable: Variable, name: &str) -> String {
    let row = variable.row();
    let mark = if row.extension { " (extension)" } else { "" };
    let mut text = format!("{name}{mark}: {}.\n", row.words);
    if let Some((_, title, about)) = CHAPTERS.iter().find(|c| c.0 == row.place) {
        text += &format!("Output variable. {title}. {}.\n", about.replace('`', ""));
    }
    let components = components(variable);
    if !components.is_empty() {
        text += &format!("  components: {components}\n");
    }
    let default = by_default(variable);
    if !default.is_empty() {
        text += &format!("  by default: {default}\n");
    }
    text
}
