//! Cards of materials whose strength depends on pressure, porosity or direction.

use crate::deck::Span;
pub use crate::deck::table::strength::{
    CapHardening, CapPlasticity, ConcreteCompressionDamage, ConcreteCompressionHardening, ConcreteDamagedPlasticity,
    ConcreteFailure, ConcreteTensionDamage, ConcreteTensionStiffening, DruckerPrager, DruckerPragerHardening,
    HolmquistJohnsonCook, PorousFailureCriteria, PorousMetalPlasticity, Potential, VoidNucleation,
};

/// Returns the tangent of an angle in degrees, with the same bits on every machine.
pub fn tangent(degrees: f64) -> f64 {
    libm::tan(degrees.to_radians())
}

impl DruckerPrager {
    /// Returns K, the ratio of the flow stresses in triaxial tension and compression; 0 and the default mean 1.
    pub fn ratio(&self) -> f64 {
        if self.row[1] == 0.0 { 1.0 } else { self.row[1] }
    }
}

impl StrengthCards {
    /// Returns whether the stress depends on the length of the element.
    pub fn takes_length(&self) -> bool {
        self.tension_stiffening.as_ref().is_some_and(|(card, _)| card.kind > 0)
    }

    /// Returns whether the constants or tables of a card depend on the strain rate.
    pub fn depends_on_rate(&self) -> bool {
        let ceramic = self.johnson_holmquist.as_ref().is_some_and(
            |(constants, _)| matches!(constants[..], [_density, _shear, _a, _n, _b, _m, c, ..] if c != 0.0),
        );
        let concrete = self
            .holmquist_johnson_cook
            .as_ref()
            .is_some_and(|(card, _)| matches!(card.rows[..], [[_shear, _a, _b, c, ..], ..] if c != 0.0));
        let has_rates = |rows: &[[f64; 3]]| rows.windows(2).any(|pair| pair[0][2] != pair[1][2]);
        ceramic
            || concrete
            || self.compression_hardening.as_ref().is_some_and(|(card, _)| has_rates(&card.rows))
            || self.tension_stiffening.as_ref().is_some_and(|(card, _)| has_rates(&card.rows))
    }

    /// Multiplies displacements and energies per crack area by a factor: in an element whose length is larger by this factor,
    /// strains and stresses remain the same.
    pub fn scale_displacements(&mut self, factor: f64) {
        if let Some((card, _)) = self.tension_stiffening.as_mut().filter(|(card, _)| card.kind > 0) {
            card.rows.iter_mut().for_each(|row| row[1] *= factor);
        }
        if let Some((card, _)) = self.tension_damage.as_mut().filter(|(card, _)| card.by_displacement) {
            card.rows.iter_mut().for_each(|row| row[1] *= factor);
        }
        if let Some((card, _)) = self.concrete_failure.as_mut().filter(|(card, _)| card.by_displacement) {
            card.limits[0] *= factor;
        }
    }
}

/// Declares a field for each card, and the functions that visit them.
macro_rules! strength_cards {
    ($($(#[$doc:meta])* $field:ident: $card:ident,)+) => {
        /// Cards of a material that define its strength, with their source positions. The plan combines them to a law.
        #[derive(Clone, Debug, Default)]
        pub struct StrengthCards {
            /// Constants of `*USER MATERIAL` of a material whose name begins with `ABQ_JH2`: the second law of Johnson and
            /// Holmquist.
            pub johnson_holmquist: Option<(Vec<f64>, Span)>,
            $($(#[$doc])* pub $field: Option<($card, Span)>,)+
        }

        impl StrengthCards {
            /// Returns keyword and source position of each card.
            pub fn cards(&self) -> impl Iterator<Item = (&'static str, Span)> {
                let user = self.johnson_holmquist.as_ref().map(|(_, span)| ("USER MATERIAL", *span));
                let others = [$(self.$field.as_ref().map(|(_, span)| ($card::ROW.name, *span))),+];
                user.into_iter().chain(others.into_iter().flatten())
            }
        }
    };
}

strength_cards! {
    /// `*DRUCKER PRAGER`.
    drucker_prager: DruckerPrager,
    /// `*DRUCKER PRAGER HARDENING`.
    drucker_prager_hardening: DruckerPragerHardening,
    /// `*CAP PLASTICITY`.
    cap: CapPlasticity,
    /// `*CAP HARDENING`.
    cap_hardening: CapHardening,
    /// `*CONCRETE DAMAGED PLASTICITY`.
    concrete: ConcreteDamagedPlasticity,
    /// `*CONCRETE COMPRESSION HARDENING`.
    compression_hardening: ConcreteCompressionHardening,
    /// `*CONCRETE TENSION STIFFENING`.
    tension_stiffening: ConcreteTensionStiffening,
    /// `*CONCRETE COMPRESSION DAMAGE`.
    compression_damage: ConcreteCompressionDamage,
    /// `*CONCRETE TENSION DAMAGE`.
    tension_damage: ConcreteTensionDamage,
    /// `*CONCRETE FAILURE`.
    concrete_failure: ConcreteFailure,
    /// `*HOLMQUIST JOHNSON COOK`.
    holmquist_johnson_cook: HolmquistJohnsonCook,
    /// `*POTENTIAL`.
    potential: Potential,
    /// `*POROUS METAL PLASTICITY`.
    porous_metal: PorousMetalPlasticity,
    /// `*VOID NUCLEATION`.
    void_nucleation: VoidNucleation,
    /// `*POROUS FAILURE CRITERIA`.
    porous_failure: PorousFailureCriteria,
}
