//! A pressure given by the user's routine (`PNU`).
//! Never here: how the routine was made or loaded.

use super::{Account, Cause, FacetFields, Force, Halt, Limit, Magnitude, Slot};
use crate::kernel::facet::Facet;
use crate::state::{BodyState, Instant};
use crate::user::{LoadFailure, LoadPoints, SharedLoad};

/// Facets of one body with the arrays a routine is shown.
pub struct UserPressure {
    cause: Cause,
    name: String,
    body: usize,
    magnitude: Magnitude,
    routine: SharedLoad,
    elements: Vec<usize>,
    area_z: Vec<f64>,
    r: Vec<f64>,
    z_start: Vec<f64>,
    z: Vec<f64>,
    velocity_r: Vec<f64>,
    velocity_z: Vec<f64>,
    normal_r: Vec<f64>,
    normal_z: Vec<f64>,
    pressure: Vec<f64>,
    /// Pressure of the evaluation before: what frames show if the routine fails now.
    pressure_before: Vec<f64>,
}

impl UserPressure {
    /// The load of a named surface on the facets (with element index) of one body.
    pub fn new(
        cause: Cause,
        name: String,
        body: usize,
        magnitude: Magnitude,
        routine: SharedLoad,
        facets: &[(usize, Facet)],
    ) -> Self {
        let column = |f: &dyn Fn(&Facet) -> f64| facets.iter().map(|(_, facet)| f(facet)).collect::<Vec<f64>>();
        let zeros = || vec![0.0; facets.len()];
        UserPressure {
            cause,
            name,
            body,
            magnitude,
            routine,
            elements: facets.iter().map(|f| f.0).collect(),
            area_z: column(&|f| f.area * f.normal[1]),
            r: column(&|f| f.middle()[0]),
            z_start: column(&|f| f.middle()[1]),
            z: zeros(),
            velocity_r: zeros(),
            velocity_z: zeros(),
            normal_r: column(&|f| f.normal[0]),
            normal_z: column(&|f| f.normal[1]),
            pressure: zeros(),
            pressure_before: zeros(),
        }
    }

    fn failure(&self, now: &Instant, failure: &LoadFailure) -> Halt {
        let point = failure
            .point
            .filter(|&i| i < self.r.len())
            .map_or(String::new(), |i| format!(" at point {} (r = {}, z = {})", i + 1, self.r[i], self.z[i]));
        Halt {
            code: "R201",
            reason: format!(
                "the user load on `{}` failed{point}, time {:e}: {}",
                self.name, now.total_time, failure.reason
            ),
        }
    }

    fn non_finite(&self, now: &Instant) -> Halt {
        let point = self.pressure.iter().position(|p| !p.is_finite());
        let value = point.map_or(f64::NAN, |i| self.pressure[i]);
        self.failure(
            now,
            &LoadFailure {
                point,
                reason: format!("it gave the pressure {value}; a point it leaves out keeps NaN, so set every one"),
            },
        )
    }
}

impl Force for UserPressure {
    fn cause(&self) -> Cause {
        self.cause
    }

    fn slots(&self) -> Vec<Slot> {
        vec![Slot { body: self.body, account: Account::Work }]
    }

    fn evaluate(&mut self, now: &Instant, bodies: &[BodyState], out: &mut [f64]) -> Result<(), Halt> {
        let shift = bodies[self.body].displacement;
        let velocity = bodies[self.body].velocity_load;
        std::mem::swap(&mut self.pressure, &mut self.pressure_before);
        // One pass over three arrays: for a few facets the passes would cost more than what they write.
        let arrays = self.z.iter_mut().zip(&mut self.velocity_z).zip(&mut self.pressure);
        for (((z, v), pressure), start) in arrays.zip(&self.z_start) {
            *z = start + shift;
            *v = velocity;
            *pressure = f64::NAN;
        }
        let points = LoadPoints {
            surface: &self.name,
            step_time: now.step_time,
            total_time: now.total_time,
            amplitude: self.magnitude.amplitude(now),
            magnitude: self.magnitude.value,
            r: &self.r,
            z: &self.z,
            velocity_r: &self.velocity_r,
            velocity_z: &self.velocity_z,
            normal_r: &self.normal_r,
            normal_z: &self.normal_z,
        };
        let called = self.routine.call(&points, &mut self.pressure);
        out[0] = -dot(&self.pressure, &self.area_z);
        let halt = match called {
            Err(failure) => self.failure(now, &failure),
            Ok(()) if out[0].is_finite() => return Ok(()),
            Ok(()) => self.non_finite(now),
        };
        std::mem::swap(&mut self.pressure, &mut self.pressure_before);
        Err(halt)
    }

    fn limit(&self, now: &Instant, _bodies: &[BodyState]) -> Limit {
        self.magnitude.limit(now)
    }

    fn reads_velocity(&self) -> bool {
        true
    }

    fn facet_fields(&self, bodies: &[BodyState]) -> Option<FacetFields> {
        let velocity = bodies[self.body].velocity;
        Some(FacetFields {
            elements: self.elements.clone(),
            pressure: self.pressure.clone(),
            normal_velocity: self.normal_z.iter().map(|n| n * velocity).collect(),
            layer: vec![0.0; self.elements.len()],
        })
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let bytes = size_of_val(&self.r[..]);
        vec![("points", 7 * bytes), ("velocities", 2 * bytes), ("pressure", 2 * bytes)]
    }
}

/// Sum of products in eight interleaved partial sums: the same bits on every instruction set, and no chain of additions.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_tiles, a_rest) = a.as_chunks::<8>();
    let (b_tiles, b_rest) = b.as_chunks::<8>();
    for (x, y) in a_tiles.iter().zip(b_tiles) {
        for lane in 0..8 {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    for (lane, (x, y)) in a_rest.iter().zip(b_rest).enumerate() {
        lanes[lane] += x * y;
    }
    ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]))
}
