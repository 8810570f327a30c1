//! Transport of mass and element variables through the edges of a domain whose nodes move while the material rests:
//! swept rings with linear reconstruction (van Leer 1979, J. Comput. Phys. 32, 101), limited by
//! [`limiter`](super::limiter). Only elements with a corner that moves are computed.

use pulp::NullaryFnOnce;

use super::active::{ActiveParts, MeshChange, marked};
use super::geometry::{centre, share_of_first, swept};
use super::limiter::{ElementFlow, larger, smaller};
use super::topology::{DomainEdge, DomainTopology, ElementSide};
use crate::kernel::lanes::{InlineMap, PACK, Pack};
use crate::kernel::lists::Memory;
use crate::kernel::quad;
use crate::kernel::volume_balance::VolumeBalance;

/// Order of the transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportOrder {
    /// The value of the donor.
    First,
    /// Linear reconstruction in the donor.
    Second,
}

/// What passes through an edge to the element on its left.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EdgeFlux {
    volume: f64,
    pub mass: f64,
    /// Centre of the swept ring.
    middle: [f64; 2],
    /// Share of the ring that belongs to the first end of the edge.
    pub first: f64,
}

impl EdgeFlux {
    /// Returns whether the element on the right loses the ring.
    fn leaves_right(&self) -> bool {
        self.volume > 0.0
    }
}

/// Volume and centre of an element before the motion, and the density of the quantity that moves.
#[derive(Clone, Copy, Debug, Default)]
struct ElementPlace {
    volume: f64,
    centre: [f64; 2],
    density: f64,
}

/// Transport of the elements of a domain, and its work arrays.
#[derive(Clone, Debug, Memory)]
pub(super) struct ElementTransport {
    order: TransportOrder,
    places: Vec<ElementPlace>,
    fluxes: Vec<EdgeFlux>,
    flows: Vec<ElementFlow>,
    density_slopes: Vec<[f64; 2]>,
    /// Rings that edges on closed boundaries sweep at each element, and the flows that provide them. `None` if the domain
    /// has Eulerian boundaries: along the walls of a steady flow the same elements would take mass in each change, from the
    /// inflow, too.
    swept_rings: Option<SweptRings>,
    /// Gradients and new values of a pack.
    gradients: Vec<[Pack; 2]>,
    moved: Vec<Pack>,
}

/// Rings that edges on closed boundaries sweep, and flows between elements that provide them.
#[derive(Clone, Debug, Memory)]
struct SweptRings {
    /// Volumes of the rings at each element.
    volumes: Vec<f64>,
    balance: VolumeBalance,
}

impl SweptRings {
    fn new(cells: usize) -> SweptRings {
        SweptRings { volumes: vec![0.0; cells], balance: VolumeBalance::new(cells, FLOW_ACCURACY) }
    }
}

/// Accuracy of the flows that provide swept rings, relative to the largest one.
const FLOW_ACCURACY: f64 = 0.02;

/// Relative increase of the sums of squares, which keeps them regular for neighbours in one line.
const REGULAR: f64 = 1e-9;

impl ElementTransport {
    pub fn new(domain: &DomainTopology, order: TransportOrder) -> ElementTransport {
        let (cells, edges) = (domain.corners.len(), domain.edges.len());
        ElementTransport {
            order,
            places: vec![ElementPlace::default(); cells],
            fluxes: vec![EdgeFlux::default(); edges],
            flows: vec![ElementFlow::default(); cells],
            density_slopes: vec![[0.0; 2]; cells],
            swept_rings: (!domain.edges.iter().any(|edge| edge.is_open)).then(|| SweptRings::new(cells)),
            gradients: vec![[Pack::default(); 2]; cells],
            moved: vec![Pack::default(); cells],
        }
    }

