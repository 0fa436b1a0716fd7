//! Reads the elements of a URDF and checks them one by one: types of attributes, missing and repeated elements, missing
//! attributes, and nesting depth. Each error names the element and its line.

use std::fmt::Display;

use roxmltree::{Document, Error, Node, ParsingOptions};
use underbrush_recording::{InputError, line_at, short};

use super::limits::{MAX_ELEMENTS, MAX_NESTED_ELEMENTS};
use super::source::Source;

/// What an attribute holds.
#[derive(Clone, Copy)]
enum AttributeKind {
    /// This many numbers, separated by spaces.
    Numbers(usize),
    /// A name.
    Name,
    /// One of [`JOINT_TYPES`].
    Joint,
}

use AttributeKind::{Joint, Name, Numbers};

/// The types of joints in URDF files.
const JOINT_TYPES: [&str; 7] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];

/// The attributes that are read: element, attributes, their type, and whether they are required.
const ATTRIBUTES: &[(&str, &[&str], AttributeKind, bool)] = &[
    ("link", &["name"], Name, true),
    ("joint", &["name"], Name, true),
    ("joint", &["type"], Joint, true),
    ("parent", &["link"], Name, true),
    ("child", &["link"], Name, true),
    ("origin", &["xyz", "rpy"], Numbers(3), false),
    ("mass", &["value"], Numbers(1), true),
    ("inertia", &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"], Numbers(1), true),
    ("sphere", &["radius"], Numbers(1), true),
    ("cylinder", &["radius", "length"], Numbers(1), true),
    ("capsule", &["radius", "length"], Numbers(1), true),
    ("box", &["size"], Numbers(3), true),
    ("mesh", &["filename"], Name, true),
    ("mesh", &["scale"], Numbers(3), false),
    ("mimic", &["joint"], Name, true),
    ("mimic", &["multiplier", "offset"], Numbers(1), false),
    ("axis", &["xyz"], Numbers(3), true),
    ("limit", &["lower", "upper", "effort"], Numbers(1), false),
    ("limit", &["velocity"], Numbers(1), true),
];

/// Children: an element, the elements of which it may contain at most one, and whether it must contain one.
const CHILDREN: &[(&str, &[&str], bool)] = &[
    ("link", &["inertial"], false),
    ("joint", &["origin"], false),
    ("joint", &["parent"], true),
    ("joint", &["child"], true),
    ("joint", &["axis"], false),
    ("joint", &["limit"], false),
    ("inertial", &["origin"], false),
    ("inertial", &["mass"], true),
    ("inertial", &["inertia"], true),
    ("collision", &["origin"], false),
    ("collision", &["geometry"], true),
    ("geometry", SHAPES, true),
];

/// The elements that give the shape of a geometry.
pub(super) const SHAPES: &[&str] = &["box", "cylinder", "capsule", "sphere", "mesh"];

/// What to do about a fault.
const REMEDY: &str = "correct the URDF";

/// An element of the file.
pub(super) type Element<'a> = Node<'a, 'a>;

/// The elements of a URDF, checked.
pub(super) struct Elements<'a> {
    source: &'a Source,
    document: Document<'a>,
}

impl<'a> Elements<'a> {
    /// Reads and checks the text.
    ///
    /// # Errors
    /// When it is not XML, an attribute has the wrong type, or a required element or attribute is missing.
    pub(super) fn read(source: &'a Source) -> Result<Self, InputError> {
        let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
        let document = Document::parse_with_options(&source.text, options).map_err(|error| {
            let line = match error {
                Error::UnclosedRootNode | Error::UnexpectedEndOfStream => source.text.lines().count(),
                _ => error.pos().row as usize,
            };
            source.fault("robot", error, "a URDF robot description in XML", REMEDY).at_line(line)
        })?;
        let elements = Elements { source, document };
        let root = elements.document.root_element();
        if !root.has_tag_name("robot") {
            let found = format!("<{}>", root.tag_name().name());
            let allowed = "a URDF, whose root is <robot>";
            return Err(source.fault("robot", found, allowed, REMEDY).at_line(elements.line_of(root)));
        }
        elements.check_size()?;
        // Elements outside links and joints (transmissions, extensions of simulators) are not read.
        for owner in elements.owners() {
            for element in owner.descendants().filter(Node::is_element) {
                elements.check(element)?;
            }
        }
        Ok(elements)
    }

