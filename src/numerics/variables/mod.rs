//! Table of output variables: name, location, component labels, description, dimension and formula. A new variable is
//! one entry here; the owner of its value returns it from `value(.., Variable)`.
//!
//! Source of names and meanings: Abaqus Analysis User's Guide, "Abaqus/Explicit output variable identifiers".

pub mod dimension;
pub mod manual;
pub mod request;
pub mod statistic;

use crate::kernel::stress;
use dimension::*;

/// Location of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariablePlace {
    /// One value per node.
    Node,
    /// At the integration point of an element.
    Point,
    /// One value per element.
    Element,
    /// On facets of loaded surfaces.
    Facet,
    /// An energy of the whole model.
    Energy,
    /// One value per increment, such as the time increment.
    Increment,
    /// For a surface over which integrals are taken.
    Section,
    /// For a pair of contact surfaces.
    Pair,
    /// For a part: the elements of a set.
    Part,
}

/// Condition under which a variable is written without a request by name (`PRESELECT`, or no request at all).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreselectRule {
    /// Only by request.
    Never,
    /// In every model.
    Always,
    /// In models with deformable bodies.
    Deformable,
    /// If elements can be deleted.
    ElementDeletion,
    /// If nodal temperatures are solved for; the variable exists only then.
    HeatConduction,
    /// With contact of element surfaces; the variable exists only then.
    SurfaceContact,
    /// With cohesive behaviour of contact surfaces; the variable exists only then.
    CohesiveContact,
    /// With penalty contact; the variable exists only then.
    PenaltyContact,
    /// With a material that can be damaged or fail; the variable exists only then.
    Damage,
    /// With mass scaling; the variable exists only then.
    MassScaling,
    /// With adaptive meshes; the variable exists only then.
    AdaptiveMesh,
    /// With Eulerian boundaries of adaptive meshes; the variable exists only then.
    EulerianBoundary,
    /// With a rigid body with six degrees of freedom; the variable exists only then.
    SixDofBody,
}

/// One entry of the table.
#[derive(Clone, Copy, Debug)]
pub struct VariableRow {
    /// Name in decks and files.
    pub name: &'static str,
    /// Names of the components; empty for a scalar and for numbered variables.
    pub labels: &'static [&'static str],
    /// Nodes, integration points, elements or another location of the values.
    pub place: VariablePlace,
    /// Description for the manual.
    pub words: &'static str,
    /// Condition under which frames contain it without a request by name.
    pub preselected: PreselectRule,
    /// Whether the variable exists only with deformable bodies.
    pub deforming: bool,
    /// Whether a number follows its name (`SDV1`).
    pub numbered: bool,
    /// Whether elements compute it only if an output requests it.
    pub followed: bool,
    /// Variable that an element must have to compute this one, for variables computed on request.
    pub needs: Option<Variable>,
    /// Whether the variable is an extension that ABAQUS does not have.
    pub extension: bool,
    /// Formula from other variables of the element; `None` if its owner returns it.
    pub formula: Option<VariableFormula>,
    /// Combines the values of several loads on one facet: the result so far and the next value.
    pub combined: fn(f64, f64) -> f64,
    /// Physical dimension of the values, as powers of the base dimensions.
    pub dimension: DimensionPowers,
}

/// Computes a component of a variable from other values of the element; `None` if the element lacks one.
pub type VariableFormula = fn(&dyn ElementValues, usize) -> Option<f64>;

/// Element values as input of formulas.
pub trait ElementValues {
    /// Returns a component of a stored variable; `None` if the element does not have it.
    fn held(&self, variable: Variable, component: usize) -> Option<f64>;
    /// Returns the current volume.
    fn volume(&self) -> f64;
}

/// Declares the variables as an enumeration and a table in the same order, which is also the order of output.
macro_rules! variables {
    ($($variant:ident: $row:expr,)*) => {
        /// An output variable; its row has the description.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[allow(missing_docs)] // The descriptions are in the rows.
        pub enum Variable { $($variant,)* }

        impl Variable {
            /// All variables, in the order of output.
            pub const ALL: &'static [Variable] = &[$(Variable::$variant,)*];
        }

        const ROWS: &[VariableRow] = &[$($row,)*];
    };
}

