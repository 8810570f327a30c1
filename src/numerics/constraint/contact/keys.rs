//! Values of the keys of a contact: one key for each point that may carry a pressure. They are the memory of contact from
//! increment to increment.

use super::active_pairs::ActivePairs;
use super::mesh_continuation::{KeyPlace, MeshContinuation};
use super::slip_damping::SlipDamping;
use super::stored_energy::StoredEnergy;
use super::sweeps::{ContactRow, ContactRows, ContactVelocities, most_rows};
use super::user_friction::UserFrictionKeys;
use super::written::WrittenEntries;
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::state::archive::Persist;

/// Values of all keys.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: pressures, gap_offsets, opening, slip; present: user_friction; derived: written_openings, written_pressures)]
pub(super) struct KeyValues {
    /// Pressure and shear stress of each key over the previous increment.
    pub(super) pressures: Vec<[f64; 2]>,
    /// Energy of each key with a soft law.
    pub(super) stored_energy: StoredEnergy,
    /// Damping of frictional flutter.
    pub(super) slip_damping: SlipDamping,
    /// Difference that is subtracted from the gap of each key; empty if all are zero.
    pub(super) gap_offsets: Vec<f64>,
    /// Keys with an opening, and keys with a pressure.
    written_openings: WrittenEntries,
    written_pressures: WrittenEntries,
    /// Gap of each key, for output; NaN if no surface is near.
    pub(super) opening: Vec<f64>,
    /// Accumulated slip of each key while in contact, for output.
    pub(super) slip: Vec<f64>,
    /// Friction by a user subroutine; `None` without one.
    pub(super) user_friction: Option<Box<UserFrictionKeys>>,
}

impl KeyValues {
    /// Creates the values of a number of keys with these laws.
    pub(super) fn new(keys: usize, laws: &[InteractionLaw]) -> KeyValues {
        let mut values = KeyValues {
            pressures: vec![[0.0; 2]; keys],
            opening: vec![f64::NAN; keys],
            slip: vec![0.0; keys],
            ..KeyValues::default()
        };
        if laws.iter().any(|law| law.is_soft()) {
            values.stored_energy = StoredEnergy::new(keys);
        }
        if laws.iter().any(|law| law.friction.damps()) {
            values.slip_damping = SlipDamping::new(keys);
        }
        let variables = laws.iter().filter_map(|law| Some(law.friction_routine.as_ref()?.variables)).max();
        values.user_friction = variables.map(|variables| Box::new(UserFrictionKeys::new(keys, variables)));
        values
    }

    pub(super) fn count(&self) -> usize {
        self.pressures.len()
    }

    /// Notes that any key may have values.
    pub(super) fn forget_written(&mut self) {
        self.written_openings.forget();
        self.written_pressures.forget();
        self.slip_damping.forget_written();
        self.stored_energy.forget_written();
    }

    /// Allocates the lists of written keys.
    pub(super) fn reserve(&mut self) {
        let rows = most_rows(self.count());
        self.written_openings.reserve(rows);
        self.written_pressures.reserve(rows);
        self.slip_damping.reserve(rows);
        self.stored_energy.reserve(rows);
    }

    /// Returns the difference that is subtracted from the gap of a key.
    #[inline]
    pub(super) fn gap_offset(&self, key: usize) -> f64 {
        self.gap_offsets.get(key).copied().unwrap_or(0.0)
    }

    /// Returns whether a key has a value: its pair has been near or in contact.
    pub(super) fn has_value(&self, key: usize) -> bool {
        let is_shown = !self.opening[key].is_nan() || self.slip[key] != 0.0;
        is_shown || self.pressures[key] != [0.0; 2] || self.stored_energy.stored.get(key).is_some_and(|e| *e > 0.0)
    }

    /// Takes the values of a key from a place among those of a previous contact.
    pub(super) fn take_over(&mut self, key: usize, previous: &KeyValues, place: KeyPlace) {
        self.pressures[key] = [0, 1].inline_map(|part: usize| place.value(|other| previous.pressures[other][part]));
        self.stored_energy.take_over(key, &previous.stored_energy, place);
        self.slip_damping.take_over(key, &previous.slip_damping, place);
        self.forget_written();
        self.opening[key] = place.value(|other| previous.opening[other]);
        self.slip[key] = place.value(|other| previous.slip[other]);
        if let (Some(friction), Some(previous)) = (&mut self.user_friction, &previous.user_friction) {
            friction.take_over(key, previous, place);
        }
        let offset = place.value(|other| previous.gap_offset(other));
        if offset != 0.0 && self.gap_offsets.is_empty() {
            self.gap_offsets = vec![0.0; self.count()];
        }
        if let Some(known) = self.gap_offsets.get_mut(key) {
            *known = offset;
        }
    }

    /// Moves the values to the new places of the keys on adaptive meshes, energies excepted.
    pub(super) fn carry(&mut self, mesh: &mut MeshContinuation) {
        self.written_pressures.forget();
        mesh.carry(&mut self.pressures, |[pressure, _]| pressure);
        mesh.carry(&mut self.pressures, |[_, shear]| shear);
        mesh.carry(&mut self.gap_offsets, |offset| offset);
        mesh.carry(&mut self.slip, |slip| slip);
        self.slip_damping.carry(mesh);
        if let Some(friction) = &mut self.user_friction {
            friction.carry(mesh);
        }
    }

    /// Stores the pressures of rows whose impulses have acted over the time `half`.
    pub(super) fn store_pressures(&mut self, rows: &ContactRows, half: f64, active: &ActivePairs) {
        self.written_pressures.reset_keys(&mut self.pressures, [0.0; 2], active);
        for row in rows.rows.iter().filter(|row| row.acts()) {
            self.pressures[row.key as usize] = [row.normal_impulse / half, row.shear_impulse / half];
            self.written_pressures.add(row.key);
        }
    }

    /// Removes the openings of the previous increment.
    pub(super) fn clear_openings(&mut self, active: &ActivePairs) {
        self.written_openings.reset_keys(&mut self.opening, f64::NAN, active);
    }

    /// Stores the gaps at the start of the increment.
    pub(super) fn store_openings(&mut self, rows: &[ContactRow]) {
        for row in rows.iter().filter(|row| row.closest_point.is_none()) {
            self.opening[row.key as usize] = row.gap / row.area;
            self.written_openings.add(row.key);
        }
    }

    /// Stores the gap of a key at the start of the increment.
    pub(super) fn set_opening(&mut self, key: u32, gap: f64) {
        self.opening[key as usize] = gap;
        self.written_openings.add(key);
    }

    /// Adds the slip of an increment of length `dt`.
    pub(super) fn add_slip(&mut self, rows: &ContactRows, motion: &ContactVelocities, dt: f64) {
        for row in rows.rows.iter().filter(|row| row.normal_impulse > 0.0) {
            self.slip[row.key as usize] += dt * motion.slip(rows.terms_of(row)) / row.area;
        }
    }
}
