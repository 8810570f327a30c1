//! Arguments of calls as messages: one list of fields defines both writing and reading.

use super::super::{
    EnergyCall, FrictionCall, HardeningCall, LengthCall, LoadPoints, MaterialCall, MotionCall, NodalFieldCall,
};
use super::message::{MessageField, MessageReader, MessageWriter, get, put};

/// Implements messages for calls of which all fields are sent.
macro_rules! calls {
    ($($call:ident { $($field:ident),* })*) => {$(
        impl<'m> MessageField<'m> for $call<'m> {
            fn put(&self, to: &mut MessageWriter<'_>) {
                put!(to; $(self.$field),*);
            }

            fn get(from: &mut MessageReader<'m>) -> Self {
                get!(from; $($field),*);
                $call { $($field),* }
            }
        }
    )*};
}

calls! {
    MotionCall { set, kind, node, dof, now, increments, amplitude, coordinates, state, across, mass }
    NodalFieldCall { set, now, lengths, variables, nodes, coordinates, motion }
    FrictionCall {
        interaction, now, dt, friction_work, variables, properties, nodes, slip, stick, previous, normal, area, directions,
        coordinates, velocities
    }
    MaterialCall {
        name, now, dt, count, integration_point, variables, properties, coordinates, length, density, strain, spin,
        elements, temperature, fields, field, stretch, gradient, stress, state, internal, inelastic
    }
    EnergyCall {
        name, now, dt, count, integration_point, variables, fields, properties, elements, state, families, temperature,
        field, invariants, cosines
    }
    HardeningCall {
        name, now, dt, count, integration_point, variables, fields, properties, elements, temperature, field, state,
        strain, rate
    }
    LengthCall {
        name, now, dt, count, integration_point, variables, fields, corners, properties, elements, coordinates, nodes,
        field, state
    }
}

impl<'m> MessageField<'m> for LoadPoints<'m> {
    fn put(&self, to: &mut MessageWriter<'_>) {
        put!(to; self.surface, self.load_type, self.now, self.amplitude, self.magnitude, self.r.len());
        put!(to; self.coordinates, self.motion, self.directions);
    }

    fn get(from: &mut MessageReader<'m>) -> Self {
        get!(from; surface, load_type, now, amplitude, magnitude, n);
        let [coordinates, motion, directions]: [&[f64]; 3] = MessageField::get(from);
        LoadPoints {
            memory: &[],
            surface,
            load_type,
            now,
            amplitude,
            magnitude,
            r: &coordinates[..n],
            z: &coordinates[n..2 * n],
            velocity_r: &motion[..n],
            velocity_z: &motion[n..2 * n],
            // Compiled subroutines read normals from `directions`.
            normal_r: &directions[..n],
            normal_z: &directions[2 * n..3 * n],
            coordinates,
            motion,
            directions,
        }
    }
}
