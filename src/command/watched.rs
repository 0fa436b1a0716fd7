//! A reach that is shown in the browser while it is simulated.

use std::sync::Arc;
use std::thread::JoinHandle;

use underbrush_recording::{Frame, Recording};
use underbrush_replay::{Live, Server};
use underbrush_sim::reach::ReachSoFar;
use underbrush_sim::simulation::Simulation;

use super::replay;
use crate::failure::Failure;
use crate::output;

/// A reach and the server that shows it.
pub struct Watched<'a> {
    so_far: ReachSoFar<'a>,
    live: Arc<Live>,
    server: JoinHandle<()>,
}

impl<'a> Watched<'a> {
    /// Starts the server and says where the page is.
    pub fn begin(so_far: ReachSoFar<'a>) -> Result<Self, Failure> {
        let live = Arc::new(Live::new());
        let server = Server::watch(Arc::clone(&live), replay::known(), 0)?;
        let address = server.address();
        output::remark(format!("the reach begins when {address} is opened in a browser"));
        replay::show(&address);
        Ok(Watched {
            so_far,
            live,
            server: std::thread::spawn(move || server.run()),
        })
    }

    /// Shows one more frame. Waits while the reach is paused.
    pub fn frame(&mut self, simulation: &Simulation, frame: &Frame) {
        self.so_far.observe(simulation, frame);
        self.live.frame(|| self.so_far.recording());
    }

    /// Shows the whole reach until the program is ended.
    pub fn end(self, recording: Recording) -> Result<(), Failure> {
        self.live.end(recording);
        output::remark("the page can be used until Ctrl-C");
        let ended = self.server.join();
        ended.map_err(|_| Failure::run("the server of the page has failed; please report this"))
    }
}
