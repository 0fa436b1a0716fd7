use super::*;

fn categories() -> Vec<String> {
    vec!["leaf".into(), "trunk".into()]
}

fn category(name: &str) -> Verdict {
    Verdict::Category(name.into())
}

/// Tests the thresholds of section V-D: a category above 80, an outlier from 15 to 80, uncertain below 15, whichever
/// category is best.
#[test]
fn the_papers_thresholds_cut_where_it_says() {
    let judge = Decision::paper().prepare(&categories()).unwrap();
    for (margin, expected) in [
        (80.001, category("trunk")),
        (80.0, Verdict::Outlier),
        (15.0, Verdict::Outlier),
        (14.999, Verdict::Uncertain),
        (0.0, Verdict::Uncertain),
        (-14.0, Verdict::Uncertain),
        (-40.0, Verdict::Outlier),
        (-200.0, category("leaf")),
        (f64::INFINITY, category("trunk")),
    ] {
        assert_eq!(judge.choose(&[0.0, margin]), expected, "margin {margin}");
    }
}

/// Tests eq. 3: a prior of 0.9 against 0.1 adds ln 9 = 2.197 nats to the margin, whatever the priors' unit.
#[test]
fn priors_shift_the_margin() {
    for unit in [1.0, 50.0] {
        let prior = BTreeMap::from([("leaf".to_owned(), 0.9 * unit), ("trunk".to_owned(), 0.1 * unit)]);
        let judge = Decision { prior, rule: Rule::Argmax }.prepare(&categories()).unwrap();
        assert_eq!(judge.choose(&[-10.0, -7.81]), category("leaf"));
        assert_eq!(judge.choose(&[-10.0, -7.79]), category("trunk"));
    }
}

/// Tests that ties, and scores that are all −inf, give no category, and that a single model always wins.
#[test]
fn impossible_data_are_uncertain() {
    let judge = Decision::argmax().prepare(&categories()).unwrap();
    assert_eq!(judge.choose(&[f64::NEG_INFINITY; 2]), Verdict::Uncertain);
    assert_eq!(judge.choose(&[-3.0, -3.0]), Verdict::Uncertain);
    assert_eq!(judge.choose(&[f64::NEG_INFINITY, -1e5]), category("trunk"));
    let alone = Decision::paper().prepare(&["leaf".into()]).unwrap();
    assert_eq!(alone.choose(&[-5.0]), category("leaf"));
}

/// Tests the rule of section V-B at its threshold.
#[test]
fn plain_threshold() {
    let judge = Decision::new(Rule::UncertainBelow { margin: 2.0 }).prepare(&categories()).unwrap();
    assert_eq!(judge.choose(&[2.0, 0.0]), category("leaf"));
    assert_eq!(judge.choose(&[1.999, 0.0]), Verdict::Uncertain);
}

/// Tests which priors and thresholds are refused.
#[test]
fn invalid_decisions_are_refused() {
    let with_prior = |prior: &[(&str, f64)]| Decision {
        prior: prior.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
        rule: Rule::Argmax,
    };
    let refused = [
        with_prior(&[("leaf", 1.0)]),
        with_prior(&[("leaf", 1.0), ("foam", 1.0)]),
        with_prior(&[("leaf", 1.0), ("trunk", 0.0)]),
        with_prior(&[("leaf", 1.0), ("trunk", 1e-10)]),
        // Their sum is infinite.
        with_prior(&[("leaf", 1e308), ("trunk", 1e308)]),
        with_prior(&[("leaf", f64::NAN), ("trunk", 1.0)]),
        Decision::new(Rule::OutlierBand { uncertain_below: 80.0, category_above: 15.0 }),
        Decision::new(Rule::UncertainBelow { margin: f64::NAN }),
        Decision::new(Rule::UncertainBelow { margin: -1.0 }),
    ];
    for decision in refused {
        assert!(decision.prepare(&categories()).is_err(), "{decision:?}");
    }
}

/// Tests the JSON of verdicts and of the paper's decision.
#[test]
fn verdicts_are_written_in_words() {
    let json = |verdict: &Verdict| serde_json::to_string(verdict).unwrap();
    assert_eq!(json(&category("leaf")), r#"{"category":"leaf"}"#);
    assert_eq!(json(&Verdict::Outlier), r#""outlier""#);
    let text = serde_json::to_string(&Decision::paper()).unwrap();
    assert_eq!(text, r#"{"rule":{"outlier_band":{"uncertain_below":15.0,"category_above":80.0}}}"#);
    assert_eq!(serde_json::from_str::<Decision>(&text).unwrap(), Decision::paper());
}

/// Tests that model files written before `lead` was renamed to `margin` still load, and that new files say `margin`.
#[test]
fn the_old_key_of_the_margin_still_loads() {
    let rule = Rule::UncertainBelow { margin: 3.5 };
    for key in ["lead", "margin"] {
        let text = format!(r#"{{"uncertain_below":{{"{key}":3.5}}}}"#);
        assert_eq!(serde_json::from_str::<Rule>(&text).unwrap(), rule);
    }
    let written = serde_json::to_string(&rule).unwrap();
    assert_eq!(written, r#"{"uncertain_below":{"margin":3.5}}"#);
}
