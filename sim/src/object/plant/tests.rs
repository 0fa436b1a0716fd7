//! Tests of how plants are drawn and built.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::*;
use crate::object::Group;

/// A plant with the default quantities.
fn draw(seed: u64) -> Box<dyn Object> {
    let group: Group<Plant> = toml::from_str("count = 1").unwrap();
    let footing = Footing { height_m: 0.0, foam_modulus_pa: Some(5e4) };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    group.0.draw(&mut random, &footing).unwrap().0
}

/// Tests that a plant weighs what its stem and blades with their petioles weigh.
#[test]
fn the_pieces_have_the_mass_of_the_whole() {
    let plant = draw(1);
    let value = |name: &str| plant.parameters()[name];
    let stem_kg = 0.25 * PI * value("stem_diameter_m").powi(2) * STEM_DENSITY_KG_PER_M3 * value("height_m");
    let blade_m2 = value("blade_width_m") * (value("blade_length_m") + value("petiole_m"));
    let blades_kg = value("blades") * value("mass_per_area_kg_per_m2") * blade_m2;
    let structure = plant.structure(9.81);
    let found: f64 = structure.bodies.iter().map(|body| body.inertia.mass_kg).sum();
    // The lowest piece of the stem does not move, so its mass is left out.
    assert!(found < stem_kg + blades_kg && found > 0.6 * stem_kg + blades_kg, "{found} {stem_kg} {blades_kg}");
}

/// Tests that blades droop by the given angle from base to tip, and that plants stay within their footprint and height.
#[test]
fn blades_droop_as_drawn() {
    for seed in 0..20 {
        let plant = draw(seed);
        let structure = plant.structure(9.81);
        let poses = structure.rest_poses(Pose::IDENTITY);
        let directions: Vec<f64> = structure
            .bodies
            .iter()
            .zip(&poses)
            .filter(|(body, _)| body.drag.is_some())
            .map(|(_, pose)| pose.transform_vector(DVec3::Z).z.asin().to_degrees())
            .collect();
        let (low, high) = directions.iter().fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(*at), high.max(*at)));
        let droop_deg = plant.parameters()["droop_deg"];
        // Hinges lie within the blade, so the highest piece already droops by the first hinge's part.
        assert!(high - low < droop_deg && high - low > 0.5 * droop_deg, "{low} {high} {droop_deg}");
        let (Footprint::Disc(radius_m), height_m) = plant.size() else { panic!("not a disc") };
        for pose in &poses {
            assert!(pose.position.truncate().length() <= radius_m && pose.position.z <= height_m);
            assert!(pose.position.z >= 0.0);
        }
    }
}
