//! A reach that is shown in the browser while it is simulated.

use std::sync::Arc;
use std::thread::JoinHandle;

use underbrush_recording::{Fault, Recording, SkinLayout};
use underbrush_replay::{Judging, Live, PartialReach, Server, VerdictLog, unjudged};
use underbrush_sim::reach::{Observed, ReachSoFar};

use super::replay::ServerArguments;
use crate::{Failure, output};

/// What messages call the reach.
const REACH: &str = "this reach";

/// A reach and the server that shows it.
pub struct Watched<'a> {
    so_far: ReachSoFar<'a>,
    verdicts: Option<VerdictLog>,
    /// Why there are no more verdicts.
    fault: Option<Fault>,
    live: Arc<Live>,
    server: JoinHandle<()>,
}

impl<'a> Watched<'a> {
    /// Starts the server and says where the page is. With a model the page shows its verdicts.
    pub fn begin(
        so_far: ReachSoFar<'a>,
        skin: &SkinLayout,
        judging: Option<&Judging>,
        arguments: &ServerArguments,
    ) -> Result<Self, Failure> {
        let verdicts = judging.map(|judging| judging.begin(skin)).transpose();
        let verdicts = verdicts.map_err(unjudged(REACH))?;
        let live = Arc::new(Live::default());
        let server = Server::watch(Arc::clone(&live), underbrush_report::replayed::known(), arguments.port)?;
        let address = server.address.clone();
        output::remark(format!("the reach begins when {address} is opened in a browser"));
        arguments.show(&address);
        Ok(Watched { so_far, verdicts, fault: None, live, server: std::thread::spawn(move || server.run()) })
    }

    /// Shows one more frame. Waits while the reach is paused.
    pub fn frame(&mut self, observed: Observed) {
        self.so_far.observe(observed);
        if let Some(Err(source)) = self.verdicts.as_mut().map(|verdicts| verdicts.update(observed.frame)) {
            self.verdicts = None;
            self.fault = Some(unjudged(REACH)(source));
        }
        self.live.frame(|| self.so_far.recording().map(|recording| self.with_verdicts(recording)));
    }

    fn with_verdicts(&self, recording: Recording) -> PartialReach {
        PartialReach { recording, verdicts: self.verdicts.as_ref().map(|log| log.verdicts.clone()) }
    }

    /// Shows the whole reach until the program is ended.
    pub fn end(self, recording: Recording) -> Result<(), Failure> {
        self.live.end(self.with_verdicts(recording));
        if let Some(fault) = self.fault {
            return Err(fault.into());
        }
        output::remark("the page can be used until Ctrl-C");
        let ended = self.server.join();
        ended.map_err(|_| Failure::run("the server of the page has failed; please report this"))
    }
}
