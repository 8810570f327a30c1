//! Charts as data: lines, markers and areas over one axis.
//! Never here: where the numbers come from, how they are drawn (`draw`).

use serde::Serialize;

/// A chart.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Name of the horizontal axis.
    pub x_label: String,
    /// Name of the vertical axis.
    pub y_label: String,
    /// Units of both; empty where they are not known.
    pub units: [String; 2],
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

/// How points are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Joined by a line.
    #[default]
    Line,
    /// Each by itself.
    Marks,
    /// An area on top of the areas before it: what is above zero upwards, what is below downwards. All areas of a chart have the
    /// same abscissae.
    Area,
    /// A thin broken line to compare others with.
    Guide,
    /// What lies within an outline: points along its lower edge, then back along the upper one.
    Band,
}

/// Points with a name.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Shown in the legend.
    pub name: String,
    /// `(x, y)`, ascending in x.
    pub points: Vec<(f64, f64)>,
    /// How they are shown.
    pub form: Form,
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
