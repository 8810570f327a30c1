//! A group of two-node axisymmetric shells of one section.
//! Never here: arithmetic of frames and points.
//!
//! A node of shells turns as well as it moves. Its rotation is a degree of freedom of its own in the list of nodes: a companion
//! whose first coordinate is the angle (counter-clockwise in r and z, radians) and whose mass is the rotary inertia. So a shell acts
//! on two nodes, then on their rotations, on which moments act as forces along r do on nodes.

use std::sync::Arc;

use super::point::{Flow, advance};
use super::record::{PointStrains, Record};
use super::section::{Section, Thinning};
use crate::element::block::is_larger;
use crate::element::constants::CHANGE;
use crate::element::group::{
    Deletion, ElementGroup, Extensions, GroupProperties, InitialState, Pass, Settings, Stiffness, Totals,
};
use crate::kernel::lanes::{Corners, InlineMap, LANES};
use crate::kernel::shell::{Five, Frame};
use crate::kernel::topology::{ElementNodes, PerNode, Topology};
use crate::state::archive::persist_struct;
use crate::state::nodes::Node;
use crate::variables::{Part, Variable};

/// Shells of one section.
#[derive(Clone)]
pub struct Shells {
    section: Arc<Section>,
    /// Nodes, then their rotations.
    ends: Vec<[u32; 4]>,
    /// Masses of the nodes, then rotary inertias.
    masses: Vec<[f64; 4]>,
    state: Vec<Shell>,
    /// Stress along meridian and hoop at the points, element by element.
    stress: Vec<[f64; 2]>,
    /// What flows there; empty where nothing does.
    flow: Vec<Flow>,
    /// What outputs ask for; `None` without.
    record: Option<Box<Record>>,
    /// Elements that were deleted; empty where none can be.
    deleted: Vec<bool>,
}

/// What an element keeps beside its points.
#[derive(Clone, Copy, Debug, Default)]
struct Shell {
    /// Thickness now.
    thickness: f64,
    /// Transverse shear force a length.
    shear: f64,
}

/// Which points of an element a variable is of.
fn place(variable: Variable) -> Option<(Variable, Side)> {
    Some(match variable {
        Variable::BottomStress => (Variable::Stress, Side::Bottom),
        Variable::TopStress => (Variable::Stress, Side::Top),
        Variable::BottomPlasticStrain => (Variable::PlasticStrain, Side::Bottom),
        Variable::TopPlasticStrain => (Variable::PlasticStrain, Side::Top),
        Variable::BottomStrain => (Variable::LogarithmicStrain, Side::Bottom),
        Variable::TopStrain => (Variable::LogarithmicStrain, Side::Top),
        Variable::BottomTemperature => (Variable::Temperature, Side::Bottom),
        Variable::TopTemperature => (Variable::Temperature, Side::Top),
        Variable::Stress
        | Variable::PlasticStrain
        | Variable::LogarithmicStrain
        | Variable::PlasticComponents
        | Variable::StrainRate
        | Variable::Temperature => (variable, Side::Middle),
        _ => return None,
    })
}

enum Side {
    Bottom,
    Middle,
    Top,
}

impl Shells {
    /// Elements by their nodes and rotations, at their places at the start.
    pub fn new(section: Section, ends: Vec<[u32; 4]>, nodes: &[Node]) -> Self {
        let frames: Vec<Frame> = ends.iter().map(|e| frame(e, nodes)).collect();
        let masses = |(ends, frame): (&[u32; 4], &Frame)| {
            let radii = [ends[0], ends[1]].inline_map(|n| nodes[n as usize].r);
            frame.masses(radii, section.per_area, section.thickness, &section.elastic)
        };
        let points = ends.len() * section.points.len();
        Shells {
            masses: ends.iter().zip(&frames).map(masses).collect(),
            state: vec![Shell { thickness: section.thickness, shear: 0.0 }; ends.len()],
            stress: vec![[0.0; 2]; points],
            flow: if section.flowing.is_some() { vec![Flow::default(); points] } else { Vec::new() },
            section: Arc::new(section),
            ends,
            record: None,
            deleted: Vec::new(),
        }
    }

    fn frame(&self, element: usize, nodes: &[Node]) -> Frame {
        frame(&self.ends[element], nodes)
    }

    fn is_deleted(&self, element: usize) -> bool {
        self.deleted.get(element) == Some(&true)
    }

    fn point(&self, element: usize, side: Side) -> usize {
        let count = self.section.points.len();
        let point = match side {
            Side::Bottom => 0,
            Side::Middle => count / 2,
            Side::Top => count - 1,
        };
        element * count + point
    }

