//! Laws with elastic moduli and a yield surface that depends on more than the von Mises stress: soil, rock, concrete, ceramics,
//! porous metals, sheet. Each law is one file, evaluated point by point ([`law::StressReturn`]); this file is the material
//! for all laws.
#![allow(clippy::needless_range_loop)] // Loops over lanes, with one array per quantity.

pub mod cap;
pub mod compression;
pub mod concrete;
pub mod concrete_lanes;
pub mod concrete_return;
pub mod concrete_tables;
#[cfg(test)]
mod concrete_tests;
pub mod drucker_prager;
pub mod eos_solid;
pub mod hill;
pub mod holmquist_johnson_cook;
pub mod johnson_holmquist;
mod lane_law;
pub mod lane_roots;
pub mod law;
pub mod path;
pub mod points;
pub mod porous_lanes;
pub mod porous_metal;
pub mod porous_return;
pub mod root;
pub mod spall;

use super::carried::CarriedState;
use super::increment::{StrainIncrement, StressUpdate};
use super::{BlockStart, Material, PlasticFlow, PointValue};
use crate::kernel::lanes::{LANES, Lanes, column, inline_from_fn, put_column};
use crate::state::archive::Persist;
use crate::variables::{Variable, VariableComponent};
use lane_law::LaneLaw;
use lane_roots::any;
use law::{ReturnPoint, StressReturn};
use points::ReturnedPoints;

/// Material of a law that returns an elastic trial stress.
pub struct ReturnMaterial {
    /// Law of a point.
    pub law: Box<dyn StressReturn>,
    /// Whether elements stay that the law would delete (`ELEMENT DELETION=NO`).
    pub keeps_elements: bool,
}

/// State of a block of points.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: states; derived: length, volume)]
pub struct ReturnState {
    /// States of the law, one list each.
    states: Vec<Lanes>,
    /// Angle in the (r, z) plane by which the material has rotated, radians.
    angle: Lanes,
    /// 1 for an active element, 0 for a deleted one.
    active: Lanes,
    /// Characteristic lengths.
    length: Lanes,
    /// Initial volumes.
    volume: Lanes,
}

impl Material for ReturnMaterial {
    type State = ReturnState;
    const FLOW: PlasticFlow = PlasticFlow::Coupled;
    const MODULI_VARY: bool = true;
    const FAILS: bool = true;
    const USES_SPIN: bool = true;

    fn initial_state(&self, start: &BlockStart) -> ReturnState {
        let states = self.law.initial_state().into_iter().map(|value| [value; LANES]).collect();
        let length = inline_from_fn(|l| characteristic_length(start.area[l], start.corners[l]));
        ReturnState { states, angle: [0.0; LANES], active: [1.0; LANES], length, volume: start.volume }
    }

    fn holds_pressure(&self) -> bool {
        self.law.holds_pressure()
    }

    /// Updates each point of a block; an increment of zero length changes nothing. Equation (20.2).
    #[inline(always)] // Compiled for the instruction set of the machine.
    fn update(
        &self,
        state: &mut ReturnState,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        let moduli = self.law.moduli();
        (update.bulk, update.shear) = ([moduli.bulk; LANES], [moduli.shear; LANES]);
        if strain.dt == 0.0 {
            return;
        }
        let mut points = ReturnedPoints::zero();
        points.begin(moduli, strain, &state.active);
        self.return_points(state, strain, &mut points);
        update.deleted += points.finish(stress, strain, update, self.law.holds_pressure());
    }

    fn share(&self, state: &ReturnState, lane: usize) -> f64 {
        state.active[lane]
    }

    fn can_delete(&self) -> bool {
        self.law.deletes() && !self.keeps_elements
    }

    fn initial_volume(&self, state: &ReturnState, lane: usize) -> f64 {
        state.volume[lane]
    }

    fn value(&self, state: &ReturnState, lane: usize, part: VariableComponent) -> Option<f64> {
        if part.variable == Variable::Status {
            return self.can_delete().then(|| state.active[lane]);
        }
        self.law.output(part).map(|index| state.states[index][lane])
    }

