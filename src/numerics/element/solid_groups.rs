//! Element groups of solids: the combinations of material laws that element groups are compiled for, and the function
//! that creates a group. Nothing else names a composition of laws, so that each is compiled once, in this crate.

use super::constants::ElementConstants;
use super::group::ElementGroup;
use super::quad::QuadGroup;
use super::six_node::SixNodeTriangles;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad::corner_masses;
use crate::kernel::topology::ElementTopology;
use crate::material::Material;
use crate::material::equation_of_state::EquationOfState;
use crate::material::failed::KeptFailure;
use crate::material::failure::MaterialFailure;
use crate::material::foam::FoamMaterial;
use crate::material::hyperelastic::{HyperelasticMaterial, NeoHooke};
use crate::material::kinematic::KinematicHardening;
use crate::material::kinematic_rate::RateKinematicHardening;
use crate::material::plasticity::{ElasticOnly, PiecewiseLinearHardening, RateDependentHardening};
use crate::material::point_law::PointLaw;
use crate::material::returns::ReturnMaterial;
use crate::material::strain_energy::{OgdenEnergy, PolynomialEnergy};
use crate::material::user::SubroutineMaterial;
use crate::material::volumetric::{ConstantBulkModulus, VolumetricLaw};
use crate::material::von_mises::VonMises;
use crate::state::nodes::Node;

/// Connectivity of an element group, in solver nodes.
pub enum Connectivity {
    /// Corners; the last two of a triangle are the same node.
    Quadrilaterals(Vec<[u32; 4]>),
    /// Six nodes around the boundary.
    SixNodeTriangles(Vec<[u32; 6]>),
}

impl Connectivity {
    /// Returns the number of elements.
    pub fn count(&self) -> usize {
        match self {
            Connectivity::Quadrilaterals(list) => list.len(),
            Connectivity::SixNodeTriangles(list) => list.len(),
        }
    }

    /// Returns the element type for reports.
    pub fn element_type(&self) -> &'static str {
        match self {
            Connectivity::Quadrilaterals(_) => "CAX4R",
            Connectivity::SixNodeTriangles(_) => "CAX6M",
        }
    }

    /// Returns the corners of quadrilaterals and triangles; empty for six-node triangles.
    pub fn quadrilaterals(&self) -> &[[u32; 4]] {
        if let Connectivity::Quadrilaterals(list) = self { list } else { &[] }
    }

    /// Returns the corners of the quadrilateral cells that make up the elements.
    pub fn cells(&self) -> Vec<[u32; 4]> {
        match self {
            Connectivity::Quadrilaterals(list) => list.clone(),
            Connectivity::SixNodeTriangles(list) => {
                let cells = ElementTopology::SixNodeTriangle.cells();
                list.iter().flat_map(|e| cells.iter().map(|cell| cell.inline_map(|i| e[i]))).collect()
            }
        }
    }

    /// Adds the nodal masses of the elements.
    pub fn add_masses(&self, nodes: &[Node], density: f64, mass: &mut [f64]) {
        for cell in self.cells() {
            for (n, m) in cell.iter().zip(corner_masses(cell.inline_map(|n| nodes[n as usize].place()), density)) {
                mass[*n as usize] += m;
            }
        }
    }
}

/// Deviatoric law of a von Mises material. Only the laws that support failure have one.
pub enum HardeningLaw {
    /// No plasticity.
    Elastic(Option<MaterialFailure>),
    /// Table of yield stress over plastic strain, without rate, heat and failure.
    PiecewiseLinear(PiecewiseLinearHardening),
    /// Isotropic hardening that may depend on rate and temperature.
    RateDependent(RateDependentHardening, Option<MaterialFailure>),
    /// The same with failed elements that stay.
    Failing(RateDependentHardening, KeptFailure),
    /// J2 plasticity with linear kinematic hardening.
    Kinematic(KinematicHardening),
    /// Linear kinematic hardening that depends on rate or temperature.
    RateKinematic(RateKinematicHardening),
}

/// Material of a group of solid elements.
pub enum SolidMaterial {
    /// Deviatoric law with a constant bulk modulus or an equation of state.
    VonMises(HardeningLaw, Option<EquationOfState>),
    /// Rubber with the neo-Hooke energy.
    NeoHooke(NeoHooke),
    /// Rubber with a polynomial strain energy.
    Polynomial(HyperelasticMaterial<PolynomialEnergy>),
    /// Rubber with an Ogden strain energy.
    Ogden(HyperelasticMaterial<OgdenEnergy>),
    /// Crushable foam with a strain-dependent yield surface.
    Foam(FoamMaterial),
    /// Strength that depends on pressure, porosity or direction.
    Return(ReturnMaterial),
    /// Law in Rust, evaluated point by point.
    Point(PointLaw<false>),
    /// Law in Rust that uses more than strain and stress, or sets its moduli.
    DetailedPoint(PointLaw<true>),
    /// VUMAT user subroutine, which computes the stress.
    UserStress(SubroutineMaterial<false>),
    /// Strain energy of invariants, built in or of VUANISOHYPER_INV.
    UserEnergy(SubroutineMaterial<false, true>),
    /// User subroutine that computes the yield stress, or built-in plasticity that is evaluated point by point.
    UserFlow(SubroutineMaterial<true>),
}

