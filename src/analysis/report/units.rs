//! Unit names from the summary of a run.

use serde_json::Value;

use crate::model::DeckUnits;
use crate::variables::dimension::{DimensionPowers, dimension_of};

const LENGTH: DimensionPowers = [1, 0, 0, 0];
const TIME: DimensionPowers = [0, 0, 1, 0];
const ENERGY: DimensionPowers = [2, 1, -2, 0];

/// Unit names; empty if the deck has no `*UNITS`.
#[derive(Clone, Debug, Default)]
pub struct UnitNames(Option<DeckUnits>);

impl UnitNames {
    pub fn of(summary: &Value) -> UnitNames {
        UnitNames(summary.get("units").and_then(|units| serde_json::from_value(units.clone()).ok()))
    }

    fn name(&self, powers: DimensionPowers) -> String {
        self.0.as_ref().map_or(String::new(), |units| units.name(powers))
    }

    /// Returns the unit of a history column or field; empty if unknown.
    pub fn of_column(&self, name: &str) -> String {
        dimension_of(name).map_or(String::new(), |powers| self.name(powers))
    }

    /// Returns the units of length and time.
    pub fn length_and_time(&self) -> [String; 2] {
        [self.name(LENGTH), self.name(TIME)]
    }

    /// Returns the units of both axes of a chart over time.
    pub fn over_time(&self, title: &str) -> [String; 2] {
        let unit = match title {
            "Energy" => self.name(ENERGY),
            "Increment" => self.name(TIME),
            title => self.of_column(title),
        };
        [self.name(TIME), unit]
    }
}
