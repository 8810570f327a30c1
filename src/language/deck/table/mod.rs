//! Rows of the keyword table, one file per family of cards, and the macros that build them.

pub mod adaptive;
pub mod constraints;
mod loads;
pub mod materials;
mod mesh;
mod output;
pub mod steps;
pub mod strength;
mod unsupported;

use super::keywords::Keyword;

/// All rows, in the order of the manual.
pub static ALL: &[&[Keyword]] = &[
    mesh::CARDS,
    materials::CARDS,
    strength::CARDS,
    constraints::CARDS,
    steps::CARDS,
    adaptive::CARDS,
    loads::CARDS,
    output::CARDS,
    unsupported::OUTPUT_ONLY,
    unsupported::PHYSICS,
    unsupported::ELSEWHERE,
    unsupported::INERT,
];

/// Builds the rule of a parameter or field: its name, then optionally `read` (supported, the default), `extension`
/// (supported, not in ABAQUS), `only [values]` or `refused` with the reason of the error, `inert` with the reason in
/// the ledger; a [`ValueSpec`](super::value::ValueSpec) in parentheses with its allowed range; help text.
macro_rules! rule {
    ($name:literal $(read)? $(($value:expr))? $($help:literal)?) => {
        $crate::deck::table::rule!(@ $name, InputUsage::Read, concat!($($help)?), false, value::TEXT $(; $value)?)
    };
    ($name:literal extension $(($value:expr))? $help:literal) => {
        $crate::deck::table::rule!(@ $name, InputUsage::Read, $help, true, value::TEXT $(; $value)?)
    };
    ($name:literal only [$($value:literal),*] $why:literal) => {
        $crate::deck::table::rule!(@ $name, InputUsage::Only(&[$($value),*], $why), "", false, value::TEXT)
    };
    ($name:literal inert $note:literal) => {
        $crate::deck::table::rule!(@ $name, InputUsage::Inert($note), "", false, value::TEXT)
    };
    ($name:literal refused $why:literal) => {
        $crate::deck::table::rule!(@ $name, InputUsage::Refused($why), "", false, value::TEXT)
    };
    (@ $name:literal, $usage:expr, $help:expr, $extension:literal, $text:expr; $value:expr) => {
        $crate::deck::table::rule!(@ $name, $usage, $help, $extension, $value)
    };
    (@ $name:literal, $usage:expr, $help:expr, $extension:literal, $value:expr) => {{
        #[allow(unused_imports)] // Not every rule uses both.
        use $crate::deck::{keywords::InputUsage, value};
        $crate::deck::keywords::InputRule { name: $name, usage: $usage, help: $help, extension: $extension, value: $value }
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

/// Builds the layout of data lines: `lines [..] [..]` (these lines), `rows [..] [..]` (the last line may be repeated),
/// `stream [..]`, `wrapped n [..]`, `list rule`, `text rule`.
macro_rules! shape {
    (lines $([$($fields:tt)*])*) => { DataShape::Lines(&[$($crate::deck::table::rules!($($fields)*)),*], false) };
    (rows $([$($fields:tt)*])*) => { DataShape::Lines(&[$($crate::deck::table::rules!($($fields)*)),*], true) };
    (stream [$($fields:tt)*]) => { DataShape::Stream($crate::deck::table::rules!($($fields)*)) };
    (wrapped $count:literal [$($fields:tt)*]) => { DataShape::Wrapped($count, $crate::deck::table::rules!($($fields)*)) };
    (list $($rule:tt)*) => { DataShape::List($crate::deck::table::rule!($($rule)*)) };
    (text $($rule:tt)*) => { DataShape::Text($crate::deck::table::rule!($($rule)*)) };
}
use shape;

/// Builds a layout with its condition: `when "PARAMETER"` or `when "PARAMETER" = "VALUE" | "VALUE"`, followed by the layout.
macro_rules! data {
    (when $name:literal = $($value:literal)|+ $shape:ident $($rest:tt)*) => {
        ConditionalShape { when: Some(($name, &[$($value),+])), shape: $crate::deck::table::shape!($shape $($rest)*) }
    };
    (when $name:literal $shape:ident $($rest:tt)*) => {
        ConditionalShape { when: Some(($name, &[])), shape: $crate::deck::table::shape!($shape $($rest)*) }
    };
    ($($shape:tt)*) => { ConditionalShape { when: None, shape: $crate::deck::table::shape!($($shape)*) } };
}
use data;

macro_rules! times {
    () => {
        CardMultiplicity::Any
    };
    (once $(each)? $(step)? $(below $($parent:literal)|+)?) => {
        CardMultiplicity::Once
    };
    (unique $name:literal) => {
        CardMultiplicity::Unique($name)
    };
    ($($other:tt)*) => {
        CardMultiplicity::Any
    };
}
use times;

macro_rules! place {
    (once step) => {
        CardPlace::Step
    };
    ($(once)? each step) => {
        CardPlace::EachStep
    };
    (step) => {
        CardPlace::Step
    };
    ($(once)? below $($parent:literal)|+) => {
        CardPlace::Below(&[$($parent),+])
    };
    ($($other:tt)*) => {
        CardPlace::Anywhere
    };
}
use place;

/// Builds a row of the table: `NAME`, summary, (number of times and position), `{ parameters }`, `refused { reason:
/// names; }` for unsupported parameters with a common reason, `[ (data lines) ]`.
macro_rules! row {
    ($tier:ident, $name:literal, $summary:literal) => { $crate::deck::table::row!(@ KeywordTier::$tier, false, $name, $summary, (), {}, []) };
    (inert $why:literal, $name:literal, $summary:literal) => { $crate::deck::table::row!(@ KeywordTier::Inert($why), false, $name, $summary, (), {}, []) };
    (extension $name:literal, $($rest:tt)*) => { $crate::deck::table::row!(@ KeywordTier::Used, true, $name, $($rest)*) };
    ($name:literal, $($rest:tt)*) => { $crate::deck::table::row!(@ KeywordTier::Used, false, $name, $($rest)*) };
    (@ $tier:expr, $extension:literal, $name:literal, $summary:literal, ($($often:tt)*), { $($parameters:tt)* } $(refused { $($refused:tt)* })?, [$(($($data:tt)*)),* $(,)?]) => {{
        #[allow(unused_imports)] // Not every row uses all types.
        use $crate::deck::keywords::{ConditionalShape, Keyword, CardPlace, DataShape, KeywordTier, CardMultiplicity};
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

/// Defines the type of a card and its row. The syntax is that of [`row`] with the name of the type first; `field: Type
/// =` before a parameter, or before the layouts of the data lines, adds a field to the type.
macro_rules! card {
    ($type:ident: extension $keyword:literal, $($rest:tt)*) => { $crate::deck::table::card!(@ $type, true, $keyword, $($rest)*); };
    ($type:ident: $keyword:literal, $($rest:tt)*) => { $crate::deck::table::card!(@ $type, false, $keyword, $($rest)*); };
    (@ $type:ident, $extension:literal, $keyword:literal, $summary:literal, ($($often:tt)*), {
        $($($field:ident: $of:ty =)? $name:literal $($kind:ident)? $([$($only:literal),*])? $(($value:expr))? $($text:literal)?),* $(,)?
    } $(refused { $($refused:tt)* })?, $($lines:ident: $lines_of:ty =)? [$($data:tt)*]) => {
        #[doc = concat!("`*", $keyword, "`: ", $summary, ".")]
        #[derive(Clone, Debug)]
        pub struct $type {
            $($(#[doc = concat!("`", $name, "`.")] pub $field: $of,)?)*
            $(#[doc = "Data lines."] pub $lines: $lines_of,)?
        }

        impl $type {
            /// Row of the keyword table.
            pub const ROW: $crate::deck::keywords::Keyword = $crate::deck::table::row!(
                @ KeywordTier::Used, $extension, $keyword, $summary, ($($often)*),
                { $($name $($kind)? $([$($only),*])? $(($value))? $($text)?),* } $(refused { $($refused)* })?, [$($data)*]
            );
        }

        impl $crate::deck::read::ReadCard for $type {
            #[allow(unused_variables)] // Some cards have neither parameters nor data lines.
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
