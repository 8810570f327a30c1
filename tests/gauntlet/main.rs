//! The gauntlet: scenes in which explicit codes often fail. Each case states the usual failure, the criterion and the
//! result; `docs/stability.md` is generated from them.
//!
//! Every case ends with a result within its tolerance or halts with a place.

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

/// Result of a case.
pub struct CaseVerdict {
    /// Result in few digits.
    pub figure: String,
    /// Whether the criterion is met.
    pub holds: bool,
}

/// A case of the gauntlet.
pub struct GauntletCase {
    /// Topic of the case.
    pub theme: &'static str,
    /// Name of the test.
    pub name: &'static str,
    /// How a less careful code fails.
    pub breaks: &'static str,
    /// Criterion of success.
    pub criterion: &'static str,
    /// Runs the case.
    pub run: fn() -> CaseVerdict,
}

/// Lists the cases of a topic and makes a test of each.
macro_rules! cases {
    ($theme:literal: $($name:ident, $breaks:literal, $criterion:literal;)*) => {
        pub const CASES: &[crate::GauntletCase] = &[$(crate::GauntletCase {
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

/// Returns all cases in the order of the page.
pub fn all() -> impl Iterator<Item = &'static GauntletCase> {
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

fn judge(name: &str, verdict: &CaseVerdict) {
    println!("{name}: {}", verdict.figure);
    assert!(verdict.holds, "{name}: {}", verdict.figure);
}
