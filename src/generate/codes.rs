//! Diagnostic codes of made meshes (`G…`), for `revolve explain`.

use crate::deck::Code;

/// All codes of this folder.
pub const CODES: &[Code] = codes! {
    "G001" "size that is none" "Radius, length, element size and all other lengths of `revolve mesh` are positive, finite numbers in one unit of length; the element size is not larger than the radius, and not so small that the mesh has more than ten million elements."
    "G002" "nose that does not exist" "An ogive has a calibre-radius-head of at least 1/2 (a hemisphere); below that its circle does not reach the shank. A cone has a half angle between 0 and 90 degrees, or a height above 0."
    "G003" "projectile shorter than its nose" "The length is that of the whole projectile, nose included. That of an ogive's nose is a sqrt(4 CRH - 1), of a cone's a/tan(half angle), of a hemisphere's a, with a the radius of the shank."
    "G004" "profile that cannot be turned" "The file of a polyline has one point a line, `r, z`, from the tip to the base: r is nowhere negative and above zero from the second point on, z never falls, and only the front may be level. Up to the largest radius r does not fall."
    "G005" "cavity that does not fit" "A hollow projectile has a wall thinner than its radius, a cavity that begins behind the shoulder of the nose and, behind it, a base that ends before the projectile does. Its shank has one radius along the cavity."
    "G006" "mesh that folds" "With this profile and size an element would have a corner of 180 degrees or more. Concave noses and steps in a profile do that: give points of the profile nearer to each other, or smaller elements."
    "G007" "mass that cannot be reached" "The fill alone weighs as much as the mass that is asked for, so that no density of the case gives it."
};
