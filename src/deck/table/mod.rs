//! The rows of the keyword table, one file for each family of cards.
//! Never here: what a card does.

mod constraints;
mod loads;
mod materials;
mod mesh;
mod output;
mod steps;
mod unsupported;

use super::keywords::Keyword;

/// Every row, in the order of the manual.
pub static ALL: &[&[Keyword]] = &[
    mesh::CARDS,
    materials::CARDS,
    constraints::CARDS,
    steps::CARDS,
    loads::CARDS,
    output::CARDS,
    unsupported::OUTPUT_ONLY,
    unsupported::PHYSICS,
    unsupported::ELSEWHERE,
    unsupported::INERT,
];

/// A parameter or a field: its name alone for one that is read, or its name, what is done with it, and words: `read` and
/// `extension` with help, `only [values]` and `refused` with the reason, `inert` with the note of the ledger.
macro_rules! rule {
    ($name:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Read, "", false)
    };
    ($name:literal read $help:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Read, $help, false)
    };
    ($name:literal extension $help:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Read, $help, true)
    };
    ($name:literal only [$($value:literal),*] $why:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Only(&[$($value),*], $why), "", false)
    };
    ($name:literal inert $note:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Inert($note), "", false)
    };
    ($name:literal refused $why:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Refused($why), "", false)
    };
    (@ $name:literal, $usage:expr, $help:literal, $extension:literal) => {{
        use crate::deck::keywords::Usage;
        crate::deck::keywords::Rule { name: $name, usage: $usage, help: $help, extension: $extension }
    }};
}
use rule;

macro_rules! rules {
    ($($name:literal $($kind:ident $([$($value:literal),*])? $text:literal)?),* $(,)?) => {
        &[$($crate::deck::table::rule!($name $($kind $([$($value),*])? $text)?)),*]
    };
}
use rules;

/// `lines [..] [..]`: these lines; `rows [..] [..]`: the last of them repeats; `stream [..]`, `wrapped n [..]`, `list rule`,
/// `text rule`.
macro_rules! shape {
    (lines $([$($fields:tt)*])*) => { Shape::Lines(&[$($crate::deck::table::rules!($($fields)*)),*], false) };
    (rows $([$($fields:tt)*])*) => { Shape::Lines(&[$($crate::deck::table::rules!($($fields)*)),*], true) };
    (stream [$($fields:tt)*]) => { Shape::Stream($crate::deck::table::rules!($($fields)*)) };
    (wrapped $count:literal [$($fields:tt)*]) => { Shape::Wrapped($count, $crate::deck::table::rules!($($fields)*)) };
    (list $($rule:tt)*) => { Shape::List($crate::deck::table::rule!($($rule)*)) };
    (text $($rule:tt)*) => { Shape::Text($crate::deck::table::rule!($($rule)*)) };
}
use shape;

/// `when "PARAMETER" = "VALUE"` before a shape: only there.
macro_rules! data {
    (when $name:literal = $value:literal $($shape:tt)*) => {
        Data { when: Some(($name, $value)), shape: $crate::deck::table::shape!($($shape)*) }
    };
    ($($shape:tt)*) => { Data { when: None, shape: $crate::deck::table::shape!($($shape)*) } };
}
use data;

macro_rules! times {
    () => {
        Times::Any
    };
    (once $(step)? $(below $parent:literal)?) => {
        Times::Once
    };
    (unique $name:literal) => {
        Times::Unique($name)
    };
    ($($other:tt)*) => {
        Times::Any
    };
}
use times;

macro_rules! place {
    (once step) => {
        Place::Step
    };
    (step) => {
        Place::Step
    };
    (once below $parent:literal) => {
        Place::Below($parent)
    };
    (below $parent:literal) => {
        Place::Below($parent)
    };
    ($($other:tt)*) => {
        Place::Anywhere
    };
}
use place;

/// A row: `NAME`, summary, (how often and where it may stand), `{ parameters }`, `[ (data lines) ]`.
macro_rules! row {
    ($tier:ident, $name:literal, $summary:literal) => { $crate::deck::table::row!(@ Tier::$tier, false, $name, $summary, (), {}, []) };
    (inert $why:literal, $name:literal, $summary:literal) => { $crate::deck::table::row!(@ Tier::Inert($why), false, $name, $summary, (), {}, []) };
    (extension $name:literal, $($rest:tt)*) => { $crate::deck::table::row!(@ Tier::Used, true, $name, $($rest)*) };
    ($name:literal, $($rest:tt)*) => { $crate::deck::table::row!(@ Tier::Used, false, $name, $($rest)*) };
    (@ $tier:expr, $extension:literal, $name:literal, $summary:literal, ($($often:tt)*), { $($parameters:tt)* }, [$(($($data:tt)*)),* $(,)?]) => {{
        #[allow(unused_imports)] // Not every row names a value of each.
        use $crate::deck::keywords::{Data, Keyword, Place, Shape, Tier, Times};
        Keyword {
            name: $name,
            tier: $tier,
            extension: $extension,
            summary: $summary,
            times: $crate::deck::table::times!($($often)*),
            place: $crate::deck::table::place!($($often)*),
            parameters: $crate::deck::table::rules!($($parameters)*),
            data: &[$($crate::deck::table::data!($($data)*)),*],
        }
    }};
}
use row;
