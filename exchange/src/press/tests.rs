#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use super::*;

const MODULUS: f64 = 3e7;
const HARDENING: f64 = 250.0;
const LOSS_S: f64 = 0.003;

/// A press to 2 mm and back at 20 mm/s and at 2 mm/s, 500 samples a second. `noise` is a share of the largest force.
fn press(punch: Punch, noise: f64, seed: u64) -> Vec<PressSample> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut depths = Vec::new();
    for speed in [0.02, 0.002] {
        let step = speed * 0.002;
        let count = (0.002 / step) as usize;
        depths.extend((0..count).map(|at| (at as f64 * step, speed)));
        depths.extend((0..count).rev().map(|at| (at as f64 * step, -speed)));
    }
    // Simpson's rule over the pressed disc.
    let force = |depth: f64, speed: f64| {
        // Force is (1 + τ d/dt) of the elastic force; its slope by central differences.
        let elastic = |d: f64| MODULUS * d / (1.0 - HARDENING * d);
        let pressure = |d: f64| {
            let small = 1e-8;
            elastic(d) + LOSS_S * speed * (elastic(d + small) - elastic(d - small)) / (2.0 * small)
        };
        match punch {
            Punch::Flat(area) => area * pressure(depth),
            Punch::Ball(radius) => {
                let count = 1000;
                let at = |n: usize| pressure(depth * n as f64 / count as f64);
                let inner: f64 = (1..count).map(|n| if n % 2 == 1 { 4.0 } else { 2.0 } * at(n)).sum();
                2.0 * PI * radius * depth / (3.0 * count as f64) * (at(0) + inner + at(count))
            }
        }
    };
    let largest_n = force(0.002, 0.02);
    let rows = depths.into_iter().enumerate().map(|(at, (depth_m, speed))| {
        // The mean of twelve uniform numbers is nearly normal; its deviation is 1/12.
        let normal = (0..12).map(|_| random.random::<f64>() - 0.5).sum::<f64>();
        PressSample { time_s: at as f64 * 0.002, depth_m, force_n: force(depth_m, speed) + normal * noise * largest_n }
    });
    rows.collect()
}

/// Tests that a press without noise gives back its law, for a flat punch and a ball: within 3 %, because the speed is wrong
/// at the 4 of 2,200 samples where the press turns round.
#[test]
fn a_press_gives_back_its_law() {
    for punch in [Punch::Flat(4e-4), Punch::Ball(0.01)] {
        let fit = fit_press(&press(punch, 0.0, 0), punch).unwrap();
        for (found, expected) in
            [(fit.modulus_n_per_m3, MODULUS), (fit.hardening_per_m, HARDENING), (fit.loss_time_s.unwrap(), LOSS_S)]
        {
            assert!((found.value / expected - 1.0).abs() < 0.03, "{punch:?}: {found:?}, {expected}");
        }
    }
}

/// Tests that the intervals of 95 % hold the truth in at least 88 % of 100 presses with noise of 1 %: three standard errors
/// below 95.
#[test]
fn intervals_hold_the_truth() {
    let punch = Punch::Flat(4e-4);
    let mut held = [0; 3];
    for seed in 0..100 {
        let fit = fit_press(&press(punch, 0.01, seed), punch).unwrap();
        let estimates =
            [(fit.modulus_n_per_m3, MODULUS), (fit.hardening_per_m, HARDENING), (fit.loss_time_s.unwrap(), LOSS_S)];
        for (count, (found, truth)) in held.iter_mut().zip(estimates) {
            *count += usize::from((found.interval[0]..=found.interval[1]).contains(&truth));
        }
    }
    assert!(held.iter().all(|count| *count >= 88), "{held:?}");
}

/// Tests that a hold that loses 6 % of its force per decade is found, and that a press without a hold has none.
#[test]
fn relaxation_is_that_of_the_hold() {
    let punch = Punch::Flat(4e-4);
    let mut samples = press(punch, 0.0, 0);
    assert_eq!(fit_press(&samples, punch).unwrap().relaxation_share_per_decade, None);
    let start_s = samples.last().unwrap().time_s + 1.0;
    samples.extend((0..1000).map(|at| {
        let time_s = at as f64 * 0.01;
        let force_n = 20.0 * (1.0 - 0.06 * (time_s.max(0.001) / 0.1).log10());
        PressSample { time_s: start_s + time_s, depth_m: 0.0015, force_n }
    }));
    let found = relaxation(&samples).unwrap();
    assert!((found - 0.06).abs() < 1e-3, "{found}");
    // The first and the last sample of a hold tell no slope.
    samples.drain(samples.len() - 999..samples.len() - 1);
    assert_eq!(relaxation(&samples), None);
}

