//! Tests of the libraries beyond the command line.

mod arms;
mod balance;
mod categories;
mod documents;
mod engine;
mod imports;
mod own_controller;
mod ranges;
mod reach_controller;
mod scenes;
mod self_contact;
mod suites;
mod table;
