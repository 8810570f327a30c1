//! What a deck says of a material that asks the user's routines at its points.
//! Never here: asking them.

use crate::kernel::lanes::inline_from_fn;
use std::sync::Arc;

use crate::kernel::hardening::{RateFactor, YieldStress};
use crate::kernel::heating::Heating;
use crate::kernel::levels::NestedTable;

/// What a deck says of a user material.
#[derive(Clone, Debug)]
pub struct Description {
    /// Name, upper case (`cmname`).
    pub name: String,
    /// Constants.
    pub properties: Vec<f64>,
    /// Variables that each element keeps.
    pub variables: usize,
    /// The one of them, counted from 0, that deletes an element when it becomes zero.
    pub delete: Option<usize>,
    /// Field variables.
    pub fields: usize,
    /// Constants of the routine of fields, where there is one (`*USER DEFINED FIELD`).
    pub asks_fields: Option<Vec<f64>>,
    /// Constants of the routine of characteristic lengths, where there is one (`*CHARACTERISTIC LENGTH, DEFINITION=USER`).
    pub asks_lengths: Option<Vec<f64>>,
    /// Elasticity and plasticity, where the routine does not give the stress itself.
    pub flow: Option<Flow>,
    /// Rise of temperature by inelastic work.
    pub heating: Heating,
    /// Mass a volume at the start.
    pub density: f64,
}

/// Who gives the yield stress.
#[derive(Clone)]
pub enum Yield {
    /// Nobody: the material is elastic.
    Never,
    /// A law that is built in.
    Law(Arc<dyn YieldStress>),
    /// A table that is built in, over field variables of the point.
    OverFields(Arc<YieldOverFields>),
    /// The user's routine, with these constants.
    User(Vec<f64>),
}

/// A yield stress over the plastic strain, the temperature and field variables, times a factor of rate.
#[derive(Clone, Debug)]
pub struct YieldOverFields {
    /// The static part, over the plastic strain, the temperature and the field variables.
    pub table: NestedTable,
    pub factor: Option<RateFactor>,
    /// Field variables that it depends on, from the first on.
    pub fields: usize,
}

/// Field variables that a table depends on at most.
pub const MOST_DEPENDENCIES: usize = 5;

/// A [`YieldOverFields`] at the field variables of a point.
pub struct AtFields<'a> {
    law: &'a YieldOverFields,
    fields: [f64; MOST_DEPENDENCIES],
}

impl<'a> AtFields<'a> {
    /// At field variables by their number.
    pub fn new(law: &'a YieldOverFields, field: impl Fn(usize) -> f64) -> Self {
        AtFields { law, fields: of_point(law.fields, field) }
    }
}

impl YieldStress for AtFields<'_> {
    fn at(&self, strain: f64, rate: f64, temperature: f64) -> f64 {
        let mut over = [0.0; 2 + MOST_DEPENDENCIES];
        (over[0], over[1]) = (strain, temperature);
        over[2..].copy_from_slice(&self.fields);
        let fixed = self.law.table.at(&over[..2 + self.law.fields]);
        self.law.factor.as_ref().map_or(fixed, |factor| fixed * factor.at(rate, temperature))
    }
}

/// Moduli over the temperature and field variables.
#[derive(Clone, Debug)]
pub struct Elasticity {
    pub young: NestedTable,
    pub ratio: NestedTable,
    /// Field variables that they depend on, from the first on.
    pub fields: usize,
}

impl Elasticity {
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

impl std::fmt::Debug for Yield {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Yield::Never => f.write_str("Never"),
            Yield::Law(_) => f.write_str("Law"),
            Yield::OverFields(law) => f.debug_tuple("OverFields").field(law).finish(),
            Yield::User(properties) => f.debug_tuple("User").field(properties).finish(),
        }
    }
}

/// Isotropic elasticity and von Mises plasticity.
#[derive(Clone, Debug)]
pub struct Flow {
    /// Bulk modulus; the largest where it is not constant.
    pub bulk: f64,
    /// Shear modulus, likewise.
    pub shear: f64,
    /// Moduli over temperature and field variables; `None` where they are constant.
    pub elasticity: Option<Arc<Elasticity>>,
    pub yields: Yield,
}
