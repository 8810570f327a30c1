//! The gauntlet: scenes that break codes that are not careful. Each case says what breaks such a code, by what it is
//! judged, and what was reached; `docs/stability.md` is written from them.
//!
//! Every case ends in an answer inside its tolerance or in a halt that names a place.

#[path = "../common/mod.rs"]
mod common;

mod axis;
mod guards;
mod hourglass;
mod implosion;
mod incompressible;
mod loads;
mod meshes;
mod numbers;
mod page;
mod random;
mod scene;
mod shocks;

/// What a case came to.
pub struct Verdict {
    /// In few digits.
    pub figure: String,
    /// Whether the criterion is met.
    pub holds: bool,
}

/// A case of the gauntlet.
pub struct Case {
    /// What it is about.
    pub theme: &'static str,
    /// Name of the test.
    pub name: &'static str,
    /// What breaks a code that is not careful.
    pub breaks: &'static str,
    /// By what it is judged.
    pub criterion: &'static str,
    /// Runs it.
    pub run: fn() -> Verdict,
}

/// Lists the cases of a theme and makes a test of each.
macro_rules! cases {
    ($theme:literal: $($name:ident, $breaks:literal, $criterion:literal;)*) => {
        pub const CASES: &[crate::Case] = &[$(crate::Case {
            theme: $theme,
            name: stringify!($name),
            breaks: $breaks,
            criterion: $criterion,
            run: $name,
        }),*];

        mod cases {
            $(#[test]
            fn $name() {
                crate::judge(stringify!($name), &super::$name());
            })*
        }
    };
}
pub(crate) use cases;

/// All cases in the order of the page.
pub fn all() -> impl Iterator<Item = &'static Case> {
    [
        axis::CASES,
        shocks::CASES,
        implosion::CASES,
        incompressible::CASES,
        hourglass::CASES,
        meshes::CASES,
        loads::CASES,
        numbers::CASES,
        guards::CASES,
        random::CASES,
    ]
    .into_iter()
    .flatten()
}

fn judge(name: &str, verdict: &Verdict) {
    println!("{name}: {}", verdict.figure);
    assert!(verdict.holds, "{name}: {}", verdict.figure);
}
