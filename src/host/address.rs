//! User loads given by the address of a C function in this process, for example from a just-in-time compiler.
#![allow(unsafe_code)]

use super::{LoadFailure, LoadPoints, UserLoad};

/// `void load(int64_t n, double time, const double *coordinates, const double *velocities, const double *normals,
/// double *pressures)`. Coordinates, velocities and normals hold r of all points, then z of all points.
type CLoadFunction = unsafe extern "C-unwind" fn(i64, f64, *const f64, *const f64, *const f64, *mut f64);

struct AddressLoad {
    call: CLoadFunction,
    normals: Vec<f64>,
}

impl UserLoad for AddressLoad {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        let count = points.r.len();
        self.normals.clear();
        self.normals.extend_from_slice(points.normal_r);
        self.normals.extend_from_slice(points.normal_z);
        // SAFETY: the arrays hold two values per point, the pressures one, as the function expects.
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

    fn reads_magnitude(&self) -> bool {
        false
    }
}

/// Returns a user load that is a C function in this process: `void load(int64_t n, double time, const double
/// *coordinates, const double *velocities, const double *normals, double *pressures)`. `time` is the total time;
/// coordinates, velocities and outward normals hold r of all points, then z of all points. The function is trusted like
/// an opened library: the address must be that of such a function, and must stay valid. Returns `None` for the address
/// 0.
pub fn load_at(address: usize) -> Option<impl UserLoad> {
    // SAFETY: an address has the size of a pointer; the caller guarantees that it is a function of this type.
    let call = unsafe { std::mem::transmute::<usize, Option<CLoadFunction>>(address) }?;
    Some(AddressLoad { call, normals: Vec::new() })
}
