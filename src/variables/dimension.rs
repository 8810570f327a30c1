//! Dimensions of output variables, by which their units are named.
//! Never here: names of units.

use super::statistic::Statistic;
use super::{Part, Variable};

/// Powers of length, mass, time and temperature.
pub type Powers = [i32; 4];

pub(super) const NONE: Powers = [0; 4];
pub(super) const LENGTH: Powers = [1, 0, 0, 0];
pub(super) const AREA: Powers = [2, 0, 0, 0];
pub(super) const VOLUME: Powers = [3, 0, 0, 0];
pub(super) const TIME: Powers = [0, 0, 1, 0];
pub(super) const PER_TIME: Powers = [0, 0, -1, 0];
pub(super) const MASS: Powers = [0, 1, 0, 0];
pub(super) const VELOCITY: Powers = [1, 0, -1, 0];
pub(super) const ACCELERATION: Powers = [1, 0, -2, 0];
pub(super) const FORCE: Powers = [1, 1, -2, 0];
pub(super) const STRESS: Powers = [-1, 1, -2, 0];
pub(super) const ENERGY: Powers = [2, 1, -2, 0];
pub(super) const POWER: Powers = [2, 1, -3, 0];
pub(super) const TEMPERATURE: Powers = [0, 0, 0, 1];

impl Variable {
    /// Its dimension, all zero of a plain number; `None` of a state variable, which only the user's routine knows.
    pub fn dimension(self) -> Option<Powers> {
        (self != Variable::State).then_some(self.row().dimension)
    }
}

/// The dimension of what a history column or a field of a frame shows, by its name: `U2@TIP`, `|V|`, `S_MISES`.
pub fn dimension_of(name: &str) -> Option<Powers> {
    let name = name.split('@').next().unwrap_or(name).trim_matches('|');
    let name = if name == "S_MISES" { "MISES" } else { name };
    let name = Statistic::split(name).0;
    let whole = Variable::ALL.iter().copied().find(|v| v.name() == name);
    whole.or_else(|| Part::parse(name).map(|part| part.variable))?.dimension()
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
