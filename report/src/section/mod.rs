//! The sections of the report: one file for each experiment in the list `for_each_experiment`, with its sentences,
//! tables and charts. `add` shows the experiment's result.

use crate::report::Report;

macro_rules! declare {
    ($($name:ident: $result:ident,)*) => {
        $(pub mod $name;)*

        /// Adds all sections to a report, in the order of the list.
        pub fn add_all(report: &mut Report) {
            $($name::add(report, &report.results.outcomes.$name);)*
        }
    };
}
underbrush_experiments::for_each_experiment!(declare);