variables! {
    Displacement: node("U", &["U1", "U2"], "Displacement along r and z").preselected(PreselectRule::Always).dimension(LENGTH),
    Velocity: node("V", &["V1", "V2"], "Velocity along r and z").preselected(PreselectRule::Always).dimension(VELOCITY),
    Acceleration: node("A", &["A1", "A2"], "Acceleration along r and z").preselected(PreselectRule::Always).dimension(ACCELERATION),
    Reaction: node("RF", &["RF1", "RF2"], "Reaction force of prescribed motions; of a rigid body at its reference node")
        .preselected(PreselectRule::Deformable).dimension(FORCE),
    Coordinate: node("COORD", &["COOR1", "COOR2"], "Current coordinates, which frames have as their points").dimension(LENGTH),
    NodalTemperature: node("NT", &["NT11"], "Nodal temperature, if it is solved for or prescribed").with(PreselectRule::HeatConduction).dimension(TEMPERATURE),
    ReactionFlux: node("RFL", &["RFL11"], "Reaction heat rate of prescribed temperatures, positive into the body").with(PreselectRule::HeatConduction).dimension(POWER),
    Rotation: node("UR", &["UR3"], "Rotation of nodes of shells in the r-z plane, counter-clockwise, radians")
        .preselected(PreselectRule::Always),
    RotationalVelocity: node("VR", &["VR3"], "Rotational velocity of nodes of shells").dimension(PER_TIME),
    RotationalAcceleration: node("AR", &["AR3"], "Rotational acceleration of nodes of shells").dimension([0, 0, -2, 0]),
    ReactionMoment: node("RM", &["RM3"], "Reaction moment of prescribed rotations of shells").dimension(ENERGY),
    ContactPressure: node("CPRESS", &[], "Contact pressure at the nodes of one surface of a pair").with(PreselectRule::SurfaceContact).dimension(STRESS),
    ContactShear: node("CSHEAR", &["CSHEAR1"], "Frictional shear stress at these nodes, positive to the left of the outward normal").with(PreselectRule::SurfaceContact).dimension(STRESS),
    ContactOpening: node("COPEN", &[], "Contact opening at these nodes, negative for an overlap, if a surface is near").with(PreselectRule::SurfaceContact).dimension(LENGTH),
    ContactSlip: node("CSLIP", &["CSLIP1"], "Accumulated slip at these nodes while in contact").with(PreselectRule::SurfaceContact).dimension(LENGTH),
    SurfaceDamage: node("CSDMG", &[], "Damage of cohesive surfaces at these nodes, 0 to 1").with(PreselectRule::CohesiveContact),
    LargestTractionInitiation: node("CSMAXSCRT", &[], "Maximum nominal stress criterion of cohesive surfaces").with(PreselectRule::CohesiveContact),
    QuadraticTractionInitiation: node("CSQUADSCRT", &[], "Quadratic nominal stress criterion of cohesive surfaces").with(PreselectRule::CohesiveContact),
    LargestSeparationInitiation: node("CSMAXUCRT", &[], "Maximum separation criterion of cohesive surfaces").with(PreselectRule::CohesiveContact),
    QuadraticSeparationInitiation: node("CSQUADUCRT", &[], "Quadratic separation criterion of cohesive surfaces").with(PreselectRule::CohesiveContact),
    ThirdDisplacement: node("U3", &[], "Displacement along 3 of bodies with six degrees of freedom").preselected(PreselectRule::SixDofBody).as_extension().dimension(LENGTH),
    ThirdVelocity: node("V3", &[], "Velocity along 3 of bodies with six degrees of freedom").preselected(PreselectRule::SixDofBody).as_extension().dimension(VELOCITY),
    ThirdAcceleration: node("A3", &[], "Acceleration along 3 of bodies with six degrees of freedom").preselected(PreselectRule::SixDofBody).as_extension().dimension(ACCELERATION),
    OutwardRotation: node("UROUT", &["UR1", "UR2"], "Rotation about 1 and 2 of bodies with six degrees of freedom: with UR3 the rotation vector, radians").preselected(PreselectRule::SixDofBody).as_extension(),
    OutwardRotationalVelocity: node("VROUT", &["VR1", "VR2"], "Rotational velocity about 1 and 2 of bodies with six degrees of freedom").preselected(PreselectRule::SixDofBody).as_extension().dimension(PER_TIME),
    OutwardRotationalAcceleration: node("AROUT", &["AR1", "AR2"], "Rotational acceleration about 1 and 2 of bodies with six degrees of freedom").preselected(PreselectRule::SixDofBody).as_extension().dimension([0, 0, -2, 0]),
    Yaw: node("YAW", &[], "Angle between the axis of a body with six degrees of freedom and its velocity, degrees, 0 to 90").preselected(PreselectRule::SixDofBody).as_extension(),
    Tilt: node("TILT", &[], "Angle between the axis of a body with six degrees of freedom and direction 2, degrees").preselected(PreselectRule::SixDofBody).as_extension(),
    Stress: point("S", &["S11", "S22", "S33", "S12"], "Stress: radial, axial, hoop, shear; of shells at the middle section point: meridian, hoop, or the directions 1 and 2 of its layer; of cohesive elements: S22 normal, S12 shear traction").preselected(PreselectRule::Deformable).dimension(STRESS),
    Mises: point("MISES", &[], "Mises equivalent stress").preselected(PreselectRule::Deformable)
        .by(|e, _| Some(stress::mises(tensor(e, Variable::Stress)?))).dimension(STRESS),
    Pressure: point("PRESS", &[], "Equivalent pressure stress, positive in compression")
        .preselected(PreselectRule::Deformable).by(|e, _| Some(stress::pressure(tensor(e, Variable::Stress)?))).dimension(STRESS),
    PrincipalStress: point("SP", &["SP1", "SP2", "SP3"], "Principal stresses, ascending").by(|e, i| Some(stress::principal(tensor(e, Variable::Stress)?)[i])).dimension(STRESS),
    Tresca: point("TRESC", &[], "Tresca equivalent stress: the difference of the outer principal stresses")
        .by(|e, _| Some(stress::tresca(tensor(e, Variable::Stress)?))).dimension(STRESS),
    Triaxiality: point("TRIAX", &[], "Stress triaxiality: minus PRESS over MISES; 0 without stress")
        .by(|e, _| Some(stress::triaxiality(tensor(e, Variable::Stress)?))),
    PlasticStrain: point("PEEQ", &[], "Equivalent plastic strain").preselected(PreselectRule::Deformable),
    Temperature: point("TEMP", &[], "Temperature, if the material computes it").dimension(TEMPERATURE),
    HeatFlux: point("HFL", &["HFL1", "HFL2"], "Heat flux along r and z, if temperatures are solved for").with(PreselectRule::HeatConduction).dimension([0, 1, -3, 0]),
    LogarithmicStrain: point("LE", &["LE11", "LE22", "LE33", "LE12"], "Logarithmic strain; LE12 is the engineering shear")
        .preselected(PreselectRule::Deformable).followed(None),
    PrincipalStrain: point("LEP", &["LEP1", "LEP2", "LEP3"], "Principal logarithmic strains, ascending").followed(None)
        .by(|e, i| Some(stress::principal(strain(e, Variable::LogarithmicStrain)?)[i])),
    PlasticComponents: point("PE", &["PE11", "PE22", "PE33", "PE12"], "Plastic strain; PE12 is the engineering shear")
        .preselected(PreselectRule::Deformable).followed(Some(Variable::PlasticStrain)),
    PrincipalPlasticStrain: point("PEP", &["PEP1", "PEP2", "PEP3"], "Principal plastic strains, ascending")
        .followed(Some(Variable::PlasticStrain)).by(|e, i| Some(stress::principal(strain(e, Variable::PlasticComponents)?)[i])),
    PlasticMagnitude: point("PEMAG", &[], "Magnitude of the plastic strain: sqrt(2/3 PE:PE)").followed(Some(Variable::PlasticStrain))
        .by(|e, _| Some(stress::magnitude(strain(e, Variable::PlasticComponents)?))),
    StrainRate: point("ER", &["ER11", "ER22", "ER33", "ER12"], "Strain rate of the last increment; ER12 is the engineering shear")
        .followed(None).dimension(PER_TIME),
    PrincipalStrainRate: point("ERP", &["ERP1", "ERP2", "ERP3"], "Principal strain rates, ascending").followed(None)
        .by(|e, i| Some(stress::principal(strain(e, Variable::StrainRate)?)[i])).dimension(PER_TIME),
    VolumetricStrainRate: point("ERV", &[], "Volumetric strain rate").followed(None)
        .by(|e, _| Some(-3.0 * stress::pressure(strain(e, Variable::StrainRate)?))).dimension(PER_TIME),
    StrainEnergy: point("SENER", &[], "Elastic strain energy per unit of current volume").followed(None)
        .by(|e, _| Some(e.held(Variable::ElementStrainEnergy, 0)? / volume(e))).dimension(STRESS),
    PlasticEnergy: point("PENER", &[], "Energy dissipated by plastic flow per unit of current volume").followed(None)
        .by(|e, _| Some(e.held(Variable::ElementPlasticEnergy, 0)? / volume(e))).dimension(STRESS),
    BottomStress: point("S_SNEG", &["S11_SNEG", "S22_SNEG"], "Stress of shells at section point 1, the side SNEG: meridian, hoop")
        .preselected(PreselectRule::Deformable).as_extension().dimension(STRESS),
    TopStress: point("S_SPOS", &["S11_SPOS", "S22_SPOS"], "Stress of shells at the last section point, the side SPOS: meridian, hoop")
        .preselected(PreselectRule::Deformable).as_extension().dimension(STRESS),
    BottomMises: point("MISES_SNEG", &[], "Mises equivalent stress of shells at the side SNEG").preselected(PreselectRule::Deformable)
        .as_extension().by(|e, _| Some(stress::mises(tensor(e, Variable::BottomStress)?))).dimension(STRESS),
    TopMises: point("MISES_SPOS", &[], "Mises equivalent stress of shells at the side SPOS").preselected(PreselectRule::Deformable)
        .as_extension().by(|e, _| Some(stress::mises(tensor(e, Variable::TopStress)?))).dimension(STRESS),
    BottomPlasticStrain: point("PEEQ_SNEG", &[], "Equivalent plastic strain of shells at the side SNEG")
        .preselected(PreselectRule::Deformable).as_extension(),
    TopPlasticStrain: point("PEEQ_SPOS", &[], "Equivalent plastic strain of shells at the side SPOS")
        .preselected(PreselectRule::Deformable).as_extension(),
    BottomStrain: point("LE_SNEG", &["LE11_SNEG", "LE22_SNEG", "LE33_SNEG"], "Logarithmic strain of shells at the side SNEG: meridian, hoop, thickness")
        .preselected(PreselectRule::Deformable).followed(Some(Variable::Thickness)).as_extension(),
    TopStrain: point("LE_SPOS", &["LE11_SPOS", "LE22_SPOS", "LE33_SPOS"], "Logarithmic strain of shells at the side SPOS: meridian, hoop, thickness")
        .preselected(PreselectRule::Deformable).followed(Some(Variable::Thickness)).as_extension(),
    BottomTemperature: point("TEMP_SNEG", &[], "Temperature of shells at the side SNEG").as_extension().dimension(TEMPERATURE),
    TopTemperature: point("TEMP_SPOS", &[], "Temperature of shells at the side SPOS").as_extension().dimension(TEMPERATURE),
    Thickness: point("STH", &[], "Thickness of shells").preselected(PreselectRule::Deformable).dimension(LENGTH),
    SectionForce: point("SF", &["SF1", "SF2", "SF4"], "Section force of shells per length: meridian, hoop, transverse shear").dimension([0, 1, -2, 0]),
    SectionMoment: point("SM", &["SM1", "SM2"], "Section moment of shells per length: meridian, hoop; positive with tension on the side SPOS").dimension(FORCE),
    SectionStrain: point("SE", &["SE1", "SE2", "SE4"], "Section strain of shells: meridian, hoop, transverse shear")
        .followed(Some(Variable::Thickness)),
    SectionCurvature: point("SK", &["SK1", "SK2"], "Change of curvature of shells: meridian, hoop").followed(Some(Variable::Thickness)).dimension([-1, 0, 0, 0]),
    Status: element("STATUS", "1 for an active element, 0 for a deleted element").preselected(PreselectRule::ElementDeletion),
    Volume: element("EVOL", "Current volume of an element").by(|e, _| Some(volume(e))).dimension(VOLUME),
    Density: point("DENSITY", &[], "Mass per unit of current volume").by(|e, _| Some(e.held(Variable::Mass, 0)? / volume(e))).dimension([-3, 1, 0, 0]),
    ElementStrainEnergy: element("ELSE", "Elastic strain energy of an element").followed(None).dimension(ENERGY),
    ElementPlasticEnergy: element("ELPD", "Energy dissipated by plastic flow in an element").followed(None).dimension(ENERGY),
    ElementArtificialEnergy: element("ELASE", "Artificial strain energy of hourglass control in an element").followed(None).dimension(ENERGY),
    ElementDamageEnergy: element("ELDMD", "Elastic energy of an element that was lost by damage").followed(Some(Variable::Degradation)).dimension(ENERGY),
    Mass: element("MASS", "Mass of an element").as_extension().dimension(MASS),
    MassScalingFactor: element("EMSF", "Factor of mass scaling on the mass of an element"),
    SpecificEnergy: point("SPECIFIC_ENERGY", &[], "Internal energy per unit of mass, if an equation of state computes it").as_extension().dimension([2, 0, -2, 0]),
    Degradation: point("SDEG", &[], "Scalar stiffness degradation: the fraction by which damage reduces the stress"),
    Damage: point("DAMAGE", &[], "Damage of brittle materials (Johnson-Holmquist, Holmquist-Johnson-Cook), 0 intact to 1 fractured").as_extension(),
    TensionDamage: point("DAMAGET", &[], "Damage of concrete in tension"),
    CompressionDamage: point("DAMAGEC", &[], "Damage of concrete in compression"),
    TensionPlasticStrain: point("PEEQT", &[], "Equivalent plastic strain of concrete in tension; PEEQ is that in compression"),
    CapStrain: point("PEQC", &["PEQC1", "PEQC2", "PEQC3", "PEQC4"], "Equivalent plastic strains of the failure, cap and transition surface, and the volumetric plastic strain, positive for compaction"),
    VoidVolumeFraction: point("VVF", &[], "Void volume fraction of a porous metal"),
    RelativeDensity: point("RD", &[], "Relative density of a porous metal, 1 - VVF"),
    PlasticCompaction: point("MUP", &[], "Plastic compaction of concrete (Holmquist-Johnson-Cook)").as_extension(),
    Distension: point("PALPH", &[], "Distension of a compacting material: density of the solid over that of the porous material"),
    DamageInitiation: point("DMICRT", &[], "Damage initiation criterion, the largest of all; damage begins at 1"),
    DuctileInitiation: point("DUCTCRT", &[], "Ductile damage initiation criterion"),
    JohnsonCookInitiation: point("JCCRT", &[], "Johnson-Cook damage initiation criterion"),
    NominalStrain: point("E", &["E22", "E12"], "Nominal strain of cohesive elements: normal and shear separation over the constitutive thickness"),
    LargestStressInitiation: point("MAXSCRT", &[], "Maximum nominal stress criterion of cohesive elements"),
    QuadraticStressInitiation: point("QUADSCRT", &[], "Quadratic nominal stress criterion of cohesive elements"),
    LargestStrainInitiation: point("MAXECRT", &[], "Maximum nominal strain criterion of cohesive elements"),
    QuadraticStrainInitiation: point("QUADECRT", &[], "Quadratic nominal strain criterion of cohesive elements"),
    BurnFraction: point("BURNF", &[], "Burn fraction of an explosive"),
    State: point("SDV", &[], "Solution-dependent state variables of a user material; SDV1 is the first").numbered(),
    FacetPressure: facet("PRESSURE", "Pressure of the loads on a facet", |sum, next| sum + next).dimension(STRESS),
    NormalVelocity: facet("NORMAL_VELOCITY", "Velocity of a facet along its outward normal", |_, last| last).dimension(VELOCITY),
    Layer: facet("LAYER", "Number (from 1) of the target layer that contains the largest part of a facet; 0 outside the target", f64::max),
    SurfaceForce: section("SOF", &["SOF1", "SOF2"], "Force on a surface: the reaction that holds its elements against their internal forces").dimension(FORCE),
    SectionArea: section("SOAREA", &[], "Current area of a surface").dimension(AREA),
    NormalContactForce: pair("CFN", &["CFN1", "CFN2"], "Force of contact pressure on the first surface of a pair: radial, integrated around the axis, and axial").dimension(FORCE),
    ShearContactForce: pair("CFS", &["CFS1", "CFS2"], "Force of friction on the first surface of a pair").dimension(FORCE),
    ContactForce: pair("CFT", &["CFT1", "CFT2"], "Force of contact, CFN and CFS, on the first surface of a pair").dimension(FORCE),
    NormalContactMagnitude: pair("CFNM", &[], "Magnitude of CFN").dimension(FORCE),
    ShearContactMagnitude: pair("CFSM", &[], "Magnitude of CFS").dimension(FORCE),
    ContactMagnitude: pair("CFTM", &[], "Magnitude of CFT").dimension(FORCE),
    ContactArea: pair("CAREA", &[], "Area in contact").dimension(AREA),
    PartMass: part("PARTMASS", "Mass of the active elements of a part").dimension(MASS),
    PartMomentum: part("PARTMOM", "Momentum of the active elements of a part along z").dimension([1, 1, -1, 0]),
    PartVelocity: part("PARTVEL", "Velocity along z of the centre of mass of the active elements of a part: PARTMOM over PARTMASS").dimension(VELOCITY),
    PartKineticEnergy: part("PARTKE", "Kinetic energy of the active elements of a part").dimension(ENERGY),
    PartInternalEnergy: part("PARTIE", "Internal energy of the active elements of a part: as ALLIE, the strain energy, the energies dissipated by plastic flow and damage, and that of hourglass control")
        .followed(None).dimension(ENERGY),
    PartErodedMass: part("PARTERO", "Mass of the deleted elements of a part").dimension(MASS),
    KineticEnergy: energy("ALLKE", "Kinetic energy"),
    Work: energy("ALLWK", "External work of loads and prescribed motions"),
    FrictionEnergy: energy("ALLFD", "Energy dissipated by friction"),
    CavityEnergy: energy("ALLCAV", "Energy dissipated by cavity expansion in targets").as_extension(),
    InternalEnergy: energy("ALLIE", "Internal energy: ALLSE + ALLPD + ALLAE + ALLDMD").deformable_only(),
    AllStrainEnergy: energy("ALLSE", "Recoverable strain energy").deformable_only(),
    AllPlasticEnergy: energy("ALLPD", "Energy dissipated by plastic flow").deformable_only(),
    AllDamageEnergy: energy("ALLDMD", "Elastic energy lost by damage and failure of materials").with(PreselectRule::Damage),
    ViscousEnergy: energy("ALLVD", "Energy dissipated by bulk viscosity, dashpots and damping").deformable_only(),
    ArtificialEnergy: energy("ALLAE", "Artificial strain energy of hourglass control").deformable_only(),
    ConstraintWork: energy("ALLCW", "Constraint work: energy lost in contact").deformable_only(),
    PenaltyWork: energy("ALLPW", "Energy stored and lost by penalty springs of contact").with(PreselectRule::PenaltyContact),
    MassScalingWork: energy("ALLMW", "Work done in propelling mass added by mass scaling").with(PreselectRule::MassScaling),
    DistortionEnergy: energy("ALLDC", "Energy dissipated by distortion control").deformable_only(),
    AdvectionEnergy: energy("ALLADV", "Kinetic energy lost in the transport through adaptive meshes").with(PreselectRule::AdaptiveMesh).as_extension(),
    FlowKineticEnergy: energy("ALLFKE", "Kinetic energy that has entered through Eulerian boundaries of adaptive meshes less that which has left").with(PreselectRule::EulerianBoundary).as_extension(),
    MassIn: energy("MASSIN", "Mass that has entered through Eulerian boundaries").with(PreselectRule::EulerianBoundary).as_extension().dimension(MASS),
    MassOut: energy("MASSOUT", "Mass that has left through Eulerian boundaries").with(PreselectRule::EulerianBoundary).as_extension().dimension(MASS),
    FlowMomentum: energy("MOMFLOW", "Momentum along z that has entered through Eulerian boundaries less that which has left").with(PreselectRule::EulerianBoundary).as_extension().dimension([1, 1, -1, 0]),
    ExternalHeat: energy("ALLHF", "External heat through fluxes, films, prescribed temperatures and Eulerian boundaries").with(PreselectRule::HeatConduction),
    InternalHeat: energy("ALLIHE", "Internal heat energy: ALLHF plus the heat generated by plastic work and friction").with(PreselectRule::HeatConduction),
    RemovedMass: energy("EROMASS", "Mass of deleted elements").with(PreselectRule::ElementDeletion).as_extension().dimension(MASS),
    RemovedEnergy: energy("EROIE", "Internal energy of deleted elements, part of ALLIE").with(PreselectRule::ElementDeletion).as_extension(),
    PointMass: energy("EROPMASS", "Mass of nodes whose elements are all deleted; they remain as point masses").with(PreselectRule::ElementDeletion).as_extension().dimension(MASS),
    PointKineticEnergy: energy("EROPKE", "Kinetic energy of the point masses, part of ALLKE").with(PreselectRule::ElementDeletion).as_extension(),
    PointMomentum: energy("EROPMOM", "Momentum of the point masses along z").with(PreselectRule::ElementDeletion).as_extension().dimension([1, 1, -1, 0]),
    TotalEnergy: energy("ETOTAL", "Energy balance, constant: ALLKE + ALLIE + ALLVD + ALLFD + ALLCW + ALLPW + ALLDC + ALLADV + ALLCAV - ALLWK - ALLMW - ALLFKE"),
    TimeIncrement: VariableRow { place: VariablePlace::Increment, ..energy("DT", "Time increment") }.dimension(TIME),
    MeshChanges: VariableRow { place: VariablePlace::Increment, ..energy("NADAPT", "Number of changes of adaptive meshes") }
        .with(PreselectRule::AdaptiveMesh).as_extension().dimension([0; 4]),
    SmallestAngle: VariableRow { place: VariablePlace::Increment, ..energy("ADANGLE", "Smallest angle of elements in adaptive meshes, degrees") }
        .with(PreselectRule::AdaptiveMesh).as_extension().dimension([0; 4]),
    AddedMass: VariableRow { place: VariablePlace::Increment, ..energy("DMASS", "Mass added by mass scaling, percent of the original mass of the deformable bodies") }
        .with(PreselectRule::MassScaling).dimension([0; 4]),
}

