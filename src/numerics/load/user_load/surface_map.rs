//! Points of a load and the geometry they belong to: facets and solids of rigid bodies that move along z, stations of
//! rigid bodies with six degrees of freedom, faces and elements of deformable bodies.

use super::surface_view::SurfaceView;
use super::{RigidSolid, UserLoadData};
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::{Memory, heap_bytes};
use crate::load::SceneView;
use crate::load::body_force::corner_volumes;
use crate::load::fields::FacetFields;
use crate::load::pressure::{add_pressure, face_forces};
use crate::load::stations::SurfaceStation;
use crate::load::stiffness::{FaceSample, LoadStiffness, StiffnessMonitor};
use crate::mesh::surface::{CurrentFace, DeformableFaces};
use crate::platform::PortableMath as _;
use crate::routines::{LoadFailure, MAX_BLOCK};
use crate::state::BodyState;
use crate::state::archive::{Persist, StateArchive, persist_fields};
use crate::state::dofs::Dofs;
use crate::state::halt::HaltReason;
use crate::state::nodes::Nodes;
use crate::state::rigid_body_3d::{RigidBody3d, Wrench};

/// Points of one call, at most [`MAX_BLOCK`].
#[derive(Clone, Debug, Persist)]
// Previous pressures are not saved: the next evaluation sets them from the current ones.
#[persist(derived: pressure_before)]
pub(super) struct PointBlock {
    pub(super) map: SurfaceMap,
    view: SurfaceView,
    /// Previous pressures on a rigid body, written to frames if the subroutine fails.
    pressure_before: Vec<f64>,
}

/// Geometry of the points of a block: fills a [`SurfaceView`] from positions and motion, and converts its pressures to
/// forces.
#[derive(Clone, Debug)]
pub(super) enum SurfaceMap {
    /// Rigid body that moves along z: index of its force among the load's forces, force along z per unit value (minus
    /// area times n_z, or volume), initial z, and elements in the mesh.
    Body { slot: usize, body: usize, weight: Vec<f64>, z_start: Vec<f64>, elements: Vec<usize> },
    /// Stations of a rigid body with six degrees of freedom; `slot` is its first index among the load's forces.
    Stations { slot: usize, body: usize, stations: Vec<SurfaceStation> },
    /// Faces of deformable elements (with capacity for faces that become exposed), and the estimate of the load's
    /// stiffness.
    Faces { skin: DeformableFaces, watch: StiffnessMonitor },
    /// Deformable elements by their corner nodes; axis of the force.
    Elements { corners: Vec<[u32; 4]>, axis: usize },
}

impl SurfaceMap {
    pub(super) fn bytes(&self) -> usize {
        match self {
            SurfaceMap::Body { weight, z_start, elements, .. } => {
                8 * (weight.capacity() + z_start.capacity() + elements.capacity())
            }
            SurfaceMap::Stations { stations, .. } => heap_bytes(stations),
            SurfaceMap::Faces { skin, watch } => skin.bytes() + watch.bytes(),
            SurfaceMap::Elements { corners, .. } => heap_bytes(corners),
        }
    }
}

/// Returns the mean of a nodal quantity over the corners of an element.
fn corner_mean(element: [u32; 4], of: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
    let c = element.inline_map(|n| of(n as usize));
    [0, 1].inline_map(|k| 0.25 * ((c[0][k] + c[1][k]) + (c[2][k] + c[3][k])))
}

/// Point of a rigid body that moves along z.
struct RigidPoint {
    element: usize,
    place: [f64; 2],
    normal: [f64; 2],
    /// Force along z per pressure, or volume of a solid.
    weight: f64,
}

impl PointBlock {
    pub(super) fn of_facets(load: &UserLoadData, slot: usize, body: usize, facets: &[(usize, Facet)]) -> PointBlock {
        let points = facets.iter().map(|(element, f)| RigidPoint {
            element: *element,
            place: f.middle(),
            normal: f.normal,
            weight: -f.area * f.normal[1],
        });
        PointBlock::of_body(load, slot, body, points.collect())
    }

