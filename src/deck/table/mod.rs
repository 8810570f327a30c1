//! The rows of the keyword table, one file for each family of cards.
//! Never here: what a card does.

pub mod constraints;
mod loads;
pub mod materials;
mod mesh;
mod output;
pub mod steps;
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

/// A parameter or a field: its name alone for a text that is read, or its name, what is done with it, what it may be, and
/// words: `extension` for one that ABAQUS does not have, `only [values]` and `refused` with the reason, `inert` with the note of
/// the ledger; a [`Value`](super::value::Value) in brackets for one that is checked; help.
macro_rules! rule {
    ($name:literal $(read)? $(($value:expr))? $($help:literal)?) => {
        $crate::deck::table::rule!(@ $name, Usage::Read, concat!($($help)?), false, value::TEXT $(; $value)?)
    };
    ($name:literal extension $(($value:expr))? $help:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Read, $help, true, value::TEXT $(; $value)?)
    };
    ($name:literal only [$($value:literal),*] $why:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Only(&[$($value),*], $why), "", false, value::TEXT)
    };
    ($name:literal inert $note:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Inert($note), "", false, value::TEXT)
    };
    ($name:literal refused $why:literal) => {
        $crate::deck::table::rule!(@ $name, Usage::Refused($why), "", false, value::TEXT)
    };
    (@ $name:literal, $usage:expr, $help:expr, $extension:literal, $text:expr; $value:expr) => {
        $crate::deck::table::rule!(@ $name, $usage, $help, $extension, $value)
    };
    (@ $name:literal, $usage:expr, $help:expr, $extension:literal, $value:expr) => {{
        #[allow(unused_imports)] // Not every rule names a value of each.
        use $crate::deck::{keywords::Usage, value};
        $crate::deck::keywords::Rule { name: $name, usage: $usage, help: $help, extension: $extension, value: $value }
    }};
}
use rule;

macro_rules! rules {
    (@ { $($why:literal: $($refused:literal),+;)* } $($name:literal $($kind:ident)? $([$($only:literal),*])? $(($value:expr))? $($text:literal)?),* $(,)?) => {
        &[
            $($crate::deck::table::rule!($name $($kind)? $([$($only),*])? $(($value))? $($text)?),)*
            $($($crate::deck::table::rule!($refused refused $why),)+)*
        ]
    };
    ($($name:literal $($kind:ident)? $([$($only:literal),*])? $(($value:expr))? $($text:literal)?),* $(,)?) => {
        &[$($crate::deck::table::rule!($name $($kind)? $([$($only),*])? $(($value))? $($text)?)),*]
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
    (once $(each)? $(step)? $(below $parent:literal)?) => {
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
    ($(once)? each step) => {
        Place::EachStep
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

/// A row: `NAME`, summary, (how often and where it may stand), `{ parameters }`, `refused { reason: parameters; }` of parameters
/// that are refused for the same reason, `[ (data lines) ]`.
macro_rules! row {
    ($tier:ident, $name:literal, $summary:literal) => { $crate::deck::table::row!(@ Tier::$tier, false, $name, $summary, (), {}, []) };
    (inert $why:literal, $name:literal, $summary:literal) => { $crate::deck::table::row!(@ Tier::Inert($why), false, $name, $summary, (), {}, []) };
    (extension $name:literal, $($rest:tt)*) => { $crate::deck::table::row!(@ Tier::Used, true, $name, $($rest)*) };
    ($name:literal, $($rest:tt)*) => { $crate::deck::table::row!(@ Tier::Used, false, $name, $($rest)*) };
    (@ $tier:expr, $extension:literal, $name:literal, $summary:literal, ($($often:tt)*), { $($parameters:tt)* } $(refused { $($refused:tt)* })?, [$(($($data:tt)*)),* $(,)?]) => {{
        #[allow(unused_imports)] // Not every row names a value of each.
        use $crate::deck::keywords::{Data, Keyword, Place, Shape, Tier, Times};
        Keyword {
            name: $name,
            tier: $tier,
            extension: $extension,
            summary: $summary,
            times: $crate::deck::table::times!($($often)*),
            place: $crate::deck::table::place!($($often)*),
            parameters: $crate::deck::table::rules!(@ { $($($refused)*)? } $($parameters)*),
            data: &[$($crate::deck::table::data!($($data)*)),*],
        }
    }};
}
use row;

/// A card as a type and its row: as [`row`], with the type's name in front, a field's name and type in front of each parameter that
/// the type holds, and those of its data lines in front of their shapes.
macro_rules! card {
    ($type:ident: extension $keyword:literal, $($rest:tt)*) => { $crate::deck::table::card!(@ $type, true, $keyword, $($rest)*); };
    ($type:ident: $keyword:literal, $($rest:tt)*) => { $crate::deck::table::card!(@ $type, false, $keyword, $($rest)*); };
    (@ $type:ident, $extension:literal, $keyword:literal, $summary:literal, ($($often:tt)*), {
        $($($field:ident: $of:ty =)? $name:literal $($kind:ident)? $([$($only:literal),*])? $(($value:expr))? $($text:literal)?),* $(,)?
    } $(refused { $($refused:tt)* })?, $($lines:ident: $lines_of:ty =)? [$($data:tt)*]) => {
        #[doc = concat!("`*", $keyword, "`.")]
        #[derive(Clone, Debug)]
        pub struct $type {
            $($(#[doc = concat!("`", $name, "`.")] pub $field: $of,)?)*
            $(#[doc = "Data lines."] pub $lines: $lines_of,)?
        }

        impl $type {
            /// Its row of the keyword table.
            pub const ROW: $crate::deck::keywords::Keyword = $crate::deck::table::row!(
                @ Tier::Used, $extension, $keyword, $summary, ($($often)*),
                { $($name $($kind)? $([$($only),*])? $(($value))? $($text)?),* } $(refused { $($refused)* })?, [$($data)*]
            );
        }

        impl $crate::deck::read::ReadCard for $type {
            #[allow(unused_variables)] // A card may have nothing to be read.
            fn read(card: &$crate::deck::Card) -> Self {
                $type {
                    $($($field: card.read($name),)?)*
                    $($lines: card.read_lines::<$lines_of>(),)?
                }
            }
        }
    };
}
use card;
