//! Thermal strain (`*EXPANSION`), which is subtracted from the strain that causes stress.

use std::sync::Arc;

use super::conductors::at;
use super::field::TemperatureField;
use crate::element::elements::Elements;
use crate::kernel::hardening::LinearTable;
use crate::kernel::lists::Memory;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;

/// Thermal expansion of a group of elements: `alpha(T) (T - T0) - alpha(T_I) (T_I - T0)`, with the initial temperature
/// T_I (ABAQUS Analysis User's Guide 26.1.2, "Thermal expansion").
#[derive(Clone, Debug)]
pub struct GroupExpansion {
    pub id: EffectId,
    pub group: usize,
    /// Mean coefficient from the reference temperature, over temperature.
    pub coefficient: LinearTable,
    /// Reference temperature T0.
    pub reference: f64,
}

impl GroupExpansion {
    /// Returns the thermal strain relative to T0. Equation (6.7).
    fn strain(&self, temperature: f64) -> f64 {
        at(&self.coefficient, temperature) * (temperature - self.reference)
    }
}

/// Thermal strains of all groups with expansion.
#[derive(Clone, Persist, Memory)]
#[persist(fixed_lists: strains; derived: list, scratch)]
#[memory(inside: strains; uncounted: list)]
pub struct ThermalStrains {
    list: Arc<Vec<GroupExpansion>>,
    /// Strains relative to T0 already applied to the elements, group by group.
    strains: Vec<Vec<f64>>,
    /// Work arrays for temperatures and strain increments of a group.
    scratch: [Vec<f64>; 2],
}

impl ThermalStrains {
    /// Creates the strains from groups with the initial temperatures of their elements.
    pub fn new(list: Vec<(GroupExpansion, Vec<f64>)>) -> Self {
        let largest = list.iter().map(|l| l.1.len()).max().unwrap_or(0);
        let strains = list.iter().map(|(e, start)| start.iter().map(|t| e.strain(*t)).collect()).collect();
        let list = Arc::new(list.into_iter().map(|l| l.0).collect());
        ThermalStrains { list, strains, scratch: [vec![0.0; largest], vec![0.0; largest]] }
    }

    /// Applies the increments of thermal strain at the current temperatures, and adds the stress work that the element
    /// update will omit.
    pub(super) fn apply(&mut self, heat: Option<&TemperatureField>, elements: &mut Elements, dofs: &mut Dofs) {
        let [temperatures, increments] = &mut self.scratch;
        for (expanding, strains) in self.list.iter().zip(&mut self.strains) {
            let Some(group) = elements.groups[expanding.group].as_solid() else { continue };
            let (temperatures, increments) = (&mut temperatures[..strains.len()], &mut increments[..strains.len()]);
            let prescribed = || elements.fields.as_ref()?.temperatures_of(expanding.group);
            match heat.and_then(|h| h.given_to(expanding.group)).or_else(prescribed) {
                Some(given) => temperatures.copy_from_slice(given),
                None => group.temperatures(temperatures),
            }
            let mut any = false;
            for ((strain, temperature), increment) in strains.iter_mut().zip(&*temperatures).zip(&mut *increments) {
                let now = expanding.strain(*temperature);
                *increment = now - *strain;
                *strain = now;
                any |= *increment != 0.0;
            }
            if any {
                let work = group.expand(increments, dofs.nodes.as_slice(), dofs.nodes.previous_dt);
                dofs.energies.internal += work.omitted;
                dofs.energies.supplied += work.supplied;
            }
        }
    }

    /// Adds the thermal strains at the current temperatures of a group, times a sign, to those that have been applied. Taken
    /// off before a transport in an adaptive mesh and added after it, only the strain that is still to be applied stays.
    pub fn add_current(&mut self, sign: f64, index: usize, heat: Option<&TemperatureField>, elements: &mut Elements) {
        let [temperatures, _] = &mut self.scratch;
        for (expanding, strains) in self.list.iter().zip(&mut self.strains).filter(|e| e.0.group == index) {
            let temperatures = &mut temperatures[..strains.len()];
            let prescribed = elements.fields.as_ref().and_then(|fields| fields.temperatures_of(index));
            match (heat.filter(|heat| heat.conducts(index)), prescribed) {
                (Some(heat), _) => {
                    for (e, temperature) in temperatures.iter_mut().enumerate() {
                        *temperature = heat.element_temperature(index, e).unwrap_or(f64::NAN);
                    }
                }
                (None, Some(given)) => temperatures.copy_from_slice(given),
                (None, None) => {
                    if let Some(group) = elements.groups[index].as_solid() {
                        group.temperatures(temperatures);
                    }
                }
            }
            for (strain, temperature) in strains.iter_mut().zip(&*temperatures) {
                *strain += sign * expanding.strain(*temperature);
            }
        }
    }

    /// Takes the applied strains of the other groups of a model in which a group had another mesh.
    pub fn follow_new_mesh(&mut self, previous: &ThermalStrains, index: usize) {
        let lists = self.list.iter().zip(self.strains.iter_mut().zip(&previous.strains));
        lists.filter(|(own, _)| own.group != index).for_each(|(_, (strains, before))| strains.clone_from(before));
    }

    /// Returns the strains of a group; `None` if it does not expand.
    pub fn of_group(&mut self, index: usize) -> Option<&mut Vec<f64>> {
        self.list.iter().zip(&mut self.strains).find(|e| e.0.group == index).map(|e| e.1)
    }
}
