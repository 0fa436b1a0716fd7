//! Checks the text of a URDF, element by element, before urdf-rs parses it: the types of attributes, missing elements and
//! attributes, and nesting depth. urdf-rs names neither the element nor the line of an error, skips words among numbers, and
//! recurses for every nested element until the stack overflows.

use underbrush_recording::InputError;
use underbrush_recording::limits::short;
use xml::attribute::OwnedAttribute;
use xml::common::Position;
use xml::reader::{EventReader, ParserConfig, XmlEvent};

use super::limits::{MAX_ELEMENTS, MAX_NESTED_ELEMENTS};
use super::source::Source;

/// What an attribute holds.
#[derive(Clone, Copy)]
enum Holds {
    /// This many numbers, separated by spaces.
    Numbers(usize),
    /// A name.
    Name,
    /// One of these words.
    Word(&'static [&'static str]),
}

use Holds::{Name, Numbers, Word};

const JOINT_TYPES: &[&str] = &[
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
    "floating",
    "planar",
    "spherical",
];

/// The attributes that are read: element, attribute, type, and whether the attribute is required.
const ATTRIBUTES: &[(&str, &str, Holds, bool)] = &[
    ("link", "name", Name, true),
    ("joint", "name", Name, true),
    ("joint", "type", Word(JOINT_TYPES), true),
    ("parent", "link", Name, true),
    ("child", "link", Name, true),
    ("origin", "xyz", Numbers(3), false),
    ("origin", "rpy", Numbers(3), false),
    ("mass", "value", Numbers(1), true),
    ("inertia", "ixx", Numbers(1), true),
    ("inertia", "ixy", Numbers(1), true),
    ("inertia", "ixz", Numbers(1), true),
    ("inertia", "iyy", Numbers(1), true),
    ("inertia", "iyz", Numbers(1), true),
    ("inertia", "izz", Numbers(1), true),
    ("sphere", "radius", Numbers(1), true),
    ("cylinder", "radius", Numbers(1), true),
    ("cylinder", "length", Numbers(1), true),
    ("capsule", "radius", Numbers(1), true),
    ("capsule", "length", Numbers(1), true),
    ("box", "size", Numbers(3), true),
    ("mesh", "filename", Name, true),
    ("mesh", "scale", Numbers(3), false),
    ("axis", "xyz", Numbers(3), true),
    ("limit", "lower", Numbers(1), false),
    ("limit", "upper", Numbers(1), false),
    ("limit", "effort", Numbers(1), false),
    ("limit", "velocity", Numbers(1), true),
    ("dynamics", "damping", Numbers(1), false),
    ("dynamics", "friction", Numbers(1), false),
    ("mimic", "joint", Name, true),
    ("mimic", "multiplier", Numbers(1), false),
    ("mimic", "offset", Numbers(1), false),
    ("safety_controller", "soft_lower_limit", Numbers(1), false),
    ("safety_controller", "soft_upper_limit", Numbers(1), false),
    ("safety_controller", "k_position", Numbers(1), false),
    ("safety_controller", "k_velocity", Numbers(1), true),
    ("color", "rgba", Numbers(4), true),
];

/// Required children: an element, and the elements of which it must contain one.
const CHILDREN: &[(&str, &[&str])] = &[
    ("joint", &["parent"]),
    ("joint", &["child"]),
    ("inertial", &["mass"]),
    ("inertial", &["inertia"]),
    ("visual", &["geometry"]),
    ("collision", &["geometry"]),
    ("geometry", &["box", "cylinder", "capsule", "sphere", "mesh"]),
];

const REMEDY: &str = "correct the element";

/// The lines of a URDF's elements.
pub(super) struct Elements {
    /// For every element: its link or joint, such as `link forearm`, its path in that, such as `inertial.mass`, and its line.
    places: Vec<(String, String, usize)>,
}

impl Elements {
    /// The line of the element at `path` in an owner such as `link forearm`, or else of the closest element around it.
    pub(super) fn line(&self, owner: &str, path: &str) -> Option<usize> {
        let mut path = path;
        loop {
            let found = self
                .places
                .iter()
                .find(|(name, place, _)| name == owner && place == path);
            if let Some((.., line)) = found {
                return Some(*line);
            }
            if path.is_empty() {
                return None;
            }
            path = path.rsplit_once('.').map_or("", |(around, _)| around);
        }
    }
}

/// An element that is open.
struct Open {
    name: String,
    line: usize,
    /// Names of the elements in it so far.
    children: Vec<String>,
}

/// Checks the text.
///
/// # Errors
/// When it is not XML, an attribute has the wrong type, or a required element or attribute is missing.
pub(super) fn elements(source: &Source) -> Result<Elements, InputError> {
    let config = ParserConfig::new().override_encoding(Some(xml::Encoding::Utf8));
    let mut reader = EventReader::new_with_config(source.text.as_bytes(), config);
    let mut walk = Walk {
        source,
        open: Vec::new(),
        owner: String::new(),
        places: Vec::new(),
        count: 0,
    };
    loop {
        let event = reader.next();
        let line = reader.position().row as usize + 1;
        match event {
            Ok(XmlEvent::StartElement { name, attributes, .. }) => walk.start(name.local_name, &attributes, line)?,
            Ok(XmlEvent::EndElement { .. }) => walk.end()?,
            Ok(XmlEvent::EndDocument) => return Ok(Elements { places: walk.places }),
            Ok(_) => {}
            Err(error) => {
                let line = error.position().row as usize + 1;
                let fault = source.fault("robot", error.msg(), "a URDF robot description in XML", REMEDY);
                return Err(fault.at_line(line));
            }
        }
    }
}

