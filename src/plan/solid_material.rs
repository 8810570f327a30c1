//! Materials of deformable bodies: which laws a group of elements is made of.
//! Never here: nodes, loads, arithmetic of elements.

use std::marker::PhantomData;
use std::sync::Arc;

use super::Compiler;
use super::solid::{Connectivity, add_masses};
use super::user_material::asks_at_points;
use crate::deck::{Diagnostic, Span};
use crate::element::constants::{Constants, HourglassControl};
use crate::element::group::{ElementGroup, Quads};
use crate::element::numbers::Numbers;
use crate::element::six_node::SixNodeTriangles;
use crate::kernel::hardening::{FlowStress, JohnsonCook, RateFactor, StaticYield, Table, TableOverTemperature};
use crate::kernel::heating::Heating;
use crate::kernel::levels::NestedTable;
use crate::kernel::moduli::Moduli;
use crate::material::Material as Law;
use crate::material::eos::{IdealGas, Tabulated, UsUp};
use crate::material::equation_of_state::EquationOfState;
use crate::material::failure::{CRITERIA, Criterion, Cutoff, Evolution, Failing, FailureStrain};
use crate::material::kinematic::Kinematic;
use crate::material::kinematic_rate::RateKinematic;
use crate::material::plasticity::{Elastic, PiecewiseLinearHardening, RateDependentHardening};
use crate::material::volumetric::{Linear, Volumetric};
use crate::material::von_mises::VonMises;
use crate::model::{
    DamageEvolution, EosKind, FailureCriterion, Hourglass, Material, Plastic, RateDependence, SectionControls,
    SolidSection, StrainAtFailure,
};
use crate::state::nodes::Node;

/// Default hourglass stiffness over the shear modulus (ABAQUS Analysis User's Guide, "Section controls": factor 0.005).
const HOURGLASS_STIFFNESS: f64 = 0.005;
/// Default hourglass viscosity, the fraction of what is critical at the element's highest frequency.
const HOURGLASS_VISCOSITY: f64 = 0.05;
/// The same of what has no shear modulus: with 0.05 Noh's sphere on squares overshoots behind its shock (docs/verification.md).
const FLUID_VISCOSITY: f64 = 0.15;

/// Makes the group of a material's elements; `None` where an error has been reported.
type MakeGroup = fn(&mut Compiler<'_>, &Material, Span, GroupBuilder<'_, false>) -> Option<Box<dyn ElementGroup>>;

/// Family of materials: which cards ask for it, and the group of its elements.
struct MaterialRow {
    applies: fn(&Material) -> bool,
    group: MakeGroup,
}

/// Materials by their cards; the first row that applies. A new material is a file in `material` and a row here.
const MATERIALS: &[MaterialRow] = &[
    MaterialRow { applies: |m| m.hyperelastic.is_some(), group: |c, m, span, builder| c.rubber(m, span, builder) },
    MaterialRow {
        applies: |m| m.foam.shape.is_some() || !m.foam.hardening.is_empty(),
        group: |c, m, span, builder| c.foam(m, span, builder),
    },
    MaterialRow { applies: |m| m.eos.is_some(), group: |c, m, span, builder| c.equation_of_state(m, span, builder) },
    MaterialRow { applies: |_| true, group: |c, m, span, builder| c.with_volumetric(m, span, Linear, builder) },
];

/// Everything but the material that a group of elements is made of.
#[derive(Clone, Copy)]
pub(super) struct GroupBuilder<'a, const AREA: bool, T = f64> {
    pub(super) constants: Constants,
    density: f64,
    connectivity: &'a Connectivity,
    nodes: &'a [Node],
    heats: bool,
    /// 1 less the damage at which an element is deleted.
    spared: f64,
    /// Whether elements that fail stay.
    kept: bool,
    /// Whether quarters of elements push back.
    subzonal: bool,
    /// Of which numbers.
    numbers: PhantomData<T>,
}

impl<'a> GroupBuilder<'a, false> {
    /// A builder without options.
    pub(super) fn new(
        constants: Constants,
        density: f64,
        connectivity: &'a Connectivity,
        nodes: &'a [Node],
    ) -> GroupBuilder<'a, false> {
        let (heats, kept, subzonal, numbers) = (false, false, false, PhantomData);
        GroupBuilder { constants, density, connectivity, nodes, heats, spared: 0.0, kept, subzonal, numbers }
    }
}

