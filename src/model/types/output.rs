//! Output requests.
//! Never here: files.

use super::handle::{ElementSetId, InteractionId, NodeSetId, SurfaceId, TimePointsId};
use super::{Sides, SurfaceContact};
use crate::deck::Span;
use crate::variables::Place;
use crate::variables::request::VariableRequest;
use crate::variables::statistic::Statistic;

/// What output requests of all steps refer to.
#[derive(Clone, Debug, Default)]
pub struct OutputDefinitions {
    /// `*OUTPUT EXPRESSION`: history columns that follow from others.
    pub expressions: Vec<OutputExpression>,
    /// `*TIME POINTS` in deck order.
    pub time_points: Vec<TimePoints>,
}

/// What to write and when.
#[derive(Clone, Debug)]
pub struct OutputRequest {
    /// Fields into frames, or histories into columns.
    pub kind: OutputKind,
    /// How often.
    pub interval: Interval,
    /// The card that asks: `PRESELECT` and `ALL` mean what lives there.
    pub card: OutputCard,
    /// What is asked for.
    pub variables: Vec<VariableRequest>,
    /// Where fields of elements are shown.
    pub position: Position,
    /// What the variables are taken from.
    pub region: Region,
    /// What histories show of the whole set (`STATISTICS`); a column for each member where empty.
    pub statistics: Vec<Statistic>,
    /// Name of the sensor that it is (`SENSOR, NAME=`), upper case.
    pub sensor: Option<String>,
    /// The card.
    pub span: Span,
}

/// A history column that follows from others.
#[derive(Clone, Debug)]
pub struct OutputExpression {
    /// Its name, upper case.
    pub name: String,
    /// The expression over names of history columns, as written.
    pub text: String,
    /// Where the definition stands.
    pub span: Span,
    /// Where the expression stands.
    pub place: Span,
}

/// Frames or histories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// `*OUTPUT, FIELD`.
    Field,
    /// `*OUTPUT, HISTORY`.
    History,
}

/// The card of an output request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputCard {
    /// `*OUTPUT, VARIABLE=` itself.
    Output,
    /// `*NODE OUTPUT`.
    Node,
    /// `*ELEMENT OUTPUT`.
    Element,
    /// `*ENERGY OUTPUT`.
    Energy,
    /// `*INCREMENTATION OUTPUT`.
    Incrementation,
    /// `*INTEGRATED OUTPUT`.
    Integrated,
    /// `*CONTACT OUTPUT`.
    Contact,
}

impl OutputCard {
    /// Where the variables live that it may ask for.
    pub fn places(self) -> &'static [Place] {
        match self {
            OutputCard::Output => {
                &[Place::Node, Place::Point, Place::Element, Place::Facet, Place::Energy, Place::Increment]
            }
            OutputCard::Node => &[Place::Node],
            OutputCard::Element => &[Place::Point, Place::Element, Place::Facet],
            OutputCard::Energy => &[Place::Energy],
            OutputCard::Incrementation => &[Place::Increment],
            OutputCard::Integrated => &[Place::Section],
            OutputCard::Contact => &[Place::Node, Place::Pair],
        }
    }
}

/// `POSITION` of `*ELEMENT OUTPUT`: where a frame shows variables of integration points. An element has one such point, in
/// its middle, so that those and centroids are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Position {
    /// `INTEGRATION POINTS`, `CENTROIDAL`: on elements.
    #[default]
    Element,
    /// `NODES`, `AVERAGED AT NODES`: on nodes, the mean over the elements around.
    Nodes,
}

/// How often output is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interval {
    /// Every so much time.
    Time(f64),
    /// So many times over the step, evenly.
    Number(u32),
    /// Every so many increments.
    Increments(u32),
    /// At these times of the step.
    Points(TimePointsId),
    /// Never (`FREQUENCY=0`).
    Never,
    /// The program's default.
    Default,
}

/// `*TIME POINTS`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimePoints {
    /// Name, upper case.
    pub name: String,
    /// Times of the step, ascending.
    pub times: Vec<f64>,
}

/// What output variables are taken from.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// The whole model.
    Whole,
    /// A node set.
    Nodes(NodeSetId),
    /// An element set.
    Elements(ElementSetId),
    /// A surface of element faces, and the name of its columns.
    Surface(SurfaceId, String),
    /// Pairs of surfaces in contact.
    Pairs(WhichPairs),
}

/// Which pairs of surfaces are meant: those that are all of what is given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WhichPairs {
    /// The set of pairs, upper case.
    pub cpset: Option<String>,
    /// The surface interaction.
    pub interaction: Option<InteractionId>,
    /// Whether those of general contact alone.
    pub general: bool,
    /// Surfaces by upper-case name, or parts of which the pair has.
    pub surfaces: Vec<String>,
}

impl WhichPairs {
    /// Whether a pair is meant.
    pub fn means(&self, pair: &SurfaceContact) -> bool {
        let has = |name: &String| {
            let is = |s: &Sides| {
                s.name == *name
                    || s.name.strip_suffix(name.as_str()).is_some_and(|b| b.ends_with('.') && !b.ends_with(".NOT."))
            };
            pair.sides.iter().any(is)
        };
        self.cpset.as_ref().is_none_or(|set| pair.cpset.as_ref() == Some(set))
            && self.interaction.is_none_or(|id| pair.interaction == Some(id))
            && (!self.general || pair.general)
            && self.surfaces.iter().all(has)
    }
}
