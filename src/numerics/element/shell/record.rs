//! Strains and energies of shells that are integrated over increments for output only.

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::shell::SectionComponents;
use crate::state::archive::Persist;

/// Recorded values of one element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub(super) struct ShellElementRecord {
    /// Section strains: membrane strains, curvatures, transverse shear.
    pub section: SectionComponents,
    /// Work of the stress, and its plastically dissipated part.
    pub work: [f64; 2],
}

/// Recorded strains of one point: meridian, hoop, thickness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub(super) struct PointStrains {
    /// Logarithmic strain.
    pub total: [f64; 3],
    /// Plastic strain.
    pub plastic: [f64; 3],
    /// Strain rate of the previous increment.
    pub rate: [f64; 3],
}

/// Recorded values of a group.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: elements, points)]
pub(super) struct ShellRecord {
    pub elements: Vec<ShellElementRecord>,
    pub points: Vec<PointStrains>,
}

impl PointStrains {
    pub fn follow(&mut self, strain: [f64; 3], plastic: [f64; 2], dt: f64) {
        let plastic = [plastic[0], plastic[1], -(plastic[0] + plastic[1])];
        self.total.iter_mut().zip(strain).for_each(|(sum, strain)| *sum += strain);
        self.plastic.iter_mut().zip(plastic).for_each(|(sum, strain)| *sum += strain);
        self.rate = strain.inline_map(|strain| if dt > 0.0 { strain / dt } else { 0.0 });
    }
}

impl ShellRecord {
    pub fn new(elements: usize, points: usize) -> Self {
        ShellRecord {
            elements: vec![ShellElementRecord::default(); elements],
            points: vec![PointStrains::default(); points],
        }
    }
}
