//! The scenes that ship.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use underbrush_recording::Category;
use underbrush_sim::clutter::PlacedObject;
use underbrush_sim::geometry::Footprint;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

/// Every scene file below `folder`, sorted.
fn scene_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(scene_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "toml") {
            files.push(path);
        }
    }
    files.sort();
    files
}

fn scenes() -> Vec<PathBuf> {
    scene_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"))
}

fn plan(path: &Path, seed: u64) -> ReachPlan {
    ReachPlan::new(Scene::load(path).unwrap(), None, seed).unwrap()
}

/// Tests that the four environments of the paper, the second outlier and the ten engineered scenes exist, five per
/// category.
#[test]
fn all_that_the_readers_are_told_of_are_there() {
    let names: Vec<String> =
        scenes().iter().map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    for name in ["leaf", "trunk", "mixed", "outlier", "bottle"] {
        assert!(names.iter().any(|found| found == name), "no scene {name}");
    }
    for prefix in ["leaf-", "trunk-"] {
        assert_eq!(names.iter().filter(|name| name.starts_with(prefix)).count(), 5, "{names:?}");
    }
}

/// Tests that the objects of each scene find room in six draws, that no two of them overlap except what stands in or
/// passes through foam, and that nothing touches the arm in the first frame, with every object in the solver.
#[test]
fn every_scene_draws_and_stands_free() {
    let draws: Vec<(PathBuf, u64)> =
        scenes().into_iter().flat_map(|path| (0..6).map(move |seed| (path.clone(), seed))).collect();
    draws.par_iter().for_each(|(path, seed)| {
        let plan = plan(path, *seed);
        let clutter = plan.draw(0).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert_eq!(clutter.goals.len(), plan.scene.file.goals.number() as usize);
        for (index, a) in clutter.objects.iter().enumerate() {
            for b in &clutter.objects[..index] {
                assert!(apart(a, b), "{}, seed {seed}: {a:?} overlaps {b:?}", path.display());
            }
        }
        let contacts = contacts_at_start(&plan);
        assert_eq!(contacts, 0, "{}, seed {seed}", path.display());
    });
}

/// Whether two footprints are apart: no point on the edge of either lies within the other. The program itself compares
/// projections onto axes.
fn apart(a: &PlacedObject, b: &PlacedObject) -> bool {
    let foam = |placed: &PlacedObject| placed.object.foam_top().is_some();
    if foam(a) != foam(b) {
        return true;
    }
    let enters = |from: &PlacedObject, into: &PlacedObject| edge(from).into_iter().any(|point| holds(into, point));
    !enters(a, b) && !enters(b, a)
}

/// Points along the edge of a footprint, 1 mm inside it, and its centre, m, world frame.
fn edge(placed: &PlacedObject) -> Vec<[f64; 2]> {
    let inset_m = 0.001;
    let round = |index: usize| std::f64::consts::TAU * index as f64 / 400.0;
    let local = (0..400).map(round).map(|angle| match placed.object.size().0 {
        Footprint::Disc(radius) => [(radius - inset_m) * angle.cos(), (radius - inset_m) * angle.sin()],
        Footprint::Rectangle(x, y) => {
            let (x, y) = (x - inset_m, y - inset_m);
            let scale = (angle.cos().abs() / x).max(angle.sin().abs() / y);
            [angle.cos() / scale, angle.sin() / scale]
        }
    });
    let (sine, cosine) = placed.yaw_rad.sin_cos();
    let foot = placed.foot_world;
    local.chain([[0.0, 0.0]]).map(|[x, y]| [foot.x + cosine * x - sine * y, foot.y + sine * x + cosine * y]).collect()
}

/// Whether a point on the ground, m, world frame, lies in a footprint.
fn holds(placed: &PlacedObject, [x, y]: [f64; 2]) -> bool {
    let (x, y) = (x - placed.foot_world.x, y - placed.foot_world.y);
    let (sine, cosine) = placed.yaw_rad.sin_cos();
    let (along, across) = (cosine * x + sine * y, cosine * y - sine * x);
    match placed.object.size().0 {
        Footprint::Disc(radius) => along.hypot(across) < radius,
        Footprint::Rectangle(half_x, half_y) => along.abs() < half_x && across.abs() < half_y,
    }
}

