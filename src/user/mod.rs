//! User loads: the trait a Rust plug-in implements, with the arguments of VDLOAD.
//! Never here: solver internals.

use std::cell::RefCell;
use std::rc::Rc;

/// What a user load is told, for one surface and a block of points: VDLOAD's arguments, structure of arrays
/// (ABAQUS User Subroutines Reference, VDLOAD). Slices have one entry a point unless said otherwise.
#[derive(Debug)]
pub struct LoadPoints<'a> {
    /// Surface or element-set name (`sname`), as the deck has it.
    pub surface: &'a str,
    /// Time since the start of the step.
    pub step_time: f64,
    /// Total time.
    pub total_time: f64,
    /// Current value of the amplitude the load refers to (1 without one); the routine applies it.
    pub amplitude: f64,
    /// Magnitude on the data line.
    pub magnitude: f64,
    /// Current r of each point, length.
    pub r: &'a [f64],
    /// Current z of each point, length.
    pub z: &'a [f64],
    /// Velocity of each point, r component.
    pub velocity_r: &'a [f64],
    /// Velocity of each point, z component.
    pub velocity_z: &'a [f64],
    /// Outward unit normal of each point, r component.
    pub normal_r: &'a [f64],
    /// Outward unit normal of each point, z component.
    pub normal_z: &'a [f64],
}

/// Why a user load gave up.
#[derive(Clone, Debug)]
pub struct LoadFailure {
    /// Index of the point in the block, where one is to blame.
    pub point: Option<usize>,
    /// In words.
    pub reason: String,
}

/// A load routine of the user: gives the pressure at each point. May keep state; is called once an increment and surface.
pub trait UserLoad {
    /// Fills `pressure` (one entry a point, positive pushes against the outward normal; NaN on entry).
    ///
    /// # Errors
    /// Any reason; the run halts with the last good state written.
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure>;
}

/// One routine shared by all the surfaces of a job, as one VDLOAD serves a whole ABAQUS job: its state is common to
/// them. A job runs its loads one after the other, so sharing needs no lock.
#[derive(Clone)]
pub struct SharedLoad(Rc<RefCell<dyn UserLoad>>);

impl SharedLoad {
    /// Shares a routine.
    pub fn new(routine: impl UserLoad + 'static) -> Self {
        SharedLoad(Rc::new(RefCell::new(routine)))
    }

    /// Calls the routine.
    ///
    /// # Errors
    /// Those of the routine.
    pub fn call(&self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        self.0.borrow_mut().pressure(points, pressure)
    }
}
