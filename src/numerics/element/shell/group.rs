//! A group of two-node axisymmetric shells with the same section.
//!
//! Nodes of shells have a rotation as well as displacements. The rotation is stored as a companion node: its first
//! coordinate is the angle (counter-clockwise in r and z, radians), its mass is the rotary inertia. A shell therefore
//! acts on two nodes and their two companion nodes; moments act on companion nodes as forces along r act on nodes.

use std::sync::Arc;

use super::point::{ShellPointState, advance};
use super::record::{PointStrains, ShellRecord};
use super::section::{ShellProperties, ThicknessRule};
use crate::element::block::is_larger;
use crate::element::constants::CHANGE;
use crate::element::group::{
    ElementGroup, ElementPass, ElementStiffness, GroupDeletion, GroupExtensions, GroupProperties, GroupSettings,
    GroupTotals, InitialState,
};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES};
use crate::kernel::shell::{SectionComponents, ShellFrame};
use crate::kernel::topology::{ElementNodes, ElementTopology, PerNode};
use crate::state::archive::persist_struct;
use crate::state::nodes::Node;
use crate::variables::{Variable, VariableComponent};

/// Group of shell elements with the same section.
#[derive(Clone)]
pub struct ShellGroup {
    section: Arc<ShellProperties>,
    /// Nodes, then their rotations.
    ends: Vec<[u32; 4]>,
    /// Masses of the nodes, then rotary inertias.
    masses: Vec<[f64; 4]>,
    state: Vec<ShellState>,
    /// Stress along meridian and hoop at the section points, element by element.
    stress: Vec<[f64; 2]>,
    /// Plastic state of the section points; empty for an elastic section.
    flow: Vec<ShellPointState>,
    /// Record for output; `None` if not requested.
    record: Option<Box<ShellRecord>>,
    /// Deleted elements; empty if no element can be deleted.
    deleted: Vec<bool>,
}

/// State of an element apart from its section points.
#[derive(Clone, Copy, Debug, Default)]
struct ShellState {
    /// Current thickness, length.
    thickness: f64,
    /// Transverse shear force per length.
    shear: f64,
    /// Slow parts of the rates of area and curvature.
    slow_rates: [f64; 2],
    /// Force and moment of bulk viscosity per length.
    viscous: [f64; 2],
}

/// Splits a variable at the bottom, middle or top of the shell into the plain variable and the position.
fn place(variable: Variable) -> Option<(Variable, ThicknessPosition)> {
    Some(match variable {
        Variable::BottomStress => (Variable::Stress, ThicknessPosition::Bottom),
        Variable::TopStress => (Variable::Stress, ThicknessPosition::Top),
        Variable::BottomPlasticStrain => (Variable::PlasticStrain, ThicknessPosition::Bottom),
        Variable::TopPlasticStrain => (Variable::PlasticStrain, ThicknessPosition::Top),
        Variable::BottomStrain => (Variable::LogarithmicStrain, ThicknessPosition::Bottom),
        Variable::TopStrain => (Variable::LogarithmicStrain, ThicknessPosition::Top),
        Variable::BottomTemperature => (Variable::Temperature, ThicknessPosition::Bottom),
        Variable::TopTemperature => (Variable::Temperature, ThicknessPosition::Top),
        Variable::Stress
        | Variable::PlasticStrain
        | Variable::LogarithmicStrain
        | Variable::PlasticComponents
        | Variable::StrainRate
        | Variable::Temperature => (variable, ThicknessPosition::Middle),
        _ => return None,
    })
}

enum ThicknessPosition {
    Bottom,
    Middle,
    Top,
}