    pub(super) fn of_solids(load: &UserLoadData, slot: usize, solids: &[RigidSolid]) -> PointBlock {
        let points = solids.iter().map(|&RigidSolid { element, centre, volume, .. }| RigidPoint {
            element,
            place: centre,
            normal: [0.0; 2],
            weight: volume,
        });
        PointBlock::of_body(load, slot, solids[0].body, points.collect())
    }

    fn of_body(load: &UserLoadData, slot: usize, body: usize, points: Vec<RigidPoint>) -> PointBlock {
        let n = points.len();
        let mut view = SurfaceView::new(n, n);
        for (i, &RigidPoint { place, normal, .. }) in points.iter().enumerate() {
            view.coordinates[i] = place[0];
            view.coordinates[n + i] = place[1];
            view.set_normal(i, normal, load.inward);
        }
        let map = SurfaceMap::Body {
            slot,
            body,
            weight: points.iter().map(|p| p.weight).collect(),
            z_start: points.iter().map(|p| p.place[1]).collect(),
            elements: points.iter().map(|p| p.element).collect(),
        };
        let pressure_before = (0..=MAX_BLOCK).map(|i| if i < n { 0.0 } else { f64::NAN }).collect();
        PointBlock { map, view, pressure_before }
    }

    pub(super) fn of_stations(slot: usize, body: usize, stations: &[SurfaceStation]) -> PointBlock {
        let map = SurfaceMap::Stations { slot, body, stations: stations.to_vec() };
        let pressure_before = (0..=MAX_BLOCK).map(|i| if i < stations.len() { 0.0 } else { f64::NAN }).collect();
        PointBlock { map, view: SurfaceView::new(stations.len(), stations.len()), pressure_before }
    }

    /// Creates a block of faces of deformable elements, with capacity for `most` faces.
    pub(super) fn of_faces(mut skin: DeformableFaces, most: usize) -> PointBlock {
        let watch = StiffnessMonitor::new(most);
        let view = SurfaceView::new(skin.faces.len(), most);
        skin.reserve(most - skin.faces.len());
        PointBlock { map: SurfaceMap::Faces { skin, watch }, view, pressure_before: Vec::new() }
    }

    /// Adds a face that has become exposed.
    pub(super) fn add_face(&mut self, (face, element): ([usize; 2], usize)) {
        let SurfaceMap::Faces { skin, .. } = &mut self.map else { return };
        skin.push(face, element);
        self.view.resize(skin.faces.len());
    }

    /// Removes all faces after the first `count`.
    pub(super) fn cut(&mut self, count: usize) {
        if let SurfaceMap::Faces { skin, .. } = &mut self.map
            && skin.faces.len() > count
        {
            skin.truncate(count);
            self.view.resize(count);
        }
    }

    pub(super) fn of_elements(load: &UserLoadData, elements: &[[u32; 4]]) -> PointBlock {
        let mut view = SurfaceView::new(elements.len(), elements.len());
        (0..elements.len()).for_each(|i| view.set_normal(i, [0.0; 2], false));
        let axis = if load.load_type == 1 { 0 } else { 1 };
        let map = SurfaceMap::Elements { corners: elements.to_vec(), axis };
        PointBlock { map, view, pressure_before: Vec::new() }
    }

    /// Returns the index of the block's force among the load's forces on bodies.
    pub(super) fn slot(&self) -> usize {
        if let SurfaceMap::Body { slot, .. } | SurfaceMap::Stations { slot, .. } = self.map { slot } else { 0 }
    }

    /// Returns the rigid body of the points.
    #[inline]
    pub(super) fn body(&self) -> usize {
        if let SurfaceMap::Body { body, .. } | SurfaceMap::Stations { body, .. } = self.map { body } else { 0 }
    }

    pub(super) fn arrays(&self) -> Vec<(&'static str, usize)> {
        let mut arrays = self.view.arrays();
        arrays.push(("value", 8 * self.pressure_before.capacity()));
        arrays
    }

