//! Arguments of a user load: position, normal and motion of the points, and the pressures that the subroutine writes.

use std::cell::Cell;

use super::UserLoadData;
use crate::kernel::lists::heap_bytes;
use crate::routines::{LoadFailure, LoadPoints, MAX_BLOCK, UserLoad};
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::state::halt::HaltReason;
use crate::state::magnitude::AmplitudeClock;

/// Arrays of one call, for at most [`MAX_BLOCK`] points; [`LoadPoints`] describes their layout.
#[derive(Clone, Debug, Persist)]
// Motion is saved, because for some subroutines only the velocities are updated. The number of points follows from the
// exposed faces.
#[persist(fixed: coordinates, motion, pressure, memory; derived: count, per_point, directions, normal_r, normal_z)]
pub(super) struct SurfaceView {
    count: usize,
    /// r of all points, z of all points, then NaN.
    pub(super) coordinates: Vec<f64>,
    /// Velocity, displacement and acceleration: r, then z of all points.
    pub(super) motion: Vec<f64>,
    directions: Vec<f64>,
    normal_r: Vec<f64>,
    pub(super) normal_z: Vec<f64>,
    /// Pressures, with capacity for a whole block and one more entry, which detects a subroutine that writes past its
    /// points.
    pub(super) pressure: Vec<f64>,
    /// Numbers that the load keeps, point by point, and their count per point.
    memory: Vec<f64>,
    per_point: usize,
}

/// Signalling NaN for a third coordinate or direction: its use, even in a comparison, raises a floating-point
/// exception.
const SIGNALLING: u64 = 0x7ff4_0000_0000_0000;

impl SurfaceView {
    /// Creates arrays for `count` points with capacity for `most`.
    pub(super) fn new(count: usize, most: usize) -> Self {
        let slabs = |slabs: usize, value: f64| vec![value; slabs * most];
        let no_number = f64::from_bits(SIGNALLING);
        SurfaceView {
            count,
            coordinates: slabs(3, no_number),
            motion: slabs(6, 0.0),
            directions: slabs(9, no_number),
            normal_r: slabs(1, 0.0),
            normal_z: slabs(1, 0.0),
            pressure: vec![f64::NAN; MAX_BLOCK + 1],
            memory: Vec::new(),
            per_point: 0,
        }
    }

    /// Allocates the memory of the load.
    pub(super) fn reserve_memory(&mut self, per_point: usize) {
        self.memory = vec![0.0; per_point * self.normal_r.len()];
        self.per_point = per_point;
    }

