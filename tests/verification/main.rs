//! Verification: answers of the solver against answers from outside the code. One file a subject; the rows of
//! `docs/verification.md` name them.

#[path = "../common/mod.rs"]
mod common;

mod alike;
mod area;
mod bars;
mod cavities;
mod element_output;
mod fidelity;
mod large_motion;
mod links;
mod loads;
mod mass_scaling;
mod materials;
mod over_temperature;
mod properties;
mod rates;
mod rigid;
mod scene;
mod shock;
mod soft;
mod solid;
mod steps;
mod taylor;
mod vessels;
mod waves;
