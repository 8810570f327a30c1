//! What is followed of shells over increments only because some output asks for it: strains and energies.
//! Never here: anything that stresses or forces need.

use crate::kernel::lanes::InlineMap;
use crate::kernel::shell::Five;
use crate::state::archive::persist_struct;

/// Of one element.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Followed {
    /// Section strains: membrane strains, curvatures, transverse shear.
    pub section: Five,
    /// Work of the stress, and the part of it that flow has dissipated.
    pub work: [f64; 2],
}

/// Of one point: strains along meridian, hoop and thickness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PointStrains {
    /// Logarithmic strain.
    pub total: [f64; 3],
    /// Plastic strain.
    pub plastic: [f64; 3],
    /// Strain rate of the increment behind.
    pub rate: [f64; 3],
}

/// Of a group.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    pub elements: Vec<Followed>,
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

impl Record {
    pub fn new(elements: usize, points: usize) -> Self {
        Record { elements: vec![Followed::default(); elements], points: vec![PointStrains::default(); points] }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.elements) + size_of_val(&*self.points)
    }
}

persist_struct!(Followed { section, work });

persist_struct!(PointStrains { total, plastic, rate });

persist_struct!(Record { elements: fixed, points: fixed });