    /// Measures the rings that edges sweep from the places `before` to `after`. Returns the largest share of its volume
    /// that an element loses. Equation (18.14).
    pub fn measure(&mut self, change: MeshChange<'_>, [before, after]: [&[[f64; 2]]; 2]) -> f64 {
        let MeshChange { domain, active, loops } = change;
        loops.each(&mut self.places, |start, part| {
            for (e, place) in marked(part, start, &active.reads) {
                let corners = domain.corners[e].inline_map(|n| before[n as usize]);
                (place.volume, place.centre) = (quad::volume(corners), centre(corners));
            }
        });
        let places = &self.places;
        loops.each(&mut self.fluxes, |start, part| {
            for (flux, edge) in part.iter_mut().zip(&domain.edges[start..]) {
                *flux = measured(edge, active, [before, after]);
                if edge.is_open && flux.leaves_right() {
                    // What enters through an Eulerian boundary has the mean values of the element there.
                    flux.middle = places[edge.left as usize].centre;
                }
            }
        });
        self.provide_swept_rings(change, [before, after]);
        let ElementTransport { places, fluxes, flows, order, .. } = self;
        let (places, fluxes, second) = (&*places, &*fluxes, *order == TransportOrder::Second);
        loops.combined(flows, (0.0, larger), |start, part| {
            let mut largest_share = 0.0;
            for (e, flow) in marked(part, start, &active.changes) {
                let sides = &domain.sides[e];
                if second {
                    flow.slopes = slopes(places, e, sides);
                }
                let lost = flow_of_volumes(flow, places, fluxes, (e, sides));
                largest_share = larger(largest_share, lost / places[e].volume);
            }
            largest_share
        })
    }

    /// Adds flows between elements that provide the rings which edges on closed boundaries sweep: a node that slides along
    /// a bent outline gives one element a volume, and takes it from the next one, without material.
    fn provide_swept_rings(&mut self, change: MeshChange<'_>, [before, after]: [&[[f64; 2]]; 2]) {
        let MeshChange { domain, active, .. } = change;
        let Some(SweptRings { volumes, balance }) = &mut self.swept_rings else { return };
        volumes.fill(0.0);
        let moves = |edge: &DomainEdge| edge.nodes.iter().any(|n| active.moves[*n as usize]);
        for edge in domain.edges.iter().filter(|edge| !edge.is_passed() && moves(edge)) {
            let [start, end] = [before, after].inline_map(|places| edge.nodes.inline_map(|n| places[n as usize]));
            volumes[edge.left as usize] += swept(start, end).0;
        }
        let sides = |edge: &DomainEdge| [edge.left as usize, edge.right as usize];
        let links = |edge: &DomainEdge| edge.is_inner() && sides(edge).iter().all(|e| active.changes[*e]);
        let places = &self.places;
        let volume = |e: usize| places[e].volume;
        if !balance.solve(domain.edges.iter().filter(|edge| links(edge)).map(sides), volume, volumes) {
            return;
        }
        for (flux, edge) in self.fluxes.iter_mut().zip(&domain.edges).filter(|(_, edge)| links(edge)) {
            if !moves(edge) {
                let [a, b] = edge.nodes.inline_map(|n| before[n as usize]);
                *flux = EdgeFlux { middle: swept([a, b], [a, b]).1, first: share_of_first(a[0], b[0]), ..*flux };
            }
            flux.volume += balance.flow(sides(edge), volume);
        }
    }

    /// Moves masses, given before the motion, through the measured rings.
    pub fn move_masses(&mut self, change: MeshChange<'_>, masses: &mut [f64]) {
        self.move_content(change, masses);
        let (masses, fluxes) = (&*masses, &self.fluxes);
        change.loops.each(&mut self.flows, |start, part| {
            for (e, flow) in marked(part, start, &change.active.changes) {
                flow_of_masses(flow, fluxes, &change.domain.sides[e], masses[e]);
            }
        });
    }

    /// Moves a quantity of the elements, given before the motion, through the measured rings. [`EdgeFlux::mass`] is then
    /// the part of the quantity that passes. Equal fractions of masses and of another quantity move where both have the same ratio
    /// in all elements. Precedes [`Self::move_masses`]. Equation (18.5).
    pub fn move_content(&mut self, change: MeshChange<'_>, content: &mut [f64]) {
        let MeshChange { domain, active, loops } = change;
        for ((place, amount), _) in self.places.iter_mut().zip(&*content).zip(&active.reads).filter(|e| *e.1) {
            place.density = amount / place.volume;
        }
        let (places, flows) = (&self.places, &self.flows);
        let density = |e: u32| [places[e as usize].density];
        loops.each(&mut self.density_slopes, |start, part| {
            for (e, slope) in marked(part, start, &active.changes) {
                let around = domain.sides[e].inline_map(|side| density(side.beside));
                let around = [&around[0], &around[1], &around[2], &around[3]];
                let ([[along_r], [along_z]], _) = flows[e].gradient(&density(e as u32), around);
                *slope = [along_r, along_z];
            }
        });
        let slopes = &self.density_slopes;
        loops.each(&mut self.fluxes, |start, part| {
            for (flux, edge) in part.iter_mut().zip(&domain.edges[start..]).filter(|(flux, _)| flux.volume != 0.0) {
                let donor = if flux.leaves_right() { edge.right } else { edge.left } as usize;
                let (donor_place, [along_r, along_z]) = (&places[donor], slopes[donor]);
                let [r, z] = [0, 1].inline_map(|i: usize| flux.middle[i] - donor_place.centre[i]);
                flux.mass = flux.volume * (donor_place.density + (along_r * r + along_z * z));
            }
        });
        let fluxes = &self.fluxes;
        loops.each(content, |start, part| {
            for (e, amount) in marked(part, start, &active.changes) {
                let sides = &domain.sides[e];
                *amount += sides.iter().map(|side| fluxes[side.edge as usize].entering(side)).sum::<f64>();
            }
        });
    }

