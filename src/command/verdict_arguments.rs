//! The options that choose the verdicts of a controller.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_sim::scene::limits::ALLOWED_FORCE_N;

use crate::Failure;
use crate::options::pair;

/// What tells the controller what the skin touches.
#[derive(Args)]
pub struct VerdictArguments {
    /// Tell the controller what the skin touches: by this touch model, by the true categories (`truth`), which no robot
    /// knows, or not at all (`none`)
    #[arg(long, value_name = "MODEL|truth|none")]
    pub verdicts: Option<PathBuf>,
    /// With --verdicts: how hard the arm may press on objects of a category, or on `unknown` ones, instead of the scene's
    /// force, N
    #[arg(long, value_name = "CATEGORY=N", requires = "verdicts", value_parser = allowed)]
    pub allow: Vec<(String, f64)>,
}

fn allowed(text: &str) -> Result<(String, f64), String> {
    let read = pair(text, '=').filter(|(_, force_n)| ALLOWED_FORCE_N.hold(*force_n));
    read.ok_or_else(|| format!("must be a category and a force of {ALLOWED_FORCE_N}, such as leaf=6"))
}

impl VerdictArguments {
    /// The verdicts that the options ask for.
    ///
    /// # Errors
    /// If the model cannot be read, or `--allow` names something twice or something that no verdict says.
    pub fn control(&self) -> Result<Option<VerdictControl>, Failure> {
        let mut known = BTreeSet::new();
        if let Some((twice, _)) = self.allow.iter().find(|(name, _)| !known.insert(name)) {
            return Err(Failure::usage(format!("--allow is given twice for {twice}; give it once for each category")));
        }
        match self.verdicts.as_deref().map(VerdictControl::named).transpose()?.flatten() {
            Some(control) => Ok(Some(control.with_asked(self.allow.clone())?)),
            None if self.allow.is_empty() => Ok(None),
            None => Err(Failure::usage("--allow needs verdicts; give --verdicts a touch model or `truth`")),
        }
    }

    /// The file of the touch model, if there is one.
    pub fn model(&self) -> Option<PathBuf> {
        self.verdicts.clone().filter(|path| !["truth", "none"].map(PathBuf::from).contains(path))
    }
}
