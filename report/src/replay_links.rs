//! Links from figures to the replay pages beside the report, which show the reaches that the figures are about.
//! `replay_pages` writes those pages.

/// The page with the general reach that figures show, if there is one, followed by the outlier reaches.
pub const TEST_FILE: &str = "replay.html";
/// The page with the engineered reaches that were found, in the order of the experiment.
pub const ENGINEERED_FILE: &str = "replay-engineered.html";
/// The page with the training reaches of the example trials, in their order.
pub const TRAINING_FILE: &str = "replay-training.html";

/// The address of a reach on a page, coloured by verdict.
pub fn reach(file: &str, place: usize) -> String {
    format!("{file}#reach={place}&colour=verdict")
}

/// The address of a moment of a reach, in seconds, and of a taxel of a patch.
pub fn moment(file: &str, place: usize, time_s: f64, taxel: Option<(&str, usize)>) -> String {
    // A name with other characters could end the address.
    let plain = |name: &str| name.chars().all(|letter| letter.is_ascii_alphanumeric() || "-_".contains(letter));
    let taxel = taxel.filter(|(patch, _)| plain(patch));
    let taxel = taxel.map_or(String::new(), |(patch, taxel)| format!("&taxel={patch}.{taxel}"));
    format!("{file}#reach={place}&t={time_s:.2}&colour=verdict{taxel}")
}
