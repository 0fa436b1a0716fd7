//! The fabric's loop and response.

use super::*;

/// Tests the fabric's hysteresis loop: up to F and back to 0 it encloses h F² / 2 at any speed, and a reading during
/// unloading is never below that during loading.
#[test]
fn fabric_has_the_hysteresis_loop_asked_for() {
    let (share, peak) = (0.25, 8.0);
    let options = SensorOptions {
        fabric: FabricOptions { hysteresis_share: share, ..SensorOptions::off().fabric },
        ..SensorOptions::off()
    };
    for steps in [400, 4000] {
        let mut sensor = sensor(&options);
        let force = |step: i32| peak * f64::from(step) / f64::from(steps);
        let mut way = |step: i32| press(&mut sensor, (FLIPPER, 7), force(step));
        let up: Vec<f64> = (0..=steps).map(&mut way).collect();
        let mut down: Vec<f64> = (0..=steps).rev().map(&mut way).collect();
        down.reverse();
        assert!(up.iter().zip(&down).all(|(up, down)| up <= down));
        assert_eq!((down[0], up[0]), (0.0, 0.0));
        // The trapezoidal rule is exact on straight pieces; at the one corner its error is at most the square of a
        // step.
        let gap: Vec<f64> = up.iter().zip(&down).map(|(up, down)| down - up).collect();
        let area: f64 = gap.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0 * (peak / f64::from(steps))).sum();
        let expected = share * peak * peak / 2.0;
        let step = peak / f64::from(steps);
        assert!((area - expected).abs() < step * step, "{area}, {expected}");
    }
}

/// Tests the fabric's response F S / (F + S): slope 1 at small forces, half the full scale at S, never over it, in
/// counts of the converter.
#[test]
fn fabric_saturates_as_a_voltage_divider() {
    let full_scale_n = 34.1;
    let mut smooth = sensor(&SensorOptions {
        fabric: FabricOptions { full_scale_n, ..SensorOptions::off().fabric },
        ..SensorOptions::off()
    });
    let small = press(&mut smooth, (FLIPPER, 0), 1e-6);
    assert!((small / 1e-6 - 1.0).abs() < 1e-6, "slope {}", small / 1e-6);
    let half = press(&mut smooth, (FLIPPER, 0), full_scale_n);
    assert!((half - full_scale_n / 2.0).abs() < ROUNDING * half, "half scale {half}");
    let max = press(&mut smooth, (FLIPPER, 0), 1e12);
    assert!(max <= single(full_scale_n) && max > full_scale_n * (1.0 - ROUNDING) - 1e-6, "largest reading {max}");
    let mut counting = sensor(&SensorOptions {
        fabric: FabricOptions { counts_per_n: 30.0, ..SensorOptions::off().fabric },
        ..SensorOptions::off()
    });
    assert_eq!(press(&mut counting, (FLIPPER, 0), 1.02), single(31.0 / 30.0));
}
