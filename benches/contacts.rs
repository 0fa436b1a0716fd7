//! How contacts look in whole reaches: the direction and work of friction, the onset on trunks, jumps of force, and
//! depth.
//!
//!     cargo run --release --example contacts -- 20 scenes/leaf.toml scenes/trunk.toml
//!
//! Prints one row for each scene over that many reaches of seed 0. Columns: angle between friction and −slip where a
//! patch slides, median and 90 %; work of friction divided by μ N times the sliding distance; time until a link's force
//! on a trunk is 63 % of the level it has 0.15 to 0.3 s after the touch, and the largest force of the first 150 ms
//! divided by that level, medians; largest change of a link's force from one frame to the next, with and without an
//! impact or a back-off in the last 0.15 s; largest overlap with each category, and with patches that reach farther
//! than 5 mm. Below the table there is a row for each jump of more than 5 N without an impact or back-off: reach,
//! frame, link and object, and what changed.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the table is what it is run for")]

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;
use underbrush_recording::Category;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use underbrush_sim::simulation::{FrameReport, Simulation};

/// A patch that slips more slowly than this may stick, m/s.
const SLIDING_M_PER_S: f64 = 5e-3;
/// A link and an object that have not touched for this many frames meet with an impact. The whole arm feels the impact
/// for the same number of frames.
const IMPACT_FRAMES: usize = 15;
/// The controller backs off by changing an equilibrium angle by more than this from one frame to the next, rad. That
/// counts as an impact.
const COMMANDED_RAD: f64 = 0.02;
/// Frames after the touch over which the level of an onset is averaged.
const LEVEL: std::ops::Range<usize> = 15..30;
/// An onset that leads to at least this force is not a graze, N. It is the allowed force of the published controller.
const PRESSED_N: f64 = 3.0;
/// Larger changes of force from one frame to the next are listed, N.
const LARGE_JUMP_N: f64 = 5.0;
/// A patch that reaches farther than this from its centre is not an edge, m.
const BROAD_M: f64 = 5e-3;

/// How a force on a trunk rises.
#[derive(Clone, Copy)]
struct Onset {
    /// Time until 63 % of the level, s.
    time_s: f64,
    /// Peak divided by the level.
    overshoot: f64,
    /// The force that it leads to, N.
    level_n: f64,
}

#[derive(Default)]
struct Survey {
    angles_deg: Vec<f64>,
    work_j: f64,
    coulomb_j: f64,
    onsets: Vec<Onset>,
    /// Largest change of force from one frame to the next, with and without an impact, N.
    jump_n: [f64; 2],
    /// Large jumps without an impact.
    jumps: Vec<LargeJump>,
    deepest_m: BTreeMap<String, f64>,
    deepest_broad_m: f64,
}

impl Survey {
    fn join(mut self, other: Survey) -> Survey {
        self.angles_deg.extend(other.angles_deg);
        self.onsets.extend(other.onsets);
        self.work_j += other.work_j;
        self.coulomb_j += other.coulomb_j;
        self.jumps.extend(other.jumps);
        for (own, other) in self.jump_n.iter_mut().zip(other.jump_n) {
            *own = own.max(other);
        }
        for (category, depth) in other.deepest_m {
            let deepest = self.deepest_m.entry(category).or_default();
            *deepest = deepest.max(depth);
        }
        self.deepest_broad_m = self.deepest_broad_m.max(other.deepest_broad_m);
        self
    }

    fn observe_friction_and_depth(&mut self, simulation: &Simulation) {
        let objects = &simulation.clutter().objects;
        for contact in &simulation.report().contacts {
            let Some(object) = contact.object else { continue };
            let placed = &objects[object];
            let normal = contact.force_world.dot(contact.inward_world);
            let rubbing = contact.force_world - contact.inward_world * normal;
            let slip = contact.slip_world;
            if slip.length() > SLIDING_M_PER_S {
                self.angles_deg.push(rubbing.angle_between(-slip).to_degrees());
                let friction = 0.5 * (simulation.arm().friction + simulation.structure(object).surface.friction);
                self.work_j -= rubbing.dot(slip);
                self.coulomb_j += friction * normal * slip.length();
            }
            let deepest = self.deepest_m.entry(placed.category.name().to_owned()).or_default();
            *deepest = deepest.max(contact.penetration_m);
            if contact.radius_m > BROAD_M {
                self.deepest_broad_m = self.deepest_broad_m.max(contact.penetration_m);
            }
        }
    }

