//! What the libraries promise beyond the command line.

mod engine;
mod scenes;
