//! Thermal strain (`*EXPANSION`): what it takes off the strain that stresses answer to.
//! Never here: where temperatures come from.

use std::sync::Arc;

use super::conductors::at;
use super::field::Heat;
use crate::element::elements::Elements;
use crate::kernel::hardening::Table;
use crate::kernel::lists::heap_bytes;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;

/// How a group of elements expands: `alpha(T) (T - T0) - alpha(T_I) (T_I - T0)` from its temperatures T_I at the start (ABAQUS
/// Analysis User's Guide 26.1.2, "Thermal expansion").
#[derive(Clone, Debug)]
pub struct Expanding {
    pub id: EffectId,
    pub group: usize,
    /// Coefficient over temperature, from the reference temperature.
    pub coefficient: Table,
    /// T0.
    pub reference: f64,
}

impl Expanding {
    /// Strain over that at T0.
    fn strain(&self, temperature: f64) -> f64 {
        at(&self.coefficient, temperature) * (temperature - self.reference)
    }
}

/// All that expands.
#[derive(Clone)]
pub struct Expansion {
    list: Arc<Vec<Expanding>>,
    /// Strains over those at T0 that elements have been given, group by group.
    strains: Vec<Vec<f64>>,
    /// Room for temperatures and increments of a group.
    room: [Vec<f64>; 2],
}

impl Expansion {
    /// Groups with the temperatures of their elements at the start.
    pub fn new(list: Vec<(Expanding, Vec<f64>)>) -> Self {
        let most = list.iter().map(|l| l.1.len()).max().unwrap_or(0);
        let strains = list.iter().map(|(e, start)| start.iter().map(|t| e.strain(*t)).collect()).collect();
        let list = Arc::new(list.into_iter().map(|l| l.0).collect());
        Expansion { list, strains, room: [vec![0.0; most], vec![0.0; most]] }
    }

    /// Takes the strain of the temperatures of now off; books what elements will book too little in their work.
    pub(super) fn apply(&mut self, heat: Option<&Heat>, elements: &mut Elements, dofs: &mut Dofs) {
        let [temperatures, increments] = &mut self.room;
        for (expanding, strains) in self.list.iter().zip(&mut self.strains) {
            let Some(group) = elements.groups[expanding.group].extensions().temperatures() else { continue };
            let (temperatures, increments) = (&mut temperatures[..strains.len()], &mut increments[..strains.len()]);
            match heat.and_then(|h| h.given_to(expanding.group)) {
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
                dofs.energies.internal += group.expand(increments, dofs.nodes.as_slice(), dofs.nodes.behind);
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.strains.iter().chain(&self.room).map(heap_bytes).sum()
    }
}

persist_struct!(Expansion { strains: fixed_lists } derived { list, room });