/// Properties of an element group in addition to its material.
#[derive(Clone, Copy, Debug)]
pub struct GroupOptions {
    /// Moduli, hourglass control and bulk viscosity.
    pub constants: ElementConstants,
    /// Mass per volume.
    pub density: f64,
    /// Whether elements have subzonal pressures.
    pub subzonal: bool,
}

impl GroupOptions {
    /// Returns options without subzonal pressures.
    pub fn new(constants: ElementConstants, density: f64) -> GroupOptions {
        GroupOptions { constants, density, subzonal: false }
    }
}

/// Elements of a group without their material.
#[derive(Clone, Copy)]
struct GroupShape<'a> {
    options: GroupOptions,
    connectivity: &'a Connectivity,
    nodes: &'a [Node],
}

/// A computation with the material of a group, which is compiled for each composition of laws.
pub trait MaterialVisitor {
    type Output;

    fn visit(self, material: impl Material) -> Self::Output;
}

impl SolidMaterial {
    /// Calls a visitor with the composition of laws.
    pub fn visit<V: MaterialVisitor>(self, visitor: V) -> V::Output {
        match self {
            SolidMaterial::VonMises(law, Some(equation)) => law.visit(equation, visitor),
            SolidMaterial::VonMises(law, None) => law.visit(ConstantBulkModulus, visitor),
            SolidMaterial::NeoHooke(law) => visitor.visit(law),
            SolidMaterial::Polynomial(law) => visitor.visit(law),
            SolidMaterial::Ogden(law) => visitor.visit(law),
            SolidMaterial::Foam(law) => visitor.visit(law),
            SolidMaterial::Return(law) => visitor.visit(law),
            SolidMaterial::Point(law) => visitor.visit(law),
            SolidMaterial::DetailedPoint(law) => visitor.visit(law),
            SolidMaterial::UserStress(law) => visitor.visit(law),
            SolidMaterial::UserEnergy(law) => visitor.visit(law),
            SolidMaterial::UserFlow(law) => visitor.visit(law),
        }
    }
}

impl HardeningLaw {
    fn visit<V: MaterialVisitor>(self, volumetric: impl VolumetricLaw, visitor: V) -> V::Output {
        match self {
            HardeningLaw::Elastic(None) => visitor.visit(VonMises::new(ElasticOnly, volumetric)),
            HardeningLaw::Elastic(Some(failure)) => {
                visitor.visit(VonMises { hardening: ElasticOnly, volumetric, failure })
            }
            HardeningLaw::PiecewiseLinear(law) => visitor.visit(VonMises::new(law, volumetric)),
            HardeningLaw::RateDependent(law, None) => visitor.visit(VonMises::new(law, volumetric)),
            HardeningLaw::RateDependent(hardening, Some(failure)) => {
                visitor.visit(VonMises { hardening, volumetric, failure })
            }
            HardeningLaw::Failing(hardening, failure) => visitor.visit(VonMises { hardening, volumetric, failure }),
            HardeningLaw::Kinematic(law) => visitor.visit(VonMises::new(law, volumetric)),
            HardeningLaw::RateKinematic(law) => visitor.visit(VonMises::new(law, volumetric)),
        }
    }
}

/// Creates the element group of a material.
pub fn create_group(
    material: SolidMaterial,
    options: GroupOptions,
    connectivity: &Connectivity,
    nodes: &[Node],
) -> Box<dyn ElementGroup> {
    material.visit(GroupShape { options, connectivity, nodes })
}

impl MaterialVisitor for GroupShape<'_> {
    type Output = Box<dyn ElementGroup>;

    fn visit(self, material: impl Material) -> Box<dyn ElementGroup> {
        let GroupOptions { constants, density, subzonal } = self.options;
        match self.connectivity {
            Connectivity::SixNodeTriangles(list) => {
                Box::new(SixNodeTriangles::new(material, constants, density, list, self.nodes))
            }
            Connectivity::Quadrilaterals(list) => {
                let group = QuadGroup::new(material, constants, density, list, self.nodes);
                Box::new(if subzonal { group.with_subzones(list, self.nodes) } else { group })
            }
        }
    }
}