    /// Strains at the points over an increment. Returns the plastic work an area.
    fn strain(&mut self, element: usize, strains: &Five, dt: f64) -> f64 {
        let count = self.section.points.len();
        let thickness = self.state[element].thickness;
        let (mut thinning, mut plastic) = (0.0, 0.0);
        for (i, [place, weight]) in self.section.points.iter().enumerate() {
            let (at, height) = (element * count + i, 0.5 * place * thickness);
            let strain = [strains[0] + height * strains[2], strains[1] + height * strains[3]];
            let step = advance(&self.section, &mut self.stress[at], self.flow.get_mut(at), strain, dt);
            plastic += weight * thickness * step.returned.mises * step.returned.flow;
            thinning += weight * step.thinning;
            if let Some(record) = &mut self.record {
                let strain = [strain[0], strain[1], step.thinning];
                record.points[at].follow(strain, step.returned.plastic, dt);
            }
        }
        if let Thinning::Ratio(ratio) = self.section.thinning {
            thinning = -ratio / (1.0 - ratio) * (strains[0] + strains[1]);
        }
        let state = &mut self.state[element];
        state.thickness *= libm::exp(thinning);
        state.shear += self.section.shear_stiffness() * strains[4];
        plastic
    }

    /// Forces and moments a length of the stress.
    fn resultants(&self, element: usize) -> Five {
        let Shell { thickness, shear, .. } = self.state[element];
        let count = self.section.points.len();
        let points = self.section.points.iter().zip(&self.stress[element * count..]);
        let mut sums = [0.0, 0.0, 0.0, 0.0, shear];
        for ([place, weight], stress) in points {
            let (share, height) = (weight * thickness, 0.5 * place * thickness);
            for (i, stress) in stress.iter().enumerate() {
                sums[i] += share * stress;
                sums[2 + i] += share * height * stress;
            }
        }
        sums
    }

    /// One increment of one element; its forces go where those before stand. Returns its work (of stress, flow and viscosity)
    /// and its rate.
    fn advance(&mut self, element: usize, pass: &mut Pass<'_>) -> ([f64; 3], f64) {
        let (nodes, dt, masses) = (pass.nodes, pass.dt, self.masses[element]);
        let ends = self.ends[element].inline_map(|n| nodes[n as usize]);
        let steps = [0, 1].inline_map(|i| [dt * ends[i].v_r, dt * ends[i].v_z, dt * ends[i + 2].v_r]);
        let middle = Frame::new([0, 1].inline_map(|i| [ends[i].r - 0.5 * steps[i][0], ends[i].z - 0.5 * steps[i][1]]));
        let strains = middle.strains(steps);
        let dissipated = if dt > 0.0 { self.strain(element, &strains, dt) } else { 0.0 };
        let frame = Frame::new([0, 1].inline_map(|i| ends[i].place()));
        let thickness = self.state[element].thickness;
        let mut resultants = self.resultants(element);
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let sums = [strains[0] + strains[1], strains[2] + strains[3]];
        let [force, moment] = self.section.viscosity(&frame, &masses, thickness, sums.inline_map(|s| per_dt * s));
        for i in 0..2 {
            resultants[i] += force;
            resultants[2 + i] += moment;
        }
        let work =
            put(&frame.forces(&resultants), &steps, &mut pass.corners.double()[element / LANES], element % LANES);
        let area = frame.area();
        let (plastic, viscous) = (area * dissipated, area * (force * sums[0] + moment * sums[1]));
        if let Some(record) = &mut self.record {
            let followed = &mut record.elements[element];
            followed.section.iter_mut().zip(strains).for_each(|(sum, strain)| *sum += strain);
            followed.work = [followed.work[0] + (work - viscous), followed.work[1] + plastic];
        }
        let own = self.section.rate(&frame, &masses, thickness, per_dt * sums[0]);
        let change = per_dt * (strains[0].abs() + strains[1].abs()) / CHANGE;
        ([work - viscous, plastic, viscous], if is_larger(change, own) { change } else { own })
    }
}

/// The frame of two nodes now.
fn frame(ends: &[u32; 4], nodes: &[Node]) -> Frame {
    Frame::new([ends[0], ends[1]].inline_map(|n| nodes[n as usize].place()))
}

/// Puts the forces of an element in the place of those before, and gives the work of both over the increment: what nodes lose
/// the element gains.
fn put(forces: &[[f64; 3]; 2], steps: &[[f64; 3]; 2], corners: &mut Corners, lane: usize) -> f64 {
    let mut work = 0.0;
    for (end, (forces, steps)) in forces.iter().zip(steps).enumerate() {
        for (axis, (&force, step)) in forces.iter().zip(steps).enumerate() {
            let (corner, component) = if axis < 2 { (end, axis) } else { (2 + end, 0) };
            let slot = &mut corners.0[corner][lane][component];
            work -= 0.5 * (*slot + force) * step;
            *slot = force;
        }
    }
    work
}

impl ElementGroup for Shells {
    fn len(&self) -> usize {
        self.ends.len()
    }

    fn properties(&self) -> GroupProperties {
        GroupProperties {
            topology: Topology::Shell,
            single: false,
            deletable: !self.deleted.is_empty(),
            damped: true,
            holds_pressure: false,
            fields: 0,
        }
    }

    fn nodes(&self, element: usize) -> ElementNodes {
        self.ends[element].into()
    }

