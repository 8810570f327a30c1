//! The one keyword table: parser, `explain` and the keyword manual all read it.
//! Never here: what a card does.

/// What is done with a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    /// Parsed and used.
    Used,
    /// Changes only output files of another program: accepted, one summary note.
    OutputOnly,
    /// Parsed now; used where the capability is there, otherwise the model says why not.
    Parsed,
    /// Known and not supported; ignoring it would change the physics: an error.
    UnsupportedPhysics,
    /// Known and not supported; ignoring it changes no result: a note.
    UnsupportedInert,
}

/// A parameter that a keyword line may carry.
#[derive(Debug)]
pub struct ParameterRule {
    /// Canonical name, upper case, single blanks.
    pub name: &'static str,
    /// One line for the manual.
    pub help: &'static str,
}

/// One keyword.
#[derive(Debug)]
pub struct Keyword {
    /// Canonical name, upper case, single blanks, no star.
    pub name: &'static str,
    /// What is done with it.
    pub tier: Tier,
    /// Not in ABAQUS: ours.
    pub extension: bool,
    /// One line for the manual.
    pub summary: &'static str,
    /// The parameters it may carry.
    pub parameters: &'static [ParameterRule],
    /// What the data lines say, one line per data line.
    pub data: &'static [&'static str],
}
