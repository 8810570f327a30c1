//! Units as the summary of a run names them.

use serde_json::Value;

use crate::model::Units;
use crate::variables::dimension::{Powers, dimension_of};

const LENGTH: Powers = [1, 0, 0, 0];
const TIME: Powers = [0, 0, 1, 0];
const ENERGY: Powers = [2, 1, -2, 0];

/// Names of units; none where the deck has no `*UNITS`.
#[derive(Clone, Debug, Default)]
pub struct UnitNames(Option<Units>);

impl UnitNames {
    /// Of a summary.
    pub fn of(summary: &Value) -> UnitNames {
        UnitNames(summary.get("units").and_then(|units| serde_json::from_value(units.clone()).ok()))
    }

    fn name(&self, powers: Powers) -> String {
        self.0.as_ref().map_or(String::new(), |units| units.name(powers))
    }

    /// Of a history column or a field; empty where it is not known.
    pub fn of_column(&self, name: &str) -> String {
        dimension_of(name).map_or(String::new(), |powers| self.name(powers))
    }

    /// Of length and time.
    pub fn length_and_time(&self) -> [String; 2] {
        [self.name(LENGTH), self.name(TIME)]
    }

    /// Of both axes of a chart over time.
    pub fn over_time(&self, title: &str) -> [String; 2] {
        let unit = match title {
            "Energy" => self.name(ENERGY),
            "Increment" => self.name(TIME),
            title => self.of_column(title),
        };
        [self.name(TIME), unit]
    }
}
