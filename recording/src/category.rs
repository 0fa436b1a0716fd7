//! Ground-truth categories of the objects that an arm can touch.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// What an object is, as ground truth: a name, and the code that stands for it in columns of numbers.
///
/// Four categories are built in, those of the paper (sections IV-A and V-D). An object that is something else brings a
/// category of its own as a constant in its file:
///
/// ```
/// use underbrush_recording::Category;
///
/// const REED: Category = Category::new("reed", 4).expect("a valid name and a free code");
/// assert_eq!((REED.name(), REED.code()), ("reed", 4));
/// ```
///
/// Categories are ordered by code.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Category {
    code: i8,
    /// ASCII, filled up with zeros. Held in place, so that the value can be copied and names can come from files.
    name: [u8; Category::MAX_NAME_BYTES],
}

impl Category {
    /// Length of the longest name.
    pub const MAX_NAME_BYTES: usize = 24;
    /// A bendable leaf stuck in foam.
    pub const LEAF: Category = Category::unchecked("leaf", 0);
    /// A stiff trunk fixed to the table.
    pub const TRUNK: Category = Category::unchecked("trunk", 1);
    /// A foam block of the ground platform: an obstacle, never a training category.
    pub const BLOCK: Category = Category::unchecked("block", 2);
    /// An object foreign to the foliage, such as the foam roll. Never in training data.
    pub const OUTLIER: Category = Category::unchecked("outlier", 3);

    /// The built-in categories, in the order of their codes.
    pub const BUILT_IN: [Category; 4] = [Category::LEAF, Category::TRUNK, Category::BLOCK, Category::OUTLIER];

    /// What names and codes are allowed for further categories, for error messages.
    pub const ALLOWED: &str = "a name of up to 24 lower-case letters, digits and underscores that begins with a letter \
                               and is not built in, with a code from 4 to 127";

    /// A category that is not built in. `None` unless the name has at most 24 lower-case letters, digits and underscores,
    /// begins with a letter and is new, and the code is above those of the built-in categories.
    pub const fn new(name: &str, code: i8) -> Option<Category> {
        let bytes = name.as_bytes();
        let mut valid = bytes.len() <= Category::MAX_NAME_BYTES && !bytes.is_empty() && bytes[0].is_ascii_lowercase();
        let mut index = 0;
        while index < bytes.len() {
            valid &= matches!(bytes[index], b'a'..=b'z' | b'0'..=b'9' | b'_');
            index += 1;
        }
        // "none" stands for "touches nothing" in data sets.
        if !valid || same(bytes, b"none") || (code as usize) < Category::BUILT_IN.len() || code < 0 {
            return None;
        }
        let mut index = 0;
        while index < Category::BUILT_IN.len() {
            if same(bytes, Category::BUILT_IN[index].name_bytes()) {
                return None;
            }
            index += 1;
        }
        Some(Category::unchecked(name, code))
    }

    const fn unchecked(name: &str, code: i8) -> Category {
        let bytes = name.as_bytes();
        let mut stored = [0; Category::MAX_NAME_BYTES];
        let mut index = 0;
        while index < bytes.len() {
            stored[index] = bytes[index];
            index += 1;
        }
        Category { code, name: stored }
    }

    const fn name_bytes(&self) -> &[u8] {
        let mut length = 0;
        while length < self.name.len() && self.name[length] != 0 {
            length += 1;
        }
        self.name.split_at(length).0
    }

    /// The lower-case name used in every file.
    pub fn name(&self) -> &str {
        // Only ASCII ever gets in.
        std::str::from_utf8(self.name_bytes()).unwrap_or_default()
    }

    /// The small integer used in the per-taxel ground-truth columns of a data set (−1 there means "touches nothing").
    pub fn code(&self) -> i8 {
        self.code
    }

    /// Whether it is one of [`Category::BUILT_IN`].
    pub fn is_built_in(&self) -> bool {
        Category::BUILT_IN.contains(self)
    }

    /// The built-in category of a name as written by [`Category::name`].
    pub fn from_name(name: &str) -> Option<Category> {
        Category::BUILT_IN.into_iter().find(|category| category.name() == name)
    }
}

/// Whether two texts are equal, in constants too.
const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut equal = a.len() == b.len();
    let mut index = 0;
    while equal && index < a.len() {
        equal = a[index] == b[index];
        index += 1;
    }
    equal
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
    Further {
        name: std::borrow::Cow<'a, str>,
        code: i8,
    },
}

impl Serialize for Category {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let name = self.name().into();
        let written = if self.is_built_in() {
            Written::BuiltIn(name)
        } else {
            Written::Further { name, code: self.code }
        };
        written.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Category {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Written::deserialize(deserializer)? {
            Written::BuiltIn(name) => Category::from_name(&name).ok_or_else(|| {
                let names = Category::BUILT_IN.map(|category| category.name().to_owned()).join(", ");
                de::Error::custom(format!("category \"{name}\" without a code, and not one of {names}"))
            }),
            Written::Further { name, code } => Category::new(&name, code).ok_or_else(|| {
                let allowed = Category::ALLOWED;
                de::Error::custom(format!("category \"{name}\" with code {code}; allowed: {allowed}"))
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pins names and codes of the built-in categories, which stand in data sets that exist.
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

    /// Pins which further categories there can be, and that a reader that has never heard of one gets it whole.
    #[test]
    fn further_categories_have_valid_names_and_free_codes() {
        let longest = "a".repeat(Category::MAX_NAME_BYTES);
        for (name, code) in [("reed", 4), ("wet_rope_2", 127), (longest.as_str(), 5)] {
            let category = Category::new(name, code).unwrap();
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
            ("", 4),
            ("Reed", 4),
            ("2reed", 4),
            ("a reed", 4),
            (too_long.as_str(), 4),
        ] {
            assert_eq!(Category::new(name, code), None, "{name} {code}");
            let text = format!("{{\"name\":\"{name}\",\"code\":{code}}}");
            assert!(serde_json::from_str::<Category>(&text).is_err(), "{text}");
        }
        assert!(serde_json::from_str::<Category>("\"reed\"").is_err());
    }
}