    /// Calls the subroutine for points of a rigid body and returns the sum of the forces along z. `first` is the number
    /// of points in previous blocks.
    #[inline]
    pub(super) fn on_body(
        &mut self,
        load: &UserLoadData,
        scene: &SceneView<'_>,
        routine: &mut dyn crate::routines::UserLoad,
        first: usize,
    ) -> Result<f64, HaltReason> {
        self.swap_pressures();
        let SurfaceMap::Body { body, weight, z_start, .. } = &self.map else { return Ok(0.0) };
        show_body(&mut self.view, z_start, &scene.dofs.bodies[*body], load.reads_motion);
        let called = self.view.call(load, &scene.clock, routine);
        let force = dot(self.view.pressure(), weight);
        let accepted = called.and_then(|()| self.view.accept(force.is_finite()));
        accepted.map_err(|failure| self.view.failure(load, first, &scene.clock.now, &failure))?;
        Ok(force)
    }

    /// Calls the subroutine for stations of a rigid body with six degrees of freedom and returns the sum of forces and
    /// moments. `first` is the number of points in previous blocks.
    pub(super) fn on_stations(
        &mut self,
        load: &UserLoadData,
        scene: &SceneView<'_>,
        routine: &mut dyn crate::routines::UserLoad,
        (first, body): (usize, &RigidBody3d),
    ) -> Result<Wrench, HaltReason> {
        self.swap_pressures();
        let SurfaceMap::Stations { stations, .. } = &self.map else { return Ok(Wrench::default()) };
        self.view.clear_pressure();
        for (i, station) in stations.iter().enumerate() {
            let point = station.in_plane(body);
            self.view.set_point(i, point.place, point.start, point.velocity, point.acceleration);
            self.view.set_normal(i, point.normal, load.inward);
        }
        let called = self.view.call(load, &scene.clock, routine);
        let mut sum = Wrench::default();
        let loaded = stations.iter().zip(self.view.pressure());
        loaded.for_each(|(station, &pressure)| sum.add(&station.pressure_wrench(body, pressure)));
        let accepted = called.and_then(|()| self.view.accept(sum.is_finite()));
        accepted.map_err(|failure| self.view.failure(load, first, &scene.clock.now, &failure))?;
        Ok(sum)
    }

    pub(super) fn swap_pressures(&mut self) {
        std::mem::swap(&mut self.view.pressure, &mut self.pressure_before);
    }

    /// Calls the subroutine for points of deformable bodies and adds the nodal forces. `first` is the number of points
    /// in previous blocks.
    pub(super) fn on_nodes(
        &mut self,
        load: &UserLoadData,
        scene: &SceneView<'_>,
        routine: &mut dyn crate::routines::UserLoad,
        first: usize,
        forces: &mut [[f64; 2]],
    ) -> Result<(), HaltReason> {
        if self.view.is_empty() {
            return Ok(());
        }
        self.show_nodes(load, scene);
        let finite = |view: &SurfaceView| view.pressure().iter().all(|p| p.is_finite());
        let called = self.view.call(load, &scene.clock, routine);
        let accepted = called.and_then(|()| self.view.accept(finite(&self.view)));
        accepted.map_err(|failure: LoadFailure| self.view.failure(load, first, &scene.clock.now, &failure))?;
        self.add(&scene.dofs.nodes, scene.rings, forces);
        self.watch(scene, first);
        Ok(())
    }

    /// Records positions and pressures of the loaded faces for the estimate of the load's stiffness.
    fn watch(&mut self, scene: &SceneView<'_>, first: usize) {
        let (nodes, increment) = (&scene.dofs.nodes, scene.dofs.nodes.unaccounted_dt());
        let SurfaceMap::Faces { skin, watch, .. } = &mut self.map else { return };
        for (i, &face) in skin.faces.iter().enumerate().filter(|(i, _)| skin.is_active[*i]) {
            let face = CurrentFace::new(face, nodes);
            let shell = skin.shells.get(i).copied().unwrap_or(false);
            let unit = face_forces(&face, shell, 1.0, scene.rings);
            let [a, b] = [0, 1].inline_map(|k| unit[k][0].portable_hypot(unit[k][1]) / nodes.mass[face.nodes[k]]);
            let pressure = self.view.pressure[i];
            let sample = FaceSample { place: face.middle(), normal: face.normal, pressure, mobility: a.max(b) };
            watch.sample(i, &sample, increment, first + i, scene.clock.now.total_time);
        }
    }

    /// Allocates the memory of the load.
    pub(super) fn reserve_memory(&mut self, per_point: usize) {
        self.view.reserve_memory(per_point);
    }

