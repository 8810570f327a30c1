//! A group of cohesive elements with the same traction-separation law.
//!
//! Tractions are nominal: forces over the initial area (ABAQUS Analysis User's Guide, "Defining the constitutive response
//! of cohesive elements using a traction-separation description"). Elements are updated in their order by one thread:
//! interfaces have few elements compared with the bodies that they join.

use std::sync::Arc;

use crate::element::criteria::DeletionFilter;
use crate::element::group::{ElementGroup, ElementPass, GroupProperties, GroupSetting, GroupTotals};
use crate::element::lane_sums::is_larger;
use crate::kernel::cohesive::{self, MidSurface};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES};
use crate::kernel::topology::{ElementNodes, ElementTopology, PerNode};
use crate::kernel::traction_separation::{
    DissipatedEnergy, InterfaceHistory, InterfaceStiffness, TractionSeparationLaw,
};
use crate::material::PointValue;
use crate::state::archive::Persist;
use crate::state::nodes::Node;
use crate::variables::{Variable, VariableComponent};

/// Number of increments before a point closes in which its stiffness is that of a closed point.
const AHEAD: f64 = 3.0;

/// Geometry and section of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CohesiveElement {
    /// Nodes 1 and 2 of the bottom face, 3 and 4 of the top face, counter-clockwise.
    pub nodes: [u32; 4],
    /// Constitutive thickness, length.
    pub thickness: f64,
    /// Law of the material for this thickness: its index in the list of the group.
    pub law: usize,
}

/// Group of cohesive elements of a section.
#[derive(Clone, Persist)]
#[persist(
    fixed: masses, points, energies, rates, rate_factors, deleted;
    derived: laws, elements, areas, gaps, deletes, criterion, is_erodible, fresh
)]
pub struct CohesiveGroup {
    laws: Arc<[TractionSeparationLaw]>,
    elements: Arc<[CohesiveElement]>,
    /// Initial areas of both points.
    areas: Arc<[[f64; 2]]>,
    /// Initial vectors between the faces at both points, along normal and mid-surface.
    gaps: Arc<[[[f64; 2]; 2]]>,
    /// Whether failed elements are deleted.
    deletes: bool,
    /// Output variable of the initiation criterion; `None` without damage initiation.
    criterion: Option<Variable>,
    masses: Vec<[f64; 4]>,
    points: Vec<[CohesivePoint; 2]>,
    /// Work of the tractions, and the energy that damage has dissipated.
    energies: Vec<[f64; 2]>,
    /// One over the stable time increment of each element without damage and rotation; depends on the masses of its nodes.
    rates: Vec<f64>,
    /// Factors of the rates for the current damage and shape.
    rate_factors: Vec<f64>,
    deleted: Vec<bool>,
    /// Whether `*EROSION` may delete elements.
    is_erodible: bool,
    /// Number of elements that the last update has deleted.
    fresh: usize,
}

/// State of an integration point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
struct CohesivePoint {
    history: InterfaceHistory,
    /// Normal and shear separation.
    separation: [f64; 2],
    traction: [f64; 2],
}

impl CohesiveGroup {
    /// Creates elements in the initial configuration. The density is a mass per volume of the constitutive thickness.
    /// `deletes` states whether failed elements are deleted, `criterion` is the output variable of the initiation
    /// criterion.
    pub fn new(
        laws: Vec<TractionSeparationLaw>,
        elements: Vec<CohesiveElement>,
        density: f64,
        (deletes, criterion): (bool, Option<Variable>),
        nodes: &[Node],
    ) -> Self {
        let corners = |e: &CohesiveElement| e.nodes.inline_map(|n| nodes[n as usize].place());
        let areas: Vec<[f64; 2]> = elements.iter().map(|e| cohesive::areas(corners(e))).collect();
        let mass = |(e, [a, b]): (&CohesiveElement, &[f64; 2])| {
            [*a, *b, *b, *a].inline_map(|area| 0.5 * density * e.thickness * area)
        };
        let gaps = elements.iter().map(|e| MidSurface::new(corners(e)).jumps(corners(e)));
        let count = elements.len();
        CohesiveGroup {
            gaps: gaps.collect(),
            masses: elements.iter().zip(&areas).map(mass).collect(),
            laws: laws.into(),
            elements: elements.into(),
            areas: areas.into(),
            deletes,
            criterion,
            points: vec![[CohesivePoint::default(); 2]; count],
            energies: vec![[0.0; 2]; count],
            rates: vec![0.0; count],
            rate_factors: vec![1.0; count],
            deleted: vec![false; count],
            is_erodible: false,
            fresh: 0,
        }
    }

