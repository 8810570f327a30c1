//! Fitted constants of rubber and the test data: charts and table of nominal stress over nominal strain.

use super::chart::{Chart, ChartSeries, SeriesForm};
use super::table::{TextTable, digits};
use crate::model::{DeckUnits, HyperelasticLaw, RubberMeasurement, RubberTest};

/// Tests with their names, in the order of a chart.
const TESTS: [(RubberTest, &str); 4] = [
    (RubberTest::Uniaxial, "uniaxial"),
    (RubberTest::Equibiaxial, "equibiaxial"),
    (RubberTest::Planar, "planar"),
    (RubberTest::Volumetric, "volumetric"),
];
/// Number of points of a fitted line.
const POINTS: u32 = 200;

/// Returns the measured values of a test, in ascending order of the stretch.
fn measured(law: &HyperelasticLaw, test: RubberTest) -> Vec<RubberMeasurement> {
    let mut rows: Vec<RubberMeasurement> = law.test_data.iter().copied().filter(|row| row.test == test).collect();
    rows.sort_by(|a, b| a.stretch.total_cmp(&b.stretch));
    rows
}

/// Returns the charts of a fitted law, each with the ending of its file: nominal stress over nominal strain with the measured
/// values as points and the fitted law as lines, and pressure over volume ratio if it was measured.
pub fn charts(name: &str, law: &HyperelasticLaw, units: Option<&DeckUnits>) -> Vec<(&'static str, Chart)> {
    let stress = units.map_or(String::new(), |u| u.name([-1, 1, -2, 0]));
    let chart = |title: String, axes: [&str; 2], tests: &[(RubberTest, &str)]| {
        let series: Vec<ChartSeries> = tests.iter().flat_map(|(test, word)| series_of(law, *test, word)).collect();
        Chart { units: [String::new(), stress.clone()], ..Chart::new(&title, axes, series) }
    };
    let nominal = ["nominal strain", "nominal stress"];
    let shown = [
        ("_test_data", chart(format!("{name}: test data and fit"), nominal, &TESTS[..3])),
        (
            "_volumetric_test_data",
            chart(format!("{name}: volumetric test data and fit"), ["volume ratio", "pressure"], &TESTS[3..]),
        ),
    ];
    shown.into_iter().filter(|(_, chart)| !chart.is_empty()).collect()
}

fn series_of(law: &HyperelasticLaw, test: RubberTest, word: &str) -> Vec<ChartSeries> {
    let rows = measured(law, test);
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return Vec::new() };
    let offset = if test == RubberTest::Volumetric { 0.0 } else { 1.0 };
    let [low, high] = [first.stretch.min(1.0), last.stretch.max(1.0)];
    let line = (0..=POINTS).map(|i| low + (high - low) * f64::from(i) / f64::from(POINTS));
    let line = line.map(|stretch| (stretch - offset, law.test_stress(test, stretch))).collect();
    let points = rows.iter().map(|row| (row.stretch - offset, row.stress)).collect();
    vec![
        ChartSeries::new(format!("{word}, measured"), SeriesForm::Marks, points),
        ChartSeries::new(format!("{word}, fitted"), SeriesForm::Line, line),
    ]
}

/// Returns the measured and the fitted values of a law: root mean square and largest relative error of each test.
pub fn table(fitted: &[(String, &HyperelasticLaw)]) -> TextTable {
    let header = ["material", "test", "values", "rms error %", "largest error %"].map(String::from).into();
    let row = |name: &str, law: &HyperelasticLaw, test: RubberTest, word: &str| {
        let rows = measured(law, test);
        let errors: Vec<f64> =
            rows.iter().map(|row| 100.0 * (law.test_stress(test, row.stretch) / row.stress - 1.0).abs()).collect();
        let mean_square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
        let largest = errors.iter().copied().fold(0.0, f64::max);
        let cells = [rows.len().to_string(), digits(mean_square.sqrt(), 3), digits(largest, 3)];
        (!rows.is_empty()).then(|| [name.to_owned(), word.to_owned()].into_iter().chain(cells).collect())
    };
    let rows =
        fitted.iter().flat_map(|(name, law)| TESTS.into_iter().filter_map(|(test, word)| row(name, law, test, word)));
    TextTable { header, rows: rows.collect() }
}