/// Tests that holds are told from the fast and the slow press before and after them: creep, 6 % of the force per decade of time, does
/// not change the law.
#[test]
fn holds_between_presses_do_not_change_the_law() {
    let punch = Punch::Flat(4e-4);
    let (mut samples, mut late_s) = (Vec::new(), 0.0);
    for pair in press(punch, 0.0, 0).windows(2) {
        let turn = PressSample { time_s: pair[0].time_s + late_s, ..pair[0] };
        samples.push(turn);
        if turn.depth_m > 0.001 && turn.depth_m == pair[1].depth_m {
            samples.extend((1..2500).map(|at| {
                let held_s = 0.002 * f64::from(at);
                let force_n = turn.force_n * (1.0 - 0.06 * (1.0 + held_s / 0.1).log10());
                PressSample { time_s: turn.time_s + held_s, force_n, ..turn }
            }));
            late_s += 5.0;
        }
    }
    assert_eq!(holds(&samples).len(), 2);
    let fit = fit_press(&samples, punch).unwrap();
    for (found, expected) in
        [(fit.modulus_n_per_m3, MODULUS), (fit.hardening_per_m, HARDENING), (fit.loss_time_s.unwrap(), LOSS_S)]
    {
        assert!((found.value / expected - 1.0).abs() < 0.03, "{found:?}, {expected}");
    }
}

/// Tests that a press at one speed says nothing about the loss, and gives back stiffness and hardening.
#[test]
fn one_speed_tells_no_loss() {
    let punch = Punch::Flat(4e-4);
    let force = |depth_m: f64| 4e-4 * MODULUS * depth_m / (1.0 - HARDENING * depth_m);
    let sample = |at: usize| (at as f64 * 0.002, at as f64 * 4e-6);
    let samples: Vec<PressSample> = (0..500)
        .map(sample)
        .map(|(time_s, depth_m)| PressSample { time_s, depth_m, force_n: force(depth_m) })
        .collect();
    let fit = fit_press(&samples, punch).unwrap();
    assert_eq!(fit.loss_time_s, None);
    for (found, expected) in [(fit.modulus_n_per_m3, MODULUS), (fit.hardening_per_m, HARDENING)] {
        assert!((found.value / expected - 1.0).abs() < 1e-6, "{found:?}, {expected}");
    }
}

/// Tests that presses at one depth and speed are refused, and those that are too short.
#[test]
fn poor_presses_are_refused() {
    let punch = Punch::Flat(4e-4);
    assert_eq!(fit_press(&press(punch, 0.0, 0)[..10], punch), Err(PressError::FewSamples(8)));
    let level = |at: usize| PressSample { time_s: 0.01 * at as f64, depth_m: 0.001, force_n: 10.0 };
    let level: Vec<PressSample> = (0..100).map(level).collect();
    assert_eq!(fit_press(&level, punch), Err(PressError::Indistinct));
}

/// Tests that depths and forces whose squares are infinite are refused.
#[test]
fn extreme_numbers_are_refused() {
    let sample = |at: i32| {
        let number = 1e200 * f64::from(at);
        PressSample { time_s: 0.01 * f64::from(at), depth_m: number, force_n: number }
    };
    let samples: Vec<PressSample> = (1..=60).map(sample).collect();
    assert_eq!(fit_press(&samples, Punch::Flat(4e-4)), Err(PressError::Indistinct));
}

/// Tests that a faulty row is refused with its own line, also after blank lines.
#[test]
fn a_faulty_row_is_named_by_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.csv");
    for (rows, line, found) in [
        ("0,0,0\n1,x,0\n", 3, "float"),
        ("\n0,0,0\n1,x,0\n", 4, "float"),
        ("\n\n0,0,0\n\n1,0,0\n2,inf,0\n", 7, "not finite"),
        ("0,0,0\n\n\n0,0,0\n", 5, "time_s = 0"),
        ("0,0,0\n\n1,0\n", 4, "2 cells"),
    ] {
        for text in
            [format!("time_s,depth_m,force_n\n{rows}"), format!("time_s,depth_m,force_n\n{rows}").replace('\n', "\r\n")]
        {
            std::fs::write(&path, &text).unwrap();
            let error = read_press(&path).unwrap_err();
            assert_eq!(error.line, Some(line), "{text:?}: {error}");
            assert!(error.found.contains(found), "{error}");
        }
    }
    std::fs::write(&path, "time_s,depth_m,force_n\n\n0,0,0\n\n1,0.001,2\n\n").unwrap();
    assert_eq!(read_press(&path).unwrap().len(), 2);
}