    /// Moves variables, per mass, with the masses that [`Self::move_masses`] has moved. Equation (18.5).
    pub fn move_variables(&mut self, change: MeshChange<'_>, values: &mut [Pack]) {
        let MeshChange { domain, active, loops } = change;
        let inputs = PackInputs { flows: &self.flows, active, domain, values };
        let range = loops.combined(&mut self.gradients, (EMPTY, joined), |start, part| {
            loops.arch.dispatch(PackGradients { inputs, start, part })
        });
        let gradients = &self.gradients;
        loops.each(&mut self.moved, |start, part| {
            loops.arch.dispatch(PackMotion { inputs, gradients, range, start, part });
        });
        let moved = &self.moved;
        loops.each(values, |start, part| {
            for (e, value) in marked(part, start, &active.changes) {
                *value = moved[e];
            }
        });
    }

    /// Returns what passes through each edge.
    pub fn fluxes(&self) -> &[EdgeFlux] {
        &self.fluxes
    }
}

impl EdgeFlux {
    /// Returns the mass that enters an element through a side.
    pub fn entering(&self, side: &ElementSide) -> f64 {
        if side.is_left { self.mass } else { -self.mass }
    }
}

fn measured(edge: &DomainEdge, active: &ActiveParts, [before, after]: [&[[f64; 2]]; 2]) -> EdgeFlux {
    let [a, b] = edge.nodes.inline_map(|n| n as usize);
    if !(edge.is_passed() && (active.moves[a] || active.moves[b])) {
        return EdgeFlux::default();
    }
    let (volume, middle) = swept([before[a], before[b]], [after[a], after[b]]);
    EdgeFlux { volume, mass: 0.0, middle, first: share_of_first(before[a][0], before[b][0]) }
}

/// Finds the gradients for unit differences to the neighbours by least squares.
fn slopes(places: &[ElementPlace], e: usize, sides: &[ElementSide; 4]) -> [[f64; 2]; 4] {
    let own_centre = places[e].centre;
    let apart = sides.inline_map(|side| {
        let centre = places[side.beside as usize].centre;
        [centre[0] - own_centre[0], centre[1] - own_centre[1]]
    });
    let sum = |x: [f64; 4]| (x[0] + x[1]) + (x[2] + x[3]);
    let [rr, zz, rz] = [
        sum(apart.inline_map(|d| d[0] * d[0])),
        sum(apart.inline_map(|d| d[1] * d[1])),
        sum(apart.inline_map(|d| d[0] * d[1])),
    ];
    let more = REGULAR * (rr + zz);
    let (rr, zz) = (rr + more, zz + more);
    let determinant = rr * zz - rz * rz;
    if determinant > 0.0 {
        let per = 1.0 / determinant;
        apart.inline_map(|[r, z]| [per * (zz * r - rz * z), per * (rr * z - rz * r)])
    } else {
        [[0.0; 2]; 4]
    }
}

/// Sets the flow of volumes. Returns the volume that the element loses.
fn flow_of_volumes(
    flow: &mut ElementFlow,
    places: &[ElementPlace],
    fluxes: &[EdgeFlux],
    (e, sides): (usize, &[ElementSide; 4]),
) -> f64 {
    let (volume, mut lost, mut moment, mut gained) = (places[e].volume, 0.0, [0.0; 2], 0.0);
    for (i, side) in sides.iter().enumerate() {
        let flux = &fluxes[side.edge as usize];
        let entering = if side.is_left { flux.volume } else { -flux.volume };
        let donor = places[if entering > 0.0 { side.beside as usize } else { e }].centre;
        flow.inflow[i] = entering;
        flow.places[i] = [flux.middle[0] - donor[0], flux.middle[1] - donor[1]];
        gained += entering;
        if entering < 0.0 {
            lost -= entering;
            moment = [0, 1].inline_map(|k: usize| moment[k] + entering * flow.places[i][k]);
        }
    }
    flow.rest = centre_of_rest(moment, volume - lost);
    flow.inflow = flow.inflow.inline_map(|entering| entering / (volume + gained));
    lost
}

