//! What of a rigid surface moves in the tunnel that the body has opened further ahead.
//! Never here: what acts on the rest.

use crate::kernel::facet::Facet;

/// Of facets that face the motion (towards +z or -z by `sign`) the parts that meet material: at their radius no other facet lies
/// further ahead. What is separated there meets the wall again where the body is wider than ahead.
pub(super) fn facing(loaded: &[(usize, Facet)], all: &[(usize, Facet)], sign: f64) -> Vec<(usize, Facet)> {
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
    let (mut bare, mut start) = (Vec::new(), from);
    for [inner, outer] in hidden {
        if inner > start {
            bare.push([start, inner]);
        }
        start = start.max(outer);
    }
    if start < to {
        bare.push([start, to]);
    }
    if bare == [[from, to]] {
        return vec![*facet];
    }
    bare.into_iter().filter_map(|between| cut(facet, between)).collect()
}

/// The radii at which another facet lies ahead.
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

/// z at a radius, of a facet that is no cylinder.
fn height(facet: &Facet, radius: f64) -> f64 {
    let part = (radius - facet.low[0]) / (facet.high[0] - facet.low[0]);
    facet.low[1] + part * facet.height()
}

/// The part between two radii.
fn cut(facet: &Facet, [inner, outer]: [f64; 2]) -> Option<Facet> {
    let point = |radius: f64| [radius, height(facet, radius)];
    let ends = [point(inner), point(outer)];
    let found = Facet::new(ends[0], ends[1], false)?;
    Some(Facet { normal: facet.normal, ..found })
}

#[cfg(test)]
mod tests {
    use super::facing;
    use crate::kernel::facet::Facet;

    /// A nose to r = 2, a neck of r = 1 and a flare to r = 3, moving towards -z.
    fn body() -> Vec<(usize, Facet)> {
        let points = [[0.0, 0.0], [2.0, 2.0], [1.0, 3.0], [1.0, 4.0], [3.0, 6.0]];
        let facet = |w: &[[f64; 2]]| Facet::new(w[0], w[1], false);
        points.windows(2).enumerate().filter_map(|(i, w)| Some((i, facet(w)?))).collect()
    }

    #[test]
    fn a_flare_behind_a_neck_meets_the_wall_where_it_is_wider_than_the_nose() {
        let all = body();
        let loaded: Vec<_> = all.iter().filter(|f| f.1.normal[1] < 0.0).copied().collect();
        assert_eq!(loaded.len(), 2);
        let met = facing(&loaded, &all, -1.0);
        assert_eq!(met[0], all[0]);
        assert_eq!((met.len(), met[1].0), (2, 3));
        assert_eq!([met[1].1.low, met[1].1.high], [[2.0, 5.0], [3.0, 6.0]]);
        assert_eq!(met[1].1.normal, all[3].1.normal);
    }

    #[test]
    fn a_cup_is_met_all_over() {
        let points = [[0.0, 1.0], [1.0, 1.0], [2.0, 0.0], [2.0, 5.0]];
        let facet = |w: &[[f64; 2]]| Facet::new(w[0], w[1], false);
        let all: Vec<_> = points.windows(2).enumerate().filter_map(|(i, w)| Some((i, facet(w)?))).collect();
        let loaded = &all[..2];
        assert_eq!(facing(loaded, &all, -1.0), loaded);
    }
}
