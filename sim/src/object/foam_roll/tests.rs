#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use super::*;
use crate::object::Group;

/// Tests that a group whose rolls would all topple is refused with the modulus that is needed, that only rolls that
/// stand are drawn from a mixed group, and that all rolls of the default ranges stand.
#[test]
fn only_rolls_that_stand_are_drawn() {
    let footing = Footing { height_m: 0.0, foam_modulus_pa: None };
    let mut random = crate::seed::stream(0, "rolls", 0, "clutter");
    let group = |modulus_pa: &str| -> Group<FoamRoll> { toml::from_str(&format!("count = 1\n{modulus_pa}")).unwrap() };
    let error = group("modulus_pa = 5e3").0.draw(&mut random, &footing).unwrap_err();
    assert!(error.low > 5e3 && error.low < 1e5, "{error:?}");
    let mixed = group("modulus_pa = { uniform = [5e3, 2e5] }\nrelaxing_share = 0.6");
    for _ in 0..200 {
        let (standing, _) = mixed.0.draw(&mut random, &footing).unwrap();
        let of = |name: &str| standing.parameters()[name];
        let standing = FoamRoll {
            diameter_m: of("diameter_m"),
            height_m: of("height_m"),
            modulus_pa: of("modulus_pa"),
            relaxing_share: of("relaxing_share"),
            relaxation_time_s: of("relaxation_time_s"),
            density_kg_per_m3: of("density_kg_per_m3"),
        };
        assert!(standing.stands_by_itself(), "{standing:?}");
    }
    // The slimmest, highest and softest roll of the default ranges.
    let worst = FoamRoll {
        diameter_m: 0.10,
        height_m: 0.55,
        modulus_pa: 5.0e4,
        relaxing_share: 0.6,
        relaxation_time_s: 3.0,
        density_kg_per_m3: 30.0,
    };
    assert!(worst.stands_by_itself(), "{}", worst.load_share());
}
