//! Finds the line and the key for a position in the text of a TOML file, for error messages.
use underbrush_recording::text_line::line_at;

/// The key that the line at `offset` sets, preceded by the name of its table, such as `goals.count`. Empty if the line
/// sets none and no table is open.
pub(crate) fn key_at(text: &str, offset: usize) -> String {
    let number = line_at(text, offset);
    let is_header = |line: &&str| line.starts_with('[');
    let lines: Vec<&str> = text.lines().take(number).map(str::trim).collect();
    let line = lines.last().copied().unwrap_or_default();
    let table = lines.iter().rev().find(|line| is_header(line));
    let table = table.map_or("", |line| line.split(']').next().unwrap_or("").trim_start_matches('['));
    let key = match line.split_once('=') {
        Some((key, _)) if !is_header(&line) => key.trim_start_matches('{').trim(),
        _ => "",
    };
    let parts: Vec<&str> = [table, key].into_iter().filter(|part| !part.is_empty()).collect();
    parts.join(".")
}

/// Keys that files may still use under an earlier name: (present name, earlier name). serde reads them as aliases; this
/// list is for finding their lines.
const EARLIER_KEYS: [(&str, &str); 4] = [
    ("spurious_share", "stray_share"),
    ("spurious_time_s", "stray_time_s"),
    ("spurious_force_n", "stray_force_n"),
    ("model_stiffness_nm_per_rad", "believed_stiffness_nm_per_rad"),
];

/// Whether a line sets `key`, under its present or an earlier name.
pub(crate) fn sets_key(line: &str, key: &str) -> bool {
    let earlier = EARLIER_KEYS.iter().filter(|(present, _)| *present == key);
    let mut names = earlier.map(|(_, earlier)| *earlier).chain([key]);
    names.any(|name| {
        let rest = line.trim_start().strip_prefix(name);
        rest.is_some_and(|rest| rest.trim_start().starts_with('='))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that a key is found under its earlier name as well, and that a longer key is not taken for it.
    #[test]
    fn keys_are_found_under_their_earlier_names() {
        assert!(sets_key("  spurious_share = 0.1", "spurious_share"));
        assert!(sets_key("stray_share=0.1", "spurious_share"));
        assert!(!sets_key("stray_share = 0.1", "spurious_time_s"));
        assert!(!sets_key("spurious_share_of_all = 0.1", "spurious_share"));
    }

    /// Tests the key of a line of a table, of one before all tables, of a header, and of an inline table.
    #[test]
    fn keys_are_named_with_their_table() {
        let text = "name = 1\n\n[[objects.leaf]]\n  count = 2\npoints = [\n    { position_m = 3 },\n]\n";
        for (part, key) in [
            ("1", "name"),
            ("[[objects", "objects.leaf"),
            ("2", "objects.leaf.count"),
            ("3 }", "objects.leaf.position_m"),
        ] {
            assert_eq!(key_at(text, text.find(part).unwrap()), key);
        }
    }
}
