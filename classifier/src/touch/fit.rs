//! Fitting a touch model to recordings with ground truth.

use std::sync::Arc;

use rayon::prelude::*;

use super::decision::TouchDecision;
use super::example::Examples;
use super::held_out::{
    Judged, category_network, check_share, judged, lapses, largest_limit, nothing_above, sharpness, touched_network,
};
use super::model::{Calibrated, TOUCH_FORMAT, TouchModel};
use super::object::fit_objects;
use super::training_rows::{FOLDS, TouchExamples};
use crate::error::ModelError;
use crate::provenance::Provenance;

impl TouchExamples {
    /// Fits a model. Probabilities are calibrated, and limits chosen, on reaches that are held out in turn; the model
    /// itself is then fitted to all. The result is the same for any number of threads.
    ///
    /// `limit_wrong` is the largest allowed share, in a new reach and on average over reaches, of the taxel frames on which a
    /// known category presses whose region is called another known category. The largest cost of an uncertain verdict
    /// within this limit is chosen, so that as few verdicts as possible are uncertain.
    ///
    /// # Errors
    /// [`ModelError::NoCategories`] if no known category touches the patch for long enough; [`ModelError::Mismatch`] if
    /// such categories do so in fewer than two recordings; [`ModelError::BadOption`] for a limit that is not between 0 and 1,
    /// and [`ModelError::FewReaches`] for one that needs more reaches.
    pub fn fit(&self, limit_wrong: Option<f64>) -> Result<TouchModel, ModelError> {
        let trials = self.reaches.len();
        limit_wrong.map_or(Ok(()), |share| check_share(share, trials))?;
        if trials < FOLDS {
            let found = if trials == 1 { "1 reach to fit to" } else { "no reaches to fit to" };
            let allowed = format!(
                "{FOLDS} or more (of {FOLDS} reaches or more, each is held out once to calibrate probabilities); give \
                 a data set, or several recordings"
            );
            return Err(ModelError::mismatch(found, allowed));
        }
        let categories = self.categories();
        if categories.is_empty() {
            return Err(ModelError::NoCategories(trials));
        }
        let folds = self.folds();
        if !self.fill(&folds) {
            let found = format!("something of a known category touches the skin in one of {trials} recordings");
            let allowed = format!(
                "{FOLDS} such recordings or more, because probabilities are calibrated on recordings that are held out"
            );
            return Err(ModelError::mismatch(found, allowed));
        }
        let held_out: Vec<_> = (0..FOLDS).into_par_iter().map(|fold| judged(self, &folds, fold, &categories)).collect();
        let taxels: Vec<&Judged> = held_out.iter().flat_map(|(taxels, _)| taxels).collect();
        let regions: Vec<&Judged> = held_out.iter().flat_map(|(_, regions)| regions).collect();
        // Rows of regions are not taken in every frame, so short touches may leave none.
        if regions.is_empty() {
            return Err(ModelError::NoCategories(trials));
        }
        let all: Vec<&Examples> = self.reaches.iter().map(Arc::as_ref).collect();
        let (touched, category) = rayon::join(|| touched_network(&all), || category_network(&all, &categories));
        let touched = Calibrated { sharpness: sharpness(&taxels), network: touched };
        let category = Calibrated { sharpness: sharpness(&regions), network: category };
        let mut decision =
            TouchDecision { nothing_above: nothing_above(&taxels, touched.sharpness), ..TouchDecision::default() };
        if let Some(share) = limit_wrong {
            decision.cost_of_uncertain = largest_limit(share, trials, lapses(&regions, category.sharpness));
        }
        let [known, auxiliary] = [&self.reaches, &self.auxiliary]
            .map(|reaches| reaches.iter().map(|reach| reach.objects.as_slice()).collect::<Vec<_>>());
        let (of_objects, unknown, stiffness) = fit_objects(&known, &auxiliary, &categories)?;
        Ok(TouchModel {
            format: TOUCH_FORMAT.into(),
            options: self.options.clone(),
            decision,
            category,
            categories,
            touched,
            of_objects,
            unknown,
            stiffness,
            provenance: Provenance::default(),
        })
    }
}
