//! Conservation, accuracy and bounds of the transport, on meshes that move through material at rest.

use super::active::{ActiveParts, MeshChange};
use super::corner_masses;
use super::geometry::centre;
use super::held_places::HeldPlaces;
use super::momentum::MomentumTransport;
use super::smoothing::{BoundaryContact, MeshSmoothing, NodeMobility, SmoothingWeights, Surroundings};
use super::topology::DomainTopology;
use super::transport::{ElementTransport, TransportOrder};
use crate::element::constants::{ElementConstants, HourglassControl};
use crate::element::quad::QuadGroup;
use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::kernel::chunks::ChunkLoops;
use crate::kernel::lanes::{PACK, Pack};
use crate::kernel::quad;
use crate::kernel::shape::smallest_angle;
use crate::material::plasticity::ElasticOnly;
use crate::material::volumetric::ConstantBulkModulus;
use crate::material::von_mises::VonMises;
use crate::state::nodes::Node;

/// A square section of n by n elements of a thick ring, or of a cylinder with the axis; each may be two triangles.
struct Section {
    topology: DomainTopology,
    places: Vec<[f64; 2]>,
}

impl Section {
    fn new(n: usize, inner: f64) -> Section {
        Section::of(n, inner, false)
    }

    fn of(n: usize, inner: f64, triangles: bool) -> Section {
        let side = n + 1;
        let place_of = |i: usize| [inner + (i % side) as f64 / n as f64, (i / side) as f64 / n as f64];
        let places: Vec<[f64; 2]> = (0..side * side).map(place_of).collect();
        let nodes: Vec<Node> = places.iter().map(|[r, z]| Node { r: *r, z: *z, ..Node::default() }).collect();
        let corner = |e: usize| {
            let first = (e / n * side + e % n) as u32;
            [first, first + 1, first + side as u32 + 1, first + side as u32]
        };
        let mut elements: Vec<[u32; 4]> = (0..n * n).map(corner).collect();
        if triangles {
            elements = elements.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c, *c], [*a, *c, *d, *d]]).collect();
        }
        let constants = ElementConstants {
            bulk: 3.0,
            shear: 1.0,
            hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.0, relaxes: true, enhanced: 0.0 },
            bulk_viscosity: BulkViscosity::NONE,
            shear_viscosity: 0.0,
            by_area: false,
        };
        let group = QuadGroup::new(VonMises::new(ElasticOnly, ConstantBulkModulus), constants, 1.0, &elements, &nodes);
        let topology = DomainTopology::new(&group, (0..elements.len() as u32).collect(), |_| false);
        Section { topology, places }
    }

    /// Returns the places of nodes in a vortex of the section; `phase` 0 and 1 are the initial places.
    fn in_vortex(&self, inner: f64, phase: f64) -> Vec<[f64; 2]> {
        let (pi, turn) = (std::f64::consts::PI, 0.12 * (std::f64::consts::PI * phase).sin());
        let moved = |[r, z]: &[f64; 2]| {
            let x = r - inner;
            let (s, t) = ((pi * x).sin(), (pi * z).sin());
            [r + turn * s * s * (2.0 * pi * z).sin(), z - turn * t * t * (2.0 * pi * x).sin()]
        };
        self.places.iter().map(moved).collect()
    }

    fn corners(&self, e: usize, places: &[[f64; 2]]) -> [[f64; 2]; 4] {
        self.topology.corners[e].map(|n| places[n as usize])
    }

    /// Returns masses and means of a value over elements, for a density.
    fn means(
        &self,
        places: &[[f64; 2]],
        density: impl Fn([f64; 2]) -> f64,
        value: impl Fn([f64; 2]) -> f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let mass_and_value = |e: usize| {
            let corners = self.corners(e, places);
            let middle = centre(corners);
            (density(middle) * quad::volume(corners), value(middle))
        };
        (0..self.topology.corners.len()).map(mass_and_value).unzip()
    }
}