    /// Returns the stiffness at both points of an element, force per separation.
    pub fn stiffness_of_points(&self, element: usize) -> [f64; 2] {
        let stiffness = self.law(element).largest_stiffness(1.0);
        self.areas[element].inline_map(|area| stiffness * area)
    }

    /// Sets one over the stable time increment of an element, which depends on the bodies that it joins.
    pub(super) fn set_rate(&mut self, element: usize, rate: f64) {
        self.rates[element] = rate;
    }

    fn law(&self, element: usize) -> &TractionSeparationLaw {
        &self.laws[self.elements[element].law]
    }

    /// Updates an element to the current positions of its nodes; replaces its corner forces and adds its energies.
    fn update_element(
        &mut self,
        element: usize,
        (nodes, dt): (&[Node], f64),
        corners: &mut BlockCornerForces,
        totals: &mut GroupTotals,
    ) {
        let lane = element % LANES;
        let ends = self.elements[element].nodes.inline_map(|n| &nodes[n as usize]);
        let mut forces = [[0.0; 2]; 4];
        let mut dissipated = DissipatedEnergy::default();
        if !self.deleted[element] {
            let places = ends.inline_map(|node| node.place());
            let surface = MidSurface::new(places);
            let jumps = surface.jumps(places);
            dissipated = self.update_points(element, (jumps, surface.length), dt);
            if self.has_failed(element) {
                dissipated.add(self.delete(element), 1.0);
            } else {
                let (points, areas) = (&self.points[element], &self.areas[element]);
                let between = [0, 1].inline_map(|i: usize| points[i].traction.inline_map(|t| areas[i] * t));
                forces = surface.forces(between, jumps);
            }
        }
        // By the trapezoidal rule, as the work of all forces: energy gained by the element.
        let mut work = 0.0;
        for (corner, node) in ends.into_iter().enumerate() {
            for (axis, velocity) in [node.v_r, node.v_z].into_iter().enumerate() {
                let force = &mut corners[corner][axis][lane];
                work -= 0.5 * dt * (*force + forces[corner][axis]) * velocity;
                *force = forces[corner][axis];
            }
        }
        let work = work - dissipated.by_viscosity;
        totals.internal += work;
        totals.plastic += dissipated.by_damage;
        totals.damaged += dissipated.by_damage;
        totals.viscous += dissipated.by_viscosity;
        let energies = &mut self.energies[element];
        *energies = [energies[0] + work, energies[1] + dissipated.by_damage];
    }

    /// Updates the points of an element for the vectors between its faces and the length of the mid-surface after the time
    /// `dt`; returns the dissipated energy.
    fn update_points(&mut self, element: usize, (jumps, length): ([[f64; 2]; 2], f64), dt: f64) -> DissipatedEnergy {
        let law = &self.laws[self.elements[element].law];
        let mut dissipated = DissipatedEnergy::default();
        let mut stiffness = [InterfaceStiffness::default(); 2];
        for (i, point) in self.points[element].iter_mut().enumerate() {
            let gap = self.gaps[element][i];
            let separation = [jumps[i][0] - gap[0], jumps[i][1] - gap[1]];
            let response = law.advance(&mut point.history, [point.separation, separation], dt);
            stiffness[i] = InterfaceStiffness {
                damage: point.history.damage,
                closes: separation[0] + AHEAD * (separation[0] - point.separation[0]) <= 0.0,
                leverage: jumps[i].inline_map(|jump| jump / length),
            };
            point.separation = separation;
            point.traction = response.traction;
            dissipated.add(response.dissipated, self.areas[element][i]);
        }
        self.rate_factors[element] = law.stiffness_ratio(stiffness).sqrt();
        dissipated
    }

    /// Returns one over the stable time increment of an element.
    fn rate(&self, element: usize) -> f64 {
        self.rate_factors[element] * self.rates[element]
    }

    /// Returns whether an element is to be deleted: all its points have failed, and none is in compression.
    fn has_failed(&self, element: usize) -> bool {
        let law = self.law(element);
        let failed = |point: &CohesivePoint| law.has_failed(&point.history) && point.traction[0] >= 0.0;
        self.deletes && self.points[element].iter().all(failed)
    }

    /// Deletes an element; returns the energy that its tractions release.
    fn delete(&mut self, element: usize) -> DissipatedEnergy {
        let law = &self.laws[self.elements[element].law];
        let mut released = DissipatedEnergy::default();
        for (point, area) in self.points[element].iter_mut().zip(self.areas[element]) {
            released.add(law.released(point.history.damage, point.separation), area);
            point.traction = [0.0; 2];
        }
        self.deleted[element] = true;
        self.fresh += 1;
        released
    }

    /// Returns the mean of both points, weighted by area.
    fn mean(&self, element: usize, of: impl Fn(&CohesivePoint) -> f64) -> f64 {
        let ([first, second], [a, b]) = (&self.points[element], self.areas[element]);
        (a * of(first) + b * of(second)) / (a + b)
    }