fn flow_of_masses(flow: &mut ElementFlow, fluxes: &[EdgeFlux], sides: &[ElementSide; 4], mass: f64) {
    let (mut remaining_mass, mut moment) = (mass, [0.0; 2]);
    for (i, side) in sides.iter().enumerate() {
        let entering = fluxes[side.edge as usize].entering(side);
        if entering > 0.0 {
            remaining_mass -= entering;
        } else {
            moment = [0, 1].inline_map(|k: usize| moment[k] + entering * flow.places[i][k]);
        }
        flow.inflow[i] = entering / mass;
    }
    flow.rest = centre_of_rest(moment, remaining_mass);
}

fn centre_of_rest(moment: [f64; 2], weight: f64) -> [f64; 2] {
    if weight > 0.0 { moment.inline_map(|x| x / weight) } else { [0.0; 2] }
}

/// Smallest and largest values.
type PackRange = [Pack; 2];

const EMPTY: PackRange = [Pack([f64::INFINITY; PACK]), Pack([f64::NEG_INFINITY; PACK])];

#[inline(always)]
fn joined([mut low, mut high]: PackRange, [other_low, other_high]: PackRange) -> PackRange {
    for l in 0..PACK {
        low.0[l] = smaller(low.0[l], other_low.0[l]);
        high.0[l] = larger(high.0[l], other_high.0[l]);
    }
    [low, high]
}

/// Variables of elements before a motion, and what passes between the elements.
#[derive(Clone, Copy)]
struct PackInputs<'a> {
    flows: &'a [ElementFlow],
    active: &'a ActiveParts,
    domain: &'a DomainTopology,
    values: &'a [Pack],
}

impl<'a> PackInputs<'a> {
    #[inline(always)]
    fn beside(&self, side: ElementSide) -> &'a [f64; PACK] {
        &self.values[side.beside as usize].0
    }

    /// Returns the values of an element and their gradients.
    #[inline(always)]
    fn field(&self, e: u32, gradients: &'a [[Pack; 2]]) -> (&'a [f64; PACK], [&'a [f64; PACK]; 2]) {
        let [along_r, along_z] = &gradients[e as usize];
        (&self.values[e as usize].0, [&along_r.0, &along_z.0])
    }
}

/// Limited gradients of a part of the elements; returns the range of the values around them.
struct PackGradients<'a> {
    inputs: PackInputs<'a>,
    start: usize,
    part: &'a mut [[Pack; 2]],
}

impl NullaryFnOnce for PackGradients<'_> {
    type Output = PackRange;

    #[inline(always)]
    fn call(self) -> PackRange {
        let PackGradients { inputs, start, part } = self;
        let mut range = EMPTY;
        for (at, gradient) in part.iter_mut().enumerate() {
            let e = start + at;
            if !inputs.active.changes[e] {
                continue;
            }
            let [a, b, c, d] = inputs.domain.sides[e];
            let around = [inputs.beside(a), inputs.beside(b), inputs.beside(c), inputs.beside(d)];
            let (new_gradient, [low, high]) = inputs.flows[e].gradient(&inputs.values[e].0, around);
            *gradient = [Pack(new_gradient[0]), Pack(new_gradient[1])];
            range = joined(range, [Pack(low), Pack(high)]);
        }
        range
    }
}

/// Values of a part of the elements after the motion.
struct PackMotion<'a> {
    inputs: PackInputs<'a>,
    gradients: &'a [[Pack; 2]],
    range: PackRange,
    start: usize,
    part: &'a mut [Pack],
}

impl NullaryFnOnce for PackMotion<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let PackMotion { inputs, gradients, range: [Pack(low), Pack(high)], start, part } = self;
        for (at, moved) in part.iter_mut().enumerate() {
            let e = start + at;
            if !inputs.active.changes[e] {
                continue;
            }
            let [a, b, c, d] = inputs.domain.sides[e];
            let around = [
                inputs.field(a.beside, gradients),
                inputs.field(b.beside, gradients),
                inputs.field(c.beside, gradients),
                inputs.field(d.beside, gradients),
            ];
            let new = inputs.flows[e].moved(inputs.field(e as u32, gradients), around);
            // Rounding may exceed the range by a last bit.
            for l in 0..PACK {
                moved.0[l] = larger(smaller(new[l], high[l]), low[l]);
            }
        }
    }
}
