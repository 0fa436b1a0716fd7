//! What is doubtful about an arm's skin, said on stderr before work that stands on it.

use underbrush_sim::arm::Arm;

use crate::output;

/// Says what is doubtful about the skins of these arms, each sentence once.
pub fn warn<'a>(arms: impl IntoIterator<Item = &'a Arm>) {
    let mut said: Vec<String> = Vec::new();
    for doubt in arms.into_iter().flat_map(Arm::skin_doubts) {
        if !said.contains(&doubt) {
            output::remark(format!("doubtful: {doubt}"));
            said.push(doubt);
        }
    }
}
