//! A group of two-node axisymmetric shells with the same section.
//!
//! Nodes of shells have a rotation as well as displacements. The rotation is stored as a companion node: its first
//! coordinate is the angle (counter-clockwise in r and z, radians), its mass is the rotary inertia. A shell therefore
//! acts on two nodes and their two companion nodes; moments act on companion nodes as forces along r act on nodes.

use crate::kernel::lists::Memory;
use std::sync::Arc;

use pulp::Arch;

use super::block::ShellBlockUpdate;
use super::record::{PointStrains, ShellRecord};
use super::section::{ShellProperties, ThicknessPoint};
use crate::element::criteria::DeletionFilter;
use crate::element::group::{ElementGroup, ElementPass, GroupProperties, GroupSetting, GroupTotals};
use crate::element::lane_sums::is_larger;
use crate::kernel::laminate::in_layer;
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::shell::{SectionComponents, ShellFrame};
use crate::kernel::topology::{ElementNodes, ElementTopology, PerNode};
use crate::material::PointValue;
use crate::material::available::AvailableEnergy;
use crate::state::archive::Persist;
use crate::state::nodes::Node;
use crate::variables::{Variable, VariableComponent};

/// Group of shell elements with the same section.
#[derive(Clone, Persist)]
#[persist(fixed: deleted, masses, state, stress, flow; present: record; derived: section, arch, ends)]
pub struct ShellGroup {
    pub(super) section: Arc<ShellProperties>,
    /// Instruction set of the update.
    arch: Arch,
    /// Nodes, then their rotations.
    pub(super) ends: Vec<[u32; 4]>,
    /// Masses of the nodes, then rotary inertias.
    pub(super) masses: Vec<[f64; 4]>,
    pub(super) state: Vec<ShellState>,
    /// Stress along meridian and hoop at the section points, element by element.
    pub(super) stress: Vec<[f64; 2]>,
    /// Plastic state of the section points; empty for an elastic section.
    pub(super) flow: Vec<ShellPointState>,
    /// Record for output; `None` if not requested.
    pub(super) record: Option<Box<ShellRecord>>,
    /// Deleted elements; empty if no element can be deleted.
    deleted: Vec<bool>,
}

/// State of an element apart from its section points.
#[derive(Clone, Copy, Debug, Default, Persist)]
pub(super) struct ShellState {
    /// Current thickness, length.
    pub thickness: f64,
    /// Transverse shear force per length.
    pub shear: f64,
    /// Slow parts of the rates of area and curvature.
    pub slow_rates: [f64; 2],
    /// Force and moment of bulk viscosity per length.
    pub viscous: [f64; 2],
}

/// Plastic state of a section point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub(super) struct ShellPointState {
    /// Equivalent plastic strain.
    pub strain: f64,
    pub temperature: f64,
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
            frame.masses(radii, section.per_area, section.rotary)
        };
        let points = ends.len() * section.points.len();
        ShellGroup {
            masses: ends.iter().zip(&frames).map(masses).collect(),
            state: vec![ShellState { thickness: section.thickness, ..ShellState::default() }; ends.len()],
            stress: vec![[0.0; 2]; points],
            flow: if section.flows() { vec![ShellPointState::default(); points] } else { Vec::new() },
            section: Arc::new(section),
            arch: Arch::new(),
            ends,
            record: None,
            deleted: Vec::new(),
        }
    }

    fn frame(&self, element: usize, nodes: &[Node]) -> ShellFrame {
        frame(&self.ends[element], nodes)
    }

    pub(super) fn is_deleted(&self, element: usize) -> bool {
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

    /// Returns a component 11, 22, 33 or 12 of the stress at a section point in the directions of its layer.
    fn stress_in_layer(&self, point: usize, component: usize) -> f64 {
        let layer = &self.section.layers[self.section.points[point % self.section.points.len()].layer];
        let [along, hoop] = self.stress[point];
        let [first, second, shear] = in_layer(layer.angle, [along, hoop, layer.elasticity.shear_stress([along, hoop])]);
        [first, second, 0.0, shear].get(component).copied().unwrap_or(0.0)
    }

    /// Returns a component 11, 22, 33 or 12 (engineering shear) of a strain along meridian, hoop and thickness in the
    /// directions of the layer of a section point.
    fn strain_in_layer(&self, point: usize, [along, hoop, thinning]: [f64; 3], component: usize) -> f64 {
        let layer = &self.section.layers[self.section.points[point % self.section.points.len()].layer];
        let [first, second, shear] = in_layer(layer.angle, [along, hoop, 0.0]);
        [first, second, thinning, 2.0 * shear].get(component).copied().unwrap_or(0.0)
    }

    /// Returns forces and moments of the stress per length.
    fn resultants(&self, element: usize) -> SectionComponents {
        let ShellState { thickness, shear, .. } = self.state[element];
        let count = self.section.points.len();
        let points = self.section.points.iter().zip(&self.stress[element * count..]);
        let mut sums = [0.0, 0.0, 0.0, 0.0, shear];
        for (ThicknessPoint { place, weight, .. }, stress) in points {
            let (share, height) = (weight * thickness, 0.5 * place * thickness);
            for (i, stress) in stress.iter().enumerate() {
                sums[i] += share * stress;
                sums[2 + i] += share * height * stress;
            }
        }
        sums
    }
}