impl<'a, const AREA: bool, T: Numbers> GroupBuilder<'a, AREA, T> {
    pub(super) fn group(self, material: impl Law<T> + Law) -> Box<dyn ElementGroup> {
        let GroupBuilder { constants, density, connectivity, nodes, subzonal, .. } = self;
        let corners = match connectivity {
            Connectivity::SixNodeTriangles(list) => {
                return Box::new(SixNodeTriangles::new(material, constants, density, list, nodes));
            }
            Connectivity::Quadrilaterals(list) => list,
        };
        let quads = Quads::<_, AREA, T>::weighted(material, constants, density, corners, nodes);
        Box::new(if subzonal { quads.with_subzones(corners, nodes) } else { quads })
    }

    /// The same with other weights and numbers.
    fn turned<const BY_AREA: bool, U>(self) -> GroupBuilder<'a, BY_AREA, U> {
        let GroupBuilder { constants, density, connectivity, nodes, heats, spared, kept, subzonal, numbers: _ } = self;
        GroupBuilder { constants, density, connectivity, nodes, heats, spared, kept, subzonal, numbers: PhantomData }
    }
}

impl Compiler<'_> {
    pub(super) fn group(
        &mut self,
        section: &SolidSection,
        elements: &[usize],
        connectivity: &Connectivity,
        nodes: &[Node],
        mass: &mut [f64],
    ) -> Option<Box<dyn ElementGroup>> {
        let triangles = matches!(connectivity, Connectivity::SixNodeTriangles(_));
        let material = &self.model.materials[section.material];
        if let Some(constants) = &material.user.material
            && let Some(law) = self.routines.law(&material.name)
        {
            let law = Arc::clone(law);
            return self.law_group(section, (material, constants, law), (connectivity, nodes), mass);
        }
        if triangles && (asks_at_points(material) || material.user.lengths.is_some()) {
            self.refuse_six_nodes(section, "user subroutines at points (VUMAT, VUHARD, VUSDFLD, VUCHARLENGTH)");
            return None;
        }
        if asks_at_points(material) {
            if section.controls.by_area {
                let message = "WEIGHTING=AREA with routines of the user at points is not supported";
                return self.diagnostics.refuse(Diagnostic::error("P050", message).at(section.span, "this section"));
            }
            return self.user_group(section, material, elements, connectivity, nodes, mass);
        }
        let evolves = material.failures.iter().any(FailureCriterion::takes_length);
        self.asks_lengths(section, material, evolves)?;
        let moduli = self.moduli(material, section.span)?;
        let density = material.density.unwrap_or(0.0);
        add_masses(connectivity, nodes, density, mass);
        let hourglass = self.control(section, material, moduli, connectivity)?;
        let bulk_viscosity = self.model.steps.first().map_or([0.06, 1.2], |s| s.bulk_viscosity);
        let constants = Constants { bulk: moduli.bulk, shear: moduli.shear, hourglass, bulk_viscosity };
        let heats = self.adiabatic() || self.conducts(section);
        self.solid_rows(section, (elements.len(), connectivity.element_type()), &constants, (material, heats));
        let (spared, kept) = self.spared(section, material);
        let subzonal = self.subzonal(section, material, elements.len())?;
        let make = GroupBuilder::new(constants, density, connectivity, nodes);
        let make = GroupBuilder { heats, spared, kept, subzonal, ..make };
        if triangles {
            self.stays_double(section.span, elements.len(), "CAX6M");
        } else if self.is_single(section, material, &constants) {
            return self.with_volumetric(material, section.span, Linear, make.turned::<false, f32>());
        }
        if section.controls.by_area {
            return self.by_area(section, material, make.turned());
        }
        let burns = matches!(&material.eos, Some(eos) if matches!(eos.kind, EosKind::Jwl(_)));
        if !burns && !material.detonation.is_empty() {
            self.unused(material.span, "*DETONATION POINT", "only *EOS, TYPE=JWL detonates");
        }
        let row = MATERIALS.iter().find(|row| (row.applies)(material))?;
        (row.group)(self, material, section.span, make)
    }

    fn refuse_six_nodes(&mut self, section: &SolidSection, with: &str) {
        let finding = Diagnostic::error("P024", format!("CAX6M with {with} is not supported"));
        self.diagnostics.push(finding.at(section.span, "this section").help("give CAX3 or CAX4R"));
    }

    /// Hourglass control of a group: none of six-node triangles, which need a shear modulus instead.
    pub(super) fn control(
        &mut self,
        section: &SolidSection,
        material: &Material,
        moduli: Moduli,
        connectivity: &Connectivity,
    ) -> Option<HourglassControl> {
        if let Connectivity::Quadrilaterals(_) = connectivity {
            return self.hourglass(section, material, moduli);
        }
        if moduli.shear == 0.0 {
            self.refuse_six_nodes(section, "a material without a shear modulus");
        } else if section.controls.hourglass.is_some() {
            self.refuse_six_nodes(section, "HOURGLASS of *SECTION CONTROLS (the element has no hourglass pattern)");
        } else {
            return Some(HourglassControl::NONE);
        }
        None
    }

    /// Elastic moduli of a material; a missing or contradictory card is an error.
    pub(super) fn moduli(&mut self, material: &Material, span: Span) -> Option<Moduli> {
        let refusal = match material {
            Material { density: None, .. } => format!("material `{}` has no *DENSITY", material.name),
            Material {
                hyperelastic: Some(rubber),
                elastic: None,
                shear_modulus: None,
                eos: None,
                plastic,
                foam,
                ..
            } => {
                if plastic.is_none()
                    && foam.shape.is_none()
                    && material.failures.is_empty()
                    && material.tensile_failure.is_none()
                {
                    return Some(Moduli { bulk: 0.0, shear: rubber.shape.shear() });
                }
                format!("material `{}` is rubber that yields or fails, which is not supported", material.name)
            }
            Material { hyperelastic: Some(_), .. } => {
                format!("material `{}` has *HYPERELASTIC and another elasticity", material.name)
            }
            Material { eos: Some(_), elastic: None, shear_modulus, plastic, .. } => {
                let shear = shear_modulus.unwrap_or(0.0);
                if plastic.is_none() || shear > 0.0 {
                    return Some(Moduli { bulk: 0.0, shear });
                }
                format!("material `{}` yields but has no *ELASTIC, TYPE=SHEAR", material.name)
            }
            Material { eos: Some(_), .. } => {
                format!("material `{}` has an equation of state and a bulk modulus from *ELASTIC", material.name)
            }
            Material { elastic: Some(_), elastic_table, .. } if !elastic_table.is_empty() => {
                return Some(stiffest(elastic_table));
            }
            Material { elastic: Some([e, nu]), .. } => {
                let bulk = e / (3.0 * (1.0 - 2.0 * nu));
                return Some(Moduli { bulk, shear: e / (2.0 * (1.0 + nu)) });
            }
            Material { shear_modulus: Some(_), .. } => {
                format!("material `{}` has a shear modulus alone: *EOS is missing", material.name)
            }
            _ => format!("material `{}` has no *ELASTIC", material.name),
        };
        self.diagnostics.refuse(Diagnostic::error("P013", refusal).at(span, "these elements deform"))
    }

    /// The group of an equation of state, with what it takes from other cards.
    fn equation_of_state(
        &mut self,
        material: &Material,
        span: Span,
        builder: GroupBuilder<'_, false>,
    ) -> Option<Box<dyn ElementGroup>> {
        let (eos, density) = (material.eos.as_ref()?, builder.density);
        let mut row = |detail| self.cause(eos.span, "equation of state", 1, "material", detail);
        match (eos.kind.clone(), material.thermal.specific_heat.as_deref()) {
            (EosKind::IdealGas([gas_constant, ambient]), Some(&[[specific_heat, _]])) => {
                row(format!("ideal gas, gamma = {}", 1.0 + gas_constant / specific_heat));
                let absolute_zero = self.model.settings.absolute_zero;
                let law = IdealGas { gas_constant, specific_heat, ambient, absolute_zero };
                self.with_volumetric(material, span, EquationOfState::IdealGas(law), builder)
            }
            (EosKind::IdealGas(_), rows) => {
                let why = if rows.is_none() { "without *SPECIFIC HEAT" } else { "whose specific heat is not constant" };
                let message = format!("material `{}` is an ideal gas {why}", material.name);
                self.diagnostics.refuse(Diagnostic::error("P013", message).at(span, "these elements deform"))
            }
            (EosKind::UsUp([c0, s, gamma0]), _) => {
                row(format!("Us = {c0} + {s} Up, Gamma0 = {gamma0}"));
                self.with_volumetric(material, span, EquationOfState::UsUp(UsUp { density, c0, s, gamma0 }), builder)
            }
            (EosKind::Tabular(rows), _) => {
                row(format!("table of {} rows", rows.len()));
                self.with_volumetric(material, span, EquationOfState::Tabulated(Tabulated { density, rows }), builder)
            }
            (EosKind::Jwl(values), _) => {
                let law = self.explosive(material, eos.span, &values, span)?;
                self.with_volumetric(material, span, EquationOfState::Explosive(law), builder)
            }
        }
    }

    /// The group of a volumetric law, with the yield stress of the material.
    fn with_volumetric<V: Volumetric, const AREA: bool, T: Numbers>(
        &mut self,
        material: &Material,
        span: Span,
        volumetric: V,
        make: GroupBuilder<'_, AREA, T>,
    ) -> Option<Box<dyn ElementGroup>> {
        let heating = if make.heats { heating(material, make.density) } else { Heating::None };
        let failing =
            self.failing(material)?.map(|failing| Failing { spared: make.spared, kept: make.kept, ..failing });
        let Some(plastic) = &material.plastic else {
            return Some(match failing {
                Some(failure) => make.group(VonMises { hardening: Elastic, volumetric, failure }),
                None => make.group(VonMises::new(Elastic, volumetric)),
            });
        };
        if let Plastic::Kinematic(lines) = plastic {
            if failing.is_some() {
                // What damage leaves of the work against a back stress is not defined.
                let message = "kinematic hardening with failure is not supported";
                return self
                    .diagnostics
                    .refuse(Diagnostic::error("P014", message).at(span, "the material of this section"));
            }
            if let ([[yield_stress, slope, _]], None, Heating::None) = (&lines[..], &material.rate, &heating) {
                let law = Kinematic { yield_stress: *yield_stress, slope: *slope };
                return Some(make.group(VonMises::new(law, volumetric)));
            }
            let law = moving(lines, material.rate.as_ref(), heating);
            return Some(make.group(VonMises::new(law, volumetric)));
        }
        let law = self.yield_stress(plastic, material, span)?;
        if let Some(failure) = failing {
            let hardening = RateDependentHardening { law, heating };
            return Some(make.group(VonMises { hardening, volumetric, failure }));
        }
        let cold = |rows: &[[f64; 3]]| rows.iter().all(|r| r[2].is_nan());
        if let (Plastic::Tabular(rows), None, Heating::None) = (plastic, &material.rate, &heating)
            && cold(rows)
        {
            let mut rows: Vec<[f64; 2]> = rows.iter().map(|r| [r[0], r[1]]).collect();
            extrapolate(&mut rows, material);
            if let Some(lines) = PiecewiseLinearHardening::new(&rows, make.constants.shear) {
                return Some(make.group(VonMises::new(lines, volumetric)));
            }
        }
        Some(make.group(VonMises::new(RateDependentHardening { law, heating }, volumetric)))
    }

    /// 1 less MAX DEGRADATION, and whether elements stay that come so far.
    fn spared(&mut self, section: &SolidSection, material: &Material) -> (f64, bool) {
        let most = section.controls.most_damage;
        let (spared, kept) = (1.0 - most, section.controls.keeps_failed.is_some());
        let grows = material.failures.iter().any(|f| f.evolution != DamageEvolution::Absent);
        if grows && kept {
            let detail = format!("MAX DEGRADATION {most}: the rest of their stiffness stays");
            self.cause(section.span, "failed elements stay", section.elements.len(), "elements", detail);
        }
        if spared > 0.0 && !kept && !grows {
            let why = format!("no damage grows in material {}", material.name);
            self.unused(section.span, "MAX DEGRADATION", why);
        }
        (spared, kept)
    }

    /// Whether quarters of a section's elements push back: where there is an equation of state and no shear modulus, unless its
    /// controls say no.
    fn subzonal(&mut self, section: &SolidSection, material: &Material, count: usize) -> Option<bool> {
        let wanted = section.controls.subzonal;
        let fluid = material.eos.is_some() && material.shear_modulus.is_none_or(|shear| shear == 0.0);
        if wanted == Some(true) && !fluid {
            let message = "SUBZONAL=YES needs *EOS and no shear modulus";
            return self
                .diagnostics
                .refuse(Diagnostic::error("P016", message).at(section.span, "the controls of this section"));
        }
        let subzonal = fluid && wanted != Some(false);
        if subzonal {
            let detail = "quarters that are denser than their element push back";
            self.cause(section.span, "subzonal pressures", count, "elements", detail.into());
        }
        Some(subzonal)
    }

    /// The group of a section that is weighted by area, where that can be.
    fn by_area(
        &mut self,
        section: &SolidSection,
        material: &Material,
        make: GroupBuilder<'_, true>,
    ) -> Option<Box<dyn ElementGroup>> {
        let model = self.model;
        let triangles = matches!(make.connectivity, Connectivity::SixNodeTriangles(_));
        let refusal = if triangles {
            Some("WEIGHTING=AREA of CAX6M is not supported")
        } else if material.eos.is_some() || material.hyperelastic.is_some() || material.foam.shape.is_some() {
            Some("WEIGHTING=AREA needs *ELASTIC, and no foam")
        } else if model.steps.iter().any(|s| s.bulk_viscosity[0] <= 0.0) {
            Some("WEIGHTING=AREA needs linear bulk viscosity: without it some of its modes grow")
        } else if model.sections.iter().any(|s| !s.controls.by_area) {
            Some("WEIGHTING=AREA in one section needs it in all")
        } else if !model.shell_sections.is_empty() {
            Some("WEIGHTING=AREA beside shells is not supported")
        } else if !self.places.tied.is_empty() || model.steps.iter().any(|s| !s.mass_scalings.is_empty()) {
            Some("WEIGHTING=AREA with tied rigid bodies or scaled masses is not supported")
        } else {
            None
        };
        if let Some(message) = refusal {
            return self.diagnostics.refuse(Diagnostic::error("P050", message).at(section.span, "this section"));
        }
        let detail = "the equation of motion over the plane section; energy is not conserved to the last digit";
        self.cause(section.span, "area weighting", make.connectivity.count(), "elements", detail.into());
        self.with_volumetric(material, section.span, Linear, make)
    }

    /// Hourglass control of a section. Where its controls say nothing, what has no shear modulus is controlled by viscosity,
    /// rubber by assumed strains, and the rest by a spring that relaxes (ABAQUS Analysis User's Guide, "Section controls";
    /// Keywords Guide, "SECTION CONTROLS").
    pub(super) fn hourglass(
        &mut self,
        section: &SolidSection,
        material: &Material,
        moduli: Moduli,
    ) -> Option<HourglassControl> {
        let fluid = moduli.shear == 0.0;
        let unsaid = match material.hyperelastic {
            _ if fluid => Hourglass::Viscous,
            Some(_) => Hourglass::Enhanced,
            None => Hourglass::RelaxStiffness,
        };
        let SectionControls { hourglass, factor, .. } = section.controls;
        let kind = hourglass.unwrap_or(unsaid);
        if fluid && kind != Hourglass::Viscous {
            let message = "hourglass control by stiffness needs a shear modulus";
            let finding = Diagnostic::error("P016", message).at(section.span, "the controls of this section");
            return self.diagnostics.refuse(finding.help("give HOURGLASS=VISCOUS, or no controls"));
        }
        let viscosity = factor * if fluid { FLUID_VISCOSITY } else { HOURGLASS_VISCOSITY };
        let stiffness = HOURGLASS_STIFFNESS * factor;
        let [stiffness, viscosity, enhanced] = match kind {
            Hourglass::RelaxStiffness | Hourglass::Stiffness => [stiffness, 0.0, 0.0],
            Hourglass::Viscous => [0.0, viscosity, 0.0],
            Hourglass::Combined(weight) => [weight * stiffness, (1.0 - weight) * viscosity, 0.0],
            Hourglass::Enhanced => [0.0, 0.0, factor],
        };
        let relaxes = matches!(kind, Hourglass::RelaxStiffness | Hourglass::Enhanced);
        Some(HourglassControl { stiffness, viscosity, relaxes, enhanced })
    }

    fn solid_rows(
        &mut self,
        section: &SolidSection,
        (count, kind): (usize, &'static str),
        constants: &Constants,
        (material, heats): (&Material, bool),
    ) {
        let elasticity = match (&material.eos, constants.shear > 0.0) {
            _ if material.hyperelastic.is_some() => "rubber by the whole deformation",
            (Some(_), false) => "fluid",
            (Some(_), true) => "equation of state and shear modulus, Jaumann rate",
            (None, _) => "elastic, Jaumann rate",
        };
        let detail = format!("material {}, {elasticity}", material.name);
        self.cause(section.span, "deformable elements", count, kind, detail);
        if let Some(plastic) = &material.plastic {
            let law = match plastic {
                Plastic::Tabular(_) => "tabular isotropic",
                Plastic::JohnsonCook(_) => "Johnson-Cook",
                Plastic::Kinematic(_) => "linear kinematic",
                Plastic::User(_) => "by the user",
                Plastic::OverFields(_) => "over field variables",
            };
            let rate = if material.rate.is_some() { ", rate dependent" } else { "" };
            let heat = if heats && !heating(material, 1.0).is_none() { ", heated by plastic work" } else { "" };
            self.cause(section.span, "plasticity", count, "elements", format!("{law}{rate}{heat}"));
        }
        self.control_rows(section, (count, kind), constants);
    }

    /// The rows of hourglass control and bulk viscosity.
    pub(super) fn control_rows(
        &mut self,
        section: &SolidSection,
        (count, element_type): (usize, &str),
        constants: &Constants,
    ) {
        if element_type != "CAX6M" {
            let HourglassControl { stiffness, viscosity, relaxes, enhanced } = constants.hourglass;
            let kind = if relaxes { "relax stiffness" } else { "stiffness" };
            let detail = if enhanced > 0.0 {
                format!("enhanced: assumed strains by direction, factor {enhanced}")
            } else {
                format!("{kind} {stiffness} G, viscosity {viscosity}")
            };
            self.cause(section.span, "hourglass control", count, "elements", detail);
        }
        let [linear, quadratic] = constants.bulk_viscosity;
        if linear != 0.0 || quadratic != 0.0 {
            self.cause(section.span, "bulk viscosity", count, "elements", format!("{linear}, {quadratic}"));
        }
    }

    /// What fails of a material; `None` where nothing does.
    fn failing(&mut self, material: &Material) -> Option<Option<Failing>> {
        let mut failing = Failing::default();
        for criterion in &material.failures {
            let evolution = match criterion.evolution {
                DamageEvolution::Sudden => Evolution::Sudden,
                DamageEvolution::Displacement(value) => Evolution::Displacement(value),
                DamageEvolution::Energy(value) => Evolution::Energy(value),
                // Where another law flows nothing follows it, and nothing would come of it.
                DamageEvolution::Absent
                    if !matches!(material.plastic, Some(Plastic::Tabular(_) | Plastic::JohnsonCook(_))) =>
                {
                    self.unused(criterion.span, "*DAMAGE INITIATION", "without *DAMAGE EVOLUTION it changes no stress");
                    continue;
                }
                DamageEvolution::Absent => Evolution::Absent,
            };
            if material.plastic.is_none() {
                return self.no_failure(criterion.span, "failure by plastic strain needs *PLASTIC");
            }
            let strain = self.failure_strain(material, criterion)?;
            let detail = match criterion.evolution {
                DamageEvolution::Displacement(value) => format!("damage over a displacement of {value}"),
                DamageEvolution::Energy(value) => format!("damage over an energy of {value} an area"),
                DamageEvolution::Absent => "followed without damage: DMICRT".into(),
                DamageEvolution::Sudden => "deletion at once".into(),
            };
            let effect = if evolution == Evolution::Absent { "damage initiation" } else { "failure" };
            self.cause(criterion.span, effect, 1, "criterion", detail);
            failing.criteria.push(Criterion { strain, evolution });
        }
        if failing.criteria.len() > CRITERIA {
            return self.no_failure(material.span, "more than three criteria of failure are not supported");
        }
        if let Some(tensile) = material.tensile_failure {
            if !tensile.deletes && material.eos.is_none() {
                // Without an equation of state nothing would remember how far the material has opened.
                return self.no_failure(tensile.span, "a cutoff of tension without deletion needs *EOS");
            }
            let end = if tensile.deletes { "deletion" } else { "cutoff" };
            self.cause(tensile.span, "tensile failure", 1, "criterion", format!("{end} at {}", tensile.cutoff));
            failing.cutoff = Some(Cutoff { stress: tensile.cutoff, deletes: tensile.deletes });
        }
        Some((!failing.criteria.is_empty() || failing.cutoff.is_some()).then_some(failing))
    }

    fn no_failure<T>(&mut self, span: Span, message: &str) -> Option<T> {
        self.diagnostics.refuse(Diagnostic::error("P019", message).at(span, "here"))
    }

    fn failure_strain(&mut self, material: &Material, criterion: &FailureCriterion) -> Option<FailureStrain> {
        Some(match &criterion.strain {
            StrainAtFailure::Constant(strain) => FailureStrain::Constant(*strain),
            // The model has made sure that they are tables.
            StrainAtFailure::Ductile(rows) => FailureStrain::Ductile(NestedTable::new(rows)?),
            StrainAtFailure::Shear(rows) => FailureStrain::Shear(NestedTable::new(rows)?),
            StrainAtFailure::JohnsonCook(d, Some([melt, transition, reference])) => {
                FailureStrain::JohnsonCook { d: *d, melt: *melt, transition: *transition, reference: *reference }
            }
            StrainAtFailure::JohnsonCook(d, None) => {
                let (melt, transition) = match material.plastic {
                    Some(Plastic::JohnsonCook([.., melt, transition])) => (melt, transition),
                    _ if d[4] != 0.0 => {
                        return self.no_failure(criterion.span, "d5 needs *PLASTIC, HARDENING=JOHNSON COOK");
                    }
                    _ => (0.0, 0.0),
                };
                let reference = match material.rate {
                    Some(RateDependence::JohnsonCook([_, reference])) => reference,
                    _ if d[3] != 0.0 => {
                        return self.no_failure(criterion.span, "d4 needs *RATE DEPENDENT, TYPE=JOHNSON COOK");
                    }
                    _ => 1.0,
                };
                FailureStrain::JohnsonCook { d: *d, melt, transition, reference }
            }
        })
    }

    pub(super) fn yield_stress(&mut self, plastic: &Plastic, material: &Material, span: Span) -> Option<FlowStress> {
        let base = match plastic {
            // They have laws of their own.
            Plastic::Kinematic(_) | Plastic::User(_) | Plastic::OverFields(_) => return None,
            Plastic::JohnsonCook([a, b, n, m, melt, transition]) => {
                let law = JohnsonCook { a: *a, b: *b, n: *n, m: *m, melt: *melt, transition: *transition };
                StaticYield::JohnsonCook(law)
            }
            Plastic::Tabular(rows) => {
                let mut tables = match tables(rows) {
                    Ok(tables) => tables,
                    Err(message) => {
                        let finding = Diagnostic::error("P014", message).at(span, "the material of this section");
                        return self.diagnostics.refuse(finding);
                    }
                };
                tables.iter_mut().for_each(|(_, table)| extrapolate(&mut table.rows, material));
                StaticYield::Tables(TableOverTemperature { tables })
            }
        };
        Some(FlowStress { base, factor: rate_factor(material.rate.as_ref()) })
    }
}

