//! Readers of cards: for each keyword of the table in `deck/table` the function that reads its cards, and the families of
//! cards whose state the function changes.

use super::builder::ModelBuilder;
use super::types::{
    FailedMaterial, FoamYieldSurface, MaterialDefinition, PoreCompaction, RangedQuantity, RayleighCoefficients,
    TensileFailure, ThermalExpansion, ValidityRange,
};
use super::{
    adaptive, amplitudes, blast, bodies, boundary, clearance, cohesive, cohesive_contact, connectors, contact,
    controls, copies, elements, eos, equations, erosion, expressions, failure, fields, general_contact, heading,
    heat_loads, interactions, links, loads, mass_scaling, materials, mesh_file, nodes, orientations, outputs, parts,
    rubber, rubber_fit, sets, shells, steps, surfaces, targets, user_material,
};
use crate::deck::table::{materials as cards, strength};
use crate::deck::{Card, Span};

/// Reader of the cards of some keywords.
pub struct CardReader {
    pub keywords: &'static [&'static str],
    /// Whether cards with a reported error are read too, because other cards depend on them. Further errors of other
    /// cards would be consequential.
    pub always: bool,
    pub read: for<'a> fn(&mut ModelBuilder<'a>, &'a Card),
}

/// Returns the reader of a keyword; `None` if its cards do not change the model.
pub fn find_reader(keyword: &str) -> Option<&'static CardReader> {
    READERS.iter().find(|reader| reader.keywords.contains(&keyword))
}

/// Builds readers from `always`, keywords, a function, and the shared context and families that are its arguments.
/// Blocks are read with the whole builder, because an instance reads the cards of its part. Cards in braces only store
/// their values in the last material.
macro_rules! readers {
    ($($block:literal)|+ => $read_block:path;
    $($($always:ident)? $($keyword:literal)|+ => $module:ident::$function:ident($($family:ident),+);)+
    { $($card:ty => $set:expr;)+ }) => {
        &[CardReader { keywords: &[$($block),+], always: true, read: $read_block }, $(CardReader {
            keywords: &[$($keyword),+],
            always: stringify!($($always)?).len() > 0,
            read: |builder, card| $module::$function($(&mut builder.$family,)+ card),
        },)+ $(CardReader {
            keywords: &[<$card>::ROW.name],
            always: false,
            read: |builder, card| {
                let set: fn(&mut MaterialDefinition, $card, Span) = $set;
                set(builder.context.last_material(), card.values(), card.span);
            },
        }),+]
    };
}

