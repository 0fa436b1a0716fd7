use std::path::Path;
use std::sync::{Arc, Mutex};

use serde_json::{Value, json};
use underbrush_classifier::touch::{REGION_FEATURE_COUNT, TAXEL_FEATURE_COUNT, TOUCH_FORMAT, TouchVerdict};
use underbrush_recording::{Frame, Recording};
use underbrush_sim::controller::{
    AllowedForces, ContactVerdict, Controller, ControllerInput, ControllerKind, ControllerOutput, TaxelContact, Touched,
};
use underbrush_sim::{Arm, ReachPlan, Scene};

use crate::verdict_controller::VerdictControl;

/// A network that gives these scores, whatever it sees.
fn constant(inputs: usize, scores: [f64; 2]) -> Value {
    json!({
        "sharpness": 1.0,
        "network": {
            "mean": vec![0.0; inputs],
            "scale": vec![0.0; inputs],
            "hidden": vec![vec![0.0; 24]; inputs + 1],
            "output": vec![vec![0.0; 24]; 2],
            "output_constant": scores,
        },
    })
}

/// A model that gives every taxel in contact the same verdict.
fn always(touch: TouchVerdict) -> VerdictControl {
    let touched = [if touch == TouchVerdict::Nothing { 9.0 } else { -9.0 }, 0.0];
    let category = match touch {
        TouchVerdict::Category(0) => [9.0, 0.0],
        TouchVerdict::Category(_) => [0.0, 9.0],
        _ => [0.0, 0.0],
    };
    // Everything is at least as unlike what is known as this share of the known objects, or nothing is.
    let unknown_share = if touch == TouchVerdict::Unknown { 1.0 } else { 0.0 };
    let model = json!({
        "format": TOUCH_FORMAT,
        "options": { "threshold_n": 0.03 },
        "categories": ["leaf", "trunk"],
        "decision": { "nothing_above": 0.5, "unknown_share": unknown_share, "cost_of_uncertain": 0.1 },
        "touched": constant(TAXEL_FEATURE_COUNT, touched),
        "category": constant(REGION_FEATURE_COUNT, category),
    });
    VerdictControl::from_json(Path::new("touch.json"), &model.to_string()).unwrap()
}

/// A reach with trunks beside the forearm, and a goal behind them.
fn plan() -> ReachPlan {
    let text = "summary = \"Trunks beside the forearm\"\n\
                goals = { count = 1, retries = 0, patience_s = 1.0, x_m = { uniform = [0.60, 0.72] } }\n\
                [[objects.trunk]]\n\
                count = 4\n\
                place = { x_m = { uniform = [0.25, 0.50] }, y_m = { uniform = [-0.50, -0.15] } }\n";
    // In its first reach a trunk presses on a taxel of the forearm with 3 N, the published limit.
    ReachPlan::new(Scene::parse("trunk.toml", text.into()).unwrap(), None, 4).unwrap()
}

/// The contacts that the inner controller is given in a whole reach.
type Given = Arc<Mutex<Vec<TaxelContact>>>;

/// Records the contacts that it is given, and passes them on.
struct Noting(Box<dyn Controller>, Given);

impl Controller for Noting {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn rate_hz(&self) -> f64 {
        self.0.rate_hz()
    }

    fn observe(&mut self, frame: &Frame) {
        self.0.observe(frame);
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        self.1.lock().unwrap().extend_from_slice(&input.contacts);
        self.0.control(input)
    }
}

/// Runs a reach, with verdicts if wanted; returns the recording and the contacts that the inner controller was given.
fn run(verdicts: Option<&VerdictControl>) -> (Recording, Vec<TaxelContact>) {
    let given = Given::default();
    let notes = given.clone();
    let plan = plan().with_controller_within(move |inner| Box::new(Noting(inner, notes.clone())));
    let plan = verdicts.map_or(plan.clone(), |verdicts| verdicts.applied_to(plan).unwrap());
    let recording = plan.run(0, &mut |_| {}).unwrap();
    let contacts = given.lock().unwrap().clone();
    (recording, contacts)
}

/// Tests the limit for each verdict: the limit of its category if it has one, the limit for unknown objects, or the
/// usual limit; and that a spurious reading is ignored.
#[test]
fn each_verdict_has_its_limit() {
    let allowed = AllowedForces {
        categories_n: [("leaf".to_owned(), 7.0), ("trunk".to_owned(), 2.0)].into(),
        unknown_n: Some(1.25),
    };
    let (_, usual) = run(None);
    let limited = TaxelContact { allowed_force_n: Some(3.5), ..usual[0].clone() };
    let applied = |verdict| {
        let mut contact = limited.clone();
        allowed.apply(&mut contact, verdict).then_some(contact)
    };
    for (touched, expected) in [
        (Touched::Nothing, None),
        (Touched::Category("grass".into()), Some(3.5)),
        (Touched::Category("leaf".into()), Some(7.0)),
        (Touched::Category("trunk".into()), Some(2.0)),
        (Touched::Uncertain, Some(3.5)),
        (Touched::Unknown, Some(1.25)),
    ] {
        let verdict = Some(ContactVerdict { touched, probability: 0.9 });
        let judged = applied(verdict.clone());
        let expected = expected.map(|limit_n| TaxelContact {
            allowed_force_n: Some(limit_n),
            verdict: verdict.clone(),
            ..limited.clone()
        });
        assert_eq!(judged, expected, "{verdict:?}");
    }
    assert_eq!(applied(None), Some(limited.clone()));
}