    /// The links, or the joints.
    pub(super) fn of_kind(&self, kind: &'static str) -> impl Iterator<Item = Element<'_>> {
        self.owners().filter(move |owner| owner.tag_name().name() == kind)
    }

    /// Links and joints.
    fn owners(&self) -> impl Iterator<Item = Node<'_, 'a>> {
        children(self.document.root_element()).filter(|element| matches!(element.tag_name().name(), "link" | "joint"))
    }

    fn check_size(&self) -> Result<(), InputError> {
        let fault = |element, found: String, allowed| {
            Err(self.source.fault("robot", found, allowed, REMEDY).at_line(self.line_of(element)))
        };
        let elements = self.document.descendants().filter(Node::is_element);
        for (index, element) in elements.enumerate() {
            if index == MAX_ELEMENTS {
                return fault(element, format!("more than {MAX_ELEMENTS} elements"), "a robot");
            }
            if element.ancestors().filter(Node::is_element).count() > MAX_NESTED_ELEMENTS {
                let found = format!("more than {MAX_NESTED_ELEMENTS} nested elements");
                return fault(element, found, "robot, link, collision, geometry, shape");
            }
        }
        Ok(())
    }

    fn check(&self, element: Node) -> Result<(), InputError> {
        let name = element.tag_name().name();
        for (_, keys, holds, is_required) in ATTRIBUTES.iter().filter(|(element, ..)| *element == name) {
            for key in *keys {
                let found = match attribute(element, key) {
                    None if *is_required => format!("no attribute `{key}`"),
                    Some(value) if !holds.fits(value) => format!("{value:?}"),
                    _ => continue,
                };
                return Err(self.fault(element, key, found, &holds.allowed()));
            }
        }
        for (_, wanted, is_required) in CHILDREN.iter().filter(|(element, ..)| *element == name) {
            let count = children(element).filter(|child| wanted.contains(&child.tag_name().name())).count();
            if count > 1 || count == 0 && *is_required {
                let number = if count == 0 { "no".into() } else { count.to_string() };
                let found = format!("{number} <{}>", wanted.join("> or <"));
                return Err(self.fault(element, "", found, &format!("one in each <{name}>")));
            }
        }
        Ok(())
    }

    /// An error about an attribute or a child of an element or, without a key, about the element itself. Its line is that of the
    /// child, if there is one, or of the element.
    pub(super) fn fault(&self, element: Node, key: &str, found: impl Display, allowed: &str) -> InputError {
        let child = children(element).find(|child| child.tag_name().name() == key);
        let fault = self.source.fault(place(element, key), found, allowed, REMEDY);
        fault.at_line(self.line_of(child.unwrap_or(element)))
    }

    /// The line at which an element begins.
    pub(super) fn line_of(&self, element: Node) -> usize {
        line_at(&self.source.text, element.range().start)
    }
}

fn children<'a, 'input>(element: Node<'a, 'input>) -> impl Iterator<Item = Node<'a, 'input>> {
    element.children().filter(Node::is_element)
}

/// The children with one of these names.
pub(super) fn named<'a>(element: Element<'a>, names: &[&str]) -> impl Iterator<Item = Element<'a>> {
    children(element).filter(|child| names.contains(&child.tag_name().name()))
}

/// The value of an attribute in any namespace.
pub(super) fn attribute<'a>(element: Node<'a, '_>, key: &str) -> Option<&'a str> {
    element.attributes().find(|attribute| attribute.name() == key).map(|attribute| attribute.value())
}

/// The numbers of an attribute, if there is one.
pub(super) fn numbers<const N: usize>(element: Option<Element>, key: &str) -> Option<[f64; N]> {
    parsed(attribute(element?, key)?)?.try_into().ok()
}

/// The number of an attribute; 0 if there is none.
pub(super) fn number(element: Option<Element>, key: &str) -> f64 {
    numbers(element, key).map_or(0.0, |[number]| number)
}

/// Numbers separated by spaces.
fn parsed(text: &str) -> Option<Vec<f64>> {
    text.split_whitespace().map(|word| word.parse().ok()).collect()
}

/// The element's name; if there are others of this name before it, with its number, as in `collision[1]`.
fn part_name(element: Node) -> String {
    let name = element.tag_name().name();
    match element.prev_siblings().skip(1).filter(|other| other.tag_name().name() == name).count() {
        0 => name.to_owned(),
        number => format!("{name}[{number}]"),
    }
}

/// How errors name an attribute of an element in a link or joint, such as `link forearm, inertial.mass.value`.
fn place(element: Node, key: &str) -> String {
    let owner = element.ancestors().take_while(|own| own.parent_element().is_some()).last().unwrap_or(element);
    let around = element.ancestors().take_while(|around| *around != owner);
    let key = Some(key.to_owned()).filter(|key| !key.is_empty());
    let mut parts: Vec<String> = key.into_iter().chain(around.map(part_name)).collect();
    parts.reverse();
    let owner = format!("{} {}", owner.tag_name().name(), attribute(owner, "name").unwrap_or_default());
    if parts.is_empty() { owner.trim_end().into() } else { format!("{}, {}", owner.trim_end(), parts.join(".")) }
}

impl AttributeKind {
    fn fits(self, text: &str) -> bool {
        match self {
            Numbers(count) => parsed(text).is_some_and(|numbers| numbers.len() == count),
            Name => !text.is_empty(),
            Joint => JOINT_TYPES.contains(&text),
        }
    }

    fn allowed(self) -> String {
        match self {
            Numbers(1) => "a number".into(),
            Numbers(count) => format!("{} numbers, separated by spaces", short(count as f64)),
            Name => "a name".into(),
            Joint => "a joint type of URDF; on the arm revolute, continuous or fixed".into(),
        }
    }
}
