//! The ABAQUS subroutines that a run calls: a table of all arguments with their kinds and values. The types of the
//! functions, the calls and the check of prototypes are generated from it.
#![allow(unsafe_code)]

use std::ffi::c_char;

use super::{
    AmplitudeCall, EnergyAnswer, EnergyCall, FieldAnswer, FieldCall, FrictionCall, HardeningAnswer, HardeningCall,
    LengthCall, LoadPoints, MAX_BLOCK, MAX_MATERIAL_BLOCK, MaterialAnswer, MaterialCall, MotionCall, NodalFieldCall,
};

/// Kind of an argument, and whether the subroutine writes a result there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArgumentKind {
    /// `integer*4` that the subroutine reads.
    Integer,
    /// `real*8` that the subroutine reads.
    Real,
    /// `character*80` that the subroutine reads.
    Character,
    /// `integer*4` that the subroutine sets.
    IntegerResult,
    /// `real*8` that the subroutine sets.
    RealResult,
}

/// Pointer types of arguments, by [`ArgumentKind`].
mod pointer {
    pub type Integer = *const i32;
    pub type Real = *const f64;
    pub type Character = *const super::c_char;
    pub type IntegerResult = *mut i32;
    pub type RealResult = *mut f64;
}

/// A subroutine with its arguments in order.
#[derive(Debug)]
pub struct SubroutineInterface {
    /// Name in lower case.
    pub name: &'static str,
    /// Names in the manual, and kinds.
    pub arguments: &'static [(&'static str, ArgumentKind)],
}

impl SubroutineInterface {
    /// Returns the names of the arguments of a kind.
    pub fn arguments_of(&self, kind: ArgumentKind) -> impl Iterator<Item = &'static str> {
        self.arguments.iter().filter(move |(_, of)| *of == kind).map(|(name, _)| *name)
    }
}

/// Returns the interface of a supported subroutine.
pub fn interface(name: &str) -> Option<&'static SubroutineInterface> {
    INTERFACES.iter().find(|interface| interface.name == name)
}

/// Length of names in arguments.
pub const NAME: usize = 80;
/// Degrees of freedom of a node in an axisymmetric model: r, z, rotation.
pub const DOFS: usize = 3;

/// Type of the hidden length that a Fortran compiler passes for each text, after all arguments.
macro_rules! length_type {
    ($length:ident) => {
        usize
    };
}