pub(super) fn rate_factor(rate: Option<&RateDependence>) -> Option<RateFactor> {
    match rate? {
        RateDependence::JohnsonCook([c, reference]) => Some(RateFactor::JohnsonCook { c: *c, reference: *reference }),
        RateDependence::PowerLaw(rows) => {
            let over = |i: usize| Table { rows: rows.iter().map(|r| [r[i], r[2]]).collect() };
            Some(RateFactor::PowerLaw { d: over(0), n: over(1) })
        }
        RateDependence::YieldRatio(rows) => Some(RateFactor::Ratio(TableOverTemperature { tables: blocks(rows) })),
    }
}

/// The largest moduli of a table: between its rows, where Young's modulus and Poisson's ratio are linear, none is larger.
fn stiffest(rows: &[Vec<f64>]) -> Moduli {
    let largest = |of: fn(f64, f64) -> f64| rows.iter().map(|r| of(r[0], r[1])).fold(0.0, f64::max);
    let bulk = largest(|e, nu| e / (3.0 * (1.0 - 2.0 * nu)));
    let shear = largest(|e, nu| e / (2.0 * (1.0 + nu)));
    Moduli { bulk, shear }
}

/// Kinematic hardening by lines of yield stress, slope and temperature.
fn moving(lines: &[[f64; 3]], rate: Option<&RateDependence>, heating: Heating) -> RateKinematic {
    let size = |line: &[f64; 3]| (line[2], Table { rows: vec![[line[0], 0.0]] });
    let slope = Table { rows: lines.iter().map(|l| [l[1], l[2]]).collect() };
    let base = StaticYield::Tables(TableOverTemperature { tables: lines.iter().map(size).collect() });
    RateKinematic { size: FlowStress { base, factor: rate_factor(rate) }, slope, heating }
}