/// Returns the current frame of two nodes.
fn frame(ends: &[u32; 4], nodes: &[Node]) -> ShellFrame {
    ShellFrame::new([ends[0], ends[1]].inline_map(|n| nodes[n as usize].place()))
}

impl DeletionFilter for ShellGroup {}

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
            equation_of_state: false,
            fields: 0,
            tiles: false,
        }
    }

    fn nodes(&self, element: usize) -> ElementNodes {
        self.ends[element].into()
    }

    fn masses(&self, element: usize) -> PerNode<f64> {
        self.masses[element].into()
    }

    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        self.masses[element].copy_from_slice(masses);
    }

    fn update(&mut self, pass: ElementPass<'_>) -> GroupTotals {
        let ElementPass { nodes, dt, corners, .. } = pass;
        let (arch, mut totals) = (self.arch, GroupTotals::default());
        for (index, corners) in corners.iter_mut().enumerate() {
            let updated = arch.dispatch(ShellBlockUpdate { group: self, index, nodes, dt, corners });
            for element in (index * LANES..self.ends.len().min((index + 1) * LANES)).filter(|e| !self.is_deleted(*e)) {
                let l = element % LANES;
                let [internal, plastic, viscous] = updated.work.inline_map(|list| list[l]);
                totals.internal += internal;
                totals.plastic += plastic;
                totals.viscous += viscous;
                if is_larger(updated.rate[l], totals.rate) {
                    (totals.rate, totals.limiting) = (updated.rate[l], element);
                }
            }
        }
        totals
    }

    fn value(&self, element: usize, part: VariableComponent) -> Option<f64> {
        let component = part.component;
        if let Some((variable, side)) = place(part.variable) {
            let point = self.point(element, side);
            let strain = |of: fn(&PointStrains) -> [f64; 3]| {
                Some(self.strain_in_layer(point, of(self.record.as_ref()?.points.get(point)?), component))
            };
            return match variable {
                Variable::Stress => Some(self.stress_in_layer(point, component)),
                Variable::PlasticStrain => Some(self.flow.get(point)?.strain),
                Variable::Temperature => Some(self.flow.get(point)?.temperature),
                Variable::LogarithmicStrain => strain(|p| p.total),
                Variable::PlasticComponents if self.flow.is_empty() => None,
                Variable::PlasticComponents => strain(|p| p.plastic),
                _ => strain(|p| p.rate),
            };
        }
        let followed = || Some(self.record.as_ref()?.elements[element]);
        match part.variable {
            Variable::Thickness => self.thickness(element),
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

    fn set(&mut self, element: usize, value: PointValue) -> bool {
        let count = self.section.points.len();
        let points = element * count..(element + 1) * count;
        match value {
            PointValue::Stress([meridian, hoop, ..]) => self.stress[points].fill([meridian, hoop]),
            PointValue::Temperature(temperature) => {
                self.flow.get_mut(points).into_iter().flatten().for_each(|f| f.temperature = temperature);
            }
            _ => return false,
        }
        true
    }

    fn thickness(&self, element: usize) -> Option<f64> {
        Some(self.state[element].thickness)
    }

    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64> {
        let masses = masses.map_or(Some(&self.masses[element]), |list| list.first_chunk())?;
        Some(self.section.rate(&self.frame(element, nodes), masses, self.state[element].thickness, 0.0))
    }

    fn available_energy(&self, element: usize, nodes: &[Node]) -> AvailableEnergy {
        let points = self.section.points.iter().zip(&self.stress[element * self.section.points.len()..]);
        let per_area = points.map(|(p, stress)| p.weight * self.section.layers[p.layer].elasticity.energy(*stress));
        let volume = self.frame(element, nodes).area() * self.state[element].thickness;
        AvailableEnergy::initial(volume * per_area.sum::<f64>())
    }

    fn configure(&mut self, setting: GroupSetting) {
        match setting {
            GroupSetting::Records => {
                self.record = Some(Box::new(ShellRecord::new(self.ends.len(), self.stress.len())));
            }
            GroupSetting::Deletion => self.deleted = vec![false; self.ends.len()],
            GroupSetting::Instructions(arch) => self.arch = arch,
            GroupSetting::StableRates | GroupSetting::MassScales | GroupSetting::HighestFrequency(_) => {}
        }
    }

    /// Deletes a shell and sets its stress to zero.
    fn erode(&mut self, element: usize, _volume: f64) {
        self.deleted[element] = true;
        self.state[element].shear = 0.0;
        self.set(element, PointValue::Stress([0.0; 4]));
    }

    fn bytes(&self) -> usize {
        let lists = size_of_val(&*self.section.points) + size_of_val(&*self.section.layers);
        let section = size_of_val(&*self.section) + lists;
        let elements = size_of_val(&*self.ends) + size_of_val(&*self.masses) + size_of_val(&*self.state);
        let record = self.record.as_ref().map_or(0, |r| size_of_val(&**r) + r.bytes());
        section + elements + size_of_val(&*self.stress) + size_of_val(&*self.flow) + record + self.deleted.capacity()
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }
}
