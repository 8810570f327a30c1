//! A prescribed pressure on facets (`P`).
//! Never here: pressures that depend on motion.

use crate::load::Account;
use crate::load::FacetFields;
use crate::load::Force;
use crate::load::Slot;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist};
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::state::{BodyState, Instant};

/// A pressure on facets of bodies; positive pushes against the outward normal. On a body that only shifts along z the
/// facets enter by the sum of their axial areas alone.
#[derive(Debug)]
pub struct Pressure {
    /// What asked for it.
    pub cause: EffectId,
    /// `(body, sum of area times n_z)`.
    pub axial_areas: Vec<(usize, f64)>,
    /// `(element, body, n_z)` of each facet, for frames.
    pub facets: Vec<(usize, usize, f64)>,
    /// Pressure.
    pub magnitude: Magnitude,
    /// Pressure at the last evaluation, for frames.
    pub current: f64,
}

impl Force for Pressure {
    fn cause(&self) -> EffectId {
        self.cause
    }

    fn slots(&self) -> Vec<Slot> {
        self.axial_areas.iter().map(|&(body, _)| Slot { body, account: Account::Work }).collect()
    }

    fn evaluate(&mut self, now: &Instant, _bodies: &[BodyState], out: &mut [f64]) -> Result<(), Halt> {
        self.current = self.magnitude.at(now);
        for (force, (_, area)) in out.iter_mut().zip(&self.axial_areas) {
            *force = -self.current * area;
        }
        Ok(())
    }

    fn limit(&self, now: &Instant, _bodies: &[BodyState]) -> Limit {
        self.magnitude.limit(now)
    }

    fn facet_fields(&self, bodies: &[BodyState]) -> Option<FacetFields> {
        Some(FacetFields {
            elements: self.facets.iter().map(|f| f.0).collect(),
            pressure: vec![self.current; self.facets.len()],
            normal_velocity: self.facets.iter().map(|f| bodies[f.1].velocity * f.2).collect(),
            layer: vec![0.0; self.facets.len()],
        })
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        vec![("facets", size_of_val(&self.facets[..]))]
    }
}

impl Persist for Pressure {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Pressure { cause: _, axial_areas: _, facets: _, magnitude: _, current } = self;
        current.persist(archive);
    }
}
