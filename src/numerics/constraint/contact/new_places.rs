//! Places of nodes that slide along a surface in contact, and of new nodes on it: which nodes contact corrects, and where
//! analytical surfaces are.

use super::analytical::AnalyticalSurface;
use super::curve::PointCarrier;
use super::pairs::ContactPair;
use super::system::ContactSystem;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::distance;
use crate::state::dofs::Dofs;

/// Largest gap or overlap of a node in contact, in units of an edge.
const TOUCHING: f64 = 0.02;

impl ContactSystem {
    /// Returns whether the contact corrects the new place of a point whose mesh moves (`MeshContinuation::follow`), after
    /// [`Self::begin_mesh_motion`]: another surface with facets is near, no analytical one presses, and no bond acts.
    pub fn keeps_gaps(&self, carrier: PointCarrier) -> bool {
        let Some(point) = self.surfaces.point_on(carrier) else { return false };
        let mut keeps = false;
        for pair in self.surfaces.active.list.iter().map(|index| &self.pairs[*index as usize]) {
            let index_in = |curve: usize| self.surfaces.curves[curve].points.binary_search(&point).ok();
            let own_index = index_in(pair.secondary);
            let is_pressed = |index: usize| self.keys.pressures[pair.first_key as usize + index][0] > 0.0;
            if pair.analytical.is_some() && own_index.is_some_and(is_pressed) {
                return false;
            }
            if pair.analytical.is_none() && own_index.or_else(|| index_in(pair.other?)).is_some() {
                if pair.is_cohesive {
                    return false;
                }
                keeps = self.surfaces.near.has(point);
            }
        }
        keeps
    }

    /// Returns the closest place to `place` on the only analytical surface of a point, at the start of an increment of which
    /// only the motion of bodies has been made; `None` without one. In soft contact it is the closest place with the gap that
    /// the material has there.
    pub fn place_on_surface(&self, carrier: PointCarrier, place: [f64; 2], dofs: &Dofs) -> Option<[f64; 2]> {
        let point = self.surfaces.point_on(carrier)?;
        let analytical_pairs = self.pairs.iter().filter(|pair| pair.analytical.is_some());
        let index_in = |pair: &ContactPair| self.surfaces.curves[pair.secondary].points.binary_search(&point).ok();
        let mut pairs = analytical_pairs.filter_map(|pair| Some((pair, index_in(pair)?)));
        let (Some((pair, index)), None) = (pairs.next(), pairs.next()) else { return None };
        let analytical = &self.surfaces.analyticals[pair.analytical?];
        let lift = self.surfaces.place_of(analytical.point, dofs, 0.0)[1];
        let gap = if self.laws[pair.law_of(index) as usize].is_soft() {
            self.gap_along_facets(pair, index, place, dofs)?
        } else {
            0.0
        };
        analytical.place_at(self.zero_of(analytical, index, pair.first_key as usize + index) + gap, place, lift)
    }

    /// Returns the gap to an analytical surface at the new place of a point that slides along its facets: between the gaps
    /// of the point and of the next one. `None` beyond the ends of the surface.
    fn gap_along_facets(&self, pair: &ContactPair, index: usize, place: [f64; 2], dofs: &Dofs) -> Option<f64> {
        let (analytical, secondary) =
            (&self.surfaces.analyticals[pair.analytical?], &self.surfaces.curves[pair.secondary]);
        let place_of = |point: u32| self.surfaces.place_of(point, dofs, 0.0);
        let lift = place_of(analytical.point)[1];
        let gap = |index: usize| {
            let nearest = analytical.profile.nearest(place_of(secondary.points[index]), lift);
            let zero = self.zero_of(analytical, index, pair.first_key as usize + index);
            (!nearest.beyond).then_some(nearest.gap - zero)
        };
        let start = gap(index)?;
        let Some((next, share)) = secondary.next_point(index, place, place_of) else { return Some(start) };
        let end = secondary.points.binary_search(&next).ok().and_then(gap).unwrap_or(start);
        Some(start + share * (end - start))
    }

    /// Returns the distance from the profile that is gap zero at a point.
    fn zero_of(&self, analytical: &AnalyticalSurface, index: usize, key: usize) -> f64 {
        analytical.lift[index] + self.keys.gap_offset(key)
    }

    /// Returns the place of a new node on the edge between two nodes of a surface that is in contact with an analytical
    /// one: on a curved surface the edge is not on it. Between two nodes in contact the new node has the gap between
    /// theirs, and others do not overlap. `None` if the node may remain on the edge.
    pub fn place_between(&self, ends: [usize; 2], share: f64, dofs: &Dofs) -> Option<[f64; 2]> {
        let end_places = ends.inline_map(|node| dofs.nodes[node].place());
        let edge = distance(end_places[0], end_places[1]);
        let start = [0, 1].inline_map(|i: usize| end_places[0][i] + share * (end_places[1][i] - end_places[0][i]));
        let surfaces = &self.surfaces;
        self.pairs.iter().find_map(|pair| {
            let analytical = &surfaces.analyticals[pair.analytical?];
            let PointCarrier::Body(body, [_, z]) = surfaces.points[analytical.point as usize].carrier else {
                return None;
            };
            let (own_points, lift) = (&surfaces.curves[pair.secondary].points, z + dofs.bodies[body].displacement);
            let is_at =
                |node: usize| move |point: &u32| surfaces.points[*point as usize].carrier == PointCarrier::Node(node);
            let [first, second] = ends.inline_map(|node| own_points.iter().position(is_at(node)));
            let zeros = [first?, second?].inline_map(|i| self.zero_of(analytical, i, pair.first_key as usize + i));
            let gap = |place: [f64; 2], zero: f64| {
                let nearest = analytical.profile.nearest(place, lift);
                (!nearest.beyond).then_some(nearest.gap - zero)
            };
            let zero = zeros[0] + share * (zeros[1] - zeros[0]);
            let end_gaps = [gap(end_places[0], zeros[0])?, gap(end_places[1], zeros[1])?];
            let (start_gap, mean_gap) = (gap(start, zero)?, end_gaps[0] + share * (end_gaps[1] - end_gaps[0]));
            let touches = end_gaps.iter().all(|gap| gap.abs() <= TOUCHING * edge);
            let moves = if touches { start_gap != mean_gap } else { start_gap < mean_gap.min(0.0) };
            let target = zero + if touches { mean_gap } else { mean_gap.min(0.0) };
            if moves { analytical.place_at(target, start, lift) } else { None }
        })
    }
}
