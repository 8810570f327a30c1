//! Handles: what a model refers to, resolved when its cards are read.
//! Never here: names.

use std::ops::{Index, IndexMut};

use indexmap::IndexMap;

use super::{Amplitude, Interaction, Material, RigidSurface, Set, Surface, Target, TimePoints};

/// Handles into lists of a model, each with the list that it leads into.
macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident: $list:ty => $item:ty;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(u32);

        impl $name {
            /// The handle of the item at a place of the list.
            pub fn new(index: usize) -> Self {
                Self(u32::try_from(index).unwrap_or(u32::MAX))
            }

            /// The place of the item in its list.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl Index<$name> for $list {
            type Output = $item;

            fn index(&self, id: $name) -> &$item {
                &self[id.index()]
            }
        }

        impl IndexMut<$name> for $list {
            fn index_mut(&mut self, id: $name) -> &mut $item {
                &mut self[id.index()]
            }
        }
    )*};
}

handles! {
    /// A material of [`super::Model::materials`].
    MaterialId: Vec<Material> => Material;
    /// An amplitude of [`super::Model::amplitudes`].
    AmplitudeId: Vec<Amplitude> => Amplitude;
    /// A surface interaction of [`super::Model::interactions`].
    InteractionId: Vec<Interaction> => Interaction;
    /// A target of [`super::Model::targets`].
    TargetId: Vec<Target> => Target;
    /// A list of times of [`super::OutputDefinitions::time_points`].
    TimePointsId: Vec<TimePoints> => TimePoints;
    /// A node set of [`super::Model::node_sets`].
    NodeSetId: IndexMap<String, Set> => Set;
    /// An element set of [`super::Model::element_sets`].
    ElementSetId: IndexMap<String, Set> => Set;
    /// A surface of [`super::Surfaces::faces`].
    SurfaceId: IndexMap<String, Surface> => Surface;
    /// An analytical surface of [`super::Surfaces::analytical`].
    RigidSurfaceId: IndexMap<String, RigidSurface> => RigidSurface;
}