/// Rows of yield stress, plastic strain and temperature (not a number if absent) as one table a temperature.
fn tables(rows: &[[f64; 3]]) -> Result<Vec<(f64, Table)>, &'static str> {
    if rows.iter().any(|r| r[2].is_nan()) && !rows.iter().all(|r| r[2].is_nan()) {
        return Err("either all rows of a table have a temperature, or none");
    }
    let tables = blocks(rows);
    if tables.windows(2).any(|w| w[0].0 > w[1].0) {
        return Err("temperatures must ascend");
    }
    let starts = |t: &Table| t.rows.first().is_some_and(|r| r[1] == 0.0);
    let ascends = |t: &Table| t.rows.windows(2).all(|w| w[1][1] > w[0][1]);
    if tables.is_empty() || !tables.iter().all(|(_, t)| starts(t) && ascends(t)) {
        return Err("plastic strains must start at 0 and ascend");
    }
    Ok(tables)
}

/// Rows of a value, its abscissa and a temperature (not a number if absent) as a table at each temperature that follows.
fn blocks(rows: &[[f64; 3]]) -> Vec<(f64, Table)> {
    let mut tables: Vec<(f64, Table)> = Vec::new();
    for [value, at, temperature] in rows {
        match tables.last_mut() {
            Some((last, table)) if *last == *temperature || temperature.is_nan() => table.rows.push([*value, *at]),
            _ => tables.push((*temperature, Table { rows: vec![[*value, *at]] })),
        }
    }
    tables
}

/// Plastic strain up to which a yield stress is extrapolated: more than any body survives.
const FAR: f64 = 1e3;

/// `EXTRAPOLATION=LINEAR`: the slope of the last two rows goes on; where it falls, down to no stress.
fn extrapolate(rows: &mut Vec<[f64; 2]>, material: &Material) {
    let [.., before, last] = rows[..] else { return };
    if !material.extrapolates {
        return;
    }
    let slope = (last[0] - before[0]) / (last[1] - before[1]);
    if slope < 0.0 {
        rows.push([0.0, last[1] - last[0] / slope]);
    } else {
        rows.push([last[0] + slope * FAR, last[1] + FAR]);
    }
}

/// Rise of temperature by plastic work; none where a card for it is missing.
pub(super) fn heating(material: &Material, density: f64) -> Heating {
    match (material.thermal.inelastic_heat_fraction, material.thermal.specific_heat.as_deref()) {
        (Some(fraction), Some(&[[heat, _]])) if fraction != 0.0 => Heating::Constant(fraction / (density * heat)),
        (Some(fraction), Some(rows)) if fraction != 0.0 => {
            Heating::Over { heat: fraction / density, capacity: Table { rows: rows.to_vec() } }
        }
        _ => Heating::None,
    }
}