    fn masses(&self, element: usize) -> PerNode<f64> {
        self.masses[element].into()
    }

    fn update(&mut self, mut pass: Pass<'_>) -> Totals {
        let mut totals = Totals::default();
        for element in 0..self.ends.len() {
            if self.is_deleted(element) {
                continue;
            }
            let ([internal, plastic, viscous], rate) = self.advance(element, &mut pass);
            totals.internal += internal;
            totals.plastic += plastic;
            totals.viscous += viscous;
            if is_larger(rate, totals.rate) {
                (totals.rate, totals.limiting) = (rate, element);
            }
        }
        totals
    }

    fn value(&self, element: usize, part: Part) -> Option<f64> {
        let component = part.component;
        if let Some((variable, side)) = place(part.variable) {
            let at = self.point(element, side);
            let strain = |of: fn(&PointStrains) -> [f64; 3]| {
                Some(of(self.record.as_ref()?.points.get(at)?).get(component).copied().unwrap_or(0.0))
            };
            return match variable {
                Variable::Stress => Some(self.stress[at].get(component).copied().unwrap_or(0.0)),
                Variable::PlasticStrain => Some(self.flow.get(at)?.strain),
                Variable::Temperature => Some(self.flow.get(at)?.temperature),
                Variable::LogarithmicStrain => strain(|p| p.total),
                Variable::PlasticComponents if self.flow.is_empty() => None,
                Variable::PlasticComponents => strain(|p| p.plastic),
                _ => strain(|p| p.rate),
            };
        }
        let followed = || Some(self.record.as_ref()?.elements[element]);
        match part.variable {
            Variable::Thickness => Some(self.state[element].thickness),
            Variable::SectionForce => [0, 1, 4].get(component).map(|&i| self.resultants(element)[i]),
            Variable::SectionMoment => [2, 3].get(component).map(|&i| self.resultants(element)[i]),
            Variable::SectionStrain => Some(followed()?.section[*[0, 1, 4].get(component)?]),
            Variable::SectionCurvature => Some(followed()?.section[*[2, 3].get(component)?]),
            Variable::ElementStrainEnergy => followed().map(|f| f.work[0] - f.work[1]),
            Variable::ElementPlasticEnergy => Some(followed()?.work[1]),
            Variable::Mass => Some(self.masses[element][0] + self.masses[element][1]),
            Variable::Status => Some(if self.is_deleted(element) { 0.0 } else { 1.0 }),
            _ => None,
        }
    }

    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64> {
        let masses = masses.map_or(Some(&self.masses[element]), |list| list.first_chunk())?;
        Some(self.section.rate(&self.frame(element, nodes), masses, self.state[element].thickness, 0.0))
    }

    fn stiffness(&self, _element: usize, _nodes: &[Node]) -> Option<Stiffness> {
        None
    }

    fn bytes(&self) -> usize {
        let section = size_of_val(&*self.section) + size_of_val(&*self.section.points);
        let elements = size_of_val(&*self.ends) + size_of_val(&*self.masses) + size_of_val(&*self.state);
        let record = self.record.as_ref().map_or(0, |r| size_of_val(&**r) + r.bytes());
        section + elements + size_of_val(&*self.stress) + size_of_val(&*self.flow) + record + self.deleted.capacity()
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }

    fn extensions(&mut self) -> &mut dyn Extensions {
        self
    }
}

impl Extensions for Shells {
    fn settings(&mut self) -> &mut dyn Settings {
        self
    }

    fn deletion(&mut self) -> &mut dyn Deletion {
        self
    }

    fn initial_state(&mut self) -> &mut dyn InitialState {
        self
    }
}

impl Settings for Shells {
    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        self.masses[element].copy_from_slice(masses);
    }

    fn follow(&mut self) {
        self.record = Some(Box::new(Record::new(self.ends.len(), self.stress.len())));
    }
}

impl Deletion for Shells {
    fn make_erodible(&mut self) {
        self.deleted = vec![false; self.ends.len()];
    }

    /// A deleted shell shows no stress.
    fn erode(&mut self, element: usize, _volume: f64) {
        self.deleted[element] = true;
        self.state[element].shear = 0.0;
        self.set(element, Some([0.0; 4]), None);
    }
}

impl InitialState for Shells {
    fn set(&mut self, element: usize, stress: Option<[f64; 4]>, temperature: Option<f64>) {
        let count = self.section.points.len();
        let points = element * count..(element + 1) * count;
        if let Some([meridian, hoop, ..]) = stress {
            self.stress[points.clone()].fill([meridian, hoop]);
        }
        if let (Some(temperature), Some(flow)) = (temperature, self.flow.get_mut(points)) {
            flow.iter_mut().for_each(|f| f.temperature = temperature);
        }
    }
}

persist_struct!(Shell { thickness, shear });

persist_struct!(Shells {
    deleted: fixed, masses: fixed, state: fixed, stress: fixed, flow: fixed, record: present
} derived {
    section, ends
});