    /// Copies the memory of a point from a point of the load that this one replaces.
    pub(super) fn continue_memory(&mut self, point: usize, previous: &SurfaceView, previous_point: usize) {
        let numbers = |point: usize, view: &SurfaceView| point * view.per_point..(point + 1) * view.per_point;
        if self.per_point == previous.per_point {
            let numbers_here = numbers(point, self);
            self.memory[numbers_here].copy_from_slice(&previous.memory[numbers(previous_point, previous)]);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Changes the number of points. All values are cleared; new points have no pressure.
    pub(super) fn resize(&mut self, count: usize) {
        let added = self.count.min(count)..count;
        let no_number = f64::from_bits(SIGNALLING);
        self.count = count;
        self.coordinates.fill(no_number);
        self.motion.fill(0.0);
        self.directions.fill(no_number);
        self.pressure[added].fill(0.0);
        self.pressure[count..].fill(f64::NAN);
    }

    /// Sets the outward normal of a point, and its directions: the normal passed to the subroutine (reversed if
    /// `inward`), and the tangent, which is the normal turned counter-clockwise, (n_r, n_z) to (-n_z, n_r).
    pub(super) fn set_normal(&mut self, point: usize, [r, z]: [f64; 2], inward: bool) {
        (self.normal_r[point], self.normal_z[point]) = (r, z);
        let sign = if inward { -1.0 } else { 1.0 };
        for (slab, value) in [sign * r, -sign * z, sign * z, sign * r].into_iter().enumerate() {
            self.directions[slab * self.count + point] = value;
        }
    }

    /// Sets position, velocity, displacement and acceleration of a point of a deformable body.
    pub(super) fn set_point(
        &mut self,
        i: usize,
        place: [f64; 2],
        start: [f64; 2],
        velocity: [f64; 2],
        acceleration: [f64; 2],
    ) {
        let n = self.count;
        for axis in 0..2 {
            self.coordinates[axis * n + i] = place[axis];
            self.motion[axis * n + i] = velocity[axis];
            self.motion[(2 + axis) * n + i] = place[axis] - start[axis];
            self.motion[(4 + axis) * n + i] = acceleration[axis];
        }
    }

    /// Returns the names and sizes (bytes) of the arrays of a call.
    pub(super) fn arrays(&self) -> Vec<(&'static str, usize)> {
        let bytes = |list: &Vec<f64>| heap_bytes(list);
        let normals = bytes(&self.normal_r) + bytes(&self.normal_z);
        let mut arrays = vec![
            ("curCoords", bytes(&self.coordinates)),
            ("velocity", bytes(&self.motion)),
            ("dirCos", bytes(&self.directions) + normals),
            ("value", bytes(&self.pressure)),
        ];
        arrays.extend((self.per_point > 0).then(|| ("memory", bytes(&self.memory))));
        arrays
    }

    pub(super) fn clear_pressure(&mut self) {
        self.pressure[..self.count].fill(f64::NAN);
    }

    pub(super) fn pressure(&self) -> &[f64] {
        &self.pressure[..self.count]
    }

    /// Calls the subroutine; its pressures must then be checked with [`SurfaceView::accept`].
    ///
    /// # Errors
    /// The errors of the subroutine.
    #[inline(always)]
    pub(super) fn call(
        &mut self,
        load: &UserLoadData,
        clock: &AmplitudeClock<'_>,
        routine: &mut dyn UserLoad,
    ) -> Result<(), LoadFailure> {
        let n = self.count;
        let points = LoadPoints {
            surface: &load.name,
            load_type: load.load_type,
            now: clock.now,
            amplitude: load.magnitude.amplitude(clock),
            magnitude: load.magnitude.value,
            r: &self.coordinates[..n],
            z: &self.coordinates[n..2 * n],
            velocity_r: &self.motion[..n],
            velocity_z: &self.motion[n..2 * n],
            normal_r: &self.normal_r[..n],
            normal_z: &self.normal_z[..n],
            coordinates: &self.coordinates[..3 * n],
            motion: &self.motion[..6 * n],
            directions: &self.directions[..9 * n],
            memory: Cell::from_mut(&mut self.memory[..self.per_point * n]).as_slice_of_cells(),
        };
        let pressure = &mut self.pressure[..n];
        routine.pressure(&points, pressure)
    }

    /// Checks the pressures. `finite` states whether all are finite, which the caller knows from their sum.
    ///
    /// # Errors
    /// If a pressure is not finite, or if the subroutine wrote past its points.
    #[inline(always)]
    pub(super) fn accept(&mut self, finite: bool) -> Result<(), LoadFailure> {
        if finite && self.pressure[self.count].is_nan() && self.pressure[MAX_BLOCK].is_nan() {
            return Ok(());
        }
        Err(self.invalid_answer())
    }

    #[cold]
    fn invalid_answer(&mut self) -> LoadFailure {
        let n = self.count;
        let point = self.pressure().iter().position(|p| !p.is_finite());
        let Some(i) = point else {
            self.pressure[n..].fill(f64::NAN);
            return LoadFailure::new(format!("it wrote past the nblock = {n} points of its argument value"));
        };
        let value = self.pressure[i];
        let hint = if value.is_nan() {
            "; the value of a point that was left out is NaN, and so are values computed from a third coordinate or \
             direction: curCoords has two coordinates, r and z"
        } else {
            ""
        };
        LoadFailure { point, reason: format!("it returned the pressure {value}{hint}") }
    }

    /// Returns the halt for a failure. `first` is the number of points in previous blocks.
    pub(super) fn failure(
        &self,
        load: &UserLoadData,
        first: usize,
        now: &Instant,
        failure: &LoadFailure,
    ) -> HaltReason {
        let coordinates = |i: usize| [self.coordinates[i], self.coordinates[self.count + i]];
        let index = failure.point.filter(|&i| i < self.count);
        let point = index.map_or(String::new(), |i| {
            let [r, z] = coordinates(i);
            format!(" at point {} (r = {r}, z = {z})", first + i + 1)
        });
        let mut halt = failure.halt(&format!("the user load on `{}`{point}", load.name), now);
        halt.details_mut().place = index.map(coordinates);
        halt
    }
}