fn density([r, z]: [f64; 2]) -> f64 {
    2.0 + (3.0 * r).sin() * (2.0 * z).cos()
}

fn smooth([r, z]: [f64; 2]) -> f64 {
    1.0 + (4.0 * r + 1.0).sin() * (3.0 * z).cos()
}

const LOOPS: ChunkLoops = ChunkLoops { arch: pulp::Arch::Scalar, threads: false };

/// Moves a mesh through a vortex and back, and returns mass, values, and the means at the last places.
fn turn(section: &Section, inner: f64, order: TransportOrder, last: f64, value: fn([f64; 2]) -> f64) -> [Vec<f64>; 4] {
    turn_with(LOOPS, section, inner, (order, last), value)
}

fn turn_with(
    loops: ChunkLoops,
    section: &Section,
    inner: f64,
    (order, last): (TransportOrder, f64),
    value: fn([f64; 2]) -> f64,
) -> [Vec<f64>; 4] {
    let steps = 4 * (section.topology.corners.len() as f64).sqrt() as usize;
    let (mut mass, mut values) = section.means(&section.places, density, value);
    let mut transport = ElementTransport::new(&section.topology, order);
    let mut packs: Vec<Pack> = values.iter().map(|value| Pack([*value; PACK])).collect();
    let mut active = ActiveParts::new(&section.topology);
    for i in 0..steps {
        let [from, to] = [i, i + 1].map(|i| section.in_vortex(inner, last * i as f64 / steps as f64));
        assert!(active.find(&section.topology, [&from, &to]));
        let change = MeshChange { domain: &section.topology, active: &active, loops };
        let share = transport.measure(change, [&from, &to]);
        assert!(share < 0.5, "{share}");
        transport.move_masses(change, &mut mass);
        transport.move_variables(change, &mut packs);
    }
    values.iter_mut().zip(&packs).for_each(|(value, pack)| *value = pack.0[PACK - 1]);
    let (exact_mass, exact) = section.means(&section.in_vortex(inner, last), density, value);
    [mass, values, exact_mass, exact]
}

/// Threads and instruction sets give the same bits.
#[test]
fn transport_has_the_same_bits_with_threads() {
    let section = Section::new(40, 1.0);
    let with = |loops| turn_with(loops, &section, 1.0, (TransportOrder::Second, 0.5), smooth);
    let expected = with(LOOPS);
    assert_eq!(with(ChunkLoops { arch: pulp::Arch::new(), threads: true }), expected);
    assert_eq!(with(ChunkLoops { threads: true, ..LOOPS }), expected);
}

/// Elements away from the nodes that move keep their mass and values.
#[test]
fn transport_changes_only_elements_at_nodes_that_move() {
    let section = Section::new(10, 1.0);
    let (mut mass, values) = section.means(&section.places, density, smooth);
    let mut packs: Vec<Pack> = values.iter().map(|value| Pack([*value; PACK])).collect();
    let (mut moved_places, initial) = (section.places.clone(), (mass.clone(), packs.clone()));
    moved_places[60] = [moved_places[60][0] + 0.02, moved_places[60][1] - 0.01];
    let mut active = ActiveParts::new(&section.topology);
    assert!(active.find(&section.topology, [&section.places, &moved_places]));
    let change = MeshChange { domain: &section.topology, active: &active, loops: LOOPS };
    let mut transport = ElementTransport::new(&section.topology, TransportOrder::Second);
    transport.measure(change, [&section.places, &moved_places]);
    transport.move_masses(change, &mut mass);
    transport.move_variables(change, &mut packs);
    for (e, corners) in section.topology.corners.iter().enumerate() {
        let same = (mass[e], packs[e]) == (initial.0[e], initial.1[e]);
        assert_eq!(same, !corners.contains(&60), "element {e}");
    }
}

