//! The replay pages beside a report, the addresses by which figures link to them, and what such pages show but recordings do
//! not contain.

use std::path::Path;

use underbrush_classifier::{Decision, HmmClassifier, Model, Rule};
use underbrush_experiments::experiment::example_trials;
use underbrush_experiments::{Session, audit, files, frame_verdicts, online_models, reaches, training};
use underbrush_recording::{Fault, Recording};
use underbrush_render::{RenderError, Size, Stage};
use underbrush_replay::{Held, Judging, JudgingModel, ReplayContext, Source, page_that_fits};
use underbrush_sim::controller::ControllerKind;

/// Largest size of a page with reaches inside, bytes. Choice: browsers refuse texts of more than about 500 MB, and
/// nobody sends that.
pub const MAX_PAGE_BYTES: usize = 400_000_000;

/// What replay pages show but recordings lack: the force limit of each controller that ships, or for all reaches the limit that
/// the user states, N; and the audit's bounds that a reach exceeds.
pub fn known(stated_limit_n: Option<f64>) -> ReplayContext {
    ReplayContext { force_limit_n, stated_limit_n, audit_warnings: audit::exceeded_bounds }
}

/// The stage of a recording, with this force limit of a taxel, N, or else that of its controller.
///
/// # Errors
/// As [`Stage::of`].
pub fn stage(recording: &Recording, limit_n: Option<f64>) -> Result<Stage<'_>, RenderError> {
    Stage::of(recording, limit_n.or_else(|| force_limit_n(&recording.controller)))
}

/// A frame of a recording with arrows of the contact forces, as PNG. The force limit is that of [`stage`].
///
/// # Errors
/// If it cannot be drawn.
pub fn png(recording: &Recording, number: usize, size: Size, limit_n: Option<f64>) -> Result<Vec<u8>, RenderError> {
    let stage = stage(recording, limit_n)?.with_arrows();
    stage.moment(number as u32, &recording.frames[number]).png(&stage.camera(size.aspect()), size)
}

/// The force limit of a controller that ships, also if verdicts change what it allows: their names follow a plus.
fn force_limit_n(controller: &str) -> Option<f64> {
    let own = controller.split('+').next()?;
    ControllerKind::from_name(own).ok().map(|kind| kind.preset().force_limit_n)
}

/// The page with the general reach that figures show, if there is one, followed by the outlier reaches.
pub(crate) const TEST_FILE: &str = "replay.html";
/// The page with the engineered reaches that were found, in the order of the experiment.
pub(crate) const ENGINEERED_FILE: &str = "replay-engineered.html";
/// The page with the training reaches of the example trials, in their order.
pub(crate) const TRAINING_FILE: &str = "replay-training.html";

/// The address of a reach on a page, coloured by verdict.
pub(crate) fn reach(file: &str, place: usize) -> String {
    format!("{file}#reach={place}&colour=verdict")
}

/// The address of a moment of a reach, in seconds, and of a taxel of a patch.
pub(crate) fn moment(file: &str, place: usize, time_s: f64, taxel: Option<(&str, usize)>) -> String {
    // A name with other characters could end the address.
    let plain = |name: &str| name.chars().all(|letter| letter.is_ascii_alphanumeric() || "-_".contains(letter));
    let taxel = taxel.filter(|(patch, _)| plain(patch));
    let taxel = taxel.map_or(String::new(), |(patch, taxel)| format!("&taxel={patch}.{taxel}"));
    format!("{file}#reach={place}&t={time_s:.2}&colour=verdict{taxel}")
}

/// Writes each replay page that has reaches, with the verdicts that the figures are about.
pub(crate) fn write(session: &Session, folder: &Path) -> Result<(), Fault> {
    let tested = session.once(reaches::run)?;
    let uncertain = frame_verdicts::uncertain_rule(session.experiment);
    let judged = |recording: &Recording, rule: Rule| held(session, recording.clone(), rule);

    // The figures show the first of the general reaches.
    let general = tested.general.iter().flat_map(|found| &found.reaches).take(1);
    let general = general.map(|recording| judged(recording, uncertain));
    let outliers = tested.outlier.iter().flat_map(|found| &found.reaches);
    let outliers = outliers.map(|recording| judged(recording, Decision::paper().rule));
    page(session, general.chain(outliers), &folder.join(TEST_FILE))?;

    let engineered = tested.engineered.iter().filter_map(|(_, found)| found.reaches.last());
    page(session, engineered.map(|recording| judged(recording, uncertain)), &folder.join(ENGINEERED_FILE))?;

    let data = session.once(training::run)?;
    let examples = session.once(example_trials::run)?;
    let places = examples.figure_5.iter().filter_map(|example| example.data.reach);
    let examples = places.map(|place| held(session, data.dataset.read_reach(place as usize)?, uncertain));
    page(session, examples, &folder.join(TRAINING_FILE))
}

/// A reach with the verdicts of the experiment's models by this rule.
fn held(session: &Session, recording: Recording, rule: Rule) -> Result<Held, Fault> {
    let models = session.once(online_models::run)?;
    let model = Model::new(Box::new(HmmClassifier::clone(&models)));
    let by = JudgingModel::OfTrials(Box::new(model), frame_verdicts::options(session.experiment, rule));
    Ok(Held { recording, judging: Some(Judging { name: "model.json".into(), by }) })
}

/// Writes a page with these reaches. Reaches that do not fit are left out with a remark.
fn page(session: &Session, reaches: impl Iterator<Item = Result<Held, Fault>>, path: &Path) -> Result<(), Fault> {
    let source = Source::of(reaches.collect::<Result<_, _>>()?, known(None))?;
    let numbers: Vec<usize> = (0..source.reaches.len()).collect();
    if numbers.is_empty() {
        return Ok(());
    }
    let (page, fitting) = page_that_fits(&source, &numbers, MAX_PAGE_BYTES)?;
    if fitting < numbers.len() {
        let (file, count) = (path.display(), numbers.len());
        session.progress.remark(&format!(
            "{file} has only the first {fitting} of {count} reaches, because browsers cannot open more"
        ));
    }
    files::write(path, page.as_bytes())
}
