//! What SVG and HTML have in common.

/// Font size, px. On a phone, where a chart is 360 px wide, text of this size is still 10 px tall.
pub(super) const FONT: f64 = 15.0;
/// Mean width of a letter of a sans-serif font, px.
pub(crate) const LETTER: f64 = 0.54 * FONT;
/// The same of a bold one.
const BOLD_LETTER: f64 = 0.6 * FONT;

/// Text with the special characters of SVG and HTML as entities. Control characters, which XML does not allow, become
/// spaces.
///
/// ```
/// use underbrush_report::drawing::escape;
///
/// assert_eq!(escape("a < b & c"), "a &lt; b &amp; c");
/// ```
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\u{FFFE}' | '\u{FFFF}' => escaped.push(' '),
            control if control.is_control() => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}

/// Letters, digits and hyphens of a text, in lower case: a name for an element or a file that needs no escaping.
///
/// ```
/// use underbrush_report::drawing::slug;
///
/// assert_eq!(slug("Table I: leaf"), slug("table i  leaf"));
/// assert!(!slug("Fig. 6").contains(' '));
/// ```
pub fn slug(text: &str) -> String {
    let lower = text.to_lowercase();
    let words = lower.split(|character: char| !character.is_ascii_alphanumeric());
    words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
}

/// The parts as one text, with a separator between them.
///
/// ```
/// use underbrush_report::drawing::joined;
///
/// assert_eq!(joined([1, 2].map(|number| number.to_string()), "; "), "1; 2");
/// ```
pub fn joined(parts: impl IntoIterator<Item = String>, separator: &str) -> String {
    parts.into_iter().collect::<Vec<String>>().join(separator)
}

/// Words of a picture at a position, px. Attributes begin with a space.
pub fn svg_text(x: f64, y: f64, attributes: &str, words: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\"{attributes}>{}</text>", escape(words))
}

/// The attributes of words that are squeezed into a width, px, if letters of this mean width would need more.
pub(crate) fn squeezed(words: &str, letter: f64, width: f64) -> String {
    if letter * (words.chars().count() as f64) <= width {
        return String::new();
    }
    format!(" textLength=\"{width:.1}\" lengthAdjust=\"spacingAndGlyphs\"")
}

/// The start of a picture whose title is shown in its first line and, with the description, read aloud. A long title is
/// squeezed into the width.
pub fn svg_head(name: &str, title: &str, description: &str, [width, height]: [f64; 2]) -> String {
    let fit = squeezed(title, BOLD_LETTER, width - 4.0);
    let (name, title, description) = (slug(name), escape(title), escape(description));
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" \
         aria-labelledby=\"{name}-title {name}-desc\" font-family=\"sans-serif\" font-size=\"{FONT}\" fill=\"#222222\">\n\
         <title id=\"{name}-title\">{title}</title>\n<desc id=\"{name}-desc\">{description}</desc>\n\
         <text x=\"2\" y=\"{FONT}\" font-weight=\"bold\"{fit}>{title}</text>\n"
    )
}
