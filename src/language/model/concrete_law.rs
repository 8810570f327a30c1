//! Law of concrete damaged plasticity from its cards.

use super::strength_law::{LawOrFault, StrengthFault, StrengthLaw, StrengthWarning, elasticity, fault};
use super::types::{ConcreteTensionDamage, ConcreteTensionStiffening, MaterialDefinition, StrengthCards, tangent};
use crate::deck::Span;
use crate::material::returns::concrete::{ConcreteDamagedPlasticity, ConcreteFailure};
use crate::material::returns::concrete_return::ConcreteSurface;
use crate::material::returns::concrete_tables::{ConcreteAbscissa, ConcreteTable};

/// Builds the law for elements with lengths up to `longest`.
pub fn concrete_law(material: &MaterialDefinition, longest: f64) -> LawOrFault {
    let cards = &material.strength;
    let Some((card, span)) = &cards.concrete else {
        let (keyword, span) = cards.cards().next().unwrap_or(("CONCRETE", material.span));
        return fault(span, format!("*{keyword} without *CONCRETE DAMAGED PLASTICITY"), "");
    };
    let moduli = elasticity(material, *span)?;
    let young = material.elastic.map_or(0.0, |[young, _]| young);
    let Some((hardening, compression_span)) = &cards.compression_hardening else {
        return fault(*span, "*CONCRETE DAMAGED PLASTICITY without *CONCRETE COMPRESSION HARDENING", "");
    };
    let (crushing, to_tension) =
        cards.compression_damage.as_ref().map_or((&[][..], 0.0), |(card, _)| (&card.rows, card.recovery));
    starts_at_zero(&hardening.rows, *compression_span)?;
    let compression = ConcreteTable::new(ConcreteAbscissa::Strain, &hardening.rows, crushing, young);
    let compression = compression.and_then(|table| table.check(longest).map(|()| table));
    let compression = compression.or_else(|reason| fault(*compression_span, format!("compression: {reason}"), ""))?;
    let tension = tension_table(cards, young, longest, material)?;
    let snap_back = tension.snap_back_length(young);
    let warning = (longest > snap_back).then(|| {
        let message = format!(
            "elements are up to {longest:.3e} long, and the tensile stress falls faster than they unload above \
             {snap_back:.3e}: they dissipate more than the fracture energy"
        );
        StrengthWarning { code: "P149", message, help: "give shorter elements".into() }
    });
    let [angle, eccentricity, biaxial, meridian] = card.row;
    let to_compression = cards.tension_damage.as_ref().map_or(1.0, |(card, _)| card.recovery);
    if let Some((card, failure_span)) = &cards.concrete_failure
        && card.limits.iter().all(|limit| limit.is_nan())
    {
        return fault(*failure_span, "*CONCRETE FAILURE has no limit", "give at least one of its four values");
    }
    let law = ConcreteDamagedPlasticity {
        dilatancy: tangent(angle),
        eccentricity,
        surface: ConcreteSurface::new(biaxial, meridian),
        moduli,
        compression,
        tension,
        recovery: [to_tension, to_compression],
        failure: concrete_failure(cards),
    };
    Ok(StrengthLaw { law: Box::new(law), warning })
}

fn tension_table(
    cards: &StrengthCards,
    young: f64,
    longest: f64,
    material: &MaterialDefinition,
) -> Result<ConcreteTable, StrengthFault> {
    let Some((ConcreteTensionStiffening { kind, rows }, span)) = &cards.tension_stiffening else {
        return fault(material.span, "*CONCRETE DAMAGED PLASTICITY without *CONCRETE TENSION STIFFENING", "");
    };
    let damages: &[[f64; 2]] = match &cards.tension_damage {
        Some((ConcreteTensionDamage { by_displacement, rows, .. }, damage_span)) => {
            if *by_displacement == (*kind == 0) {
                let help = "give TYPE=DISPLACEMENT with TYPE=DISPLACEMENT or GFI of *CONCRETE TENSION STIFFENING, TYPE=STRAIN with STRAIN";
                return fault(*damage_span, "the damage has another abscissa than the tensile stress", help);
            }
            rows
        }
        None => &[],
    };
    if *kind < 2 {
        starts_at_zero(rows, *span)?;
    }
    let table = match kind {
        0 => ConcreteTable::new(ConcreteAbscissa::Strain, rows, damages, young),
        1 => ConcreteTable::new(ConcreteAbscissa::Displacement, rows, damages, young),
        _ => ConcreteTable::of_fracture_energy(rows, damages, young),
    };
    let table = table.and_then(|table| table.check(longest).map(|()| table));
    table.or_else(|reason| fault(*span, format!("tension: {reason}"), ""))
}

/// Refuses a table whose first inelastic strain or displacement of a rate is not 0.
fn starts_at_zero(rows: &[[f64; 3]], span: Span) -> Result<(), StrengthFault> {
    let begins = |i: usize| i == 0 || rows[i][2] != rows[i - 1][2];
    match (0..rows.len()).find(|i| begins(*i) && rows[*i][1] != 0.0) {
        Some(i) => fault(span, format!("inelastic strains must start at 0, found {}", rows[i][1]), ""),
        None => Ok(()),
    }
}

fn concrete_failure(cards: &StrengthCards) -> Option<ConcreteFailure> {
    let (card, _) = cards.concrete_failure.as_ref()?;
    let [cracking, inelastic, tensile, compressive] = card.limits.map(|limit| Some(limit).filter(|limit| *limit > 0.0));
    Some(ConcreteFailure {
        cracking_strain: cracking.filter(|_| !card.by_displacement),
        cracking_displacement: cracking.filter(|_| card.by_displacement),
        inelastic_strain: inelastic,
        tension_damage: tensile,
        compression_damage: compressive,
    })
}