static READERS: &[CardReader] = readers! {
    "PART" | "END PART" | "ASSEMBLY" | "END ASSEMBLY" | "INSTANCE" | "END INSTANCE" => parts::read_block;
    always "HEADING" => heading::read_heading(context);
    "UNITS" => heading::read_units(context);
    always "NODE" => nodes::read_nodes(context, mesh);
    always "NGEN" => nodes::read_ngen(context, mesh);
    always "NFILL" => nodes::read_nfill(context, mesh);
    "NCOPY" => copies::read_ncopy(context, mesh);
    "NMAP" => copies::read_nmap(context, mesh);
    "SYSTEM" => copies::read_system(context, mesh);
    "TRANSFORM" => copies::read_transform(context, mesh);
    always "ELEMENT" => elements::read_elements(context);
    always "ELGEN" => elements::read_elgen(context);
    "ELCOPY" => copies::read_elcopy(context);
    always "NSET" => sets::read_nset(context, parts, mesh);
    always "ELSET" => sets::read_elset(context, parts);
    always "SURFACE" => surfaces::read_surface(context, mesh, steps);
    "RIGID SURFACE" => contact::read_rigid_surface(context, mesh);
    "MESH" => mesh_file::read_mesh_file(context, mesh);
    always "MATERIAL" => materials::read_material(context, materials);
    "ELASTIC" => materials::read_elastic(context);
    "EOS" => eos::read_eos(context);
    "DETONATION POINT" => eos::read_detonation_points(context);
    "HYPERELASTIC" => rubber::read_hyperelastic(context, materials);
    "UNIAXIAL TEST DATA" | "BIAXIAL TEST DATA" | "PLANAR TEST DATA" | "VOLUMETRIC TEST DATA"
    => rubber_fit::read_test_data(context, materials);
    "CRUSHABLE FOAM HARDENING" => rubber::read_foam_hardening(context);
    "SHEAR FAILURE" => failure::read_shear_failure(context);
    "PLASTIC" => materials::read_plastic(context);
    "RATE DEPENDENT" => materials::read_rate_dependent(context);
    "ANISOTROPIC HYPERELASTIC" => user_material::read_anisotropic_energy(context);
    "USER MATERIAL" => user_material::read_user_material(context);
    "USER DEFINED FIELD" => user_material::read_user_fields(context);
    "CHARACTERISTIC LENGTH" => user_material::read_characteristic_length(context);
    "DEPVAR" => user_material::read_state_variables(context);
    "DENSITY" => materials::read_density(context);
    "CAVITY EXPANSION" => materials::read_cavity_expansion(context, materials);
    "DAMAGE INITIATION" => failure::read_damage_initiation(context, materials);
    "DAMAGE EVOLUTION" => failure::read_damage_evolution(context, materials);
    "COUPLED DAMAGE" => failure::read_coupled_damage(context);
    "DAMAGE STABILIZATION" => failure::read_damage_stabilization(context, materials);
    "PHYSICAL CONSTANTS" => eos::read_physical_constants(context);
    always "SOLID SECTION" => materials::read_solid_section(context, sections);
    "ORIENTATION" => orientations::read_orientation(context);
    always "SHELL SECTION" => shells::read_shell_section(context, sections);
    always "COHESIVE SECTION" => cohesive::read_cohesive_section(context, sections);
    always "SECTION CONTROLS" => controls::read_section_controls(context, sections);
    "EROSION" => erosion::read_erosion(context);
    "REMESH" => adaptive::read_remesh(context);
    always "RIGID BODY" => bodies::read_rigid_body(context);
    "MASS" => bodies::read_mass(context, sections);
    always "ROTARY INERTIA" => bodies::read_rotary_inertia(context, sections);
    always "ATTITUDE" => bodies::read_attitude(context);
    "CONTACT PAIR" => contact::read_contact_pair(context, steps);
    "CONTACT" => general_contact::read_contact(steps);
    "CONTACT INCLUSIONS" | "CONTACT EXCLUSIONS" | "CONTACT PROPERTY ASSIGNMENT" | "CONTACT CLEARANCE ASSIGNMENT"
    | "CONTACT INITIALIZATION ASSIGNMENT" | "CONTACT CONTROLS ASSIGNMENT" | "CONTACT FORMULATION"
    => general_contact::read_general_contact_option(context, steps);
    "CONTACT CONTROLS" => clearance::read_contact_controls(context, steps);
    "CLEARANCE" => clearance::read_pair_clearance(context, steps);
    always "SURFACE INTERACTION" => interactions::read_surface_interaction(context, materials);
    "SURFACE BEHAVIOR" => interactions::read_surface_behavior(context);
    "CONTACT DAMPING" => interactions::read_contact_damping(context);
    "COHESIVE BEHAVIOR" => cohesive_contact::read_cohesive_behavior(context);
    "FRICTION" => interactions::read_friction(context);
    "GAP CONDUCTANCE" => interactions::read_gap_conductance(context);
    "GAP HEAT GENERATION" => interactions::read_gap_heat_generation(context);
    "SPRING" | "DASHPOT" => connectors::read_connectors(context, sections);
    "EQUATION" => equations::read_equation(context, mesh);
    "MPC" => links::read_mpc(context, mesh);
    "COUPLING" => links::read_coupling(context, conditions);
    "KINEMATIC" | "DISTRIBUTING" => links::read_coupling_kind(context, conditions);
    "TIE" => links::read_tie(context);
    "TARGET" => targets::read_target(context);
    "AMPLITUDE" => amplitudes::read_amplitude(context);
    "INITIAL CONDITIONS" => bodies::read_initial_conditions(context, conditions);
    always "STEP" => steps::read_step(context, parts, steps);
    always "END STEP" => steps::read_end_step(context, parts, steps);
    "DYNAMIC" | "DYNAMIC TEMPERATURE-DISPLACEMENT" => steps::read_dynamic(context, steps);
    "BULK VISCOSITY" => steps::read_bulk_viscosity(context, steps);
    "FIXED MASS SCALING" | "VARIABLE MASS SCALING" => mass_scaling::read_mass_scaling(context, steps);
    "ENERGY LIMIT" => steps::read_energy_limit(context, steps);
    "ADAPTIVE MESH" => adaptive::read_adaptive_mesh(context, steps);
    "ADAPTIVE MESH CONTROLS" => adaptive::read_adaptive_controls(context, steps);
    "ADAPTIVE MESH CONSTRAINT" => adaptive::read_adaptive_constraint(context, steps);
    always "BOUNDARY" => boundary::read_boundary(context, conditions, steps);
    "CLOAD" | "DLOAD" | "DSLOAD" => loads::read_loads(context, steps);
    "INCIDENT WAVE INTERACTION PROPERTY" => blast::read_blast_property(context, conditions);
    "CONWEP CHARGE PROPERTY" => blast::read_blast_charge(context, conditions);
    "INCIDENT WAVE INTERACTION" => blast::read_incident_wave(context, conditions, steps);
    "FIELD" | "TEMPERATURE" => fields::read_prescribed_fields(context, steps);
    "CFLUX" | "DFLUX" | "DSFLUX" | "FILM" | "SFILM" => heat_loads::read_heat_loads(context, steps);
    always "OUTPUT" => outputs::read_output(context, steps, output);
    "NODE OUTPUT" | "ELEMENT OUTPUT" | "ENERGY OUTPUT" | "INCREMENTATION OUTPUT" | "CONTACT OUTPUT" | "INTEGRATED OUTPUT"
    => outputs::read_output_variables(context, steps, output);
    "OUTPUT EXPRESSION" => expressions::read_output_expressions(context);
    "INTEGRATED OUTPUT SECTION" => outputs::read_integrated_section(context, output);
    "TIME POINTS" => outputs::read_time_points(context);
    "RESTART" => outputs::read_restart(context, steps);
    {
        cards::Viscosity => |material, values, span| material.viscosity = Some((values.viscosity[0], span));
        cards::EosCompaction => |material, cards::EosCompaction { values: [speed, porosity, begin, end] }, span| {
            let pressures = [begin, end];
            material.compaction = Some(PoreCompaction { speed, porosity, pressures, solid_density: 0.0, span });
        };
        cards::InelasticHeatFraction => |material, values, _| material.thermal.inelastic_heat_fraction = Some(values.fraction[0]);
        cards::SpecificHeat => |material, values, _| material.thermal.specific_heat = Some(values.rows);
        cards::Conductivity => |material, values, span| material.thermal.conductivity = Some((values.rows, span));
        cards::Expansion => |material, cards::Expansion { zero, rows }, span| {
            material.thermal.expansion = Some(ThermalExpansion { rows, zero, span });
        };
        cards::TensileFailure => |material, card, span| {
            let cards::TensileFailure { deletes, loses_shear, loses_tension, cutoff: [cutoff] } = card;
            material.tensile_failure = Some(TensileFailure { cutoff, deletes, loses_shear, loses_tension, span });
        };
        cards::FailedMaterial => |material, cards::FailedMaterial { values: [residual, crossings] }, span| {
            material.failed = Some(FailedMaterial { residual, crossings, span });
        };
        cards::MaterialRange => |material, card, span| {
            let or = |limit: f64, none: f64| if limit.is_nan() { none } else { limit };
            material.ranges = card.rows.iter().filter_map(|&[index, low, high]| {
                let quantity = *RangedQuantity::ALL.get(index as usize)?;
                Some(ValidityRange { quantity, low: or(low, f64::NEG_INFINITY), high: or(high, f64::INFINITY), span })
            }).collect();
        };
        cards::CrushableFoam => |material, cards::CrushableFoam { isotropic, ratios }, span| {
            let shape = if isotropic { FoamYieldSurface::Isotropic } else { FoamYieldSurface::Volumetric };
            material.foam.shape = Some((shape(ratios), span));
        };
        strength::DruckerPrager => |material, card, span| material.strength.drucker_prager = Some((card, span));
        strength::DruckerPragerHardening => |material, card, span| material.strength.drucker_prager_hardening = Some((card, span));
        strength::CapPlasticity => |material, card, span| material.strength.cap = Some((card, span));
        strength::CapHardening => |material, card, span| material.strength.cap_hardening = Some((card, span));
        strength::ConcreteDamagedPlasticity => |material, card, span| material.strength.concrete = Some((card, span));
        strength::ConcreteCompressionHardening => |material, card, span| material.strength.compression_hardening = Some((card, span));
        strength::ConcreteTensionStiffening => |material, card, span| material.strength.tension_stiffening = Some((card, span));
        strength::ConcreteCompressionDamage => |material, card, span| material.strength.compression_damage = Some((card, span));
        strength::ConcreteTensionDamage => |material, card, span| material.strength.tension_damage = Some((card, span));
        strength::ConcreteFailure => |material, card, span| material.strength.concrete_failure = Some((card, span));
        strength::HolmquistJohnsonCook => |material, card, span| material.strength.holmquist_johnson_cook = Some((card, span));
        strength::Potential => |material, card, span| material.strength.potential = Some((card, span));
        strength::PorousMetalPlasticity => |material, card, span| material.strength.porous_metal = Some((card, span));
        strength::VoidNucleation => |material, card, span| material.strength.void_nucleation = Some((card, span));
        strength::PorousFailureCriteria => |material, card, span| material.strength.porous_failure = Some((card, span));
        // Coefficients of zero mean no damping.
        cards::Damping => |material, cards::Damping { alpha, beta }, span| {
            material.damping = (alpha > 0.0 || beta > 0.0).then_some(RayleighCoefficients { alpha, beta, span });
        };
    }
};

#[cfg(test)]
mod tests {
    use super::READERS;
    use crate::deck::keywords::{KeywordTier, keywords};

    /// Cards that the parser or other cards read; the last one allows only values without effect.
    const WITHOUT_READER: &[&str] =
        &["PARAMETER", "INCLUDE", "CONTACT CLEARANCE", "CONTACT INITIALIZATION DATA", "SURFACE PROPERTY ASSIGNMENT"];

    #[test]
    fn each_keyword_has_one_reader() {
        let read: Vec<&str> = READERS.iter().flat_map(|reader| reader.keywords).copied().collect();
        for keyword in keywords() {
            let count = read.iter().filter(|name| **name == keyword.name).count();
            let is_read = keyword.tier == KeywordTier::Used && !WITHOUT_READER.contains(&keyword.name);
            assert_eq!(count, usize::from(is_read), "{}", keyword.name);
        }
        assert!(read.iter().all(|name| keywords().any(|keyword| keyword.name == *name)));
    }
}
