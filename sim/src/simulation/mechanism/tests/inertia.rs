//! Tests of the masses of objects in the engine.

use glam::DVec3;

use super::build;
use crate::object::Object;
use crate::object::foam_roll::FoamRoll;
use crate::object::leaf::Leaf;
use crate::object::water_bottle::WaterBottle;
use crate::physics::PhysicsOptions;
use crate::simulation::engine::Engine;

/// Tests that the bodies of light and heavy objects have the moments of inertia of their structure about the right axes, to
/// rounding. A piece of a leaf has some 1e-6 kg m².
#[test]
fn the_engine_has_the_inertia_of_the_structure() {
    let leaf = Leaf {
        height_m: 0.3,
        width_m: 0.03,
        flexural_rigidity_n_m2: 0.02,
        mass_per_area_kg_per_m2: 0.8,
        loss_factor: 0.2,
        root_stiffness_nm_per_rad: Some(2.0),
        segments: 4,
    };
    let roll = FoamRoll {
        diameter_m: 0.12,
        height_m: 0.5,
        modulus_pa: 1e5,
        relaxing_share: 0.5,
        relaxation_time_s: 2.0,
        density_kg_per_m3: 30.0,
    };
    let bottle =
        WaterBottle { diameter_m: 0.26, height_m: 0.45, empty_mass_kg: 0.75, water_mass_kg: 0.3, friction: 0.15 };
    for object in [&leaf as &dyn Object, &roll, &bottle] {
        let mut engine = Engine::new(PhysicsOptions { step_s: 1e-9, gravity_m_per_s2: 0.0 });
        let mechanism = build(object, &mut engine);
        // The engine sums up the masses in its first step.
        engine.step_without_contacts();
        for (own, body) in object.structure().bodies.iter().zip(mechanism.bodies()).skip(1) {
            let found = engine.bodies[*body].mass_properties();
            let inertia = found.effective_angular_inertia();
            let principal = own.inertia.principal_kg_m2;
            let diagonal = DVec3::new(inertia.m11, inertia.m22, inertia.m33);
            let rest = DVec3::new(inertia.m12, inertia.m13, inertia.m23);
            let rounding = 1e-12 * principal.max_element();
            assert!(
                (diagonal - principal).abs().max_element() <= rounding,
                "{}: {diagonal}, {principal}",
                object.kind()
            );
            assert!(rest.abs().max_element() <= rounding, "{}: {rest}", object.kind());
            assert!((found.mass() - own.inertia.mass_kg).abs() <= 1e-12 * own.inertia.mass_kg);
            assert!(found.local_mprops.local_com.distance(own.inertia.center_of_mass_body) < 1e-12);
        }
    }
}