const fn node(name: &'static str, labels: &'static [&'static str], words: &'static str) -> VariableRow {
    VariableRow {
        name,
        labels,
        place: VariablePlace::Node,
        words,
        preselected: PreselectRule::Never,
        deforming: false,
        numbered: false,
        followed: false,
        needs: None,
        extension: false,
        formula: None,
        combined: |_, last| last,
        dimension: NONE,
    }
}

const fn point(name: &'static str, labels: &'static [&'static str], words: &'static str) -> VariableRow {
    VariableRow { place: VariablePlace::Point, deforming: true, ..node(name, labels, words) }
}

const fn element(name: &'static str, words: &'static str) -> VariableRow {
    VariableRow { place: VariablePlace::Element, deforming: true, ..node(name, &[], words) }
}

const fn facet(name: &'static str, words: &'static str, combined: fn(f64, f64) -> f64) -> VariableRow {
    VariableRow { place: VariablePlace::Facet, extension: true, combined, ..node(name, &[], words) }
}

const fn section(name: &'static str, labels: &'static [&'static str], words: &'static str) -> VariableRow {
    VariableRow { place: VariablePlace::Section, deforming: true, ..node(name, labels, words) }
}

const fn pair(name: &'static str, labels: &'static [&'static str], words: &'static str) -> VariableRow {
    VariableRow { place: VariablePlace::Pair, deforming: true, ..node(name, labels, words) }
}

const fn part(name: &'static str, words: &'static str) -> VariableRow {
    VariableRow { place: VariablePlace::Part, extension: true, ..node(name, &[], words) }
}

const fn energy(name: &'static str, words: &'static str) -> VariableRow {
    VariableRow { place: VariablePlace::Energy, dimension: ENERGY, ..node(name, &[], words) }
}

impl VariableRow {
    const fn preselected(self, preselected: PreselectRule) -> VariableRow {
        VariableRow { preselected, ..self }
    }

    /// Marks a variable of deformable bodies that is preselected under a condition.
    const fn with(self, preselected: PreselectRule) -> VariableRow {
        VariableRow { preselected, deforming: true, ..self }
    }

    const fn by(self, formula: VariableFormula) -> VariableRow {
        VariableRow { formula: Some(formula), ..self }
    }

    const fn followed(self, needs: Option<Variable>) -> VariableRow {
        VariableRow { followed: true, needs, ..self }
    }

    const fn dimension(self, dimension: DimensionPowers) -> VariableRow {
        VariableRow { dimension, ..self }
    }

    const fn numbered(self) -> VariableRow {
        VariableRow { numbered: true, ..self }
    }

    const fn as_extension(self) -> VariableRow {
        VariableRow { extension: true, ..self }
    }

    const fn deformable_only(self) -> VariableRow {
        VariableRow { deforming: true, ..self }
    }
}

fn tensor(element: &dyn ElementValues, variable: Variable) -> Option<[f64; 4]> {
    let component = |i| element.held(variable, i);
    Some([component(0)?, component(1)?, component(2)?, component(3)?])
}

/// Returns a strain with the tensorial shear, half the engineering shear.
fn strain(element: &dyn ElementValues, variable: Variable) -> Option<[f64; 4]> {
    let [rr, zz, hoop, rz] = tensor(element, variable)?;
    Some([rr, zz, hoop, 0.5 * rz])
}

fn volume(element: &dyn ElementValues) -> f64 {
    element.volume()
}

impl Variable {
    /// Returns the row of the variable in the table of variables.
    pub fn row(self) -> &'static VariableRow {
        &ROWS[self as usize]
    }

    /// Returns the upper-case name, as in output requests and columns.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns the location: node, integration point, element, facet or the whole model.
    pub fn place(self) -> VariablePlace {
        self.row().place
    }

    /// Returns whether it is a nodal variable.
    pub fn is_of_nodes(self) -> bool {
        self.place() == VariablePlace::Node
    }

    /// Returns whether nodes have it and it is continuous between them, so that it has a value at any point of a body.
    pub fn is_continuous(self) -> bool {
        matches!(
            self,
            Variable::Displacement
                | Variable::Velocity
                | Variable::Acceleration
                | Variable::Coordinate
                | Variable::NodalTemperature
        )
    }

    /// Returns whether it is a variable of nodal rotations.
    pub fn is_of_rotations(self) -> bool {
        matches!(
            self,
            Variable::Rotation
                | Variable::RotationalVelocity
                | Variable::RotationalAcceleration
                | Variable::ReactionMoment
        )
    }

    /// Returns whether only shells, or their nodes, have it.
    pub fn is_of_shells(self) -> bool {
        let first = Variable::BottomStress as usize;
        self.is_of_rotations() || (first..=Variable::SectionCurvature as usize).contains(&(self as usize))
    }

    /// Returns whether it is a variable at the nodes of contact surfaces.
    pub fn is_of_contact_nodes(self) -> bool {
        matches!(self.row().preselected, PreselectRule::SurfaceContact | PreselectRule::CohesiveContact)
    }

    /// Returns whether it is an element variable.
    pub fn is_of_elements(self) -> bool {
        matches!(self.place(), VariablePlace::Point | VariablePlace::Element)
    }

    /// Returns the components of the variable; one for a scalar. The number of components of a numbered variable is
    /// unknown.
    pub fn parts(self) -> impl Iterator<Item = VariableComponent> {
        (0..self.row().labels.len().max(1)).map(move |component| VariableComponent { variable: self, component })
    }

    /// Returns a component for an element, from its formula or stored values; `None` if the element does not have it.
    pub fn of(self, component: usize, element: &dyn ElementValues) -> Option<f64> {
        match self.row().formula {
            Some(formula) => formula(element, component),
            None => element.held(self, component),
        }
    }
}

/// One component of a variable. For a numbered variable the component is its number, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VariableComponent {
    /// Variable to which the component belongs.
    pub variable: Variable,
    /// Index of the component, from 0.
    pub component: usize,
}

impl VariableComponent {
    /// Returns the label of the component in histories and frames: `S11`, `PEEQ`, `SDV2`.
    pub fn label(self) -> String {
        let row = self.variable.row();
        match row.labels.get(self.component) {
            Some(label) => (*label).to_owned(),
            None if row.numbered => format!("{}{}", row.name, self.component + 1),
            None => row.name.to_owned(),
        }
    }
}

impl From<Variable> for VariableComponent {
    /// Returns the scalar, or the first component.
    fn from(variable: Variable) -> VariableComponent {
        VariableComponent { variable, component: 0 }
    }
}