    /// Records the jumps of the force on each link, and the onsets on trunks. `steps_rad` is the largest change of an
    /// equilibrium angle from the frame before to each frame.
    fn observe_course(&mut self, trace: &[Forces], steps_rad: &[f64], is_trunk: impl Fn(usize) -> bool) {
        let mut touched: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let mut met = None;
        for (frame, forces) in trace.iter().enumerate() {
            for pair in forces.keys() {
                let is_new = touched.insert(*pair, frame).is_none_or(|last| frame - last > IMPACT_FRAMES);
                if is_new {
                    met = Some(frame);
                    if is_trunk(pair.1) && forces.keys().filter(|other| other.0 == pair.0).count() == 1 {
                        self.observe_onset(trace, frame, *pair);
                    }
                }
            }
            if steps_rad[frame] > COMMANDED_RAD {
                met = Some(frame);
            }
            let Some(before) = frame.checked_sub(1).map(|before| &trace[before]) else {
                continue;
            };
            let links: BTreeSet<usize> = forces.keys().chain(before.keys()).map(|pair| pair.0).collect();
            for link in links {
                let jump = on_link(forces, link).distance(on_link(before, link));
                let is_impact = met.is_some_and(|met| frame - met <= IMPACT_FRAMES);
                let largest = &mut self.jump_n[usize::from(!is_impact)];
                *largest = largest.max(jump);
                if !is_impact && jump > LARGE_JUMP_N {
                    self.jumps.push(LargeJump::of(before, forces, link, frame + 1));
                }
            }
        }
    }

    /// Records the onset of a contact between a link and a trunk that begins in frame `start`, if both stay in contact
    /// and the link touches nothing else.
    fn observe_onset(&mut self, trace: &[Forces], start: usize, pair: (usize, usize)) {
        let Some(course) = trace.get(start..start + LEVEL.end) else {
            return;
        };
        let alone = |frame: &Forces| frame.keys().filter(|other| other.0 == pair.0).eq([&pair]);
        if !course.iter().all(alone) {
            return;
        }
        let force: Vec<f64> = course.iter().map(|frame| frame[&pair].force.length()).collect();
        let level = force[LEVEL].iter().sum::<f64>() / LEVEL.len() as f64;
        if let Some(at) = force.iter().position(|force| *force >= 0.63 * level) {
            let peak = force[..15].iter().copied().fold(0.0, f64::max);
            self.onsets.push(Onset { time_s: (at + 1) as f64 * 0.01, overshoot: peak / level, level_n: level });
        }
    }
}

/// The contact between a link and an object in one frame.
#[derive(Clone, Copy, Default)]
struct Touch {
    /// Force on the link, N, world frame.
    force: DVec3,
    /// Force along the contacts' normals, N; `rubbing` is the force across them, N, world frame.
    normal_n: f64,
    rubbing: DVec3,
    depth_m: f64,
}

/// The contacts of one frame, by link and object.
type Forces = BTreeMap<(usize, usize), Touch>;

fn forces(report: &FrameReport) -> Forces {
    let mut forces = Forces::new();
    for contact in &report.contacts {
        let Some(object) = contact.object else { continue };
        let touch = forces.entry((contact.link, object)).or_default();
        let normal_n = contact.force_world.dot(contact.inward_world);
        touch.force += contact.force_world;
        touch.normal_n += normal_n;
        touch.rubbing += contact.force_world - contact.inward_world * normal_n;
        touch.depth_m = touch.depth_m.max(contact.penetration_m);
    }
    forces
}

fn on_link(forces: &Forces, link: usize) -> DVec3 {
    let of_link = forces.iter().filter(|(pair, _)| pair.0 == link);
    of_link.map(|(_, touch)| touch.force).sum()
}

/// A large change of the force on a link from one frame to the next, and what changed most in it.
struct LargeJump {
    /// Reach, frame, link, object.
    at: [usize; 4],
    newtons: f64,
    before: Touch,
    now: Touch,
}

impl LargeJump {
    fn of(before: &Forces, now: &Forces, link: usize, frame: usize) -> Self {
        let touch = |forces: &Forces, pair: &(usize, usize)| forces.get(pair).copied().unwrap_or_default();
        let pairs = before.keys().chain(now.keys()).filter(|pair| pair.0 == link);
        let change = |pair: &(usize, usize)| touch(before, pair).force.distance(touch(now, pair).force);
        let most = pairs.max_by(|a, b| change(a).total_cmp(&change(b)));
        let most = most.copied().unwrap_or_default();
        LargeJump {
            at: [0, frame, link, most.1],
            newtons: on_link(before, link).distance(on_link(now, link)),
            before: touch(before, &most),
            now: touch(now, &most),
        }
    }