impl ShellGroup {
    /// Creates shells from their nodes and rotations in the initial configuration.
    pub fn new(section: ShellProperties, ends: Vec<[u32; 4]>, nodes: &[Node]) -> Self {
        let frames: Vec<ShellFrame> = ends.iter().map(|e| frame(e, nodes)).collect();
        let masses = |(ends, frame): (&[u32; 4], &ShellFrame)| {
            let radii = [ends[0], ends[1]].inline_map(|n| nodes[n as usize].r);
            frame.masses(radii, section.per_area, section.thickness, &section.elastic)
        };
        let points = ends.len() * section.points.len();
        ShellGroup {
            masses: ends.iter().zip(&frames).map(masses).collect(),
            state: vec![ShellState { thickness: section.thickness, ..ShellState::default() }; ends.len()],
            stress: vec![[0.0; 2]; points],
            flow: if section.flowing.is_some() { vec![ShellPointState::default(); points] } else { Vec::new() },
            section: Arc::new(section),
            ends,
            record: None,
            deleted: Vec::new(),
        }
    }

    fn frame(&self, element: usize, nodes: &[Node]) -> ShellFrame {
        frame(&self.ends[element], nodes)
    }

    fn is_deleted(&self, element: usize) -> bool {
        self.deleted.get(element) == Some(&true)
    }

    fn point(&self, element: usize, side: ThicknessPosition) -> usize {
        let count = self.section.points.len();
        let point = match side {
            ThicknessPosition::Bottom => 0,
            ThicknessPosition::Middle => count / 2,
            ThicknessPosition::Top => count - 1,
        };
        element * count + point
    }

    /// Updates the section points over an increment. Returns the plastic work per area.
    fn strain(&mut self, element: usize, strains: &SectionComponents, dt: f64) -> f64 {
        let count = self.section.points.len();
        let thickness = self.state[element].thickness;
        let (mut thinning, mut plastic) = (0.0, 0.0);
        for (i, [place, weight]) in self.section.points.iter().enumerate() {
            let (at, height) = (element * count + i, 0.5 * place * thickness);
            let strain = [strains[0] + height * strains[2], strains[1] + height * strains[3]];
            let step = advance(&self.section, &mut self.stress[at], self.flow.get_mut(at), strain, dt);
            plastic += weight * thickness * step.work;
            thinning += weight * step.thinning;
            if let Some(record) = &mut self.record {
                let strain = [strain[0], strain[1], step.thinning];
                record.points[at].follow(strain, step.returned.plastic, dt);
            }
        }
        if let ThicknessRule::Ratio(ratio) = self.section.thinning {
            thinning = -ratio / (1.0 - ratio) * (strains[0] + strains[1]);
        }
        let state = &mut self.state[element];
        state.thickness *= libm::exp(thinning);
        state.shear += self.section.shear_stiffness() * strains[4];
        plastic
    }

