//! Reads small CSV tables without the program's own reader.

use std::collections::BTreeMap;

/// The rows of a CSV text without quoted cells, by column name.
pub fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells.len(), header.len(), "{line}");
            header.iter().zip(cells).map(|(name, cell)| (name.to_string(), cell.to_string())).collect()
        })
        .collect()
}

/// Log-likelihoods by model and trial from the output of `underbrush score`.
pub fn scores(text: &str) -> BTreeMap<(String, u64), f64> {
    assert_eq!(text.lines().next(), Some("model,trial,log_likelihood"));
    let score = |row: BTreeMap<String, String>| {
        let key = (row["model"].clone(), row["trial"].parse().unwrap());
        (key, row["log_likelihood"].parse().unwrap())
    };
    rows(text).into_iter().map(score).collect()
}
