//! Physical dimensions of output variables.

use super::statistic::Statistic;
use super::{Variable, VariableComponent};

/// Exponents of length, mass, time and temperature.
pub type DimensionPowers = [i32; 4];

pub(super) const NONE: DimensionPowers = [0; 4];
pub(super) const LENGTH: DimensionPowers = [1, 0, 0, 0];
pub(super) const AREA: DimensionPowers = [2, 0, 0, 0];
pub(super) const VOLUME: DimensionPowers = [3, 0, 0, 0];
pub(super) const TIME: DimensionPowers = [0, 0, 1, 0];
pub(super) const PER_TIME: DimensionPowers = [0, 0, -1, 0];
pub(super) const MASS: DimensionPowers = [0, 1, 0, 0];
pub(super) const VELOCITY: DimensionPowers = [1, 0, -1, 0];
pub(super) const ACCELERATION: DimensionPowers = [1, 0, -2, 0];
pub(super) const FORCE: DimensionPowers = [1, 1, -2, 0];
pub(super) const STRESS: DimensionPowers = [-1, 1, -2, 0];
pub(super) const ENERGY: DimensionPowers = [2, 1, -2, 0];
pub(super) const POWER: DimensionPowers = [2, 1, -3, 0];
pub(super) const TEMPERATURE: DimensionPowers = [0, 0, 0, 1];

impl Variable {
    /// Returns the dimension, all zero for a number without unit; `None` for a state variable, whose dimension only the
    /// user subroutine knows.
    pub fn dimension(self) -> Option<DimensionPowers> {
        (self != Variable::State).then_some(self.row().dimension)
    }
}

/// Returns the dimension of a history column or frame field by its name, such as `U2@TIP`, `|V|`, `S_MISES`; `None` for
/// an unknown name.
pub fn dimension_of(name: &str) -> Option<DimensionPowers> {
    let name = name.split('@').next().unwrap_or(name).trim_matches('|');
    let name = if name == "S_MISES" { "MISES" } else { name };
    let name = Statistic::split(name).0;
    let whole = Variable::ALL.iter().copied().find(|v| v.name() == name);
    whole.or_else(|| VariableComponent::parse(name).map(|part| part.variable))?.dimension()
}

#[cfg(test)]
mod tests {
    use super::{ENERGY, FORCE, LENGTH, STRESS, VELOCITY, dimension_of};

    #[test]
    fn columns_and_fields_have_the_dimension_of_their_variable() {
        let names = ["U2@TIP", "|V|", "S_MISES", "S12", "RF2@WALL", "ALLKE", "CFN1@A_B", "PRESS_MEAN@A"];
        let expected = [LENGTH, VELOCITY, STRESS, STRESS, FORCE, ENERGY, FORCE, STRESS];
        assert_eq!(names.map(dimension_of), expected.map(Some));
        assert_eq!([dimension_of("SDV1"), dimension_of("nothing")], [None, None]);
    }
}
