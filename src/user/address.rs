//! A load by the address of a function in this process, such as a just-in-time compiler gives.
//! Never here: opening the user's files.
#![allow(unsafe_code)]

use super::{LoadFailure, LoadPoints, Routines, UserLoad};

/// `void load(int64_t n, double time, const double *coordinates, const double *velocities, const double *normals,
/// double *pressures)`. Of coordinates, velocities and normals come the r of all points, then the z of all points.
type Function = unsafe extern "C-unwind" fn(i64, f64, *const f64, *const f64, *const f64, *mut f64);

struct LoadAt {
    call: Function,
    normals: Vec<f64>,
}

impl UserLoad for LoadAt {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        let count = points.r.len();
        self.normals.clear();
        self.normals.extend_from_slice(points.normal_r);
        self.normals.extend_from_slice(points.normal_z);
        // SAFETY: each array has two numbers a point, and the pressures one, as the function expects.
        unsafe {
            (self.call)(
                count as i64,
                points.now.total_time,
                points.coordinates.as_ptr(),
                points.motion.as_ptr(),
                self.normals.as_ptr(),
                pressure.as_mut_ptr(),
            );
        }
        Ok(())
    }
}

impl Routines {
    /// With a load that is a C function in this process: `void load(int64_t n, double time, const double *coordinates, const double
    /// *velocities, const double *normals, double *pressures)`, where `time` is the total time, and of coordinates, velocities and
    /// outward normals come the r of all points, then the z of all points. Like a library that is opened it is trusted: the
    /// address must be that of such a function, which stays where it is. `None` for the address 0.
    pub fn with_load_at(self, address: usize) -> Option<Routines> {
        // SAFETY: an address as large as a pointer; that it is one of a function is the caller's word.
        let call = unsafe { std::mem::transmute::<usize, Option<Function>>(address) }?;
        Some(self.with_load(LoadAt { call, normals: Vec::new() }))
    }
}
