//! The page, and the single file with its data inside.

use std::fmt::Write;
use std::sync::LazyLock;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::deflate::compress_to_vec_zlib;
use miniz_oxide::inflate::decompress_to_vec_zlib;
use underbrush_recording::{Fault, stop};

use crate::{Source, Summary};

/// The built page: one HTML file with its script and style inside.
pub static PAGE: LazyLock<String> = LazyLock::new(|| {
    let page = decompress_to_vec_zlib(include_bytes!(concat!(env!("OUT_DIR"), "/page.zlib")));
    // What the build has compressed can be read again, and is text.
    page.ok().and_then(|page| String::from_utf8(page).ok()).unwrap_or_default()
});
/// The place of the data in a single file. The build makes sure that the page has it exactly once.
const MARKER: &str = "<!--underbrush-data-->";

/// What the page may do, from its own `<meta>` tag: run its script, use its style and ask its server. The build writes
/// the hashes of script and style into it.
pub fn policy() -> &'static str {
    let tag = PAGE.split_once("http-equiv=\"Content-Security-Policy\" content=\"");
    let policy = tag.and_then(|(_, rest)| rest.split_once('"'));
    // A page without its tag may do nothing.
    policy.map_or("default-src 'none'", |(policy, _)| policy)
}

/// The page with these reaches inside, by their numbers in the list. It opens from disk and needs no network.
///
/// # Errors
/// As [`Source::pack`], and [`Fault::Usage`] if the file would have more than `max_bytes`.
///
/// ```
/// use underbrush_recording::fault::Fault;
/// use underbrush_replay::{ReplayContext, Source, single_file};
///
/// let context = ReplayContext { force_limit_n: |_| None, stated_limit_n: None, audit_warnings: |_, _| Vec::new() };
/// let source = Source::of(Vec::new(), context)?;
/// assert!(single_file(&source, &[], 50_000_000)?.starts_with("<!doctype html>"));
/// # Ok::<(), Fault>(())
/// ```
pub fn single_file(source: &Source, numbers: &[usize], max_bytes: usize) -> Result<String, Fault> {
    let (page, fitting) = page_that_fits(source, numbers, max_bytes)?;
    if fitting == numbers.len() {
        return Ok(page);
    }
    Err(Fault::Usage(format!(
        "the file would be larger than {} MB, which browsers cannot open; only the first {fitting} reaches fit: choose some \
         with --reaches",
        max_bytes / 1_000_000
    )))
}

/// As [`single_file`], with only as many of the reaches as fit, and their number.
///
/// # Errors
/// As [`Source::pack`].
pub fn page_that_fits(source: &Source, numbers: &[usize], max_bytes: usize) -> Result<(String, usize), Fault> {
    let mut data = String::new();
    let mut listed = Vec::new();
    for (place, number) in numbers.iter().enumerate() {
        stop::check();
        // Level 9 would save less than one percent more.
        let bytes = compress_to_vec_zlib(&source.pack(*number)?, 6);
        // Base64 turns three bytes into four.
        if PAGE.len() + data.len() + bytes.len() / 3 * 4 > max_bytes {
            break;
        }
        listed.extend(source.reaches.get(*number).map(|reach| Summary { number: place, ..reach.clone() }));
        let _ = write!(data, "<script type=\"application/octet-stream\" id=\"underbrush-reach-{place}\">");
        STANDARD.encode_string(bytes, &mut data);
        data += "</script>\n";
    }
    // Plain data can always be written. `<` is escaped, because a name could contain `</script>`.
    let list = serde_json::to_string(&listed).unwrap_or_default().replace('<', "\\u003c");
    let _ = writeln!(data, "<script type=\"application/json\" id=\"underbrush-reaches\">{list}</script>");
    Ok((PAGE.replacen(MARKER, &data, 1), listed.len()))
}
