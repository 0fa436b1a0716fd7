//! Handles signals that ask the program to end: removes temporary files and prints how to continue.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::output;

/// The folder of the results, and how to continue after an interruption, if that is possible.
static HINT: OnceLock<(PathBuf, String)> = OnceLock::new();

/// Sets the hint that is printed after an interruption if the folder is there: that `things` are kept in it, and `how` to
/// continue the run. Only the first hint of a process counts.
pub fn kept(things: &str, folder: &Path, how: &str) {
    let _ = HINT.set((folder.to_path_buf(), format!("{things} kept in {}; run {how} to go on", folder.display())));
}

/// Waits for SIGINT, SIGTERM and SIGHUP (the terminal was closed) in a separate thread.
///
/// The program then ends by the same signal, so that a shell reports 130, 143 or 129, and a script that runs the program
/// stops at Ctrl-C; it would continue if the program just exited with 130.
#[cfg(unix)]
pub fn watch() {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let mut ending = vec![SIGINT, SIGTERM];
    if !is_ignored(SIGHUP) {
        ending.push(SIGHUP);
    }
    let first_came = Arc::new(AtomicBool::new(false));
    for signal in ending.iter().copied() {
        // A second signal ends the program at once, in case the first hangs on a disk or a terminal. The order
        // matters: the flag is still false when the first signal gets here.
        let _ = signal_hook::flag::register_conditional_default(signal, Arc::clone(&first_came));
        let _ = signal_hook::flag::register(signal, Arc::clone(&first_came));
    }
    let Ok(mut signals) = Signals::new(&ending) else {
        // Signals then end the program, as they do by default, and the next run removes leftover files.
        return;
    };
    // Without this thread, the second signal ends the program.
    let _ = std::thread::Builder::new().spawn(move || {
        if let Some(signal) = signals.forever().next() {
            underbrush_recording::disk::abandon_unfinished_files();
            if let Some((folder, hint)) = HINT.get()
                && folder.exists()
            {
                output::interruption(hint);
            }
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            std::process::exit(128 + signal);
        }
    });
}

/// Whether the program was started with this signal ignored, as nohup does with SIGHUP: it then outlives its terminal.
/// Also true where the system does not tell. The signal then ends the program, as it does by default, or is ignored.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_none_or(|mask| mask >> (signal - 1) & 1 == 1)
}

/// On other systems a signal just ends the program, and the next run removes leftover files.
#[cfg(not(unix))]
pub fn watch() {}
