//! Data of materials that call user subroutines at their points.

use super::energy::AnisotropicEnergy;
use crate::kernel::lanes::inline_from_fn;
use std::sync::Arc;

use crate::kernel::hardening::{RateFactor, YieldStress};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::levels::NestedTable;

/// Data of a user material from the deck.
#[derive(Clone, Debug)]
pub struct UserMaterialData {
    /// Name, upper case (`cmname`).
    pub name: String,
    /// Constants of `*USER MATERIAL`, in deck order.
    pub properties: Vec<f64>,
    /// Number of state variables per element.
    pub variables: usize,
    /// Index of the state variable that deletes an element when it becomes zero.
    pub delete: Option<usize>,
    /// Number of field variables.
    pub fields: usize,
    /// Constants of VUSDFLD (`*USER DEFINED FIELD`); `None` if it is not called.
    pub field_constants: Option<Vec<f64>>,
    /// Constants of VUCHARLENGTH (`*CHARACTERISTIC LENGTH, DEFINITION=USER`); `None` if it is not called.
    pub length_constants: Option<Vec<f64>>,
    /// Strain energy of invariants, from which the stress follows.
    pub energy: Option<AnisotropicEnergy>,
    /// Built-in elasticity and plasticity; `None` if the subroutine computes the stress.
    pub flow: Option<BuiltInPlasticity>,
    /// Temperature rise by inelastic work.
    pub heating: PlasticHeating,
    /// Initial density, mass per length³.
    pub density: f64,
}

/// Source of the yield stress.
#[derive(Clone)]
pub enum YieldSource {
    /// No yield: the material is elastic.
    Never,
    /// A built-in hardening law.
    Law(Arc<dyn YieldStress>),
    /// A built-in table over field variables of the point.
    OverFields(Arc<YieldOverFields>),
    /// VUHARD, with its constants.
    User(Vec<f64>),
}

/// A yield stress as a table over plastic strain, temperature and field variables, times a rate factor.
#[derive(Clone, Debug)]
pub struct YieldOverFields {
    /// Static yield stress over plastic strain, temperature and field variables.
    pub table: NestedTable,
    pub factor: Option<RateFactor>,
    /// Number of field variables in the table, from the first on.
    pub fields: usize,
}

/// Largest number of field variables of a table.
pub const MOST_DEPENDENCIES: usize = 5;

/// A [`YieldOverFields`] with the field variables of a point.
pub struct PointYieldStress<'a> {
    law: &'a YieldOverFields,
    fields: [f64; MOST_DEPENDENCIES],
}

impl<'a> PointYieldStress<'a> {
    /// Binds a table to the field variables that `field` returns by index.
    pub fn new(law: &'a YieldOverFields, field: impl Fn(usize) -> f64) -> Self {
        PointYieldStress { law, fields: of_point(law.fields, field) }
    }
}

impl YieldStress for PointYieldStress<'_> {
    fn at(&self, strain: f64, rate: f64, temperature: f64) -> f64 {
        let mut over = [0.0; 2 + MOST_DEPENDENCIES];
        (over[0], over[1]) = (strain, temperature);
        over[2..].copy_from_slice(&self.fields);
        let fixed = self.law.table.at(&over[..2 + self.law.fields]);
        self.law.factor.as_ref().map_or(fixed, |factor| fixed * factor.at(rate, temperature))
    }
}

/// Elastic constants over temperature and field variables.
#[derive(Clone, Debug)]
pub struct FieldElasticity {
    pub young: NestedTable,
    pub ratio: NestedTable,
    /// Number of field variables in the tables, from the first on.
    pub fields: usize,
}

impl FieldElasticity {
    pub fn moduli(&self, temperature: f64, field: impl Fn(usize) -> f64) -> [f64; 2] {
        let mut over = [0.0; 1 + MOST_DEPENDENCIES];
        over[0] = temperature;
        over[1..].copy_from_slice(&of_point(self.fields, field));
        let over = &over[..1 + self.fields];
        let (e, nu) = (self.young.at(over), self.ratio.at(over));
        [e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))]
    }
}

fn of_point(count: usize, field: impl Fn(usize) -> f64) -> [f64; MOST_DEPENDENCIES] {
    inline_from_fn(|v| if v < count { field(v) } else { 0.0 })
}

impl std::fmt::Debug for YieldSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            YieldSource::Never => f.write_str("Never"),
            YieldSource::Law(_) => f.write_str("Law"),
            YieldSource::OverFields(law) => f.debug_tuple("OverFields").field(law).finish(),
            YieldSource::User(properties) => f.debug_tuple("User").field(properties).finish(),
        }
    }
}

/// Built-in isotropic elasticity and von Mises plasticity.
#[derive(Clone, Debug)]
pub struct BuiltInPlasticity {
    /// Bulk modulus; its maximum if it varies.
    pub bulk: f64,
    /// Shear modulus; its maximum if it varies.
    pub shear: f64,
    /// Varying moduli; `None` if they are constant.
    pub elasticity: Option<Arc<FieldElasticity>>,
    pub yields: YieldSource,
}