struct Walk<'a> {
    source: &'a Source,
    open: Vec<Open>,
    owner: String,
    places: Vec<(String, String, usize)>,
    count: usize,
}

impl Walk<'_> {
    fn start(&mut self, name: String, attributes: &[OwnedAttribute], line: usize) -> Result<(), InputError> {
        self.count += 1;
        if self.open.len() >= MAX_NESTED_ELEMENTS {
            let found = format!("more than {MAX_NESTED_ELEMENTS} nested elements");
            return Err(self.fault("robot", found, "robot, link, collision, geometry, shape", line));
        }
        if self.count > MAX_ELEMENTS {
            let found = format!("more than {MAX_ELEMENTS} elements");
            return Err(self.fault("robot", found, "a robot", line));
        }
        if self.open.len() == 1 && matches!(name.as_str(), "link" | "joint") {
            let given = attributes.iter().find(|attribute| attribute.name.local_name == "name");
            self.owner = format!("{name} {}", given.map_or("", |attribute| &attribute.value));
        }
        let mut twins = 0;
        if let Some(around) = self.open.last_mut() {
            twins = around.children.iter().filter(|other| **other == name).count();
            around.children.push(name.clone());
        }
        let inside = self.open.len() > 1;
        let part = if inside && twins > 0 {
            format!("{name}[{twins}]")
        } else {
            name
        };
        self.open.push(Open {
            name: part,
            line,
            children: Vec::new(),
        });
        // Elements outside links and joints (transmissions, extensions of simulators) are not read.
        if self.is_read() {
            self.check(attributes, line)?;
            self.places.push((self.owner.clone(), self.path(), line));
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), InputError> {
        if self.is_read()
            && let Some(open) = self.open.last()
        {
            let name = plain(&open.name);
            for (_, wanted) in CHILDREN.iter().filter(|(element, _)| *element == name) {
                if !open.children.iter().any(|child| wanted.contains(&child.as_str())) {
                    let found = format!("no <{}>", wanted.join("> or <"));
                    let allowed = format!("one in each <{name}>");
                    return Err(self.fault(&self.place(""), found, &allowed, open.line));
                }
            }
        }
        self.open.pop();
        Ok(())
    }

    fn check(&self, attributes: &[OwnedAttribute], line: usize) -> Result<(), InputError> {
        let element = self.open.last().map_or("", |open| plain(&open.name));
        for (_, key, holds, needed) in ATTRIBUTES.iter().filter(|(name, ..)| *name == element) {
            let given = attributes.iter().find(|attribute| attribute.name.local_name == *key);
            let Some(given) = given else {
                if *needed {
                    let found = format!("no attribute `{key}`");
                    return Err(self.fault(&self.place(key), found, &holds.allowed(), line));
                }
                continue;
            };
            if !holds.fits(&given.value) {
                return Err(self.fault(&self.place(key), format!("{:?}", given.value), &holds.allowed(), line));
            }
        }
        Ok(())
    }

    /// Whether the innermost open element is a link, a joint, or within one.
    fn is_read(&self) -> bool {
        let around = self.open.get(1).map(|open| plain(&open.name));
        matches!(around, Some("link" | "joint"))
    }

    /// The path of the innermost open element within its link or joint.
    fn path(&self) -> String {
        let parts: Vec<&str> = self.open.iter().skip(2).map(|open| open.name.as_str()).collect();
        parts.join(".")
    }

    /// What an error about an attribute of the innermost open element names.
    fn place(&self, key: &str) -> String {
        let path = self.path();
        let parts: Vec<&str> = [path.as_str(), key]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect();
        if parts.is_empty() {
            return self.owner.trim_end().to_string();
        }
        format!("{}, {}", self.owner.trim_end(), parts.join("."))
    }

    fn fault(&self, field: &str, found: String, allowed: &str, line: usize) -> InputError {
        self.source.fault(field, found, allowed, REMEDY).at_line(line)
    }
}

/// The element's name without its number among those of the same name.
fn plain(name: &str) -> &str {
    name.split('[').next().unwrap_or(name)
}

impl Holds {
    fn fits(self, text: &str) -> bool {
        match self {
            Numbers(count) => {
                let numbers: Vec<Option<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
                numbers.len() == count && numbers.iter().all(Option::is_some)
            }
            Name => !text.is_empty(),
            Word(words) => words.contains(&text),
        }
    }

    fn allowed(self) -> String {
        match self {
            Numbers(1) => "a number".into(),
            Numbers(count) => format!("{} numbers, separated by spaces", short(count as f64)),
            Name => "a name".into(),
            Word(words) => format!("one of {}", words.join(", ")),
        }
    }
}
