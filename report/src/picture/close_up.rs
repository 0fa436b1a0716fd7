//! Close-ups of marked taxels.

use std::fmt::Write;

use crate::category_looks::CategoryLooks;
use crate::drawing::{Mark, escape, svg_rect, svg_text};
use glam::{DVec2, DVec3};
use underbrush_recording::SkinLayout;
use underbrush_sim::snapshot::Snapshot;

use super::panel::{PANELS, Panel, View};

/// A mark on a taxel.
pub struct TaxelMark {
    /// Patch and taxel.
    pub place: (usize, usize),
    /// Colour and shape.
    pub look: (&'static str, Mark),
}

/// Pixels per metre.
const SCALE: f64 = 520.0;
/// Side lengths, m: a forearm with its surroundings.
const SIZE_M: DVec2 = DVec2::new(0.30, 0.23);
/// Font size, px, from which the height of the title follows. A close-up is enlarged to about the width of a page.
const FONT: f64 = 5.6;

/// Close-ups of marked taxels, from the right and from above; none if there are no marks. `name` is unique on a page.
pub fn close_ups(
    name: &str,
    snapshot: &Snapshot,
    looks: &CategoryLooks,
    layout: &SkinLayout,
    marks: &[TaxelMark],
    description: &str,
) -> Vec<String> {
    let frame = &snapshot.frame;
    let position = |mark: &TaxelMark| {
        let taxel = layout.patches.get(mark.place.0)?.taxels.get(mark.place.1)?;
        Some(frame.patch_pose_world.get(mark.place.0)?.transform_point(taxel.position_link))
    };
    let positions: Vec<(DVec3, &TaxelMark)> = marks.iter().filter_map(|mark| Some((position(mark)?, mark))).collect();
    if positions.is_empty() {
        return Vec::new();
    }
    let centre = positions.iter().map(|(position, _)| *position).sum::<DVec3>() / positions.len() as f64;
    PANELS.iter().map(|panel| draw(panel, name, (snapshot, looks), &positions, centre, description)).collect()
}

fn draw(
    panel: &Panel,
    name: &str,
    (snapshot, looks): (&Snapshot, &CategoryLooks),
    marks: &[(DVec3, &TaxelMark)],
    centre: DVec3,
    description: &str,
) -> String {
    let view = View { corner: panel.project(centre) - SIZE_M / 2.0, size_m: SIZE_M, scale: SCALE };
    let size = view.size_px();
    let top = 1.8 * FONT;
    let name = format!("{}-{}", escape(name), panel.title.replace(' ', "-"));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.1} {:.1}\" role=\"img\" \
         aria-labelledby=\"{name}-title {name}-desc\" font-family=\"sans-serif\" font-size=\"{FONT}\">\n\
         <title id=\"{name}-title\">Arm and skin {title}</title>\n<desc id=\"{name}-desc\">{}</desc>\n\
         <text x=\"1\" y=\"{FONT}\" font-weight=\"bold\">Arm and skin {title}</text>\n\
         <svg x=\"0\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#f6f7f9\"/>\n",
        size.x,
        size.y + top,
        escape(description),
        size.x,
        size.y,
        title = panel.title,
    );
    panel.shapes(&mut svg, &view, snapshot, looks);
    // Nearest to the viewer last.
    let mut marks: Vec<_> = marks.iter().collect();
    marks.sort_by(|a, b| panel.depth(a.0).total_cmp(&panel.depth(b.0)));
    for (position, mark) in marks {
        let at = panel.to_pixels(&view, *position);
        let _ = writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"#ffffff\"/>", at.x, at.y);
        svg += &mark.look.1.svg(at.x, at.y, 2.3, mark.look.0);
    }
    scale_bar(&mut svg, size);
    svg + "</svg>\n</svg>\n"
}

/// A scale bar of five centimetres, on an opaque background.
fn scale_bar(svg: &mut String, size: DVec2) {
    let length = 0.05 * SCALE;
    let (x, y) = (size.x - length - 6.0, size.y - 6.0);
    let plate = (length + 6.0, FONT + 7.0);
    let plate = svg_rect((x - 3.0, y + 3.0 - plate.1), plate, "rx=\"2\" fill=\"#ffffff\" opacity=\"0.85\"");
    let text = svg_text(x + length / 2.0, y - 3.0, " text-anchor=\"middle\"", "5 cm");
    let _ = writeln!(
        svg,
        "{plate}\n<path d=\"M{x:.1} {y:.1}h{length:.1}\" stroke=\"#222222\" stroke-width=\"1.5\"/>{text}"
    );
}
