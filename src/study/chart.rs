//! Charts as data: lines, markers and areas over one axis.

use serde::ser::SerializeStruct as _;
use serde::{Serialize, Serializer};

/// A chart; on a page it has the keys that `report/page.js` reads.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Name of the horizontal axis.
    pub x_label: String,
    /// Name of the vertical axis.
    pub y_label: String,
    /// Units of both; empty where they are not known.
    #[serde(skip_serializing_if = "are_unknown")]
    pub units: [String; 2],
    /// A description of what is drawn.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub words: String,
    /// How values lie along both axes.
    #[serde(rename = "logarithmic", serialize_with = "is_logarithmic")]
    pub scale: Scale,
    /// What is drawn, in order.
    pub series: Vec<Series>,
}

impl Chart {
    /// A chart with linear axes, named by quantity.
    pub fn new(title: &str, [x, y]: [&str; 2], series: Vec<Series>) -> Chart {
        Chart { title: title.into(), x_label: x.into(), y_label: y.into(), series, ..Chart::default() }
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.series.iter().all(|series| series.points.is_empty())
    }
}

/// How values lie along the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm, on both axes; values are above zero.
    LogLog,
}

/// How points are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Joined by a line.
    #[default]
    Line,
    /// Each by itself.
    Marks,
    /// An area stacked on the previous ones, negative values downwards. All areas of a chart have the same abscissae.
    Area,
    /// A thin broken line to compare others with.
    Guide,
    /// What lies within an outline: points along its lower edge, then back along the upper one.
    Band,
}

/// Points with a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Shown in the legend.
    pub name: String,
    /// `(x, y)`, ascending in x.
    pub points: Vec<(f64, f64)>,
    /// How they are shown.
    pub form: Form,
    /// A word for each point, which a page shows with it; empty where there are none.
    pub words: Vec<String>,
}

impl Series {
    /// Points without words.
    pub fn new(name: impl Into<String>, form: Form, points: Vec<(f64, f64)>) -> Series {
        Series { name: name.into(), points, form, words: Vec::new() }
    }
}

impl Serialize for Series {
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

fn is_logarithmic<S: Serializer>(scale: &Scale, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bool(*scale == Scale::LogLog)
}

/// Lower and upper edge of an area at each of its points: of what is above zero, and of what is below.
pub type Edges = [Vec<(f64, f64)>; 2];

/// Where the areas among some series lie, in their order.
pub fn stacked<'a>(series: impl IntoIterator<Item = &'a Series>) -> Vec<Edges> {
    let mut reached: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    let areas = series.into_iter().filter(|s| s.form == Form::Area);
    let lay = |area: &Series| {
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
    fn what_is_below_zero_is_stacked_downwards() {
        let area = |values: [f64; 2]| Series {
            points: vec![(0.0, values[0]), (1.0, values[1])],
            form: Form::Area,
            ..Series::default()
        };
        let edges = stacked(&[area([1.0, 2.0]), area([-3.0, 4.0]), area([5.0, -6.0])]);
        assert_eq!(edges[0], [vec![(0.0, 1.0), (0.0, 2.0)], vec![(0.0, 0.0), (0.0, 0.0)]]);
        assert_eq!(edges[1], [vec![(1.0, 1.0), (2.0, 6.0)], vec![(0.0, -3.0), (0.0, 0.0)]]);
        assert_eq!(edges[2], [vec![(1.0, 6.0), (6.0, 6.0)], vec![(-3.0, -3.0), (0.0, -6.0)]]);
    }
}
