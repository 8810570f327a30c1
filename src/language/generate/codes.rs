//! Diagnostic codes of mesh generation (`G…`), for `revolve explain`.

use revolve_numerics::codes;

use crate::deck::DiagnosticCode;

/// Diagnostic codes of mesh generation.
pub const CODES: &[DiagnosticCode] = codes! {
    "G001" "invalid size" "Radius, length, element size and all other lengths of `revolve mesh` must be positive, finite numbers in one unit of length. The element size must not exceed the radius, and the mesh may have at most ten million elements."
    "G002" "invalid nose" "An ogive has a calibre-radius-head of at least 1/2 (a hemisphere); with a smaller value its arc does not reach the shank. A cone has a half angle between 0 and 90 degrees, or a positive height."
    "G003" "projectile shorter than its nose" "The length is that of the whole projectile, nose included. With the shank radius a the nose length is a sqrt(4 CRH - 1) for an ogive, a/tan(half angle) for a cone and a for a hemisphere."
    "G004" "invalid profile" "The file of a polyline has one point per line, `r, z`, from the tip to the base. r must not be negative, and must be positive from the second point on; z must not decrease, and only the front may be flat. Up to the largest radius r must not decrease."
    "G005" "cavity does not fit" "The wall of a hollow projectile must be thinner than its radius. The cavity must start after the shoulder of the nose and end before the base, and the shank must have a constant radius along the cavity."
    "G006" "folded mesh" "With this profile and element size an element would have a corner of 180 degrees or more, for example at concave noses and steps of the profile. Give more profile points, or use smaller elements."
    "G007" "mass cannot be reached" "The fill alone has at least the requested mass, so that no density of the case gives it."
};
