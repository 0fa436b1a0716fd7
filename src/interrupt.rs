//! What happens when a signal asks the program to end: temporary files are removed, and a person learns how to go on.

use std::sync::OnceLock;

use crate::output;

/// How to go on after an interruption, where that is possible.
static HINT: OnceLock<String> = OnceLock::new();

/// Says how work that an interruption cuts off can be continued. The first hint of a process holds.
pub fn hint(text: impl Into<String>) {
    let _ = HINT.set(text.into());
}

/// Waits for SIGINT and SIGTERM in a thread of its own.
///
/// The program then ends by the same signal: a shell reports 130 or 143, and a script that ran the program stops at
/// Ctrl-C, which it would not if the program merely exited with 130.
#[cfg(unix)]
pub fn watch() {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let first_came = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // The second signal ends the program at once, should the first one hang on a disk or a terminal. This is
        // registered before the flag is set by the same signal, so the first one passes.
        let _ = signal_hook::flag::register_conditional_default(signal, Arc::clone(&first_came));
        let _ = signal_hook::flag::register(signal, Arc::clone(&first_came));
    }
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else {
        // Signals then do what they do by default: they end the program, and leftovers are removed by the next run.
        return;
    };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            underbrush_recording::disk::abandon_unfinished_files();
            if let Some(hint) = HINT.get() {
                output::interruption(hint);
            }
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            std::process::exit(128 + signal);
        }
    });
}

/// Elsewhere the system ends the program; leftovers are removed by the next run.
#[cfg(not(unix))]
pub fn watch() {}
