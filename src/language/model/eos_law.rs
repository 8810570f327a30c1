//! Solid with an equation of state as the law of a point: the target whose resistance is derived.

use super::strength_law::{StrengthFault, fault};
use super::types::{EosKind, MaterialDefinition, PoreCompaction};
use crate::kernel::hardening::LinearTable;
use crate::material::compaction::PorousCompaction;
use crate::material::eos::{Tabulated, UsUp};
use crate::material::returns::eos_solid::{EosSolid, PointPressure};

/// Builds the law of a material with `*EOS` and a yield stress over plastic strain.
///
/// # Errors
/// If the material has no strength, or its equation of state or strength is not that of a solid at one temperature and rate.
pub fn eos_law(material: &MaterialDefinition, hardening: LinearTable) -> Result<EosSolid, StrengthFault> {
    let Some(eos) = &material.eos else { return fault(material.span, "the law needs *EOS", "") };
    let Some(density) = material.density else { return fault(material.span, "the law needs *DENSITY", "") };
    let Some(shear) = material.shear_modulus.filter(|shear| *shear > 0.0) else {
        return fault(eos.span, "a fluid has no strength: the law needs *ELASTIC, TYPE=SHEAR", "");
    };
    if material.rate.is_some() {
        return fault(eos.span, "*RATE DEPENDENT with *EOS has no derived resistance", "remove *RATE DEPENDENT");
    }
    let pressure = match (&eos.kind, material.compaction) {
        (EosKind::UsUp([c0, s, gamma0]), Some(PoreCompaction { speed, porosity, pressures, solid_density, .. })) => {
            let solid = UsUp { density: solid_density, c0: *c0, s: *s, gamma0: *gamma0 };
            PointPressure::Porous(PorousCompaction::new(solid, speed, porosity, pressures))
        }
        (EosKind::UsUp([c0, s, gamma0]), None) => {
            PointPressure::Solid(UsUp { density, c0: *c0, s: *s, gamma0: *gamma0 })
        }
        (EosKind::Tabular(rows), _) => PointPressure::Table(Tabulated::new(density, rows)),
        (EosKind::IdealGas(_) | EosKind::Jwl(_) | EosKind::Law(..), _) => {
            return fault(eos.span, "only *EOS, TYPE=USUP and TABULAR have a derived resistance", "");
        }
    };
    Ok(EosSolid { pressure, density, shear, hardening })
}
