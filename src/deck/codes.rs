//! Diagnostic codes of the deck room (`D…`) with their explanations.
//! Never here: the checks.

/// A diagnostic code with its explanation, for `revolve explain`.
#[derive(Debug)]
pub struct Code {
    /// The stable code.
    pub code: &'static str,
    /// One line.
    pub title: &'static str,
    /// What it means and what to do.
    pub text: &'static str,
}

const fn code(code: &'static str, title: &'static str, text: &'static str) -> Code {
    Code { code, title, text }
}

/// All codes of this room.
pub const CODES: &[Code] = &[
    code("D100", "the deck cannot be read", "The file named on the command line is missing or may not be read."),
    code("D101", "unknown keyword", "No keyword of ABAQUS or Revolve has this name. Its data lines are passed over."),
    code("D102", "ambiguous keyword", "An abbreviation must fit one keyword only."),
    code("D103", "unknown parameter", "The keyword line carries a word that this keyword does not know."),
    code("D104", "ambiguous parameter", "An abbreviation must fit one parameter only."),
    code("D105", "parameter without value", "After the equals sign a value was expected."),
    code("D106", "data before any keyword", "Data lines belong to the keyword line above them; there is none."),
    code(
        "D107",
        "unknown <name>",
        "The name in angle brackets was not defined by *PARAMETER above. Names are case-sensitive.",
    ),
    code(
        "D108",
        "--set of an unknown parameter",
        "--set replaces the value of a *PARAMETER of the deck; the deck has none of that name.",
    ),
    code("D109", "not a definition", "Data lines of *PARAMETER read `name = expression`."),
    code(
        "D110",
        "expression not understood",
        "Expressions have numbers, names, + - * / % **, brackets, and functions such as sqrt, sin, exp, min, max.",
    ),
    code(
        "D111",
        "expression without value",
        "The expression uses an unknown name, mixes text with numbers, or has no finite result.",
    ),
    code("D112", "*INCLUDE without file", "Write *INCLUDE, INPUT=file."),
    code("D113", "included file missing", "Files are looked up relative to the file that includes them."),
    code(
        "D114",
        "circular include",
        "A file includes itself, directly or through others, or includes nest more than 32 deep.",
    ),
    code("D115", "not a number", "A number was expected: 1. .5 1e-3 1.57d0 are all right."),
    code("D116", "not a whole number", "A whole number was expected, such as a label or a count."),
    code(
        "D120",
        "known, not supported",
        "Revolve knows this keyword of ABAQUS and does not simulate what it asks for. Leaving it out silently would change the physics, so the deck is refused.",
    ),
    code("D121", "not supported, without effect", "The card is left out; no result changes."),
    code("D122", "accepted without effect", "These cards steer output files of other programs."),
];
