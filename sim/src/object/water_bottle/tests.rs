#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use super::*;
use crate::object::Group;

const FOOTING: Footing = Footing { height_m: 0.0, foam_modulus_pa: None };

/// Tests that a group of bottles that would overflow is refused with the mass of water that fits, and that no bottle of
/// a mixed group overflows.
#[test]
fn no_bottle_overflows() {
    let mut random = crate::seed::stream(0, "bottles", 0, "clutter");
    let group = |text: &str| -> Group<WaterBottle> { toml::from_str(&format!("count = 1\n{text}")).unwrap() };
    let full = "diameter_m = 0.2\nheight_m = 0.3\n";
    // π 0.1² · 0.3 m³ are 9.42 l.
    let error = group(&format!("{full}water_mass_kg = 9.5")).0.draw(&mut random, &FOOTING);
    let high = error.unwrap_err().high;
    assert!((high - 9.4248).abs() < 1e-4, "{high}");
    let mixed = group(&format!("{full}water_mass_kg = {{ uniform = [5, 15] }}"));
    for _ in 0..200 {
        let (drawn, _) = mixed.0.draw(&mut random, &FOOTING).unwrap();
        assert!(drawn.parameters()["water_mass_kg"] <= high);
    }
}

/// Tests mass, centre of mass and inertia of a bottle against values computed by hand: 1 kg of wall, 0.2 m thick and
/// 0.4 m high, and 3.1416 kg of water, which is 0.1 m deep.
#[test]
fn mass_and_inertia_are_those_of_wall_and_water() {
    let bottle = WaterBottle { diameter_m: 0.2, height_m: 0.4, empty_mass_kg: 1.0, water_mass_kg: PI, friction: 0.2 };
    // (1 · 0.2 + π · 0.05) / (1 + π)
    let center = bottle.center_of_mass_m();
    assert!((center - 0.0862179).abs() < 1e-6, "{center}");
    let inertia = bottle.inertia();
    assert!((inertia.mass_kg - 4.1415927).abs() < 1e-6);
    // Wall: m r² = 0.01; water: m r² / 2 = 0.0157080.
    assert!((inertia.principal_kg_m2.z - 0.0257080).abs() < 1e-6);
    // Wall: (6 r² + h²) / 12 = 0.0183333 and 0.1137821² more; water: π (3 r² + 0.1²) / 12 = 0.0104720 and π 0.0362179²
    // more.
    let across = 0.0183333 + 0.0129464 + 0.0104720 + 0.0041209;
    let found = inertia.principal_kg_m2;
    assert!((found.x - across).abs() < 1e-6 && found.x == found.y, "{found}");
}