    /// Returns forces and moments of the stress per length.
    fn resultants(&self, element: usize) -> SectionComponents {
        let ShellState { thickness, shear, .. } = self.state[element];
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

    /// Updates one element over an increment, and replaces its corner forces. Returns its work (of stress, plastic flow
    /// and viscosity) and its rate.
    fn advance(&mut self, element: usize, pass: &mut ElementPass<'_>) -> ([f64; 3], f64) {
        let (nodes, dt, masses) = (pass.nodes, pass.dt, self.masses[element]);
        let ends = self.ends[element].inline_map(|n| nodes[n as usize]);
        let steps = [0, 1].inline_map(|i| [dt * ends[i].v_r, dt * ends[i].v_z, dt * ends[i + 2].v_r]);
        let middle =
            ShellFrame::new([0, 1].inline_map(|i| [ends[i].r - 0.5 * steps[i][0], ends[i].z - 0.5 * steps[i][1]]));
        let strains = middle.strains(steps);
        let dissipated = if dt > 0.0 { self.strain(element, &strains, dt) } else { 0.0 };
        let frame = ShellFrame::new([0, 1].inline_map(|i| ends[i].place()));
        let thickness = self.state[element].thickness;
        let mut resultants = self.resultants(element);
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let sums = [strains[0] + strains[1], strains[2] + strains[3]];
        let (rates, before) = (sums.inline_map(|s| per_dt * s), self.state[element].slow_rates);
        let slow = self.section.slow_rates(&frame, &masses, (before, thickness), rates, dt);
        self.state[element].slow_rates = slow;
        let [force, moment] = self.section.viscosity(&frame, &masses, thickness, rates, slow);
        let previous = std::mem::replace(&mut self.state[element].viscous, [force, moment]);
        for i in 0..2 {
            resultants[i] += force;
            resultants[2 + i] += moment;
        }
        let work = put(&frame.forces(&resultants), &steps, &mut pass.corners[element / LANES], element % LANES);
        let area = frame.area();
        // By the trapezoidal rule, as the work of all forces.
        let viscous = 0.5 * area * ((previous[0] + force) * sums[0] + (previous[1] + moment) * sums[1]);
        let plastic = area * dissipated;
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

/// Returns the current frame of two nodes.
fn frame(ends: &[u32; 4], nodes: &[Node]) -> ShellFrame {
    ShellFrame::new([ends[0], ends[1]].inline_map(|n| nodes[n as usize].place()))
}

/// Replaces the forces of an element and returns the work of the previous and the new forces over the increment, by the
/// trapezoidal rule: energy gained by the element.
fn put(forces: &[[f64; 3]; 2], steps: &[[f64; 3]; 2], corners: &mut BlockCornerForces, lane: usize) -> f64 {
    let mut work = 0.0;
    for (end, (forces, steps)) in forces.iter().zip(steps).enumerate() {
        for (axis, (&force, step)) in forces.iter().zip(steps).enumerate() {
            let (corner, component) = if axis < 2 { (end, axis) } else { (2 + end, 0) };
            let slot = &mut corners[corner][component][lane];
            work -= 0.5 * (*slot + force) * step;
            *slot = force;
        }
    }
    work
}

impl ElementGroup for ShellGroup {
    fn len(&self) -> usize {
        self.ends.len()
    }

    fn properties(&self) -> GroupProperties {
        GroupProperties {
            topology: ElementTopology::Shell,
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

    fn update(&mut self, mut pass: ElementPass<'_>) -> GroupTotals {
        let mut totals = GroupTotals::default();
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

    fn value(&self, element: usize, part: VariableComponent) -> Option<f64> {
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
            // Shells have no hourglass control.
            Variable::ElementArtificialEnergy => followed().map(|_| 0.0),
            Variable::Mass => Some(self.masses[element][0] + self.masses[element][1]),
            Variable::Status => Some(if self.is_deleted(element) { 0.0 } else { 1.0 }),
            _ => None,
        }
    }

    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64> {
        let masses = masses.map_or(Some(&self.masses[element]), |list| list.first_chunk())?;
        Some(self.section.rate(&self.frame(element, nodes), masses, self.state[element].thickness, 0.0))
    }

    fn stiffness(&self, _element: usize, _nodes: &[Node]) -> Option<ElementStiffness> {
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

    fn extensions(&mut self) -> &mut dyn GroupExtensions {
        self
    }
}

impl GroupExtensions for ShellGroup {
    fn settings(&mut self) -> &mut dyn GroupSettings {
        self
    }

    fn deletion(&mut self) -> &mut dyn GroupDeletion {
        self
    }

    fn initial_state(&mut self) -> &mut dyn InitialState {
        self
    }
}

impl GroupSettings for ShellGroup {
    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        self.masses[element].copy_from_slice(masses);
    }

    fn follow(&mut self) {
        self.record = Some(Box::new(ShellRecord::new(self.ends.len(), self.stress.len())));
    }
}

impl GroupDeletion for ShellGroup {
    fn make_erodible(&mut self) {
        self.deleted = vec![false; self.ends.len()];
    }

    /// Deletes a shell and sets its stress to zero.
    fn erode(&mut self, element: usize, _volume: f64) {
        self.deleted[element] = true;
        self.state[element].shear = 0.0;
        self.set(element, Some([0.0; 4]), None);
    }
}

impl InitialState for ShellGroup {
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

persist_struct!(ShellState { thickness, shear, slow_rates, viscous });

persist_struct!(ShellGroup {
    deleted: fixed, masses: fixed, state: fixed, stress: fixed, flow: fixed, record: present
} derived {
    section, ends
});
