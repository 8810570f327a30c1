//! Output requests.

use super::handle::{ElementSetId, InteractionId, NodeSetId, SurfaceId, TimePointsId};
use super::{SideSelection, SurfaceContact};
use crate::deck::Span;
use crate::remesh::interpolation::TracerPoint;
use crate::variables::VariablePlace;
use crate::variables::request::VariableRequest;
use crate::variables::statistic::Statistic;

/// Items that output requests of all steps refer to.
#[derive(Clone, Debug, Default)]
pub struct OutputDefinitions {
    /// Derived history columns (`*OUTPUT EXPRESSION`).
    pub expressions: Vec<OutputExpression>,
    /// `*TIME POINTS` in deck order.
    pub time_points: Vec<TimePoints>,
    /// Points that histories show in place of nodes that new meshes do not have, in the order of the nodes whose names they
    /// have.
    pub tracers: Vec<TracerPoint>,
}

/// An output request: variables, region and interval.
#[derive(Clone, Debug)]
pub struct OutputRequest {
    /// Field output or history output.
    pub kind: OutputKind,
    /// Times or increments at which the request writes.
    pub interval: OutputInterval,
    /// Card of the request; it limits the variables that `PRESELECT` and `ALL` select.
    pub card: OutputCard,
    /// Variables to write, as in the data lines of the request.
    pub variables: Vec<VariableRequest>,
    /// Location at which field output of elements is written.
    pub position: OutputPosition,
    /// Nodes, elements, surfaces or contact pairs whose values are written.
    pub region: OutputRegion,
    /// Statistics over the set (`STATISTICS`); if empty, history output has one column per member.
    pub statistics: Vec<Statistic>,
    /// Upper-case name of the sensor (`SENSOR, NAME=`).
    pub sensor: Option<String>,
    /// Source position of the keyword line.
    pub span: Span,
}

/// A history column that is computed from other columns.
#[derive(Clone, Debug)]
pub struct OutputExpression {
    /// Upper-case name of the column.
    pub name: String,
    /// Expression in names of history columns, as written.
    pub text: String,
    /// Source position of the definition.
    pub span: Span,
    /// Source position of the expression.
    pub place: Span,
}

/// Field output (frames) or history output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// Frames, requested by `*OUTPUT, FIELD`.
    Field,
    /// Rows of the history, requested by `*OUTPUT, HISTORY`.
    History,
}

/// Keyword of an output request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputCard {
    /// Set of variables given by `*OUTPUT, VARIABLE=`.
    Output,
    /// Nodal variables (`*NODE OUTPUT`).
    Node,
    /// Element variables (`*ELEMENT OUTPUT`).
    Element,
    /// Energies of the whole model (`*ENERGY OUTPUT`).
    Energy,
    /// Increment data such as DT (`*INCREMENTATION OUTPUT`).
    Incrementation,
    /// Integrals over surfaces (`*INTEGRATED OUTPUT`).
    Integrated,
    /// Contact variables (`*CONTACT OUTPUT`).
    Contact,
}

impl OutputCard {
    /// Returns the locations of the variables that the card may request.
    pub fn places(self) -> &'static [VariablePlace] {
        match self {
            OutputCard::Output => &[
                VariablePlace::Node,
                VariablePlace::Point,
                VariablePlace::Element,
                VariablePlace::Facet,
                VariablePlace::Energy,
                VariablePlace::Increment,
            ],
            OutputCard::Node => &[VariablePlace::Node],
            OutputCard::Element => &[VariablePlace::Point, VariablePlace::Element, VariablePlace::Facet],
            OutputCard::Energy => &[VariablePlace::Energy, VariablePlace::Part],
            OutputCard::Incrementation => &[VariablePlace::Increment],
            OutputCard::Integrated => &[VariablePlace::Section],
            OutputCard::Contact => &[VariablePlace::Node, VariablePlace::Pair],
        }
    }
}

/// `POSITION` of `*ELEMENT OUTPUT`: location at which field output of integration points is written. Elements have one
/// such point, at the centroid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OutputPosition {
    /// `INTEGRATION POINTS` or `CENTROIDAL`: one value per element.
    #[default]
    Element,
    /// `NODES` or `AVERAGED AT NODES`: nodal values, averaged over the adjacent elements.
    Nodes,
}

/// Times or increments at which output is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutputInterval {
    /// Constant time interval.
    Time(f64),
    /// Number of equal intervals of the step.
    Number(u32),
    /// After each time this number of increments is completed.
    Increments(u32),
    /// Given times (`*TIME POINTS`).
    Points(TimePointsId),
    /// No output (`FREQUENCY=0`).
    Never,
    /// Default interval of the program.
    Default,
}

/// A list of output times (`*TIME POINTS`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimePoints {
    /// Upper-case name.
    pub name: String,
    /// Step times, ascending.
    pub times: Vec<f64>,
}

/// Region of the model for an output request.
#[derive(Clone, Debug, PartialEq)]
pub enum OutputRegion {
    /// All nodes and elements of the model.
    Whole,
    /// The nodes of a set.
    Nodes(NodeSetId),
    /// The elements of a set.
    Elements(ElementSetId),
    /// An element-based surface, and the name prefix of its columns.
    Surface(SurfaceId, String),
    /// The contact pairs that match a filter.
    Pairs(ContactPairFilter),
}

/// Filter of contact pairs; a pair is selected if it satisfies all conditions given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactPairFilter {
    /// Upper-case name of the contact pair set.
    pub cpset: Option<String>,
    /// Only pairs with this surface interaction; `None` for any.
    pub interaction: Option<InteractionId>,
    /// Whether only pairs of general contact are selected.
    pub general: bool,
    /// Upper-case names of surfaces, or of parts of the model, that the pair must contain.
    pub surfaces: Vec<String>,
}

impl ContactPairFilter {
    /// Returns whether a contact pair satisfies the filter.
    pub fn matches(&self, pair: &SurfaceContact) -> bool {
        let has = |name: &String| {
            let is = |s: &SideSelection| {
                let side = ["_SPOS", "_SNEG"].into_iter().find_map(|end| s.name.strip_suffix(end));
                s.name == *name
                    || side == Some(name.as_str())
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