    fn set(&self, state: &mut ReturnState, lane: usize, value: PointValue) -> bool {
        let PointValue::PlasticStrain(strain) = value else { return false };
        let Some(index) = self.law.hardening_state() else { return false };
        state.states[index][lane] = strain;
        true
    }

    fn bytes(&self, state: &ReturnState) -> usize {
        size_of_val(&*state.states)
    }
}

/// Returns the length of a line across an element in the (r, z) plane, from its area and its corners (their r, their z): the
/// width of a band of cracked elements. It is the side of the square, and of the square of two triangles, with the area
/// (Rots 1988, "Computational modeling of concrete fracture", thesis, TU Delft). Triangles repeat their last corner.
pub fn characteristic_length(area: f64, corners: [[f64; 4]; 2]) -> f64 {
    let is_triangle = corners.iter().all(|coordinate| coordinate[2] == coordinate[3]);
    if is_triangle { (2.0 * area).sqrt() } else { area.sqrt() }
}

/// Largest number of states of a law.
const MOST_STATES: usize = 16;

impl ReturnMaterial {
    /// Evaluates the law at the points of active elements.
    #[inline(always)] // Compiled for the instruction set of the machine.
    fn return_points(&self, state: &mut ReturnState, strain: &StrainIncrement, points: &mut ReturnedPoints) {
        for l in 0..LANES {
            state.angle[l] += if points.live[l] == 1 { strain.spin[l] } else { 0.0 };
        }
        match LaneLaw::of(&*self.law) {
            None => (),
            Some(LaneLaw::DruckerPrager(law)) => law.return_lanes(&mut state.states, points),
            Some(LaneLaw::PorousMetal(law)) => law.return_lanes(&mut state.states, points),
            Some(LaneLaw::Hill(law)) => law.return_lanes(&mut state.states, &state.angle, points),
            Some(LaneLaw::Concrete(law)) => law.return_lanes(&mut state.states, &state.length, strain, points),
        }
        if any(&points.open) {
            self.return_open_points(state, strain, points);
        }
    }

    /// Evaluates the law point by point.
    #[inline(never)]
    fn return_open_points(&self, state: &mut ReturnState, strain: &StrainIncrement, points: &mut ReturnedPoints) {
        let moduli = self.law.moduli();
        let mut values = [0.0; MOST_STATES];
        let values = &mut values[..state.states.len()];
        for l in 0..strain.count {
            if points.open[l] == 0 {
                continue;
            }
            for (value, list) in values.iter_mut().zip(&state.states) {
                *value = list[l];
            }
            let mut point = ReturnPoint {
                strain: column(&strain.strain, l),
                carried: column(&strain.carried, l),
                trial: points.trial(l),
                angle: state.angle[l],
                dt: strain.dt,
                length: state.length[l],
                state: values,
                moduli,
                stress: [0.0; 4],
                plastic: [0.0; 4],
                compacted: 0.0,
                lost: 0.0,
                deleted: false,
            };
            self.law.update(&mut point);
            let ReturnPoint { carried, moduli, stress, plastic, compacted, lost, .. } = point;
            put_column(&mut points.plastic, l, plastic);
            (points.compacted[l], points.lost[l]) = (compacted, lost);
            (points.bulk[l], points.shear[l]) = (moduli.bulk, moduli.shear);
            if point.deleted && !self.keeps_elements {
                let mut previous = [0.0; MOST_STATES];
                previous.iter_mut().zip(&state.states).for_each(|(value, list)| *value = list[l]);
                points.lost[l] = self.law.recoverable_energy(carried, &previous[..values.len()]);
                (points.kept[l], state.active[l]) = (0.0, 0.0);
            } else {
                put_column(&mut points.stress, l, stress);
            }
            for (list, &value) in state.states.iter_mut().zip(values.iter()) {
                list[l] = value;
            }
        }
    }
}

impl CarriedState for ReturnState {
    fn carry(&mut self, visit: &mut dyn FnMut(&mut Lanes)) {
        let ReturnState { states, angle, active: _, length: _, volume: _ } = self;
        states.carry(visit);
        angle.carry(visit);
    }
}
