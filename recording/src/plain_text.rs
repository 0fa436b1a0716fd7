//! Text that a terminal shows as it is.
//!
//! Control characters, among them the one that begins escape sequences, can move the cursor, change colours or set the
//! title of a terminal, and bidirectional controls can show a text in another order than it is read in. Names in files
//! must not have them, and what is printed has them escaped.

use std::borrow::Cow;

/// What is allowed as a name or a summary.
pub const PLAIN: &str = "text without control characters and without bidirectional controls";

/// Whether a terminal shows the character as it is, apart from line breaks and tabs.
fn is_plain_character(character: char) -> bool {
    let bidirectional = matches!(
        character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    !character.is_control() && !bidirectional
}

/// Whether a name or a summary has no control characters, not even line breaks or tabs, and no bidirectional controls.
pub fn is_plain(text: &str) -> bool {
    text.chars().all(is_plain_character)
}

/// The text with its control characters and bidirectional controls as `\u001b`, JSON's escapes, so that JSON keeps its
/// meaning. Line breaks and tabs stay.
///
/// ```
/// use underbrush_recording::plain_text::escaped;
///
/// // A name from a file cannot clear the terminal.
/// assert_eq!(escaped("leaf\u{1b}[2J"), r"leaf\u001b[2J");
/// ```
pub fn escaped(text: &str) -> Cow<'_, str> {
    let stays = |character: char| is_plain_character(character) || matches!(character, '\n' | '\t');
    if text.chars().all(stays) {
        return text.into();
    }
    let escape = |character: char| match stays(character) {
        true => character.to_string(),
        false => format!("\\u{:04x}", u32::from(character)),
    };
    text.chars().map(escape).collect()
}

/// The text cut to this many characters, with an ellipsis if it is longer.
///
/// ```
/// use underbrush_recording::shortened;
///
/// assert_eq!((shortened("leaf", 4), shortened("trunk", 4)), ("leaf".into(), "trun…".into()));
/// ```
pub fn shortened(text: &str, characters: usize) -> String {
    match text.char_indices().nth(characters) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::{escaped, is_plain};

    /// Tests that every control character of C0 and C1 and every bidirectional control is escaped, and no other text.
    #[test]
    fn what_changes_a_terminal_is_escaped() {
        for code in
            (0..0x20).chain(0x7f..0xa0).chain([0x61c, 0x200e, 0x200f]).chain(0x202a..=0x202e).chain(0x2066..=0x2069)
        {
            let character = char::from_u32(code).unwrap();
            assert!(!is_plain(&format!("a{character}b")), "{code:x}");
            let expected = match character {
                '\n' | '\t' => format!("a{character}b"),
                _ => format!("a\\u{code:04x}b"),
            };
            assert_eq!(escaped(&format!("a{character}b")), expected);
        }
        let plain = "leaf, Blätter, 葉, 🍃, \u{5d0}\u{5d1}, é\u{301}, \u{a0}, \\u001b";
        assert!(is_plain(plain));
        assert_eq!(escaped(plain), plain);
    }

    /// Tests that escaped JSON has the same meaning.
    #[test]
    fn escaped_json_stays_the_same_value() {
        let text = "\u{202e}\u{9b}31m\u{7f}";
        let json = serde_json::to_string(text).unwrap();
        assert_eq!(serde_json::from_str::<String>(&escaped(&json)).unwrap(), text);
        assert!(is_plain(&escaped(&json)));
    }
}
