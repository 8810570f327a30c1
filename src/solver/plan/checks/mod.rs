//! Checks that judge a complete plan, and warn of input that is probably a mistake.

pub(crate) mod contact_pairs;
pub(crate) mod overlaps;
pub(crate) mod plausibility;
pub(crate) mod values;
