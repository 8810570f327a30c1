//! The state: arrays of what moves, only what the plan declared.
//! Never here: anything no effect asked for.

/// Where the clock stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instant {
    /// Time since the start of the step.
    pub step_time: f64,
    /// Time since the start of the analysis.
    pub total_time: f64,
}

/// Rigid bodies as structure of arrays: an axisymmetric body moves along z only.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// Mass.
    pub mass: Vec<f64>,
    /// Displacement at the increment's own time.
    pub displacement: Vec<f64>,
    /// Velocity at the increment's own time.
    pub velocity: Vec<f64>,
    /// Velocity at the middle of the increment behind.
    pub velocity_half: Vec<f64>,
    /// Acceleration at the increment's own time.
    pub acceleration: Vec<f64>,
    /// The velocity that loads are shown.
    pub velocity_load: Vec<f64>,
    /// Sign of the motion a resistance opposes: of the velocity, or at rest of the force that would start it; 0 if none.
    pub direction: Vec<f64>,
}

impl Bodies {
    /// Adds a body and returns its index.
    pub fn add(&mut self, mass: f64) -> usize {
        self.mass.push(mass);
        for array in [
            &mut self.displacement,
            &mut self.velocity,
            &mut self.velocity_half,
            &mut self.acceleration,
            &mut self.velocity_load,
            &mut self.direction,
        ] {
            array.push(0.0);
        }
        self.mass.len() - 1
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.mass.len()
    }
}
