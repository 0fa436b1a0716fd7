//! The map at the end of a reach beside the truth.

use std::sync::{Arc, Mutex};

use glam::DVec2;
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_recording::Category;
use underbrush_sim::controller::mapped::map::{Map, ObstacleKind};
use underbrush_sim::controller::{Controller, ControllerInput, ControllerKind, ControllerOutput, Mapped};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

/// An obstacle on the map is a trunk's if their axes are closer than this, m: one and a half diameters.
const SAME_M: f64 = 0.05;

/// The controller, with its map for others to see.
struct Open(Mapped, Arc<Mutex<Map>>);

impl Controller for Open {
    fn name(&self) -> &str {
        "open"
    }

    fn rate_hz(&self) -> f64 {
        self.0.rate_hz()
    }

    fn control(&mut self, input: &ControllerInput<'_>) -> ControllerOutput {
        let output = self.0.control(input);
        self.1.lock().unwrap().clone_from(self.0.map());
        output
    }
}

/// Prints precision and recall of trunks and the error of their places, with true verdicts and without.
pub fn print(seed: u64, count: u64, scenes: &[&str]) {
    println!("| verdicts | obstacles | of a trunk, % | trunks touched | on the map, % | error, mm: median, 90 % |");
    println!("|---|---|---|---|---|---|");
    for is_told in [true, false] {
        let (mut obstacles, mut right, mut touched, mut found) = (0, 0, 0, 0);
        let mut errors_mm: Vec<f64> = Vec::new();
        for scene in scenes {
            for index in 0..count {
                let map = Arc::new(Mutex::new(Map::default()));
                let shown = map.clone();
                let plan = ReachPlan::new(Scene::load(scene).unwrap(), Some(ControllerKind::Mapped), seed).unwrap();
                let preset = plan.controller.preset().unwrap().clone();
                let mut plan =
                    plan.with_controller(move |arm| Box::new(Open(Mapped::new(preset.clone(), arm), shown.clone())));
                if is_told {
                    plan = VerdictControl::truth().applied_to(plan).unwrap();
                }
                let recording = plan.run(index, &mut |_, _| {}).unwrap();
                let map = map.lock().unwrap();
                let of_trunks = recording.objects.iter().enumerate();
                let of_trunks = of_trunks.filter(|(_, object)| object.category == Category::TRUNK);
                let trunks: Vec<(usize, DVec2)> =
                    of_trunks.map(|(object, own)| (object, own.position_world.truncate())).collect();
                let lasting =
                    map.obstacles.iter().filter(|own| own.kind != ObstacleKind::Yielding && !own.has_given_way);
                let mapped: Vec<DVec2> = lasting.map(|own| own.axis_world()).collect();
                let nearest_m = |place: DVec2, others: &mut dyn Iterator<Item = DVec2>| {
                    others.map(|other| other.distance(place)).fold(f64::INFINITY, f64::min)
                };
                for place in &mapped {
                    let error_m = nearest_m(*place, &mut trunks.iter().map(|(_, trunk)| *trunk));
                    obstacles += 1;
                    if error_m < SAME_M {
                        right += 1;
                        errors_mm.push(1000.0 * error_m);
                    }
                }
                for (object, place) in &trunks {
                    let is_touched = |own: &underbrush_recording::Contact| {
                        usize::from(own.object) == *object && own.patch.is_some() && own.peak_force_n > 1.0
                    };
                    if recording.contacts.iter().any(is_touched) {
                        touched += 1;
                        found += usize::from(nearest_m(*place, &mut mapped.iter().copied()) < SAME_M);
                    }
                }
            }
        }
        errors_mm.sort_by(f64::total_cmp);
        let quantile =
            |share: f64| errors_mm.get((errors_mm.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN);
        let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole as f64;
        println!(
            "| {} | {obstacles} | {:.0} | {touched} | {:.0} | {:.0}, {:.0} |",
            if is_told { "true" } else { "none" },
            percent(right, obstacles),
            percent(found, touched),
            quantile(0.5),
            quantile(0.9)
        );
    }
}
