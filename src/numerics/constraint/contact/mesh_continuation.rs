//! Values of contact keys during a change of adaptive meshes: gaps, areas and places at the start, and the new places of the
//! keys between those at the start.

use crate::kernel::lists::Memory;

/// Place of a key between two keys of a previous contact; on adaptive meshes its new place between itself and the key of
/// the next point on the side to which it moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeyPlace {
    pub(super) keys: [u32; 2],
    /// Distance from the first key, as a fraction of that between both.
    pub(super) share: f64,
}

impl KeyPlace {
    /// Returns the value at the place from those of the keys.
    pub(super) fn value(&self, mut value: impl FnMut(usize) -> f64) -> f64 {
        let first = value(self.keys[0] as usize);
        if self.share == 0.0 { first } else { mix(first, value(self.keys[1] as usize), self.share) }
    }
}

/// Contact at the start of a change of meshes, and work arrays.
#[derive(Clone, Debug, Default, Memory)]
pub(super) struct MeshContinuation {
    /// Places of all points at the start.
    pub(super) starts: Vec<[f64; 2]>,
    /// Mean gap and area of each key at the start; NaN and 0 without a row.
    pub(super) gaps: Vec<f64>,
    pub(super) areas: Vec<f64>,
    /// New places of keys that move, by ascending key.
    pub(super) shares: Vec<KeyPlace>,
    /// Values at the new places, in the order of the shares.
    mixed: Vec<f64>,
    /// Stored energies at the new places.
    pub(super) stored: Vec<f64>,
    /// Corrections of the places of each degree of freedom, and whether it may be corrected.
    pub(super) shifts: Vec<f64>,
    pub(super) is_free: Vec<bool>,
}

impl MeshContinuation {
    /// Allocates for this number of keys, points and degrees of freedom.
    pub(super) fn new(keys: usize, points: usize, dofs: usize) -> MeshContinuation {
        MeshContinuation {
            starts: vec![[0.0; 2]; points],
            gaps: vec![f64::NAN; keys],
            areas: vec![0.0; keys],
            shares: Vec::with_capacity(keys),
            mixed: Vec::with_capacity(keys),
            stored: vec![0.0; keys],
            shifts: vec![0.0; dofs],
            is_free: vec![false; dofs],
        }
    }

    /// Returns the value of a key at its new place, from those of all keys at the start.
    pub(super) fn at_new_place(&self, key: u32, value: impl Fn(usize) -> f64) -> f64 {
        let index = self.shares.binary_search_by_key(&key, |place| place.keys[0]);
        index.map_or_else(|_| value(key as usize), |index| self.shares[index].value(&value))
    }

    /// Moves a value of each key to the new places.
    pub(super) fn carry<T>(&mut self, values: &mut [T], part: impl Fn(&mut T) -> &mut f64) {
        if values.is_empty() {
            return;
        }
        self.mixed.clear();
        self.mixed.extend(self.shares.iter().map(|place| place.value(|key| *part(&mut values[key]))));
        for (place, value) in self.shares.iter().zip(&self.mixed) {
            *part(&mut values[place.keys[0] as usize]) = *value;
        }
    }
}

/// Returns the value between two keys; that of the first if one has none.
fn mix(own: f64, other: f64, share: f64) -> f64 {
    let value = own + share * (other - own);
    if value.is_nan() { own } else { value }
}
