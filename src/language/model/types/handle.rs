//! Typed handles of model items. Names in the deck are resolved to handles when the cards are read.

use std::ops::{Index, IndexMut};

use indexmap::IndexMap;

use super::{
    Amplitude, ElementSurface, MaterialDefinition, MemberSet, RigidSurface, SurfaceInteraction, TargetStack, TimePoints,
};

/// Defines a handle type for a list of the model, and indexing of the list with it.
macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident: $list:ty => $item:ty;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(u32);

        impl $name {
            /// Returns the handle of the item at an index of its list.
            pub fn new(index: usize) -> Self {
                Self(u32::try_from(index).unwrap_or(u32::MAX))
            }

            /// Returns the index of the item in its list.
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
    MaterialId: Vec<MaterialDefinition> => MaterialDefinition;
    /// An amplitude of [`super::Model::amplitudes`].
    AmplitudeId: Vec<Amplitude> => Amplitude;
    /// A surface interaction of [`super::Model::interactions`].
    InteractionId: Vec<SurfaceInteraction> => SurfaceInteraction;
    /// A target of [`super::Model::targets`].
    TargetId: Vec<TargetStack> => TargetStack;
    /// A list of time points of [`super::OutputDefinitions::time_points`].
    TimePointsId: Vec<TimePoints> => TimePoints;
    /// A node set of [`super::Model::node_sets`].
    NodeSetId: IndexMap<String, MemberSet> => MemberSet;
    /// An element set of [`super::Model::element_sets`].
    ElementSetId: IndexMap<String, MemberSet> => MemberSet;
    /// A surface of [`super::SurfaceDefinitions::faces`].
    SurfaceId: IndexMap<String, ElementSurface> => ElementSurface;
    /// An analytical surface of [`super::SurfaceDefinitions::analytical`].
    RigidSurfaceId: IndexMap<String, RigidSurface> => RigidSurface;
}
