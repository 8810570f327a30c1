//! Dimensions of output variables, by which their units are named.
//! Never here: names of units.

use super::statistic::Statistic;
use super::{Part, Place, Variable};

/// Powers of length, mass, time and temperature.
pub type Powers = [i32; 4];

const NONE: Powers = [0; 4];
const LENGTH: Powers = [1, 0, 0, 0];
const AREA: Powers = [2, 0, 0, 0];
const VOLUME: Powers = [3, 0, 0, 0];
const TIME: Powers = [0, 0, 1, 0];
const PER_TIME: Powers = [0, 0, -1, 0];
const MASS: Powers = [0, 1, 0, 0];
const VELOCITY: Powers = [1, 0, -1, 0];
const ACCELERATION: Powers = [1, 0, -2, 0];
const FORCE: Powers = [1, 1, -2, 0];
const STRESS: Powers = [-1, 1, -2, 0];
const ENERGY: Powers = [2, 1, -2, 0];
const POWER: Powers = [2, 1, -3, 0];
const TEMPERATURE: Powers = [0, 0, 0, 1];

impl Variable {
    /// Its dimension: all zero of what is a number alone; `None` of what the user's routine knows.
    pub fn dimension(self) -> Option<Powers> {
        Some(match self {
            Variable::Displacement
            | Variable::ThirdDisplacement
            | Variable::Coordinate
            | Variable::ContactOpening
            | Variable::ContactSlip
            | Variable::Thickness => LENGTH,
            Variable::Velocity | Variable::ThirdVelocity | Variable::NormalVelocity => VELOCITY,
            Variable::Acceleration | Variable::ThirdAcceleration => ACCELERATION,
            Variable::Reaction
            | Variable::SurfaceForce
            | Variable::NormalContactForce
            | Variable::ShearContactForce
            | Variable::ContactForce
            | Variable::NormalContactMagnitude
            | Variable::ShearContactMagnitude
            | Variable::ContactMagnitude => FORCE,
            Variable::NodalTemperature
            | Variable::Temperature
            | Variable::BottomTemperature
            | Variable::TopTemperature => TEMPERATURE,
            Variable::ReactionFlux => POWER,
            Variable::HeatFlux => [0, 1, -3, 0],
            Variable::RotationalVelocity
            | Variable::OutwardRotationalVelocity
            | Variable::StrainRate
            | Variable::PrincipalStrainRate
            | Variable::VolumetricStrainRate => PER_TIME,
            Variable::RotationalAcceleration | Variable::OutwardRotationalAcceleration => [0, 0, -2, 0],
            Variable::ReactionMoment => ENERGY,
            Variable::SectionForce => [0, 1, -2, 0],
            Variable::SectionMoment => FORCE,
            Variable::SectionCurvature => [-1, 0, 0, 0],
            Variable::ContactPressure
            | Variable::ContactShear
            | Variable::Stress
            | Variable::Mises
            | Variable::Pressure
            | Variable::PrincipalStress
            | Variable::Tresca
            | Variable::BottomStress
            | Variable::TopStress
            | Variable::BottomMises
            | Variable::TopMises
            | Variable::FacetPressure
            // Energy a volume.
            | Variable::StrainEnergy
            | Variable::PlasticEnergy => STRESS,
            Variable::Volume => VOLUME,
            Variable::Density => [-3, 1, 0, 0],
            Variable::SpecificEnergy => [2, 0, -2, 0],
            Variable::Mass | Variable::RemovedMass | Variable::PointMass => MASS,
            Variable::PointMomentum => [1, 1, -1, 0],
            Variable::SectionArea | Variable::ContactArea => AREA,
            Variable::ElementStrainEnergy | Variable::ElementPlasticEnergy => ENERGY,
            Variable::TimeIncrement => TIME,
            Variable::State => return None,
            _ if self.place() == Place::Energy => ENERGY,
            _ => NONE,
        })
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