    /// Copies the memory of the points of a rigid body from the same block of the replaced load.
    pub(super) fn continue_points(&mut self, previous: &PointBlock) {
        if self.body() == previous.body() && self.view.pressure().len() == previous.view.pressure().len() {
            (0..self.view.pressure().len()).for_each(|i| self.view.continue_memory(i, &previous.view, i));
        }
    }

    /// Copies the history of the faces that this block shares with a block of the replaced load.
    pub(super) fn continue_from(&mut self, previous: &PointBlock) {
        let SurfaceMap::Faces { skin, watch, .. } = &mut self.map else { return };
        let SurfaceMap::Faces { skin: known, watch: before, .. } = &previous.map else { return };
        for (i, face) in skin.faces.iter().enumerate() {
            if let Some(at) = known.faces.iter().position(|f| f == face) {
                watch.continue_from(i, before, at);
                self.view.continue_memory(i, &previous.view, at);
            }
        }
    }

    /// Returns the middles of the faces or elements of deformable bodies.
    pub(super) fn middles(&self, nodes: &Nodes) -> Vec<[f64; 2]> {
        match &self.map {
            SurfaceMap::Body { .. } | SurfaceMap::Stations { .. } => Vec::new(),
            SurfaceMap::Faces { skin, .. } => {
                skin.faces.iter().map(|face| CurrentFace::new(*face, nodes).middle()).collect()
            }
            SurfaceMap::Elements { corners, .. } => {
                corners.iter().map(|element| corner_mean(*element, |n| nodes[n].place())).collect()
            }
        }
    }

    /// Takes the stiffness that a block of the same load has shown on a previous mesh.
    pub(super) fn keep_stiffness(&mut self, stiffest: Option<&LoadStiffness>) {
        if let SurfaceMap::Faces { watch, .. } = &mut self.map {
            watch.keep(stiffest);
        }
    }

    /// Copies the memory of a point from one of the same load on a previous mesh.
    pub(super) fn continue_point(&mut self, point: usize, previous: &PointBlock, previous_point: usize) {
        self.view.continue_memory(point, &previous.view, previous_point);
    }

    pub(super) fn stiffness(&self) -> Option<&LoadStiffness> {
        if let SurfaceMap::Faces { watch, .. } = &self.map { watch.stiffest() } else { None }
    }

    /// Updates the arrays to the current instant and clears the pressures.
    fn show_nodes(&mut self, load: &UserLoadData, scene: &SceneView<'_>) {
        let (nodes, view) = (&scene.dofs.nodes, &mut self.view);
        view.clear_pressure();
        match &self.map {
            SurfaceMap::Body { .. } | SurfaceMap::Stations { .. } => {}
            SurfaceMap::Faces { skin, .. } => {
                for (i, &face) in skin.faces.iter().enumerate() {
                    let face = CurrentFace::new(face, nodes);
                    let (start, acceleration) = (face.mean(|n| nodes.start[n]), face.mean(|n| nodes.acceleration[n]));
                    view.set_point(i, face.middle(), start, face.mean(|n| scene.velocity(n)), acceleration);
                    view.set_normal(i, face.normal, load.inward);
                }
            }
            SurfaceMap::Elements { corners, .. } => {
                for (i, &element) in corners.iter().enumerate() {
                    let [place, start] =
                        [corner_mean(element, |n| nodes[n].place()), corner_mean(element, |n| nodes.start[n])];
                    let velocity = corner_mean(element, |n| scene.velocity(n));
                    view.set_point(i, place, start, velocity, corner_mean(element, |n| nodes.acceleration[n]));
                }
            }
        }
    }

    fn add(&self, nodes: &Nodes, rings: Option<&[f64]>, forces: &mut [[f64; 2]]) {
        match &self.map {
            SurfaceMap::Body { .. } | SurfaceMap::Stations { .. } => {}
            SurfaceMap::Faces { skin, .. } => {
                let shell = |i: usize| skin.shells.get(i).copied().unwrap_or(false);
                let loaded = skin.faces.iter().zip(self.view.pressure()).zip(&skin.is_active).enumerate();
                for (i, ((&face, &pressure), _)) in loaded.filter(|face| *face.1.1) {
                    add_pressure(&CurrentFace::new(face, nodes), shell(i), pressure, rings, forces);
                }
            }
            SurfaceMap::Elements { corners, axis, .. } => {
                for (element, &force) in corners.iter().zip(self.view.pressure()) {
                    for (&node, volume) in element.iter().zip(corner_volumes(element, nodes, rings)) {
                        forces[node as usize][*axis] += force * volume;
                    }
                }
            }
        }
    }