/// A mesh of triangles that is disturbed becomes regular by smoothing: no element stays flat, and the volume is the same.
#[test]
fn triangles_become_regular() {
    let section = Section::of(8, 0.0, true);
    let (topology, mut places) = (&section.topology, section.places.clone());
    let mobility: Vec<NodeMobility> =
        topology.inside.iter().map(|i| if *i { NodeMobility::Inside } else { NodeMobility::Fixed }).collect();
    for (i, place) in places.iter_mut().enumerate().filter(|(i, _)| topology.inside[*i]) {
        let shift = 0.045 * (7.0 * i as f64).sin();
        *place = [place[0] + shift, place[1] - 0.8 * shift];
    }
    let weights = SmoothingWeights { volumetric: 1.0, laplacian: 0.0, equipotential: 0.0 };
    let cosine = 30f64.to_radians().cos();
    let mut smoothing =
        MeshSmoothing::new((topology, &section.places), weights, None, cosine, (mobility, vec![false; places.len()]));
    let held_places = HeldPlaces::new(topology, Vec::new(), false);
    let volume = |places: &[[f64; 2]]| {
        (0..topology.corners.len()).map(|e| quad::volume(section.corners(e, places))).sum::<f64>()
    };
    let least = |places: &[[f64; 2]]| {
        let angles = topology.corners.iter().map(|corners| smallest_angle(corners, |n| places[n as usize]));
        angles.fold(f64::INFINITY, f64::min).to_degrees()
    };
    let initial = (least(&places), volume(&places));
    for _ in 0..100 {
        let die = FlatDie(places.iter().map(|[r, _]| [*r, 0.0]).collect());
        smoothing.restrict(topology, (&held_places.kept, &held_places), |_| false);
        smoothing.sweep(LOOPS, topology, &held_places, &die, &mut places);
    }
    assert!(initial.0 < 30.0 && least(&places) > 38.0, "{initial:?} {}", least(&places));
    assert!((volume(&places) / initial.1 - 1.0).abs() < 1e-13);
}

/// Order by the L1 norm; reference: the fields at rest.
#[test]
fn transport_of_smooth_fields_is_of_second_order() {
    for (inner, last) in [(0.0, 1.0), (1.0, 1.0), (0.0, 0.5)] {
        let errors = [20, 40, 80].map(|n| {
            let section = Section::new(n, inner);
            let [mass, values, exact_mass, exact] = turn(&section, inner, TransportOrder::Second, last, smooth);
            let whole: f64 = exact_mass.iter().sum();
            let density: f64 = mass.iter().zip(&exact_mass).map(|(m, e)| (m - e).abs()).sum();
            let value: f64 = values.iter().zip(&exact).zip(&exact_mass).map(|((v, e), m)| m * (v - e).abs()).sum();
            [density / whole, value / whole]
        });
        for i in 0..2 {
            let order = (errors[1][i] / errors[2][i]).log2();
            assert!(order > 1.8, "inner radius {inner}, field {i}: order {order}, errors {errors:?}");
            assert!(errors[2][i] < 2e-3, "inner radius {inner}, field {i}: {errors:?}");
        }
    }
}

/// A jump stays between its two values, and mass and its product with the value are conserved to rounding.
#[test]
fn transport_of_a_jump_conserves_and_keeps_bounds() {
    fn jump([r, z]: [f64; 2]) -> f64 {
        if (r - 1.4).abs() < 0.2 && (z - 0.5).abs() < 0.3 { 5.0 } else { 1.0 }
    }
    for (order, triangles) in
        [(TransportOrder::First, false), (TransportOrder::Second, false), (TransportOrder::Second, true)]
    {
        let section = Section::of(30, 1.0, triangles);
        let (mass_before, values_before) = section.means(&section.places, density, jump);
        let [mass, values, ..] = turn(&section, 1.0, order, 1.0, jump);
        let sum = |mass: &[f64], values: &[f64]| mass.iter().zip(values).map(|(m, v)| m * v).sum::<f64>();
        let ones = vec![1.0; mass.len()];
        let apart = |a: f64, b: f64| (a / b - 1.0).abs();
        assert!(apart(sum(&mass, &ones), sum(&mass_before, &ones)) < 1e-13);
        assert!(apart(sum(&mass, &values), sum(&mass_before, &values_before)) < 1e-13);
        assert!(values.iter().all(|v| (1.0..=5.0).contains(v)), "{order:?}");
        let densities = (0..mass.len()).map(|e| mass[e] / quad::volume(section.corners(e, &section.places)));
        assert!(densities.into_iter().all(|d| (1.0..=3.0).contains(&d)));
    }
}

