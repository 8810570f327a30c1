//! Data of charts: lines, markers and areas.

use serde::ser::SerializeStruct as _;
use serde::{Serialize, Serializer};
use thiserror::Error;

/// Reason why a chart cannot be drawn, as text for the user.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct ChartError(pub String);

/// A chart. Its JSON keys are those that `report/page.js` reads.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Chart {
    /// Title, drawn above the plot.
    pub title: String,
    /// Label of the horizontal axis.
    pub x_label: String,
    /// Label of the vertical axis.
    pub y_label: String,
    /// Units of the horizontal and the vertical axis; empty if unknown.
    #[serde(skip_serializing_if = "are_unknown")]
    pub units: [String; 2],
    /// Description of the chart.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub words: String,
    /// Scale of both axes.
    #[serde(rename = "logarithmic", serialize_with = "is_logarithmic")]
    pub scale: AxisScale,
    /// Series in drawing order; later ones cover earlier ones.
    pub series: Vec<ChartSeries>,
}

impl Chart {
    /// Creates a chart with linear axes and the given axis labels.
    pub fn new(title: &str, [x, y]: [&str; 2], series: Vec<ChartSeries>) -> Chart {
        Chart { title: title.into(), x_label: x.into(), y_label: y.into(), series, ..Chart::default() }
    }

    /// Returns whether the chart has no points.
    pub fn is_empty(&self) -> bool {
        self.series.iter().all(|series| series.points.is_empty())
    }
}

/// Scale of both axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AxisScale {
    /// Both axes are linear.
    #[default]
    Linear,
    /// Logarithmic axes; values must be above zero.
    LogLog,
}

/// Way in which the points of a series are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SeriesForm {
    /// Points joined by a line.
    #[default]
    Line,
    /// Separate markers without a line.
    Marks,
    /// Area stacked on the previous ones, negative values downwards. All areas of a chart have the same abscissae.
    Area,
    /// Thin dashed line, as a reference for others.
    Guide,
    /// Filled band: points along its lower edge, then back along its upper edge.
    Band,
}

/// Named series of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartSeries {
    /// Name in the legend.
    pub name: String,
    /// `(x, y)`, ascending in x.
    pub points: Vec<(f64, f64)>,
    /// How the points are drawn.
    pub form: SeriesForm,
    /// Text of each point, shown on a report page; empty without texts.
    pub words: Vec<String>,
}

impl ChartSeries {
    /// Creates a series without texts.
    pub fn new(name: impl Into<String>, form: SeriesForm, points: Vec<(f64, f64)>) -> ChartSeries {
        ChartSeries { name: name.into(), points, form, words: Vec::new() }
    }
}

impl Serialize for ChartSeries {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (x, y): (Vec<f64>, Vec<f64>) = self.points.iter().copied().unzip();
        let mut series = serializer.serialize_struct("Series", 5)?;
        series.serialize_field("name", &self.name)?;
        series.serialize_field("form", &self.form)?;
        series.serialize_field("x", &x)?;
        series.serialize_field("y", &y)?;
        if !self.words.is_empty() {
            series.serialize_field("words", &self.words)?;
        }
        series.end()
    }
}

fn are_unknown(units: &[String; 2]) -> bool {
    units.iter().all(String::is_empty)
}

fn is_logarithmic<S: Serializer>(scale: &AxisScale, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bool(*scale == AxisScale::LogLog)
}

/// Lower and upper edge of an area at each of its points, for its positive and its negative part.
pub type AreaEdges = [Vec<(f64, f64)>; 2];

/// Returns the edges of the stacked areas of some series, in the order of the series.
pub fn stacked<'a>(series: impl IntoIterator<Item = &'a ChartSeries>) -> Vec<AreaEdges> {
    let mut reached: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    let areas = series.into_iter().filter(|s| s.form == SeriesForm::Area);
    let lay = |area: &ChartSeries| {
        [f64::max as fn(f64, f64) -> f64, f64::min].map(|side| {
            let below = usize::from(side(-1.0, 1.0) < 0.0);
            reached[below].resize(area.points.len(), 0.0);
            let rise = |(top, point): (&mut f64, &(f64, f64))| {
                let from = *top;
                *top += side(point.1, 0.0);
                (from, *top)
            };
            reached[below].iter_mut().zip(&area.points).map(rise).collect()
        })
    };
    areas.map(lay).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_values_are_stacked_downwards() {
        let area = |values: [f64; 2]| ChartSeries {
            points: vec![(0.0, values[0]), (1.0, values[1])],
            form: SeriesForm::Area,
            ..ChartSeries::default()
        };
        let edges = stacked(&[area([1.0, 2.0]), area([-3.0, 4.0]), area([5.0, -6.0])]);
        assert_eq!(edges[0], [vec![(0.0, 1.0), (0.0, 2.0)], vec![(0.0, 0.0), (0.0, 0.0)]]);
        assert_eq!(edges[1], [vec![(1.0, 1.0), (2.0, 6.0)], vec![(0.0, -3.0), (0.0, 0.0)]]);
        assert_eq!(edges[2], [vec![(1.0, 6.0), (6.0, 6.0)], vec![(-3.0, -3.0), (0.0, -6.0)]]);
    }
}
