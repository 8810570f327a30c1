//! The subroutines of ABAQUS that a run calls: every argument once, with its kind and what it is given. The types of the
//! functions, the calls and the check of a source's prototypes follow from this list.
//! Never here: opening libraries, what becomes of an answer.
#![allow(unsafe_code)]

use std::ffi::c_char;

use super::{
    AmplitudeCall, FieldAnswer, FieldCall, HardeningAnswer, HardeningCall, LengthCall, LoadPoints, MAX_MATERIAL_BLOCK,
    MaterialAnswer, MaterialCall, MotionCall,
};

/// Kind of an argument, and whether the routine writes its answer there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `integer*4`.
    Integer,
    /// `real*8`.
    Real,
    /// `character*80`.
    Character,
    /// `integer*4` that the routine sets.
    IntegerResult,
    /// `real*8` that the routine sets.
    RealResult,
}

/// The pointer that is passed for an argument of each [`Kind`].
mod pointer {
    pub type Integer = *const i32;
    pub type Real = *const f64;
    pub type Character = *const super::c_char;
    pub type IntegerResult = *mut i32;
    pub type RealResult = *mut f64;
}

/// A subroutine and its arguments in order.
#[derive(Debug)]
pub struct Interface {
    /// Name in lower case.
    pub name: &'static str,
    /// Names as in the manual, and kinds.
    pub arguments: &'static [(&'static str, Kind)],
}

impl Interface {
    /// Names of the arguments of a kind.
    pub fn arguments_of(&self, kind: Kind) -> impl Iterator<Item = &'static str> {
        self.arguments.iter().filter(move |(_, of)| *of == kind).map(|(name, _)| *name)
    }
}

/// The interface of a subroutine that is called here.
pub fn interface(name: &str) -> Option<&'static Interface> {
    INTERFACES.iter().find(|interface| interface.name == name)
}

/// Length of a name in the subroutines' arguments.
pub const NAME: usize = 80;
/// Degrees of freedom of a node in an axisymmetric model: r, z, rotation.
pub const DOFS: usize = 3;

/// The type of the length that a Fortran compiler passes for each text, after all arguments.
macro_rules! length_type {
    ($length:ident) => {
        usize
    };
}

/// Of each subroutine: its name, the type of its function, what a call is made of, the lengths of its texts, and its
/// arguments as `name: kind = value`.
macro_rules! subroutines {
    ($($(#[$doc:meta])* $name:ident: $function:ident($($parameter:ident: $type:ty),*) [$($length:ident),*] {
        $($argument:ident: $kind:ident = $value:expr,)*
    })*) => {
        /// All subroutines that a run calls.
        const INTERFACES: &[Interface] = &[$(Interface {
            name: stringify!($name),
            arguments: &[$((stringify!($argument), Kind::$kind),)*],
        },)*];
        $(
            $(#[$doc])*
            pub type $function =
                unsafe extern "C-unwind" fn($(pointer::$kind,)* $(length_type!($length)),*);

            $(#[$doc])*
            ///
            /// # Safety
            /// The function has the type of that subroutine, and every list the length that the counts of the call say.
            pub unsafe fn $name(function: $function, $($parameter: $type),*) {
                // SAFETY: as this function's own.
                unsafe { function($($value,)* $($length),*) }
            }
        )*
    };
}

fn int(count: usize) -> i32 {
    count as i32
}

// ABAQUS User Subroutines Reference: 1.2.1 "VDLOAD" (6.6), "VUAMP", "VDISP" (6.11), "VUMAT", "VUHARD", "VUSDFLD",
// "VEXTERNALDB" (6.14), "VUCHARLENGTH" (2016).
subroutines! {
    /// Pressures of a load.
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
    /// Value of an amplitude.
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
    /// Motion of a node.
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
    /// Stresses of a material. ABAQUS passes arrays where older routines declare one number: `jblock` begins with nblock,
    /// `jInfoArray` with lanneal, `dtArray` with dt ("Variables passed in for information").
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
    /// Yield stresses.
    vuhard: Vuhard(call: &HardeningCall<'_>, name: *const c_char, answer: &mut HardeningAnswer<'_>) [NAME] {
        nblock: Integer = &int(call.count),
        jElem: Integer = call.elements.as_ptr(),
        kIntPt: Integer = &1,
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
    /// Field variables. `direct` and `T` are identities: the axes of the material are those of the model.
    vusdfld: Vusdfld(call: &FieldCall<'_>, name: *const c_char, axes: *const f64, answer: &mut FieldAnswer<'_>) [NAME] {
        nblock: Integer = &int(call.count),
        nstatev: Integer = &int(call.variables),
        nfieldv: Integer = &int(call.fields),
        nprops: Integer = &int(call.properties.len()),
        ndir: Integer = &3,
        nshr: Integer = &1,
        jElem: Integer = call.elements.as_ptr(),
        kIntPt: Integer = &1,
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
    /// Characteristic lengths. `jElType` begins with the shape: 2 is a triangle, 3 a quadrilateral.
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
        kIntPt: Integer = &1,
        jElType: Integer = [int(call.corners) - 1, 0, 0].as_ptr(),
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
    /// Moments of the analysis. Both arrays are longer than the counts say, for a routine that reads further.
    vexternaldb: Vexternaldb(operation: i32, integers: &mut [i32; 8], reals: &mut [f64; 4]) [] {
        lOp: Integer = &operation,
        i_Array: IntegerResult = integers.as_mut_ptr(),
        niArray: Integer = &6,
        r_Array: RealResult = reals.as_mut_ptr(),
        nrArray: Integer = &3,
    }
}

/// `jDof` of VDISP: above zero for what the call prescribes.
fn prescribed(call: &MotionCall<'_>) -> [i32; DOFS] {
    std::array::from_fn(|dof| i32::from(dof + 1 == call.dof))
}

/// Displacement (0), velocity, acceleration or reaction (3) of the node of a VDISP along r and z, and about the hoop.
fn components(call: &MotionCall<'_>, i: usize) -> [f64; DOFS] {
    let (along, across) = (call.state[i], call.across[i]);
    if call.dof == 1 { [along, across, 0.0] } else { [across, along, 0.0] }
}

/// What VUAMP reads beside its call, and what it answers.
pub struct AmplitudeArrays {
    /// Whether the analysis begins, whether the step is under way, number of the step.
    pub info: [i32; 3],
    /// Names of the sensors, each of [`NAME`] letters.
    pub sensors: Vec<u8>,
    /// `ampValueNew`.
    pub value: f64,
    /// Which of its answers VUAMP gives, and what it asks for.
    pub define: [i32; 8],
    /// `ampDerivative`.
    pub derivative: f64,
}

/// What a VUMAT is told in integers and times of a block.
pub struct MaterialArrays {
    /// nblock, integration point, layer, section point, user's numbers of the elements.
    block: [i32; 4 + MAX_MATERIAL_BLOCK],
    /// Anneal flag, integration point, layer, section point, whether moduli are asked for, where the numbers of the elements
    /// begin; then these numbers.
    info: [i32; 6 + MAX_MATERIAL_BLOCK],
    /// Length of the increment; room for moduli that nobody asks for.
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
    /// Takes the numbers of a call.
    pub fn set(&mut self, call: &MaterialCall<'_>) {
        self.block[0] = int(call.count);
        self.block[4..4 + call.count].copy_from_slice(call.elements);
        self.info[6..6 + call.count].copy_from_slice(call.elements);
        self.dt[0] = call.dt;
    }
}
