//! The different things in a list.

/// The different ones among `all`, in the order in which they first occur.
///
/// ```
/// use underbrush_recording::distinct;
///
/// assert_eq!(distinct(["leaf", "trunk", "leaf"]), ["leaf", "trunk"]);
/// ```
pub fn distinct<T: PartialEq>(all: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for one in all {
        if !found.contains(&one) {
            found.push(one);
        }
    }
    found
}
