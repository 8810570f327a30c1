//! The page of output variables and what `revolve explain` says of one, written from the table.
//! Never here: anything the table does not say.

use super::request::{FAMILIES, NOT_SIMULATED, UnsimulatedVariable, VariableFamily, VariableRequest};
use super::{Place, Preselected, Variable};

const HEAD: &str = "# Output variables\n\nWritten from the table of variables; do not edit by hand \
(`REVOLVE_BLESS=1 cargo test --test deck` writes it anew). What a scene does not have is left out of its files and \
listed as unused. Directions: 1 is r, 2 is z, 3 the hoop.\n";

const SETS: &str = "\n## Of whole sets, and of other columns\n\n`STATISTICS=` on `*NODE OUTPUT` and `*ELEMENT OUTPUT` of a history \
gives a column `<VARIABLE>_<STATISTIC>@<SET>` in place of one for each member, such as `RF2_SUM@FOOT`, the force on a wall of nodes \
that are held. MEAN is weighted by the volumes of elements now where a variable lives at integration points, and not weighted at \
nodes and of whole elements. Deleted elements are left out (of all but STATUS); where none is left MIN, MAX and MEAN are not a number. \
RF of a rigid body counts once, however many of its nodes are in the set.\n\n`*OUTPUT EXPRESSION` makes columns of others, row by row: \
`SHORTENING = -1000*(U2@TOP - U2@FOOT)`.\n";

/// Chapters in their order: where variables live, and how decks ask for them.
const CHAPTERS: &[(Place, &str, &str)] = &[
    (Place::Node, "At nodes", "`*NODE OUTPUT`: in frames on points; histories with NSET"),
    (
        Place::Point,
        "In elements, at their integration point",
        "`*ELEMENT OUTPUT`: in frames on cells, with POSITION=NODES on points as the mean over the elements around; histories \
         with ELSET",
    ),
    (Place::Element, "Of whole elements", "`*ELEMENT OUTPUT`: in frames on cells; histories with ELSET"),
    (Place::Facet, "On facets of loaded surfaces", "In every frame of a loaded surface, on cells"),
    (Place::Section, "Of surfaces, integrated", "`*INTEGRATED OUTPUT`: histories"),
    (Place::Pair, "Of two surfaces in contact", "`*CONTACT OUTPUT`: histories, a column for each pair"),
    (Place::Energy, "Energies of the whole model", "`*ENERGY OUTPUT`: histories"),
    (Place::Increment, "Of increments", "`*INCREMENTATION OUTPUT`: histories"),
];

/// The text of `docs/variables.md`.
pub fn variable_manual() -> String {
    let mut text = String::from(HEAD);
    for (place, title, about) in CHAPTERS {
        text += &format!("\n## {title}\n\n{about}.\n\n");
        text += "| name | components | what | by default |\n|---|---|---|---|\n";
        text.extend(Variable::ALL.iter().filter(|v| v.place() == *place).map(|v| line(*v)));
    }
    text += SETS;
    text += "\n## Names for several\n\n";
    text.extend(FAMILIES.iter().map(|f| format!("- `{}`: {} ({})\n", f.name, f.words, members(f))));
    text += "\n## Known and not simulated\n\nA request for them is listed as unused.\n\n";
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

/// When it is shown without a request by name.
fn by_default(variable: Variable) -> &'static str {
    match (variable.place(), variable.row().preselected, variable.row().deforming) {
        (Place::Energy, Preselected::Deleting, _) => "where there is *EROSION",
        (Place::Facet, ..) | (Place::Energy, _, false) | (_, Preselected::Always, _) => "yes",
        (_, Preselected::Springing, _) => "where contact has penalty springs",
        (Place::Energy, _, true) | (_, Preselected::Deforming, _) => "where something deforms",
        (_, Preselected::Deleting, _) => "where elements can be deleted",
        (_, Preselected::Never, _) => "",
        (_, Preselected::Meeting, _) => "where surfaces meet",
        (_, Preselected::Oblique, _) => "histories of oblique bodies",
        (_, Preselected::Conducting, _) => "preselected where temperatures are solved for",
    }
}

fn members(family: &VariableFamily) -> String {
    family.members.iter().map(|v| v.name()).collect::<Vec<_>>().join(", ")
}

/// Names of all output variables.
pub fn variable_names() -> impl Iterator<Item = &'static str> {
    Variable::ALL.iter().map(|variable| variable.name())
}

/// What is said of a variable, in any case; `None` where there is none of that name.
pub fn explain_variable(word: &str) -> Option<String> {
    match VariableRequest::parse(&word.trim().to_ascii_uppercase())? {
        VariableRequest::Whole(variable) => Some(explain(variable, variable.name())),
        VariableRequest::One(part) => Some(explain(part.variable, &part.label())),
        VariableRequest::VariableFamily(family) => {
            Some(format!("{}: {}.\nStands for {}.\n", family.name, family.words, members(family)))
        }
        VariableRequest::NotSimulated(UnsimulatedVariable { name, words, .. }) => Some(format!(
            "{name}: {words}.\nAn output variable of ABAQUS that is not simulated: a request is left unused.\n"
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
