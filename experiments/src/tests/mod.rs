#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod campaigns;
mod definitions;
mod resumed;
#[path = "../../../tests/support/scenes.rs"]
#[expect(dead_code, reason = "some scenes are enough here")]
pub(crate) mod scenes;
mod settings;
mod sources;
mod table_one_paper;
mod trials;
mod verdict_categories;
mod verdict_controller;
