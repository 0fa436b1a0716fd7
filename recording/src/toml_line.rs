//! Finds the line of a key in a TOML file, for errors that are found after parsing.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::line_at;

/// The line at which a file sets a field such as `goals.count` or `objects.leaf[1].height_m`, counted from 1; `None` if it does
/// not.
pub fn line_setting(text: &str, field: &str) -> Option<usize> {
    line_giving(text, field, &|_| true)
}

/// The line at which a file gives a field a value whose text is the one that is looked for. Where `field` names a list of
/// tables without a number, this is in the first table that gives such a value.
pub fn line_giving(text: &str, field: &str, is_value: &dyn Fn(&str) -> bool) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let is_value = |value: &Spanned<DeValue>| is_value(&text[value.span()]);
    Some(line_at(text, place(table.get_ref(), field, &is_value)?))
}

/// The byte at which a table gives a field such a value.
fn place(table: &DeTable, field: &str, is_value: &dyn Fn(&Spanned<DeValue>) -> bool) -> Option<usize> {
    let (first, rest) = field.split_once('.').map_or((field, None), |(first, rest)| (first, Some(rest)));
    let numbered = first.strip_suffix(']').and_then(|first| first.split_once('['));
    let (name, number) = numbered.map_or((first, None), |(name, number)| (name, number.parse::<usize>().ok()));
    let (key, value) = table.iter().find(|(key, _)| key.get_ref() == name)?;
    let within = |value: &Spanned<DeValue>| match (value.get_ref(), rest) {
        (DeValue::Table(table), Some(rest)) => place(table, rest, is_value),
        (_, Some(_)) => None,
        (_, None) => is_value(value).then(|| value.span().start),
    };
    match (value.get_ref(), number) {
        (DeValue::Array(all), Some(number)) => within(all.get(number)?),
        (DeValue::Array(all), None) if rest.is_some() => all.iter().find_map(within),
        _ => within(value).map(|place| if rest.is_none() { key.span().start } else { place }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "top = { inner = 1 }\nstates = [5, 10]\n\n[goals]\ncount = 4\n\"quoted\" = 2\n\n[[objects.leaf]]\ncount = 3\n\n\
                        [[objects.leaf]]\nplace.x_m = 0.5\ncount_of_all = 1\ncount = 1_0.0\n";

    /// Tests that a field is found under its table, in inline tables, as a dotted or quoted key and by its number in a list,
    /// and that a longer key is not taken for it.
    #[test]
    fn a_field_is_found_where_it_is_set() {
        let lines = [
            ("top.inner", Some(1)),
            ("states", Some(2)),
            ("goals", Some(4)),
            ("goals.count", Some(5)),
            ("goals.quoted", Some(6)),
            ("objects.leaf[0]", Some(8)),
            ("objects.leaf[0].count", Some(9)),
            ("objects.leaf[1]", Some(11)),
            ("objects.leaf[1].place.x_m", Some(12)),
            ("objects.leaf[1].count", Some(14)),
            ("objects.leaf.count", Some(9)),
            ("objects.leaf[2].count", None),
            ("goals.retries", None),
            ("inner", None),
        ];
        for (field, line) in lines {
            assert_eq!(line_setting(TEXT, field), line, "{field}");
        }
    }

    /// Tests that of a list of tables the one with the value counts.
    #[test]
    fn a_value_is_found_in_the_table_that_gives_it() {
        assert_eq!(line_giving(TEXT, "objects.leaf.count", &|text| text == "1_0.0"), Some(14));
        assert_eq!(line_giving(TEXT, "states", &|text| text.contains("10")), Some(2));
        assert_eq!(line_giving(TEXT, "objects.leaf.count", &|text| text == "7"), None);
    }
}