/// Defines subroutines: name, function type, parameters of a call, lengths of texts, and arguments as `name: kind =
/// value`.
macro_rules! subroutines {
    ($($(#[$doc:meta])* $name:ident: $function:ident($($parameter:ident: $type:ty),*) [$($length:ident),*] {
        $($argument:ident: $kind:ident = $value:expr,)*
    })*) => {
        /// Interfaces of all supported subroutines.
        const INTERFACES: &[SubroutineInterface] = &[$(SubroutineInterface {
            name: stringify!($name),
            arguments: &[$((stringify!($argument), ArgumentKind::$kind),)*],
        },)*];
        $(
            $(#[$doc])*
            pub type $function =
                unsafe extern "C-unwind" fn($(pointer::$kind,)* $(length_type!($length)),*);

            $(#[$doc])*
            ///
            /// # Safety
            /// The function has the type of the subroutine, and every array has the length given by the counts of the
            /// call.
            pub unsafe fn $name(function: $function, $($parameter: $type),*) {
                // SAFETY: guaranteed by the caller.
                unsafe { function($($value,)* $($length),*) }
            }
        )*
    };
}

fn int(count: usize) -> i32 {
    count as i32
}

// ABAQUS User Subroutines Reference: 1.2.1 "VDLOAD" (6.6), "VUAMP", "VDISP" (6.11), "VUMAT", "VUHARD", "VUSDFLD",
// "VEXTERNALDB" (6.14), "VUCHARLENGTH", "VUANISOHYPER_INV" (2016), "VUFIELD" (2024), "VFRICTION" (2017).
subroutines! {
    /// Subroutine VDLOAD, which returns the pressures of a load.
    vdload: Vdload(points: &LoadPoints<'_>, name: *const c_char, pressure: &mut [f64]) [NAME] {
        nblock: Integer = &int(points.r.len()),
        ndim: Integer = &2,
        stepTime: Real = &points.now.step_time,
        totalTime: Real = &points.now.total_time,
        amplitude: Real = &points.amplitude,
        curCoords: Real = points.coordinates.as_ptr(),
        velocity: Real = points.motion.as_ptr(),
        dirCos: Real = points.directions.as_ptr(),
        jltyp: Integer = &points.load_type,
        sname: Character = name,
        value: RealResult = pressure.as_mut_ptr(),
    }
    /// Subroutine VUAMP, which returns the value of an amplitude.
    vuamp: Vuamp(call: &mut AmplitudeCall<'_>, name: *const c_char, more: &mut AmplitudeArrays) [NAME, NAME] {
        ampName: Character = name,
        time: Real = [call.now.step_time, call.now.total_time].as_ptr(),
        ampValueOld: Real = &call.old,
        dt: Real = &call.increment,
        nprops: Integer = &int(call.properties.len()),
        props: Real = call.properties.as_ptr(),
        nSvars: Integer = &int(call.variables.len()),
        svars: RealResult = call.variables.as_mut_ptr(),
        lFlagsInfo: Integer = more.info.as_ptr(),
        nSensor: Integer = &int(call.sensor_names.len()),
        sensorValues: Real = call.sensor_values.as_ptr(),
        sensorNames: Character = more.sensors.as_ptr().cast(),
        jSensorLookUpTable: Integer = [0; 4].as_ptr(),
        ampValueNew: RealResult = &mut more.value,
        lFlagsDefine: IntegerResult = more.define.as_mut_ptr(),
        ampDerivative: RealResult = &mut more.derivative,
        ampSecDerivative: RealResult = &mut 0.0,
        ampIncIntegral: RealResult = &mut 0.0,
    }
    /// Subroutine VDISP, which returns the motion of a node.
    vdisp: Vdisp(call: &MotionCall<'_>, name: *const c_char, values: &mut [f64; DOFS]) [NAME] {
        nblock: Integer = &1,
        nDof: Integer = &int(DOFS),
        nCoord: Integer = &2,
        kstep: Integer = &(call.now.step as i32),
        kinc: Integer = &call.now.increment.try_into().unwrap_or(i32::MAX),
        stepTime: Real = &call.now.step_time,
        totalTime: Real = &call.now.total_time,
        dtNext: Real = &call.increments[1],
        dt: Real = &call.increments[0],
        cbname: Character = name,
        jBCType: Integer = &call.kind,
        jDof: Integer = prescribed(call).as_ptr(),
        jNodeUid: Integer = &call.node,
        amp: Real = &call.amplitude,
        coordNp: Real = call.coordinates.as_ptr(),
        u: Real = components(call, 0).as_ptr(),
        v: Real = components(call, 1).as_ptr(),
        a: Real = components(call, 2).as_ptr(),
        rf: Real = components(call, 3).as_ptr(),
        rmass: Real = &call.mass,
        rotaryI: Real = [0.0; 9].as_ptr(),
        rval: RealResult = values.as_mut_ptr(),
    }
    /// Subroutine VUMAT, which returns the stresses of a material. ABAQUS passes arrays where older subroutines declare
    /// one number: `jblock` begins with nblock, `jInfoArray` with lanneal, `dtArray` with dt ("Variables passed in for
    /// information").
    vumat: Vumat(call: &MaterialCall<'_>, name: *const c_char, numbers: &MaterialArrays, answer: &mut MaterialAnswer<'_>) [NAME] {
        jblock: Integer = numbers.block.as_ptr(),
        ndir: Integer = &3,
        nshr: Integer = &1,
        nstatev: Integer = &int(call.variables),
        nfieldv: Integer = &int(call.fields),
        nprops: Integer = &int(call.properties.len()),
        jInfoArray: Integer = numbers.info.as_ptr(),
        stepTime: Real = &call.now.step_time,
        totalTime: Real = &call.now.total_time,
        dtArray: Real = numbers.dt.as_ptr(),
        cmname: Character = name,
        coordMp: Real = call.coordinates.as_ptr(),
        charLength: Real = call.length.as_ptr(),
        props: Real = call.properties.as_ptr(),
        density: Real = call.density.as_ptr(),
        strainInc: Real = call.strain.as_ptr(),
        relSpinInc: Real = call.spin.as_ptr(),
        tempOld: Real = call.temperature[0].as_ptr(),
        stretchOld: Real = call.stretch[0].as_ptr(),
        defgradOld: Real = call.gradient[0].as_ptr(),
        fieldOld: Real = call.field[0].as_ptr(),
        stressOld: Real = call.stress.as_ptr(),
        stateOld: Real = call.state.as_ptr(),
        enerInternOld: Real = call.internal.as_ptr(),
        enerInelasOld: Real = call.inelastic.as_ptr(),
        tempNew: Real = call.temperature[1].as_ptr(),
        stretchNew: Real = call.stretch[1].as_ptr(),
        defgradNew: Real = call.gradient[1].as_ptr(),
        fieldNew: Real = call.field[1].as_ptr(),
        stressNew: RealResult = answer.stress.as_mut_ptr(),
        stateNew: RealResult = answer.state.as_mut_ptr(),
        enerInternNew: RealResult = answer.internal.as_mut_ptr(),
        enerInelasNew: RealResult = answer.inelastic.as_mut_ptr(),
    }
    /// Subroutine VUHARD, which returns yield stresses.
    vuhard: Vuhard(call: &HardeningCall<'_>, name: *const c_char, answer: &mut HardeningAnswer<'_>) [NAME] {
        nblock: Integer = &int(call.count),
        jElem: Integer = call.elements.as_ptr(),
        kIntPt: Integer = &int(call.integration_point),
        kLayer: Integer = &1,
        kSecPt: Integer = &1,
        lAnneal: Integer = &0,
        stepTime: Real = &call.now.step_time,
        totalTime: Real = &call.now.total_time,
        dt: Real = &call.dt,
        cmname: Character = name,
        nstatev: Integer = &int(call.variables),
        nfieldv: Integer = &int(call.fields),
        nprops: Integer = &int(call.properties.len()),
        props: Real = call.properties.as_ptr(),
        tempOld: Real = call.temperature[0].as_ptr(),
        tempNew: Real = call.temperature[1].as_ptr(),
        fieldOld: Real = call.field[0].as_ptr(),
        fieldNew: Real = call.field[1].as_ptr(),
        stateOld: Real = call.state.as_ptr(),
        eqps: Real = call.strain.as_ptr(),
        eqpsRate: Real = call.rate.as_ptr(),
        yield: RealResult = answer.stress.as_mut_ptr(),
        dyieldDtemp: RealResult = answer.by_temperature.as_mut_ptr(),
        dyieldDeqps: RealResult = answer.slopes.as_mut_ptr(),
        stateNew: RealResult = answer.state.as_mut_ptr(),
    }
    /// Subroutine VUANISOHYPER_INV, which returns derivatives of a strain energy.
    vuanisohyper_inv: VuanisohyperInv(call: &EnergyCall<'_>, name: *const c_char, answer: &mut EnergyAnswer<'_>) [NAME] {
        nblock: Integer = &int(call.count),
        nFiber: Integer = &int(call.families),
        nInv: Integer = &int(call.invariants.len() / call.count),
        jElem: Integer = call.elements.as_ptr(),
        kIntPt: Integer = &int(call.integration_point),
        kLayer: Integer = &1,
        kSecPt: Integer = &1,
        cmname: Character = name,
        nstatev: Integer = &int(call.variables),
        nfieldv: Integer = &int(call.fields),
        nprops: Integer = &int(call.properties.len()),
        props: Real = call.properties.as_ptr(),
        tempOld: Real = call.temperature[0].as_ptr(),
        tempNew: Real = call.temperature[1].as_ptr(),
        fieldOld: Real = call.field[0].as_ptr(),
        fieldNew: Real = call.field[1].as_ptr(),
        stateOld: Real = call.state.as_ptr(),
        sInvariant: Real = call.invariants.as_ptr(),
        zeta: Real = call.cosines.as_ptr(),
        uDev: RealResult = answer.deviatoric.as_mut_ptr(),
        duDi: RealResult = answer.first.as_mut_ptr(),
        d2uDiDi: RealResult = answer.second.as_mut_ptr(),
        stateNew: RealResult = answer.state.as_mut_ptr(),
    }
    /// Subroutine VUSDFLD, which returns field variables. `direct` and `T` are identities: the axes of the material are
    /// those of the model.
    vusdfld: Vusdfld(call: &FieldCall<'_>, name: *const c_char, axes: *const f64, answer: &mut FieldAnswer<'_>) [NAME] {
        nblock: Integer = &int(call.count),
        nstatev: Integer = &int(call.variables),
        nfieldv: Integer = &int(call.fields),
        nprops: Integer = &int(call.properties.len()),
        ndir: Integer = &3,
        nshr: Integer = &1,
        jElem: Integer = call.elements.as_ptr(),
        kIntPt: Integer = &int(call.integration_point),
        kLayer: Integer = &1,
        kSecPt: Integer = &1,
        stepTime: Real = &call.now.step_time,
        totalTime: Real = &call.now.total_time,
        dt: Real = &call.dt,
        cmname: Character = name,
        coordMp: Real = call.coordinates.as_ptr(),
        direct: Real = axes,
        T: Real = axes,
        charLength: Real = call.length.as_ptr(),
        props: Real = call.properties.as_ptr(),
        stateOld: Real = call.state.as_ptr(),
        stateNew: RealResult = answer.state.as_mut_ptr(),
        field: RealResult = answer.field.as_mut_ptr(),
    }
    /// Subroutine VUFIELD, which returns field variables at nodes. `JFLAGS` are the increment and the number of the call in it.
    vufield: Vufield(call: &NodalFieldCall<'_>, values: &mut [f64]) [] {
        field: RealResult = values.as_mut_ptr(),
        nblock: Integer = &int(call.nodes.len()),
        nfield: Integer = &int(call.variables[1]),
        kfield: Integer = &int(call.variables[0]),
        ncomp: Integer = &1,
        kstep: Integer = &(call.now.step as i32),
        jflags: Integer = [call.now.increment.try_into().unwrap_or(i32::MAX), 1].as_ptr(),
        jnodeuid: Integer = call.nodes.as_ptr(),
        time: Real = [call.now.step_time, call.lengths[0], call.lengths[1], call.now.total_time].as_ptr(),
        coords: Real = call.coordinates.as_ptr(),
        u: Real = call.motion[0].as_ptr(),
        v: Real = call.motion[1].as_ptr(),
        a: Real = call.motion[2].as_ptr(),
    }
    /// Subroutine VFRICTION, which returns friction forces. Vectors have three components, as in analyses in three dimensions.
    /// Each point faces one place of the opposite surface, which is no node; there are no temperatures and fields.
    vfriction: Vfriction(call: &FrictionCall<'_>, name: *const c_char, more: &FrictionArrays, forces: &mut [f64], state: &mut [f64]) [NAME, NAME, NAME] {
        fTangential: RealResult = forces.as_mut_ptr(),
        state: RealResult = state.as_mut_ptr(),
        nBlock: Integer = &int(call.nodes.len()),
        nBlockAnal: Integer = &int(call.nodes.len()),
        nBlockEdge: Integer = &1,
        nNodState: Integer = &1,
        nNodSlv: Integer = &1,
        nNodMst: Integer = &1,
        nFricDir: Integer = &2,
        nDir: Integer = &3,
        nStates: Integer = &int(call.variables),
        nProps: Integer = &int(call.properties.len()),
        nTemp: Integer = &0,
        nFields: Integer = &0,
        jFlags: Integer = [call.now.step as i32, call.now.increment.try_into().unwrap_or(i32::MAX), 1].as_ptr(),
        rData: Real = [call.now.step_time, call.now.total_time, call.dt, call.friction_work].as_ptr(),
        surfInt: Character = name,
        surfSlv: Character = more.blanks.as_ptr().cast(),
        surfMst: Character = more.blanks.as_ptr().cast(),
        jConSlvUid: Integer = call.nodes.as_ptr(),
        jConMstUid: Integer = more.no_nodes.as_ptr(),
        props: Real = call.properties.as_ptr(),
        dSlipFric: Real = call.slip.as_ptr(),
        fStickForce: Real = call.stick.as_ptr(),
        fTangPrev: Real = call.previous.as_ptr(),
        fNormal: Real = call.normal.as_ptr(),
        areaCont: Real = call.area.as_ptr(),
        dircosN: Real = call.directions[0].as_ptr(),
        dircosSl: Real = call.directions[1].as_ptr(),
        shapeSlv: Real = more.ones.as_ptr(),
        shapeMst: Real = more.ones.as_ptr(),
        coordSlv: Real = call.coordinates[0].as_ptr(),
        coordMst: Real = call.coordinates[1].as_ptr(),
        velSlv: Real = call.velocities[0].as_ptr(),
        velMst: Real = call.velocities[1].as_ptr(),
        tempSlv: Real = more.unknown.as_ptr(),
        tempMst: Real = more.unknown.as_ptr(),
        fieldSlv: Real = more.unknown.as_ptr(),
        fieldMst: Real = more.unknown.as_ptr(),
    }
    /// Subroutine VUCHARLENGTH, which returns characteristic lengths. `jElType` begins with the shape: 2 is a triangle,
    /// 3 a quadrilateral.
    vucharlength: Vucharlength(call: &LengthCall<'_>, name: *const c_char, axes: *const f64, lengths: &mut [f64]) [NAME] {
        nblock: Integer = &int(call.count),
        nfieldv: Integer = &int(call.fields),
        nprops: Integer = &int(call.properties.len()),
        ncomp: Integer = &1,
        ndim: Integer = &2,
        nnode: Integer = &int(call.corners),
        nstatev: Integer = &int(call.variables),
        kSecPt: Integer = &1,
        kLayer: Integer = &1,
        kIntPt: Integer = &int(call.integration_point),
        jElType: Integer = [if call.corners == 4 { 3 } else { 2 }, 0, 0].as_ptr(),
        jElem: Integer = call.elements.as_ptr(),
        totalTime: Real = &call.now.total_time,
        stepTime: Real = &call.now.step_time,
        dt: Real = &call.dt,
        cmname: Character = name,
        coordMp: Real = call.coordinates.as_ptr(),
        coordNode: Real = call.nodes.as_ptr(),
        direct: Real = axes,
        T: Real = axes,
        props: Real = call.properties.as_ptr(),
        field: Real = call.field.as_ptr(),
        stateOld: Real = call.state.as_ptr(),
        charLength: RealResult = lengths.as_mut_ptr(),
    }
    /// Subroutine VEXTERNALDB, called at events of the analysis. Both arrays are longer than the counts, for
    /// subroutines that read further.
    vexternaldb: Vexternaldb(operation: i32, integers: &mut [i32; 8], reals: &mut [f64; 4]) [] {
        lOp: Integer = &operation,
        i_Array: IntegerResult = integers.as_mut_ptr(),
        niArray: Integer = &6,
        r_Array: RealResult = reals.as_mut_ptr(),
        nrArray: Integer = &3,
    }
}

/// Returns `jDof` of VDISP: 1 for the prescribed degree of freedom, else 0.
fn prescribed(call: &MotionCall<'_>) -> [i32; DOFS] {
    std::array::from_fn(|dof| i32::from(dof + 1 == call.dof))
}

/// Returns displacement (0), velocity (1), acceleration (2) or reaction (3) of the node of a VDISP along r, along z and
/// about the hoop.
fn components(call: &MotionCall<'_>, i: usize) -> [f64; DOFS] {
    let (along, across) = (call.state[i], call.across[i]);
    if call.dof == 1 { [along, across, 0.0] } else { [across, along, 0.0] }
}

/// Further arguments and results of VUAMP.
pub struct AmplitudeArrays {
    /// Whether the analysis begins; whether the step has begun; number of the step.
    pub info: [i32; 3],
    /// Names of the sensors, [`NAME`] characters each.
    pub sensors: Vec<u8>,
    /// Value of the amplitude, set by the subroutine (`ampValueNew`).
    pub value: f64,
    /// Flags of the results that VUAMP sets, and of its requests.
    pub define: [i32; 8],
    /// Time derivative of the amplitude, set by the subroutine (`ampDerivative`).
    pub derivative: f64,
}

/// Arguments of VFRICTION with the same values in each call.
pub struct FrictionArrays {
    /// Names of surfaces, which are blank, as in general contact.
    blanks: [u8; 512],
    no_nodes: [i32; MAX_BLOCK],
    ones: [f64; MAX_BLOCK],
    /// NaN for temperatures and fields.
    unknown: [f64; MAX_BLOCK],
}

impl Default for FrictionArrays {
    fn default() -> Self {
        FrictionArrays {
            blanks: [b' '; 512],
            no_nodes: [0; MAX_BLOCK],
            ones: [1.0; MAX_BLOCK],
            unknown: [f64::NAN; MAX_BLOCK],
        }
    }
}

/// Integer and time arguments of VUMAT.
pub struct MaterialArrays {
    /// nblock, integration point, layer, section point, element numbers.
    block: [i32; 4 + MAX_MATERIAL_BLOCK],
    /// Anneal flag, integration point, layer, section point, flag that requests moduli, index of the first element
    /// number; then the element numbers.
    info: [i32; 6 + MAX_MATERIAL_BLOCK],
    /// Length of the increment, followed by space for moduli, which are not requested.
    dt: [f64; 1 + 2 * MAX_MATERIAL_BLOCK],
}

impl Default for MaterialArrays {
    fn default() -> Self {
        let (mut block, mut info) = ([0; 4 + MAX_MATERIAL_BLOCK], [0; 6 + MAX_MATERIAL_BLOCK]);
        block[1..4].fill(1);
        info[..6].copy_from_slice(&[0, 1, 1, 1, 0, 7]);
        MaterialArrays { block, info, dt: [0.0; 1 + 2 * MAX_MATERIAL_BLOCK] }
    }
}

impl MaterialArrays {
    /// Copies the number of points, the numbers of elements and integration points and the increment length of a call to
    /// the arrays.
    pub fn set(&mut self, call: &MaterialCall<'_>) {
        self.block[0] = int(call.count);
        (self.block[1], self.info[1]) = (int(call.integration_point), int(call.integration_point));
        self.block[4..4 + call.count].copy_from_slice(call.elements);
        self.info[6..6 + call.count].copy_from_slice(call.elements);
        self.dt[0] = call.dt;
    }
}
