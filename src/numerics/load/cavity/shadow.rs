//! Parts of a rigid surface that are inside the tunnel opened by the body further ahead; they have no resistance.

use crate::kernel::facet::Facet;

/// Returns the parts of facets facing the motion (towards +z or -z by `sign`) that touch material: no other facet at
/// their radius is further ahead. A body that is separated from the wall touches it again where it is wider than ahead.
pub(super) fn exposed_parts(loaded: &[(usize, Facet)], all: &[(usize, Facet)], sign: f64) -> Vec<(usize, Facet)> {
    loaded
        .iter()
        .flat_map(|&(element, facet)| parts(&facet, all, sign).into_iter().map(move |f| (element, f)))
        .collect()
}

fn parts(facet: &Facet, all: &[(usize, Facet)], sign: f64) -> Vec<Facet> {
    let [from, to] = radii(facet);
    if from == to {
        return vec![*facet];
    }
    let mut hidden: Vec<[f64; 2]> = all.iter().filter_map(|(_, other)| hidden_by(facet, other, sign)).collect();
    hidden.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut exposed, mut start) = (Vec::new(), from);
    for [inner, outer] in hidden {
        if inner > start {
            exposed.push([start, inner]);
        }
        start = start.max(outer);
    }
    if start < to {
        exposed.push([start, to]);
    }
    if exposed == [[from, to]] {
        return vec![*facet];
    }
    exposed.into_iter().filter_map(|between| cut(facet, between)).collect()
}

/// Returns the range of radii at which another facet is ahead.
fn hidden_by(facet: &Facet, other: &Facet, sign: f64) -> Option<[f64; 2]> {
    let ([a, b], [c, d]) = (radii(facet), radii(other));
    let (inner, outer) = (a.max(c), b.min(d));
    if outer <= inner {
        return None;
    }
    let middle = 0.5 * (inner + outer);
    (sign * (height(other, middle) - height(facet, middle)) > 0.0).then_some([inner, outer])
}

fn radii(facet: &Facet) -> [f64; 2] {
    let (a, b) = (facet.low[0], facet.high[0]);
    [a.min(b), a.max(b)]
}

/// Returns z at a radius, for a facet that is not a cylinder.
fn height(facet: &Facet, radius: f64) -> f64 {
    let part = (radius - facet.low[0]) / (facet.high[0] - facet.low[0]);
    facet.low[1] + part * facet.height()
}

/// Returns the part of a facet between two radii.
fn cut(facet: &Facet, [inner, outer]: [f64; 2]) -> Option<Facet> {
    let point = |radius: f64| [radius, height(facet, radius)];
    let ends = [point(inner), point(outer)];
    let line = Facet::new(ends[0], ends[1], false)?;
    Some(Facet { normal: facet.normal, ..line })
}

#[cfg(test)]
mod tests {
    use super::exposed_parts;
    use crate::kernel::facet::Facet;

    /// Returns a nose to r = 2, a neck of r = 1 and a flare to r = 3, moving towards -z.
    fn body() -> Vec<(usize, Facet)> {
        let points = [[0.0, 0.0], [2.0, 2.0], [1.0, 3.0], [1.0, 4.0], [3.0, 6.0]];
        let facet = |w: &[[f64; 2]]| Facet::new(w[0], w[1], false);
        points.windows(2).enumerate().filter_map(|(i, w)| Some((i, facet(w)?))).collect()
    }

    #[test]
    fn flare_after_a_neck_is_loaded_where_it_is_wider_than_the_nose() {
        let facets = body();
        let loaded: Vec<_> = facets.iter().filter(|f| f.1.normal[1] < 0.0).copied().collect();
        assert_eq!(loaded.len(), 2);
        let loaded_parts = exposed_parts(&loaded, &facets, -1.0);
        assert_eq!(loaded_parts[0], facets[0]);
        assert_eq!((loaded_parts.len(), loaded_parts[1].0), (2, 3));
        assert_eq!([loaded_parts[1].1.low, loaded_parts[1].1.high], [[2.0, 5.0], [3.0, 6.0]]);
        assert_eq!(loaded_parts[1].1.normal, facets[3].1.normal);
    }

    #[test]
    fn concave_front_is_loaded_completely() {
        let points = [[0.0, 1.0], [1.0, 1.0], [2.0, 0.0], [2.0, 5.0]];
        let facet = |w: &[[f64; 2]]| Facet::new(w[0], w[1], false);
        let facets: Vec<_> = points.windows(2).enumerate().filter_map(|(i, w)| Some((i, facet(w)?))).collect();
        let loaded = &facets[..2];
        assert_eq!(exposed_parts(loaded, &facets, -1.0), loaded);
    }
}