/// An element whose corner the material has moved beyond the opposite diagonal has positive corner masses with the sum of its mass.
/// Those of convex elements, also at the axis, are the integrals of the shape functions.
#[test]
fn corner_masses_of_concave_elements_are_positive() {
    let with_corner = |r: f64, z: f64| [[0.0, 0.0], [1.0, 0.0], [r, z], [0.0, 1.0]];
    for (r, z) in [(0.35, 0.3), (0.3, 0.25), (0.27, 0.26), (0.2, 0.2)] {
        let integrals = quad::corner_masses(with_corner(r, z), 1.0);
        let masses = corner_masses(with_corner(r, z), 3.0);
        println!("{r} {z}: integrals {integrals:?}, masses {masses:?}");
        assert!(masses.iter().all(|mass| *mass > 0.0), "{masses:?}");
        assert!((masses.iter().sum::<f64>() / 3.0 - 1.0).abs() < 1e-14, "{masses:?}");
    }
    assert!(quad::corner_masses(with_corner(0.2, 0.2), 1.0).iter().any(|mass| *mass < 0.0));
    for (r, z) in [(1.0, 1.0), (0.51, 0.5), (2.0, 0.01), (0.05, 3.0)] {
        let integrals = quad::corner_masses(with_corner(r, z), 1.0);
        let sum = (integrals[0] + integrals[1]) + (integrals[2] + integrals[3]);
        assert_eq!(corner_masses(with_corner(r, z), 3.0), integrals.map(|mass| 3.0 / sum * mass));
    }
}

/// Momentum is conserved to rounding, a uniform velocity stays uniform, no velocity leaves the range of the others, and
/// the kinetic energy does not grow.
#[test]
fn momentum_is_conserved() {
    [false, true].into_iter().for_each(assert_momentum_is_conserved);
}

fn assert_momentum_is_conserved(triangles: bool) {
    let section = Section::of(20, 0.0, triangles);
    let topology = &section.topology;
    let (mut mass, _) = section.means(&section.places, density, smooth);
    let corner = |mass: &[f64], places: &[[f64; 2]]| -> Vec<[f64; 4]> {
        (0..mass.len()).map(|e| corner_masses(section.corners(e, places), mass[e])).collect()
    };
    let nodal = |corners: &[[f64; 4]]| {
        let mut nodes = vec![0.0; topology.nodes.len()];
        for (of, masses) in topology.corners.iter().zip(corners) {
            of.iter().zip(masses).for_each(|(n, m)| nodes[*n as usize] += m);
        }
        nodes
    };
    let mut transport = ElementTransport::new(topology, TransportOrder::Second);
    let mut momentum = MomentumTransport::new(topology, TransportOrder::Second);
    let mut velocity: Vec<[f64; 2]> = section.places.iter().map(|p| [smooth(*p) - 1.5, -0.7]).collect();
    let mut active = ActiveParts::new(topology);
    let mut corners = corner(&mass, &section.places);
    let weighted_sum = |masses: &[f64], v: &[[f64; 2]], power: i32| {
        masses.iter().zip(v).map(|(m, v)| m * v[0].powi(power)).sum::<f64>()
    };
    let masses_before = nodal(&corners);
    let [start, energy] = [1, 2].map(|power| weighted_sum(&masses_before, &velocity, power));
    let range =
        |v: &[[f64; 2]]| v.iter().fold([f64::INFINITY, -f64::INFINITY], |[a, b], [x, _]| [a.min(*x), b.max(*x)]);
    let [low, high] = range(&velocity);
    for i in 0..80 {
        let [from, to] = [i, i + 1].map(|i| section.in_vortex(0.0, f64::from(i) / 80.0));
        active.find(topology, [&from, &to]);
        let change = MeshChange { domain: topology, active: &active, loops: LOOPS };
        transport.measure(change, [&from, &to]);
        transport.move_masses(change, &mut mass);
        let after = corner(&mass, &to);
        momentum.measure(change, transport.fluxes(), [&corners, &after]);
        momentum.move_velocity(change, &mut velocity, &nodal(&after));
        corners = after;
    }
    let after = nodal(&corners);
    assert!((weighted_sum(&after, &velocity, 1) / start - 1.0).abs() < 1e-13);
    let lost = 1.0 - weighted_sum(&after, &velocity, 2) / energy;
    assert!((0.0..2e-3).contains(&lost), "{lost}");
    assert!(velocity.iter().all(|v| (v[1] + 0.7).abs() < 1e-14));
    let [least, most] = range(&velocity);
    assert!(least >= low && most <= high);
}

