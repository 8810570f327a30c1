//! Points of a surface as loads see them: position, normal and motion, and the pressures that they write.
//! Never here: what the points lie on, how the routine was made or loaded.

use super::Description;
use crate::kernel::lists::heap_bytes;
use crate::state::Instant;
use crate::state::archive::persist_struct;
use crate::state::halt::Halt;
use crate::state::magnitude::Clock;
use crate::user::{LoadFailure, LoadPoints, MAX_BLOCK, UserLoad};

/// The arrays of one call, for at most [`MAX_BLOCK`] points; what they hold is said at [`LoadPoints`].
#[derive(Clone, Debug)]
pub(super) struct SurfaceView {
    count: usize,
    /// r of all points, z of all points, and NaN.
    pub(super) coordinates: Vec<f64>,
    /// Slabs of velocity, displacement and acceleration.
    pub(super) motion: Vec<f64>,
    directions: Vec<f64>,
    normal_r: Vec<f64>,
    pub(super) normal_z: Vec<f64>,
    /// Room for a whole block, and one behind it: a routine that writes past its points is found out.
    pub(super) pressure: Vec<f64>,
}

/// A NaN that is noticed wherever it is used, even in a comparison: what lies behind two coordinates.
const SIGNALLING: u64 = 0x7ff4_0000_0000_0000;

impl SurfaceView {
    /// Arrays for so many points, without values, with room for `most`.
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
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Shows so many points from now on, of which nothing is known yet; what came in has no pressure.
    pub(super) fn resize(&mut self, count: usize) {
        let came = self.count.min(count)..count;
        let no_number = f64::from_bits(SIGNALLING);
        self.count = count;
        self.coordinates.fill(no_number);
        self.motion.fill(0.0);
        self.directions.fill(no_number);
        self.pressure[came].fill(0.0);
        self.pressure[count..].fill(f64::NAN);
    }

    /// Sets the outward normal of a point, and with it the directions: the normal as the routine is shown it, and that
    /// turned counter-clockwise, by which (n_r, n_z) becomes (-n_z, n_r).
    pub(super) fn set_normal(&mut self, point: usize, [r, z]: [f64; 2], inward: bool) {
        (self.normal_r[point], self.normal_z[point]) = (r, z);
        let sign = if inward { -1.0 } else { 1.0 };
        for (slab, value) in [sign * r, -sign * z, sign * z, sign * r].into_iter().enumerate() {
            self.directions[slab * self.count + point] = value;
        }
    }

    /// Sets place, velocity, displacement and acceleration of a point that deforms.
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

    /// Names and bytes of the arrays.
    pub(super) fn arrays(&self) -> [(&'static str, usize); 4] {
        let bytes = |list: &Vec<f64>| heap_bytes(list);
        let normals = bytes(&self.normal_r) + bytes(&self.normal_z);
        [
            ("curCoords", bytes(&self.coordinates)),
            ("velocity", bytes(&self.motion)),
            ("dirCos", bytes(&self.directions) + normals),
            ("value", bytes(&self.pressure)),
        ]
    }

    pub(super) fn forget(&mut self) {
        self.pressure[..self.count].fill(f64::NAN);
    }

    pub(super) fn pressure(&self) -> &[f64] {
        &self.pressure[..self.count]
    }

    /// Calls the routine; what it answers is still to be accepted.
    ///
    /// # Errors
    /// Its own.
    #[inline(always)]
    pub(super) fn call(
        &mut self,
        load: &Description,
        clock: &Clock<'_>,
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
        };
        let pressure = &mut self.pressure[..n];
        routine.pressure(&points, pressure)
    }

    /// Accepts the answer; `finite` says whether all pressures are, which the caller knows from what it makes of them.
    ///
    /// # Errors
    /// Where one is not, or where the routine wrote past its points.
    #[inline(always)]
    pub(super) fn accept(&mut self, finite: bool) -> Result<(), LoadFailure> {
        if finite && self.pressure[self.count].is_nan() && self.pressure[MAX_BLOCK].is_nan() {
            return Ok(());
        }
        Err(self.refusal())
    }

    #[cold]
    fn refusal(&mut self) -> LoadFailure {
        let n = self.count;
        let point = self.pressure().iter().position(|p| !p.is_finite());
        let Some(i) = point else {
            self.pressure[n..].fill(f64::NAN);
            return LoadFailure::new(format!("it wrote past the nblock = {n} points of its argument value"));
        };
        let value = self.pressure[i];
        let hint = if value.is_nan() {
            "; a point that is left out keeps NaN, and so does what is computed from a third coordinate or direction: \
             curCoords has two, r and z"
        } else {
            ""
        };
        LoadFailure { point, reason: format!("it gave the pressure {value}{hint}") }
    }

    /// A failure in words; `first` points of the load came in blocks before this one.
    pub(super) fn failure(&self, load: &Description, first: usize, now: &Instant, failure: &LoadFailure) -> Halt {
        let place = |i| (self.coordinates[i], self.coordinates[self.count + i]);
        let point = failure.point.filter(|&i| i < self.count).map_or(String::new(), |i| {
            let (r, z) = place(i);
            format!(" at point {} (r = {r}, z = {z})", first + i + 1)
        });
        failure.halt(&format!("the user load on `{}`{point}", load.name), now)
    }
}

// Motion, too, of which a routine that does not ask for all has only a part kept up. The number of points follows from the
// faces that have come to lie bare.
persist_struct!(SurfaceView {
    coordinates: fixed, motion: fixed, pressure: fixed
} derived {
    count, directions, normal_r, normal_z
});