/// Tests which contacts the inner controller is given in a whole reach, for models that always give the same verdict.
/// Contacts on the model's patch above its threshold have the verdict's limit, or are missing if the verdict is
/// nothing. All other contacts are unchanged. A verdict of uncertain changes no bit of the reach.
#[test]
fn contacts_get_the_limits_of_their_verdicts() {
    let (plain, usual) = run(None);
    assert!(usual.iter().all(|contact| contact.allowed_force_n.is_none()));
    let judged = |contact: &&TaxelContact| contact.patch == 0 && contact.force_n > 0.03;
    assert!(usual.iter().filter(judged).count() > 100 && usual.iter().any(|contact| contact.patch == 1));

    let (mut uncertain, same) = run(Some(&always(TouchVerdict::Uncertain)));
    assert_eq!(uncertain.controller, "cody-2013+verdicts");
    uncertain.controller.clone_from(&plain.controller);
    let unjudged: Vec<TaxelContact> =
        same.into_iter().map(|contact| TaxelContact { verdict: None, ..contact }).collect();
    assert!(uncertain == plain && unjudged == usual);

    let limits =
        [(TouchVerdict::Category(0), Some(6.0)), (TouchVerdict::Category(1), Some(1.5)), (TouchVerdict::Unknown, None)];
    for (touch, expected) in limits {
        let (_, contacts) = run(Some(&always(touch)));
        assert!(contacts.iter().filter(judged).count() > 100);
        for contact in &contacts {
            let limit = expected.filter(|_| judged(&contact));
            assert_eq!(contact.allowed_force_n, limit, "{touch:?}, {contact:?}");
        }
    }
    let (_, contacts) = run(Some(&always(TouchVerdict::Nothing)));
    assert!(!contacts.is_empty() && !contacts.iter().any(|contact| judged(&contact)));
}

/// Tests that a reach with verdicts repeats bit for bit and keeps nothing of the previous reach; and that a limit on
/// trunks changes the reach.
#[test]
fn reaches_with_verdicts_repeat() {
    let verdicts = always(TouchVerdict::Category(1));
    let plan = verdicts.applied_to(plan()).unwrap();
    let first = plan.run(0, &mut |_| {}).unwrap();
    assert!(plan.run(0, &mut |_| {}).unwrap() == first);
    let mut plain = run(None).0;
    plain.controller.clone_from(&first.controller);
    assert!(first != plain);
}

/// Tests that contacts come with their true categories if, and only if, these are asked for, and with the forces that are
/// allowed on them, by default and as asked.
#[test]
fn true_categories_are_told_when_asked() {
    let (_, usual) = run(None);
    assert!(!usual.is_empty() && usual.iter().all(|contact| contact.verdict.is_none()));
    let asked = VerdictControl::truth().with_asked([("trunk".to_owned(), 2.0)]).unwrap();
    for (verdicts, allowed_n) in [(VerdictControl::truth(), 1.5), (asked, 2.0)] {
        let (recording, told) = run(Some(&verdicts));
        assert_eq!(recording.controller, "cody-2013+truth");
        assert!(told.len() > 100);
        for contact in &told {
            // The scene has nothing but trunks.
            let verdict = contact.verdict.as_ref().unwrap();
            assert_eq!((verdict.touched.name(), verdict.probability), ("trunk", 1.0));
            assert_eq!(contact.allowed_force_n, Some(allowed_n));
        }
    }
}

/// Tests that verdicts are refused for a controller that ignores contacts, and for a skin without the model's patch.
#[test]
fn verdicts_need_contacts_and_their_patch() {
    let verdicts = always(TouchVerdict::Uncertain);
    let scene = plan().scene;
    let blind = ReachPlan::new(scene.clone(), Some(ControllerKind::Blind), 1).unwrap();
    assert!(verdicts.applied_to(blind).unwrap_err().to_string().contains("blind"));
    let mut bare = Arm::cody().unwrap();
    bare.skin.layout.patches.clear();
    bare.skin.surfaces.clear();
    let bare = ReachPlan::with_arm(scene, Some(bare), None, 1).unwrap();
    assert!(verdicts.applied_to(bare).is_err());
}
