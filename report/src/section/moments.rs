//! One moment of a general reach and of an outlier reach, with the verdicts on their taxels (Figs. 12 and 14).

use underbrush_classifier::decision::Verdict;
use underbrush_experiments::experiment::moments::{Moment, Outcome};

use crate::drawing::slug;
use crate::picture::{self, TaxelMark};
use crate::report::Report;
use crate::skin_map;

/// Adds the section.
pub fn add(report: &mut Report, outcome: &Outcome) {
    let moments: Vec<&Moment> = [&outcome.general, &outcome.outlier].into_iter().flatten().collect();
    if moments.is_empty() {
        return;
    }
    report.section("moments", "moments of two reaches");
    moments.into_iter().for_each(|moment| add_moment(report, moment));
}

fn add_moment(report: &mut Report, moment: &Moment) {
    let Some(grid) = moment.layout.patches.get(moment.patch).and_then(|patch| patch.grid) else {
        return;
    };
    let mark = |(taxel, verdict): (&usize, &Verdict)| TaxelMark {
        place: (moment.patch, *taxel),
        look: skin_map::mark_of(verdict, moment.pressed.contains(taxel)),
    };
    let marks: Vec<TaxelMark> = moment.verdicts.iter().map(mark).collect();
    let description = format!("The patch with {} taxels in contact, marked by verdict.", marks.len());
    let name = slug(&moment.scene);
    let mut charts = picture::close_ups(&name, &moment.snapshot, &moment.layout, &marks, &description);
    let skin = format!("{name}-skin");
    charts.push(skin_map::svg(&skin, grid, &moment.verdicts, &moment.pressed));
    let untouched = moment.verdicts.keys().filter(|taxel| !moment.pressed.contains(taxel));
    let caption = format!(
        "Scene {}, draw {}, {:.2} s after the start: the moment with the most taxels in contact. A green triangle is a leaf, \
         a brown square a trunk, a red cross an outlier, a blue ring uncertain. Grey marks of the same shapes are taxels that \
         nothing presses on (spurious readings, creep, crosstalk): {} of {} here. Taxels on the far side are seen through the \
         arm. Leaves are green, trunks brown, foam blocks sand-coloured, foam rolls red.",
        moment.scene,
        moment.reach_index,
        moment.snapshot.frame.time_s,
        untouched.count(),
        moment.verdicts.len()
    );
    report.page.figure(&caption, &charts);
}
