//! Where a fault lies in the text of a TOML file: the parser tells a place in the text, a person looks for line and key.

/// The line, from 1, of the byte at `offset`.
pub(crate) fn line_of(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1
}

/// The key that is set at the line of `offset`, after the name of its table: `goals.count`. Empty where the line sets none
/// and no table is open.
pub(crate) fn key_at(text: &str, offset: usize) -> String {
    let number = line_of(text, offset);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Pins the key of a line of a table, of one before all tables, of a header, and of an inline table.
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
