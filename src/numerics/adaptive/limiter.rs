//! Flux-corrected transport (Zalesak 1979, J. Comput. Phys. 31, 335): second-order fluxes, limited so that no value
//! leaves the range of its neighbours. The sum of weight times value is conserved to rounding.

use crate::kernel::lanes::InlineMap;

/// Edge of a graph of cells, with the weight (volume or mass) that moves from the second to the first cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WeightFlux {
    pub cells: [u32; 2],
    pub weight: f64,
}

impl WeightFlux {
    /// Returns the cell from which the weight comes.
    pub fn donor(&self) -> usize {
        self.cells[usize::from(self.weight > 0.0)] as usize
    }
}

/// Work arrays of a transport; one entry per cell, or per flux.
#[derive(Clone, Debug, Default)]
pub(super) struct TransportWork {
    /// Value after a first-order step; on return the new value.
    pub value: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// Sums of corrections that raise and lower each cell, then the allowed shares of these corrections.
    raise: Vec<f64>,
    lower: Vec<f64>,
    /// Corrections of the fluxes into the first cell.
    pub correction: Vec<f64>,
}

impl TransportWork {
    pub fn new(cells: usize, fluxes: usize) -> TransportWork {
        let list = || vec![0.0; cells];
        let correction = vec![0.0; fluxes];
        TransportWork { value: list(), low: list(), high: list(), raise: list(), lower: list(), correction }
    }

    pub fn bytes(&self) -> usize {
        8 * (5 * self.value.capacity() + self.correction.capacity())
    }

    /// Moves a value with the weights; `after` are the weights of the cells after the motion, `reconstructed(i)` is the
    /// value of second order in flux i. The new values are in `self.value`. The flux of weight times value is the weight
    /// times the value of the donor, plus `self.correction`.
    pub fn transport(
        &mut self,
        values: &[f64],
        fluxes: &[WeightFlux],
        after: &[f64],
        reconstructed: impl Fn(usize) -> f64,
    ) {
        self.move_first_order(values, fluxes, after);
        self.bound(values, fluxes);
        self.correct(values, fluxes, after, reconstructed);
    }

    fn move_first_order(&mut self, values: &[f64], fluxes: &[WeightFlux], after: &[f64]) {
        // Sums of changes, so that a common value stays exact.
        self.value.fill(0.0);
        for flux in fluxes {
            let [first, second] = flux.cells;
            let carried = values[flux.donor()];
            self.value[first as usize] += flux.weight * (carried - values[first as usize]);
            self.value[second as usize] -= flux.weight * (carried - values[second as usize]);
        }
        for ((new, old), after) in self.value.iter_mut().zip(values).zip(after) {
            *new = old + *new / after;
        }
    }

    fn bound(&mut self, values: &[f64], fluxes: &[WeightFlux]) {
        for (i, (old, new)) in values.iter().zip(&self.value).enumerate() {
            (self.low[i], self.high[i]) = (old.min(*new), old.max(*new));
        }
        let new = &self.value;
        for flux in fluxes {
            let [a, b] = flux.cells.inline_map(|cell| cell as usize);
            self.low[a] = self.low[a].min(values[b]).min(new[b]);
            self.low[b] = self.low[b].min(values[a]).min(new[a]);
            self.high[a] = self.high[a].max(values[b]).max(new[b]);
            self.high[b] = self.high[b].max(values[a]).max(new[a]);
        }
    }

    fn correct(&mut self, values: &[f64], fluxes: &[WeightFlux], after: &[f64], reconstructed: impl Fn(usize) -> f64) {
        self.raise.fill(0.0);
        self.lower.fill(0.0);
        for (i, (flux, correction)) in fluxes.iter().zip(&mut self.correction).enumerate() {
            *correction = flux.weight * (reconstructed(i) - values[flux.donor()]);
            let [first, second] = flux.cells;
            let (up, down) = (correction.max(0.0), correction.min(0.0));
            self.raise[first as usize] += up;
            self.lower[first as usize] -= down;
            self.raise[second as usize] -= down;
            self.lower[second as usize] += up;
        }
        let share = |weight: f64, room: f64, sum: f64| if sum > 0.0 { (weight * room / sum).min(1.0) } else { 0.0 };
        for (i, weight) in after.iter().enumerate() {
            let value = self.value[i];
            self.raise[i] = share(*weight, self.high[i] - value, self.raise[i]);
            self.lower[i] = share(*weight, value - self.low[i], self.lower[i]);
        }
        for (flux, correction) in fluxes.iter().zip(&mut self.correction) {
            let (first, second) = (flux.cells[0] as usize, flux.cells[1] as usize);
            let share = if *correction > 0.0 {
                self.raise[first].min(self.lower[second])
            } else {
                self.lower[first].min(self.raise[second])
            };
            *correction *= share;
            self.value[first] += *correction / after[first];
            self.value[second] -= *correction / after[second];
        }
        // Rounding may exceed the range by a last bit.
        for ((value, low), high) in self.value.iter_mut().zip(&self.low).zip(&self.high) {
            *value = value.max(*low).min(*high);
        }
    }
}