    /// The cause: the contact began or ended, the friction changed by more than the normal force did, or the contact
    /// became deeper or less deep.
    fn cause(&self) -> &'static str {
        if self.now.normal_n == 0.0 {
            "the contact ended"
        } else if self.before.normal_n == 0.0 {
            "the contact began"
        } else if self.now.rubbing.distance(self.before.rubbing) > (self.now.normal_n - self.before.normal_n).abs() {
            "friction turned"
        } else if self.now.depth_m > self.before.depth_m {
            "pressed deeper"
        } else {
            "pressed less deep"
        }
    }

    fn print(&self) {
        let [reach, frame, link, object] = self.at;
        let millimetres = |touch: &Touch| 1e3 * touch.depth_m;
        println!(
            "    reach {reach}, frame {frame}, link {link}, object {object}: {:.1} N; {}: normal force {:.1} to {:.1} N, friction \
             changed by {:.1} N, depth {:.2} to {:.2} mm",
            self.newtons,
            self.cause(),
            self.before.normal_n,
            self.now.normal_n,
            self.now.rubbing.distance(self.before.rubbing),
            millimetres(&self.before),
            millimetres(&self.now),
        );
    }
}

fn survey(plan: &ReachPlan, reach: u64) -> Survey {
    let recording = plan.run(reach, &mut |_| {}).unwrap();
    let mut simulation = plan.simulation(reach).unwrap();
    let mut survey = Survey::default();
    let (mut trace, mut steps_rad) = (Vec::new(), Vec::new());
    let mut before = &recording.frames[0].equilibrium_angle_rad;
    // Frame 0 is the start.
    for frame in recording.frames.iter().skip(1) {
        let equilibrium = &frame.equilibrium_angle_rad;
        let changes = equilibrium.iter().zip(before).map(|(now, before)| (now - before).abs());
        steps_rad.push(changes.fold(0.0, f64::max));
        before = equilibrium;
        trace.push(forces(simulation.step(equilibrium)));
        survey.observe_friction_and_depth(&simulation);
    }
    let objects = &simulation.clutter().objects;
    survey.observe_course(&trace, &steps_rad, |object| objects[object].category == Category::TRUNK);
    for jump in &mut survey.jumps {
        jump.at[0] = reach as usize;
    }
    survey
}

fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(((values.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(f64::NAN)
}

/// The median over the onsets of a number computed from each.
fn median(onsets: &[Onset], number: impl Fn(&Onset) -> f64) -> f64 {
    quantile(&mut onsets.iter().map(number).collect::<Vec<_>>(), 0.5)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [reaches, scenes @ ..] = arguments.as_slice() else {
        panic!("usage: contacts REACHES SCENE…");
    };
    let reaches: u64 = reaches.parse().unwrap();
    println!(
        "| scene | reaches | angle / ° | work | onsets, pressed | onset / s, pressed | overshoot, pressed | jump / N: impact, none | deepest / mm | broad |\n\
         |---|---|---|---|---|---|---|---|---|---|"
    );
    for path in scenes {
        let scene = Scene::load(path).unwrap();
        let name = scene.name.clone();
        let plan = ReachPlan::new(scene, None, 0).unwrap();
        let surveys: Vec<Survey> = (0..reaches).into_par_iter().map(|reach| survey(&plan, reach)).collect();
        let mut all = surveys.into_iter().fold(Survey::default(), Survey::join);
        let angles = [0.5, 0.9].map(|share| quantile(&mut all.angles_deg, share));
        let pressed: Vec<Onset> = all.onsets.iter().copied().filter(|own| own.level_n >= PRESSED_N).collect();
        let deepest = all.deepest_m.iter().map(|(category, depth)| format!("{category} {:.1}", depth * 1e3));
        println!(
            "| {name} | {reaches} | {:.2}, {:.2} | {:.4} | {}, {} | {:.3}, {:.3} | {:.2}, {:.2} | {:.1}, {:.1} | {} | {:.1} |",
            angles[0],
            angles[1],
            all.work_j / all.coulomb_j,
            all.onsets.len(),
            pressed.len(),
            median(&all.onsets, |own| own.time_s),
            median(&pressed, |own| own.time_s),
            median(&all.onsets, |own| own.overshoot),
            median(&pressed, |own| own.overshoot),
            all.jump_n[0],
            all.jump_n[1],
            deepest.collect::<Vec<_>>().join(", "),
            all.deepest_broad_m * 1e3,
        );
        all.jumps.iter().for_each(LargeJump::print);
    }
}
