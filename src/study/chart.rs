//! Charts as data: lines and markers over one axis.
//! Never here: where the numbers come from, how they are drawn (`draw`).

/// A chart.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Name of the horizontal axis.
    pub x_label: String,
    /// Name of the vertical axis.
    pub y_label: String,
    /// What is drawn, in order.
    pub series: Vec<Series>,
}

/// How values lie along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithm, on both axes; values are above zero.
    LogLog,
}

/// Points with a name.
#[derive(Clone, Debug)]
pub struct Series {
    /// Shown in the legend.
    pub name: String,
    /// `(x, y)`, ascending in x.
    pub points: Vec<(f64, f64)>,
    /// Whether the points are joined.
    pub joined: bool,
}
