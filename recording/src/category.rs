//! Ground-truth categories of the objects that an arm can touch.

use serde::{Deserialize, Serialize};

/// What an object is, as ground truth (paper, sections IV-A and V-D).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Category {
    /// A bendable leaf stuck in foam.
    Leaf,
    /// A stiff trunk fixed to the table.
    Trunk,
    /// A foam block of the ground platform: an obstacle, never a training category.
    Block,
    /// An object foreign to the foliage, such as the foam roll; never in training data.
    Outlier,
}

impl Category {
    /// All categories, in the order of their codes.
    pub const ALL: [Category; 4] = [Category::Leaf, Category::Trunk, Category::Block, Category::Outlier];

    /// The lower-case name used in every file.
    pub fn name(self) -> &'static str {
        match self {
            Category::Leaf => "leaf",
            Category::Trunk => "trunk",
            Category::Block => "block",
            Category::Outlier => "outlier",
        }
    }

    /// The small integer used in the per-taxel ground-truth columns of a data set (−1 there means "touches nothing").
    pub fn code(self) -> i8 {
        self as i8
    }

    /// The category of a code, `None` for −1 or an unknown one.
    pub fn from_code(code: i8) -> Option<Category> {
        Category::ALL.into_iter().find(|category| category.code() == code)
    }

    /// The category of a name as written by [`Category::name`].
    pub fn from_name(name: &str) -> Option<Category> {
        Category::ALL.into_iter().find(|category| category.name() == name)
    }
}
