//! Ground-truth categories of the objects that an arm can touch.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::limits::NAME_BYTES;
use crate::plain_text::{PLAIN, is_plain};

/// What an object is, as ground truth: a name, and the code that represents it in columns of numbers.
///
/// Four categories are built in, those of the paper (sections IV-A and V-D). Scene files name any other; its code follows from
/// the name ([`Category::named`]). The source file of an object that always has a category of its own defines it as a constant
/// ([`Category::new`]):
///
/// ```
/// use underbrush_recording::Category;
///
/// const REED: Category = Category::new("reed", 127).expect("a valid name and code");
/// assert_eq!((REED.name(), REED.code()), ("reed", 127));
/// ```
///
/// Categories are ordered by code.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Category {
    code: i8,
    name: &'static str,
}

impl Category {
    /// A bendable leaf stuck in foam.
    pub const LEAF: Category = Category { code: 0, name: "leaf" };
    /// A stiff trunk fixed to the table.
    pub const TRUNK: Category = Category { code: 1, name: "trunk" };
    /// A foam block of the ground platform: an obstacle, never a training category.
    pub const BLOCK: Category = Category { code: 2, name: "block" };
    /// An object foreign to the foliage, such as the foam roll. Never in training data.
    pub const OUTLIER: Category = Category { code: 3, name: "outlier" };

    /// The built-in categories, in the order of their codes.
    pub const BUILT_IN: [Category; 4] = [Category::LEAF, Category::TRUNK, Category::BLOCK, Category::OUTLIER];

    /// Length of the longest name, bytes.
    pub const MAX_NAME_BYTES: usize = 24;

    /// Verdicts of classifiers that are not categories. An object with such a name could not be told from the verdict.
    pub const VERDICTS: [&str; 3] = ["nothing", Category::UNCERTAIN, "unknown"];

    /// The verdict that a classifier of trials gives if it cannot decide. No trial has this as its category.
    pub const UNCERTAIN: &str = "uncertain";

    /// A category that is not built in. `None` unless the name has at most 24 lower-case letters, digits and underscores,
    /// begins with a letter, is not that of a built-in category, `none` or one of [`Category::VERDICTS`], and the code is above
    /// those of the built-in categories.
    pub const fn new(name: &'static str, code: i8) -> Option<Category> {
        if is_free(name, code) { Some(Category { code, name }) } else { None }
    }

    /// As [`Category::new`], with a name that was read from a file. Such names are kept until the program ends; a data
    /// set has at most 124 of them.
    pub fn from_file(name: &str, code: i8) -> Option<Category> {
        static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
        if !is_free(name, code) {
            return None;
        }
        let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
        let known = names.get(name).copied();
        let name = known.unwrap_or_else(|| {
            let name: &'static str = Box::leak(name.into());
            names.insert(name);
            name
        });
        Some(Category { code, name })
    }

    /// The category with this name: a built-in one, or one whose code, from 5 to 126, follows from the name, so that it
    /// is the same in every file. `None` unless the name is built in or allowed in [`Category::new`]. Two names can have
    /// the same code; a data set cannot hold both.
    pub fn named(name: &str) -> Option<Category> {
        // FNV-1a (Fowler, Noll, Vo). The codes 4 and 127 are those of the bottle and of a made-up object of the tests.
        let hash = name.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
        let code = (5 + hash % 122) as i8;
        Category::from_name(name).or_else(|| Category::from_file(name, code))
    }

    /// What is allowed instead, if a trial of someone else's table cannot have a category of this name.
    pub fn name_fault(name: &str) -> Option<&'static str> {
        // The verdict `outlier` is also the category of outliers.
        match name {
            Category::UNCERTAIN => Some("a name other than `uncertain`, which is a verdict"),
            _ if name.len() as u64 > NAME_BYTES.most => Some("at most 1000 bytes"),
            _ => (!is_plain(name)).then_some(PLAIN),
        }
    }

    /// The lower-case name used in every file.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// The small integer used in the per-taxel ground-truth columns of a data set (−1 there means "touches nothing").
    pub fn code(self) -> i8 {
        self.code
    }

    /// Whether it is one of [`Category::BUILT_IN`].
    pub fn is_built_in(self) -> bool {
        Category::BUILT_IN.contains(&self)
    }

    /// Those of these categories that are not built in, each once, by code.
    pub fn further(all: impl Iterator<Item = Category>) -> Vec<Category> {
        let further: BTreeSet<Category> = all.filter(|category| !category.is_built_in()).collect();
        further.into_iter().collect()
    }

    /// The built-in category with this name, as written by [`Category::name`].
    pub fn from_name(name: &str) -> Option<Category> {
        Category::BUILT_IN.into_iter().find(|category| category.name() == name)
    }
}

