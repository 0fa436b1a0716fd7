//! Warnings of the libraries.

use log::{LevelFilter, Log, Metadata, Record};

/// Shows each warning of the libraries from now on.
pub fn show_warnings(show: fn(String)) {
    // It fails only if warnings are shown already.
    if log::set_logger(Box::leak(Box::new(Shown(show)))).is_ok() {
        log::set_max_level(LevelFilter::Warn);
    }
}

struct Shown(fn(String));

impl Log for Shown {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("underbrush")
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            (self.0)(record.args().to_string());
        }
    }

    fn flush(&self) {}
}
