//! Trees in model files: as text of a few megabytes.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Boosted;

/// Stands for no feature: the node is a leaf.
const LEAF: u8 = u8::MAX;

/// A node of a tree. The left child of a cut comes right after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Node {
    /// Rows go to the left if the feature is at most this part of its range.
    Cut { feature: u8, cut: u16, right: u32 },
    /// What the tree adds.
    Leaf(i16),
}

/// The smallest and the largest value of a feature, divided into 65,535 steps for cuts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "(f64, f64)")]
pub(super) struct Span(pub(super) f32, pub(super) f32);

impl TryFrom<(f64, f64)> for Span {
    type Error = &'static str;

    fn try_from((low, high): (f64, f64)) -> Result<Self, Self::Error> {
        let span = Span(low as f32, high as f32);
        let is_sound = span.0.is_finite() && span.1.is_finite() && span.0 <= span.1;
        is_sound.then_some(span).ok_or("must be the smallest and the largest value of a feature")
    }
}

impl Span {
    pub(super) fn at(self, cut: u16) -> f32 {
        self.0 + (self.1 - self.0) * (f32::from(cut) / f32::from(u16::MAX))
    }

    pub(super) fn nearest(self, value: f32) -> u16 {
        ((value - self.0) / (self.1 - self.0) * f32::from(u16::MAX)).round() as u16
    }
}

/// Trees and their features.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Packed {
    /// The smallest and the largest value of each feature.
    pub(super) spans: Vec<Span>,
    /// The nodes of each tree in depth-first order, in Base64, three bytes each. Of a cut: the number of its feature, and in two
    /// bytes, the lower one first, which part of 65,535 of the feature's range goes to the left. Of a leaf: 255, and in two bytes,
    /// the lower one first, how many ten-thousandths it adds to the log-odds, as a signed number.
    trees: Vec<String>,
}

impl From<Boosted> for Packed {
    fn from(Boosted { trees, spans }: Boosted) -> Self {
        let bytes = |node: &Node| {
            let (first, [low, high]) = match *node {
                Node::Leaf(step) => (LEAF, step.to_le_bytes()),
                Node::Cut { feature, cut, .. } => (feature, cut.to_le_bytes()),
            };
            [first, low, high]
        };
        let text = |tree: &Vec<Node>| STANDARD.encode(tree.iter().flat_map(bytes).collect::<Vec<u8>>());
        Packed { trees: trees.iter().map(text).collect(), spans }
    }
}

impl TryFrom<Packed> for Boosted {
    type Error = &'static str;

    fn try_from(Packed { trees, spans }: Packed) -> Result<Self, Self::Error> {
        let features = spans.len();
        if features >= usize::from(LEAF) {
            return Err("there are too many features");
        }
        let tree = |text: &String| tree(&STANDARD.decode(text).ok()?, features);
        match trees.iter().map(tree).collect::<Option<Vec<_>>>() {
            Some(trees) if !trees.is_empty() => Ok(Boosted { trees, spans }),
            _ => Err("a tree is damaged"),
        }
    }
}

/// The nodes of a tree over this many features; `None` if the bytes are not one whole tree.
fn tree(bytes: &[u8], features: usize) -> Option<Vec<Node>> {
    let (nodes_bytes, rest) = bytes.as_chunks::<3>();
    let mut nodes: Vec<Node> = Vec::new();
    // Cuts whose right child has not come yet.
    let mut open: Vec<usize> = Vec::new();
    for (index, &[first, low, high]) in nodes_bytes.iter().enumerate() {
        if index > 0 && matches!(nodes[index - 1], Node::Leaf(_)) {
            let parent = open.pop()?;
            if let Node::Cut { right, .. } = &mut nodes[parent] {
                *right = u32::try_from(index).ok()?;
            }
        }
        nodes.push(match first {
            LEAF => Node::Leaf(i16::from_le_bytes([low, high])),
            feature if usize::from(feature) < features => {
                open.push(index);
                Node::Cut { feature, cut: u16::from_le_bytes([low, high]), right: 0 }
            }
            _ => return None,
        });
    }
    let is_whole = rest.is_empty() && open.is_empty() && matches!(nodes.last(), Some(Node::Leaf(_)));
    is_whole.then_some(nodes)
}