/// A flat die that presses on the nodes on a plane z = 1.
struct FlatDie(Vec<[f64; 2]>);

impl Surroundings for FlatDie {
    fn contact(&self, node: usize) -> BoundaryContact {
        let gap = 1.0 - self.0[node][1];
        if gap == 0.0 { BoundaryContact::Pressed } else { BoundaryContact::Apart(gap) }
    }

    fn keeps_gaps(&self, _node: usize) -> bool {
        false
    }

    fn place_on_surface(&self, _node: usize, _place: [f64; 2]) -> Option<[f64; 2]> {
        None
    }
}

/// The corner of a mesh whose side folds onto a die takes the place of the last node in contact, no node passes through the
/// die, and the sharp elements at the fold become regular.
#[test]
fn corners_follow_the_edge_of_contact() {
    let section = Section::new(6, 0.0);
    let (topology, mut places) = (&section.topology, section.places.clone());
    // The corner is node 48; nodes 41 and 34 of the side have folded onto the die, 34 before 41.
    for (node, place) in
        [(34, [1.3, 1.0]), (41, [1.15, 0.995]), (27, [1.35, 0.75]), (20, [1.3, 0.5]), (13, [1.2, 0.25])]
    {
        places[node] = place;
    }
    let mobility: Vec<NodeMobility> =
        topology.inside.iter().map(|i| if *i { NodeMobility::Inside } else { NodeMobility::Boundary }).collect();
    let weights = SmoothingWeights { volumetric: 1.0, laplacian: 0.0, equipotential: 0.0 };
    let cosine = 30f64.to_radians().cos();
    let mut smoothing =
        MeshSmoothing::new((topology, &section.places), weights, None, cosine, (mobility, vec![false; places.len()]));
    let mut held_places = HeldPlaces::new(topology, Vec::new(), false);
    held_places.kept = section.places.iter().map(|[r, z]| [*r == 0.0, *z == 0.0]).collect();
    let least = |places: &[[f64; 2]]| {
        let angles = topology.corners.iter().map(|corners| smallest_angle(corners, |n| places[n as usize]));
        angles.fold(f64::INFINITY, f64::min).to_degrees()
    };
    let initial_angle = least(&places);
    for _ in 0..200 {
        let die = FlatDie(places.clone());
        smoothing.restrict(topology, (&held_places.kept, &held_places), |_| false);
        smoothing.read_contact(topology, &die);
        smoothing.sweep(LOOPS, topology, &held_places, &die, &mut places);
        assert!(places.iter().all(|[_, z]| *z <= 1.0));
    }
    assert_eq!(places[48], [1.3, 1.0]);
    assert!([41, 34, 27].iter().all(|n| places[*n][1] < 1.0), "{places:?}");
    assert!(initial_angle < 30.0 && least(&places) > 50.0, "{initial_angle} {}", least(&places));
}
