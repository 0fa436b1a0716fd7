//! Spurious readings.

use super::*;

/// Tests the long-run share and the mean duration of spurious readings within four standard errors, their range, that
/// there are none just after the skin was zeroed, and that they do not change the noise.
#[test]
fn spurious_readings_have_the_share_and_the_duration_asked_for() {
    let (share, time_s, range) = (0.05, 0.5, [0.02, 0.10]);
    let options = SensorOptions {
        spurious_share: share,
        spurious_time_s: time_s,
        spurious_force_n: range,
        ..SensorOptions::off()
    };
    let mut sensor_under_test = sensor(&options);
    let (frames, taxels) = (20_000, 384);
    let (mut lit, mut begun, mut before) = (0.0, 0.0, vec![0.0; taxels]);
    for frame in 0..frames {
        sensor_under_test.sample();
        let now: Vec<f64> = (0..taxels).map(|taxel| sensor_under_test.reading_n(FOREARM, taxel)).collect();
        assert!(now.iter().all(|force| *force == 0.0 || (range[0]..=range[1]).contains(force)));
        let affected = now.iter().filter(|force| **force > 0.0).count() as f64;
        assert!(frame > 0 || affected < 0.1 * share * taxels as f64, "{affected} at once");
        lit += affected;
        begun += before.iter().zip(&now).filter(|(before, now)| **before == 0.0 && **now > 0.0).count() as f64;
        before = now;
    }
    // Begin and end are independent of the past, so durations are geometric: their standard deviation is about their
    // mean.
    let error = 4.0 / f64::sqrt(begun);
    let duration_s = lit / begun * FRAME_PERIOD_S;
    assert!((duration_s / time_s - 1.0).abs() < error, "{duration_s} s on average of {begun}");
    // The long-run share. The start from zero changes the mean by one part in 400.
    let found = lit / (frames * taxels) as f64;
    assert!((found / share - 1.0).abs() < 1.5 * error + 0.0025, "share {found}");
    let noisy = |spurious_share| {
        let mut sensor = sensor(&SensorOptions { noise_n: 0.01, spurious_share, ..SensorOptions::off() });
        // A force far from zero; few taxels have spurious readings in the first frames.
        (0..5).map(|_| press(&mut sensor, (FOREARM, 7), 1.0)).collect::<Vec<f64>>()
    };
    assert_eq!(noisy(0.0), noisy(1e-6));
}
