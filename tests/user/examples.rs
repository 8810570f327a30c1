//! The examples of laws and loads in Rust, which use the public interface only, against their closed forms.

use crate::{own_eos, own_load, own_material};

/// The temperature is that at the start of an increment, a thousandth of the plastic strain p: with the rate 0.3 of softening
/// an error of 0.3 p/2000, 4e-5.
#[test]
fn heated_law_softens_as_its_closed_form() {
    let [temperature, exact] = own_material::temperatures().expect("a run");
    assert!(exact > 15.0 && (temperature / exact - 1.0).abs() < 1e-4, "{temperature} {exact}");
}

#[test]
fn stiffened_gas_follows_its_isentrope() {
    let [pressure, exact] = own_eos::pressures().expect("a run");
    assert!((pressure / exact - 1.0).abs() < 1e-6, "{pressure:e} {exact:e}");
}

#[test]
fn crushed_bed_rebounds_and_survives_a_restart() {
    let folder = tempfile::tempdir().expect("a folder");
    let [velocity, restarted, exact] = own_load::velocities(folder.path()).expect("runs");
    assert_eq!(velocity.to_bits(), restarted.to_bits());
    assert!((velocity / exact - 1.0).abs() < 1e-5, "{velocity} {exact}");
}