    pub(super) fn show_fields(&self, dofs: &Dofs, fields: &mut FacetFields) {
        match &self.map {
            SurfaceMap::Body { body, elements, .. } => {
                let velocity = dofs.bodies[*body].velocity;
                for ((&e, &pressure), n) in elements.iter().zip(self.view.pressure()).zip(&self.view.normal_z) {
                    fields.push(e, pressure, n * velocity);
                }
            }
            SurfaceMap::Stations { body, stations, .. } => {
                let Some(body) = &dofs.bodies[*body].spatial else { return };
                for (station, &pressure) in stations.iter().zip(self.view.pressure()) {
                    fields.push_station(station.element, station.area, [pressure, station.normal_velocity(body)]);
                }
            }
            SurfaceMap::Faces { skin, .. } => {
                let faces = skin.faces.iter().zip(&skin.elements).zip(&skin.is_active);
                for (((&face, &e), &carries), &pressure) in faces.zip(self.view.pressure()) {
                    let velocity = CurrentFace::new(face, &dofs.nodes).normal_velocity(&dofs.nodes);
                    fields.push(e, if carries { pressure } else { 0.0 }, velocity);
                }
            }
            SurfaceMap::Elements { .. } => {}
        }
    }
}

/// Updates the arrays of points on a rigid body to the current instant and clears the pressures, in one pass: for few
/// facets, several passes would cost more than the writes.
#[inline]
fn show_body(view: &mut SurfaceView, z_start: &[f64], body: &BodyState, all: bool) {
    let n = z_start.len();
    let SurfaceView { coordinates, motion, pressure, .. } = view;
    let (z, v) = (&mut coordinates[n..2 * n], &mut motion[n..2 * n]);
    // Four at a time: each tile is read before it is written, so the compiler need not check whether the arrays
    // overlap.
    let tiles = z.as_chunks_mut::<4>().0.iter_mut().zip(v.as_chunks_mut::<4>().0);
    let tiles = tiles.zip(pressure.as_chunks_mut::<4>().0).zip(z_start.as_chunks::<4>().0);
    for (((z, v), pressure), start) in tiles {
        *z = start.inline_map(|start| start + body.displacement);
        *v = [body.velocity_load; 4];
        *pressure = [f64::NAN; 4];
    }
    for i in n / 4 * 4..n {
        z[i] = z_start[i] + body.displacement;
        v[i] = body.velocity_load;
        pressure[i] = f64::NAN;
    }
    if all {
        motion[3 * n..4 * n].fill(body.displacement);
        motion[5 * n..].fill(body.acceleration);
    }
}

/// Returns the dot product in eight interleaved partial sums: the same bits on every instruction set, and no serial
/// chain of additions.
#[allow(clippy::needless_range_loop)] // Constant indices keep the sums in registers.
#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_tiles, a_rest) = a.as_chunks::<8>();
    let (b_tiles, b_rest) = b.as_chunks::<8>();
    for (x, y) in a_tiles.iter().zip(b_tiles) {
        for lane in 0..8 {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    let tile = a_rest.first_chunk::<4>().zip(b_rest.first_chunk::<4>());
    if let Some((x, y)) = tile {
        for lane in 0..4 {
            lanes[lane] += x[lane] * y[lane];
        }
        for lane in 4..7 {
            if let (Some(x), Some(y)) = (a_rest.get(lane), b_rest.get(lane)) {
                lanes[lane] += x * y;
            }
        }
    } else {
        for lane in 0..3 {
            if let (Some(x), Some(y)) = (a_rest.get(lane), b_rest.get(lane)) {
                lanes[lane] += x * y;
            }
        }
    }
    ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]))
}

impl Persist for SurfaceMap {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        if let SurfaceMap::Faces { skin, watch } = self {
            persist_fields!(archive; skin, watch);
        }
    }
}
