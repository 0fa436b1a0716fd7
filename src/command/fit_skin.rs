//! `underbrush fit-skin`: fits the law of a skin to a press test.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::builder::TypedValueParser;
use clap::{ArgGroup, Args};
use serde_json::json;
use underbrush_exchange::press::{Estimate, PressFit, Punch, fit_press, read_press};
use underbrush_sim::materials::{CONSTANTS, Constant, MaterialFile};

use crate::{Failure, Overwrite, options, output};

/// Options of `underbrush fit-skin`.
///
/// Press one pad of the skin on a hard ground with a flat punch or a ball, to several depths and at two speeds or more, and
/// write time_s, depth_m and force_n as CSV. The fit is p + τ dp/dt with p = C d / (1 − β d): the pressure p at the depth d of a
/// layer of the thickness 1/β. C and, if the press shows them, τ and 1/β are written as a file of materials,
/// for `underbrush generate --materials FILE`.
#[derive(Args)]
#[command(group(ArgGroup::new("punch").required(true)), mut_arg("force", |own| own.requires("out")))]
pub struct FitSkinOptions {
    /// The press test: CSV with the columns time_s, depth_m and force_n
    press: PathBuf,
    /// Area of a flat punch, or of the pad if the punch is larger, cm²
    #[arg(long, value_name = "CM2", group = "punch", value_parser = positive())]
    punch_area_cm2: Option<f64>,
    /// Radius of a ball, mm
    #[arg(long, value_name = "MM", group = "punch", value_parser = positive())]
    ball_radius_mm: Option<f64>,
    /// Write foundation modulus, loss time and thickness of the skin to this file of materials (TOML)
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

fn positive() -> impl TypedValueParser<Value = f64> {
    options::number(|value: &f64| value.is_finite() && *value > 0.0, "must be above 0")
}

/// Fits, prints and writes.
pub fn run(options: FitSkinOptions, json: bool) -> Result<(), Failure> {
    if let Some(out) = &options.out {
        options.overwrite.file(out, std::slice::from_ref(&options.press))?;
    }
    let punch = match (options.punch_area_cm2, options.ball_radius_mm) {
        (_, Some(radius_mm)) => Punch::Ball(radius_mm * 1e-3),
        (area_cm2, None) => Punch::Flat(area_cm2.unwrap_or_default() * 1e-4),
    };
    let samples = read_press(&options.press)?;
    let fit = fit_press(&samples, punch).map_err(|error| Failure::usage(error.to_string()).about(&options.press))?;
    let press = options.press.display();
    // Noise can make a small loss time negative, which no skin has.
    let constant = |name: &str, estimate: &Estimate, affects: &str| {
        let (_, limits) = CONSTANTS.iter().find(|(own, _)| *own == name)?;
        let [value, low, high] = [estimate.value, estimate.interval[0], estimate.interval[1]].map(|own| own.max(0.0));
        if !limits.hold(value) {
            let out = options.out.as_ref();
            let without = out.map_or(String::new(), |out| format!("; {} is without it", out.display()));
            output::remark(format!(
                "warning: {press}: the fit gives {name} = {value:.3}; allowed are {limits}{without}; check that depths are in m and \
                 forces in N"
            ));
            return None;
        }
        let source = format!("fit-skin of {press}; the range is that of 95 %");
        let range = [low.min(value).max(limits.min), high.max(value).min(limits.max)];
        Some((name.to_owned(), Constant { value, range, source, affects: affects.into() }))
    };
    let affects = "Peak force and onset of hard touches";
    let mut constants = BTreeMap::from_iter(constant("skin_modulus_n_per_m3", &fit.modulus_n_per_m3, affects));
    let loss_time = fit.loss_time_s.as_ref();
    constants.extend(loss_time.and_then(|own| constant("skin_loss_time_s", own, "Peak force of impacts")));
    let Estimate { value, interval: [low, high] } = fit.hardening_per_m;
    if low > 0.0 {
        let thickness = Estimate { value: 1.0 / value, interval: [1.0 / high, 1.0 / low] };
        let affects = "Depth and peak force of hard touches and edges";
        constants.extend(constant("skin_thickness_m", &thickness, affects));
    }
    if let Some(out) = &options.out {
        output::write_file(out, MaterialFile { constants }.text().as_bytes())?;
    }
    let mut report = json!(fit);
    report["file"] = json!(options.out.map(|out| out.display().to_string()));
    output::result(json, &report, || text(&fit))
}

fn text(fit: &PressFit) -> String {
    let line = |name: &str, Estimate { value, interval: [low, high] }: Estimate, scale: f64, unit: &str| {
        let [value, low, high] = [value, low, high].map(|number| number * scale);
        format!("{name}: {value:.4} {unit} (95 %: {low:.4} to {high:.4})\n")
    };
    let hold = fit.relaxation_share_per_decade.map_or_else(
        || "no hold of 2 s at one depth, so creep is not known\n".into(),
        |share| format!("a hold loses {:.1} % of its force per decade of time\n", 100.0 * share),
    );
    let loss = fit.loss_time_s.map_or_else(
        || "only one speed, so the loss time is not known\n".into(),
        |loss| line("loss time τ", loss, 1e3, "ms"),
    );
    format!(
        "{}{loss}{}{hold}{} samples down to {:.2} mm; {:.1} % of the largest force is left unexplained\n",
        line("foundation modulus C", fit.modulus_n_per_m3, 1e-6, "N/cm³"),
        line("hardening β", fit.hardening_per_m, 1e-3, "1/mm"),
        fit.samples,
        1e3 * fit.largest_depth_m,
        100.0 * fit.residual_share,
    )
}
