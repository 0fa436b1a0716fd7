//! Finds the line of a key in the text of a TOML file, for error messages.

/// Whether a line sets `key`.
pub(crate) fn sets_key(line: &str, key: &str) -> bool {
    let rest = line.trim_start().strip_prefix(key);
    rest.is_some_and(|rest| rest.trim_start().starts_with('='))
}

/// The first line, counted from 1, that sets `key`.
pub(crate) fn line_of_key(text: &str, key: &str) -> Option<usize> {
    text.lines().position(|line| sets_key(line, key)).map(|index| index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that a longer key is not taken for the one that is looked for.
    #[test]
    fn a_longer_key_is_another_key() {
        assert!(sets_key("  spurious_share=0.1", "spurious_share"));
        assert!(!sets_key("spurious_share_of_all = 0.1", "spurious_share"));
    }
}
