//! The replay pages beside a report, to which its figures link.

use std::path::Path;

use underbrush_classifier::{Decision, Model, Rule};
use underbrush_experiments::experiment::example_trials;
use underbrush_experiments::{Session, files, frame_verdicts, online_models, reaches, training};
use underbrush_recording::{Fault, Recording};
use underbrush_replay::{Held, Judging, JudgingModel, Source, page_that_fits};

use crate::replay_links::{ENGINEERED_FILE, TEST_FILE, TRAINING_FILE};
use crate::replayed::{MAX_PAGE_BYTES, known};

/// Writes each page that has reaches, with the verdicts that the figures are about.
pub fn write(session: &Session, folder: &Path) -> Result<(), Fault> {
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
    let judging = Judging {
        name: "model.json".into(),
        by: JudgingModel::OfTrials(
            Box::new(Model::new(Box::new(models.0.clone()))),
            frame_verdicts::options(session.experiment, rule),
        ),
    };
    Ok(Held { recording, judging: Some(judging) })
}

/// Writes a page with these reaches. Reaches that do not fit are left out with a remark.
fn page(session: &Session, reaches: impl Iterator<Item = Result<Held, Fault>>, path: &Path) -> Result<(), Fault> {
    let source = Source::of(reaches.collect::<Result<_, _>>()?, known())?;
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
