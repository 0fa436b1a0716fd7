//! The map of reaches beside the truth, over time.

use glam::DVec2;
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_recording::{Category, Contact, ObstacleKind, Recording};
use underbrush_sim::controller::ControllerKind;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

/// An obstacle on the map is a trunk's if their axes are closer than this, m: one and a half diameters.
const SAME_M: f64 = 0.05;
/// When maps are judged, s.
const AT_S: [f64; 4] = [5.0, 10.0, 20.0, f64::INFINITY];

/// What maps hold at a time.
#[derive(Default)]
struct Judged {
    obstacles: usize,
    touched: usize,
    found: usize,
    /// Distances of obstacles that are a trunk's from its axis, mm.
    errors_mm: Vec<f64>,
}

impl Judged {
    /// Takes in the map of a frame.
    fn add(&mut self, recording: &Recording, frame: u32) {
        let lasting = recording.map.iter().filter(|own| own.kind != ObstacleKind::Yielding);
        let lasting = lasting.filter(|own| (own.first_frame..=own.last_frame).contains(&frame));
        let mapped: Vec<DVec2> = lasting.map(|own| own.top_world.truncate()).collect();
        let objects = recording.objects.iter().enumerate();
        let trunks = objects.filter(|(_, object)| object.category == Category::TRUNK);
        let trunks: Vec<(usize, DVec2)> = trunks.map(|(index, own)| (index, own.position_world.truncate())).collect();
        let nearest_m = |place: DVec2, others: &mut dyn Iterator<Item = DVec2>| {
            others.map(|other| other.distance(place)).fold(f64::INFINITY, f64::min)
        };
        for place in &mapped {
            let error_m = nearest_m(*place, &mut trunks.iter().map(|(_, trunk)| *trunk));
            self.obstacles += 1;
            if error_m < SAME_M {
                self.errors_mm.push(1000.0 * error_m);
            }
        }
        for (object, place) in &trunks {
            let is_touch = |own: &Contact| {
                usize::from(own.object) == *object
                    && own.first_frame <= frame
                    && own.patch.is_some()
                    && own.peak_force_n > 1.0
            };
            if recording.contacts.iter().any(is_touch) {
                self.touched += 1;
                self.found += usize::from(nearest_m(*place, &mut mapped.iter().copied()) < SAME_M);
            }
        }
    }
}

/// Prints precision and recall of trunks and the error of their places, with true verdicts and without.
pub fn print(seed: u64, count: u64, scenes: &[&str]) {
    println!(
        "| verdicts | after | obstacles | of a trunk, % | trunks touched | on the map, % | error, mm: median, 90 % |"
    );
    println!("|---|---|---|---|---|---|---|");
    for is_told in [true, false] {
        let mut judged = AT_S.map(|_| Judged::default());
        for scene in scenes {
            let mut plan = ReachPlan::new(Scene::load(scene).unwrap(), Some(ControllerKind::Mapped), seed).unwrap();
            if is_told {
                plan = VerdictControl::truth().applied_to(plan).unwrap();
            }
            for index in 0..count {
                let recording = plan.run(index, &mut |_| {}).unwrap();
                let last = recording.frames.len() as u32 - 1;
                for (at_s, own) in AT_S.iter().zip(&mut judged) {
                    // Of a reach that has ended by then, its last map.
                    own.add(&recording, last.min((at_s * recording.rate_hz) as u32));
                }
            }
        }
        for (at_s, own) in AT_S.iter().zip(&mut judged) {
            own.errors_mm.sort_by(f64::total_cmp);
            let quantile = |share: f64| own.errors_mm.get((own.errors_mm.len() as f64 * share) as usize);
            let [median, ninety] = [0.5, 0.9].map(|share| quantile(share).copied().unwrap_or(f64::NAN));
            let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole as f64;
            println!(
                "| {} | {} | {} | {:.0} | {} | {:.0} | {median:.0}, {ninety:.0} |",
                if is_told { "true" } else { "none" },
                if at_s.is_finite() { format!("{at_s:.0} s") } else { "end".into() },
                own.obstacles,
                percent(own.errors_mm.len(), own.obstacles),
                own.touched,
                percent(own.found, own.touched),
            );
        }
    }
}
