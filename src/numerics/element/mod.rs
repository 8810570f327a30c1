//! Elements: groups of one topology and material, springs and dashpots, and their common time increment limit,
//! deletion, mass scaling and output.

pub mod assembly;
mod assumed;
pub mod averaging;
#[cfg(test)]
mod battery;
pub mod block;
mod calls;
pub mod cohesive;
pub mod compatible;
pub mod connector;
pub mod constants;
pub mod criteria;
pub mod damping;
mod deletion;
pub mod deletions;
mod distorted;
pub mod distortion;
mod edges;
pub mod elements;
mod enhanced;
mod eroded;
pub mod erosion;
mod estimate;
mod forces;
pub mod free_nodes;
pub mod frequency;
pub mod group;
pub mod instructions;
mod lanczos;
pub mod lane_sums;
pub mod lengths;
pub mod mass_scaling;
mod motion;
pub mod parts;
pub mod pattern;
pub mod predefined;
pub mod quad;
pub mod quiescent;
pub mod record;
pub mod removed;
mod rescale;
pub mod rings;
#[cfg(test)]
mod same_bits;
#[cfg(test)]
mod same_laws;
pub mod shell;
mod shock;
pub mod six_node;
mod solid;
pub mod solid_groups;
pub mod stable_limit;
mod strain;
mod subzonal;
mod tiles;
pub mod timing;
pub mod transfer;
pub mod user_field;
pub mod values;
pub mod volume_guard;
pub mod workspace;