/// Whether a further category can have this name and this code.
const fn is_free(name: &str, code: i8) -> bool {
    let bytes = name.as_bytes();
    // `==` cannot be used in constants. Ignoring case does no harm, because names are lower-case.
    let mut free = !bytes.is_empty()
        && bytes.len() <= Category::MAX_NAME_BYTES
        && bytes[0].is_ascii_lowercase()
        && code >= Category::BUILT_IN.len() as i8
        // This name means "touches nothing" in data sets.
        && !name.eq_ignore_ascii_case("none");
    let mut index = 0;
    while index < bytes.len() {
        free &= matches!(bytes[index], b'a'..=b'z' | b'0'..=b'9' | b'_');
        index += 1;
    }
    index = 0;
    while index < Category::BUILT_IN.len() {
        free &= !name.eq_ignore_ascii_case(Category::BUILT_IN[index].name);
        index += 1;
    }
    index = 0;
    while index < Category::VERDICTS.len() {
        free &= !name.eq_ignore_ascii_case(Category::VERDICTS[index]);
        index += 1;
    }
    free
}

impl fmt::Debug for Category {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How a category is written: a built-in one by its name, any other with its code, so that a reader that does not know
/// it gets the same category.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written<'a> {
    BuiltIn(std::borrow::Cow<'a, str>),
    Further { name: std::borrow::Cow<'a, str>, code: i8 },
}

impl Serialize for Category {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let name = self.name.into();
        let written =
            if self.is_built_in() { Written::BuiltIn(name) } else { Written::Further { name, code: self.code } };
        written.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Category {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Written::deserialize(deserializer)? {
            Written::BuiltIn(name) => Category::from_name(&name).ok_or_else(|| {
                let names = Category::BUILT_IN.map(Category::name).join(", ");
                de::Error::custom(format!("category \"{name}\" without a code, and not one of {names}"))
            }),
            Written::Further { name, code } => Category::from_file(&name, code).ok_or_else(|| {
                let max_bytes = Category::MAX_NAME_BYTES;
                let verdicts = Category::VERDICTS.join(", ");
                de::Error::custom(format!(
                    "category \"{name}\" with code {code}; allowed are up to {max_bytes} lower-case letters, digits and \
                     underscores that begin with a letter and are no built-in name, not \"none\" and no verdict ({verdicts}), with \
                     a code from 4 to 127"
                ))
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests names and codes of the built-in categories, which existing data sets contain.
    #[test]
    fn built_in_categories_keep_their_codes() {
        let found = Category::BUILT_IN.map(|category| (category.name().to_owned(), category.code()));
        let expected = [("leaf", 0), ("trunk", 1), ("block", 2), ("outlier", 3)];
        assert_eq!(found, expected.map(|(name, code)| (name.to_owned(), code)));
        for category in Category::BUILT_IN {
            assert_eq!(Category::from_name(category.name()), Some(category));
            let text = serde_json::to_string(&category).unwrap();
            assert_eq!(text, format!("\"{}\"", category.name()));
            assert_eq!(serde_json::from_str::<Category>(&text).unwrap(), category);
        }
    }

    /// Tests that a name that is not built in has the same code each time, that a built-in name is that category, and
    /// that verdicts and other words that are no names are refused.
    #[test]
    fn names_have_one_code() {
        let stalk = Category::named("stalk").unwrap();
        assert_eq!(Some(stalk), Category::from_file("stalk", stalk.code()));
        // FNV-1a of "a" is 0xe40c292c.
        assert_eq!(Category::named("a").unwrap().code(), (5 + 0xe40c_292c_u32 % 122) as i8);
        assert_eq!(Category::named("leaf"), Some(Category::LEAF));
        for name in ["unknown", "none", "", "A stalk"] {
            assert_eq!(Category::named(name), None, "{name}");
        }
    }

    /// Tests which names and codes further categories can have, and that a reader that does not know such a category
    /// gets both.
    #[test]
    fn further_categories_have_valid_names_and_free_codes() {
        let longest = "a".repeat(Category::MAX_NAME_BYTES);
        for (name, code) in [("reed", 4), ("wet_rope_2", 127), (longest.as_str(), 5)] {
            let category = Category::from_file(name, code).unwrap();
            assert_eq!((category.name(), category.code(), category.is_built_in()), (name, code, false));
            let text = serde_json::to_string(&category).unwrap();
            assert_eq!(text, format!("{{\"name\":\"{name}\",\"code\":{code}}}"));
            assert_eq!(serde_json::from_str::<Category>(&text).unwrap(), category);
        }
        let too_long = "a".repeat(Category::MAX_NAME_BYTES + 1);
        for (name, code) in [
            ("reed", 3),
            ("reed", -1),
            ("leaf", 4),
            ("none", 4),
            ("nothing", 4),
            ("uncertain", 4),
            ("unknown", 4),
            ("", 4),
            ("Reed", 4),
            ("2reed", 4),
            ("a reed", 4),
            (too_long.as_str(), 4),
        ] {
            assert_eq!(Category::from_file(name, code), None, "{name} {code}");
            let text = format!("{{\"name\":\"{name}\",\"code\":{code}}}");
            assert!(serde_json::from_str::<Category>(&text).is_err(), "{text}");
        }
        assert!(serde_json::from_str::<Category>("\"reed\"").is_err());
    }
}