    /// Returns the larger value of the initiation criterion of both points, if `shown` is this criterion.
    fn criterion(&self, element: usize, shown: Option<Variable>) -> Option<f64> {
        let [first, second] = &self.points[element];
        let value = first.history.criterion.max(second.history.criterion);
        self.criterion.filter(|own| shown.is_none_or(|shown| shown == *own)).map(|_| value)
    }
}

impl DeletionFilter for CohesiveGroup {}

impl ElementGroup for CohesiveGroup {
    fn len(&self) -> usize {
        self.elements.len()
    }

    fn properties(&self) -> GroupProperties {
        GroupProperties {
            topology: ElementTopology::Cohesive,
            deletable: self.deletes || self.is_erodible,
            damped: false,
            holds_pressure: true,
            equation_of_state: false,
            fields: 0,
            tiles: false,
        }
    }

    fn nodes(&self, element: usize) -> ElementNodes {
        self.elements[element].nodes.into()
    }

    fn masses(&self, element: usize) -> PerNode<f64> {
        self.masses[element].into()
    }

    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        self.masses[element].copy_from_slice(masses);
    }

    fn update(&mut self, pass: ElementPass<'_>) -> GroupTotals {
        let ElementPass { nodes, dt, corners, .. } = pass;
        let mut totals = GroupTotals::default();
        self.fresh = 0;
        for element in 0..self.elements.len() {
            self.update_element(element, (nodes, dt), &mut corners[element / LANES], &mut totals);
            if !self.deleted[element] && is_larger(self.rate(element), totals.rate) {
                (totals.rate, totals.limiting) = (self.rate(element), element);
            }
        }
        totals
    }

    fn value(&self, element: usize, part: VariableComponent) -> Option<f64> {
        let component = part.component;
        let thickness = self.elements[element].thickness;
        match part.variable {
            // Normal and shear traction; the interface has no stress along the mid-surface.
            Variable::Stress => Some(match component {
                1 => self.mean(element, |p| p.traction[0]),
                3 => self.mean(element, |p| p.traction[1]),
                _ => 0.0,
            }),
            Variable::NominalStrain => Some(self.mean(element, |p| p.separation[component.min(1)]) / thickness),
            Variable::Degradation if self.law(element).softening.is_some() => {
                Some(self.mean(element, |p| p.history.damage))
            }
            Variable::DamageInitiation => self.criterion(element, None),
            Variable::LargestStressInitiation
            | Variable::QuadraticStressInitiation
            | Variable::LargestStrainInitiation
            | Variable::QuadraticStrainInitiation => self.criterion(element, Some(part.variable)),
            Variable::ElementStrainEnergy => Some(self.energies[element][0] - self.energies[element][1]),
            Variable::ElementDamageEnergy => Some(self.energies[element][1]),
            Variable::ElementPlasticEnergy | Variable::ElementArtificialEnergy => Some(0.0),
            Variable::Mass => Some(self.masses[element].iter().sum()),
            Variable::Status => Some(if self.deleted[element] { 0.0 } else { 1.0 }),
            _ => None,
        }
    }

    fn set(&mut self, _element: usize, _value: PointValue) -> bool {
        false
    }

    fn thickness(&self, element: usize) -> Option<f64> {
        Some(self.elements[element].thickness)
    }

    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, _nodes: &[Node]) -> Option<f64> {
        // The bound follows from the masses of the nodes, not from those of the element.
        masses.is_none().then(|| self.rate(element))
    }

    fn bytes(&self) -> usize {
        let shared = size_of_val(&*self.laws)
            + size_of_val(&*self.elements)
            + size_of_val(&*self.areas)
            + size_of_val(&*self.gaps);
        let state = size_of_val(&*self.masses) + size_of_val(&*self.points) + size_of_val(&*self.energies);
        shared + state + size_of_val(&*self.rates) + size_of_val(&*self.rate_factors) + self.deleted.capacity()
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }

    /// Energies are always recorded.
    fn configure(&mut self, setting: GroupSetting) {
        self.is_erodible |= matches!(setting, GroupSetting::Deletion);
    }

    fn erode(&mut self, element: usize, _volume: f64) {
        self.deleted[element] = true;
        self.points[element].iter_mut().for_each(|point| point.traction = [0.0; 2]);
    }

    /// The faces that a deleted cohesive element has joined have been exposed before: no boundary is listed.
    fn newly_deleted(&mut self, deleted: &mut Vec<ElementNodes>) {
        (0..self.fresh).for_each(|_| deleted.push(ElementNodes::default()));
        self.fresh = 0;
    }

    fn as_cohesive(&mut self) -> Option<&mut CohesiveGroup> {
        Some(self)
    }
}
