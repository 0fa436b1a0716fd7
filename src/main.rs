//! The command line of underbrush.

fn main() {}