/// Contacts between arm and clutter in the first frame.
fn contacts_at_start(plan: &ReachPlan) -> usize {
    let mut simulation = plan.simulation(0).unwrap();
    simulation.step(&plan.arm.start_posture_rad()).contacts.len()
}

/// Tests that every one of a hundred draws of each scene finds its goals, and that each goal is 2 cm or more from the
/// surface of every trunk, roll and bottle, taken as an upright cylinder.
#[test]
fn goals_are_clear_of_trunks_and_rolls() {
    let nearest: Vec<(PathBuf, f64)> = scenes()
        .into_iter()
        .map(|path| {
            let plan = plan(&path, 7);
            let nearest = (0..100u64).into_par_iter().map(|reach_index| {
                let clutter = plan.draw(reach_index).unwrap_or_else(|error| panic!("reach {reach_index}: {error}"));
                let goals = clutter.goals.iter();
                let distances = goals.flat_map(|goal| {
                    let obstacles = clutter.objects.iter().filter_map(cylinder);
                    obstacles.map(move |[foot, size]| distance_to_cylinder(goal.to_array(), foot, size))
                });
                distances.fold(f64::INFINITY, f64::min)
            });
            let nearest = nearest.reduce(|| f64::INFINITY, f64::min);
            (path, nearest)
        })
        .collect();
    for (path, nearest) in &nearest {
        assert!(*nearest >= 0.02, "{}: {nearest} m", path.display());
    }
    let near = nearest.iter().filter(|(_, nearest)| *nearest < 0.04).count();
    assert!(near >= 6, "in few scenes does any goal come near to a trunk or roll: {nearest:?}");
}

/// The foot of a trunk, roll or bottle, m, with its radius and height, m.
fn cylinder(placed: &PlacedObject) -> Option<[[f64; 3]; 2]> {
    match (placed.object.kind(), placed.object.size()) {
        ("trunk" | "foam_roll" | "water_bottle", (Footprint::Disc(radius), height_m)) => {
            Some([placed.foot_world.to_array(), [radius, height_m, 0.0]])
        }
        _ => None,
    }
}

/// Distance of a point from the surface of an upright cylinder, m; 0 inside.
fn distance_to_cylinder([x, y, z]: [f64; 3], foot: [f64; 3], [radius, height, _]: [f64; 3]) -> f64 {
    let beside = ((x - foot[0]).hypot(y - foot[1]) - radius).max(0.0);
    let above = (z - foot[2] - height).max(foot[2] - z).max(0.0);
    beside.hypot(above)
}

/// Tests that the arm truly touches only leaves or foam in engineered leaf scenes and only trunks or foam in engineered
/// trunk scenes, and that it touches that category in at least one of its five scenes.
#[test]
fn engineered_scenes_touch_their_own_category() {
    for (prefix, own) in [("leaf-", Category::LEAF), ("trunk-", Category::TRUNK)] {
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let engineered: Vec<PathBuf> = scenes().into_iter().filter(|path| name(path).starts_with(prefix)).collect();
        let touched: Vec<Category> = engineered.par_iter().flat_map_iter(|path| touched(path)).collect();
        let strange: Vec<_> = touched.iter().filter(|found| ![own, Category::BLOCK].contains(found)).collect();
        assert_eq!(strange, Vec::<&Category>::new(), "in {engineered:?}");
        assert!(touched.contains(&own), "{own:?} is not touched in {engineered:?}");
    }
}

/// The categories that the arm touches on the way to the first goal of a scene.
fn touched(path: &Path) -> Vec<Category> {
    let mut plan = plan(path, 0);
    // One goal with one attempt is enough to touch things, and runs fast.
    plan.scene.file.goals.count = 1;
    plan.scene.file.goals.retries = 0;
    let recording = plan.run(0, &mut |_| {}).unwrap();
    let felt = recording.frames.iter().flat_map(|frame| &frame.taxels).filter_map(|reading| reading.object);
    let objects = felt.chain(recording.contacts.iter().map(|contact| contact.object));
    let categories: std::collections::BTreeSet<_> =
        objects.map(|object| recording.objects[usize::from(object)].category).collect();
    categories.into_iter().collect()
}
