//! Groups of objects in a scene file, and the declaration of the quantities of a kind of objects.

use std::marker::PhantomData;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use underbrush_recording::{Category, Limits};

use super::{CATEGORIES, Footing, Object};
use crate::range::{Draw, DrawError, Limited, Placement, schema_within};

/// A quantity of a kind of objects. The key of the scene file, its schema, default and limits follow from it.
#[derive(Debug)]
pub struct Declared {
    /// Its key in the scene file, with its unit.
    pub name: &'static str,
    /// What it is.
    pub text: &'static str,
    /// How it is drawn if a scene file does not say otherwise.
    pub default: Draw,
    /// Smallest and largest value that make physical sense.
    pub limits: Limits,
}

/// A kind of objects, as a scene file can ask for it.
pub trait Kind: Object + Clone + Sized + 'static {
    /// Name and description of a group in the schema of scene files.
    const GROUP: (&'static str, &'static str);
    /// Its quantities.
    const QUANTITIES: &'static [Declared];
    /// Its ground-truth category, unless a group names another.
    const CATEGORY: Category;
    /// Whether it must stand on a foam block, and not on the table beneath the foam.
    const NEEDS_FOAM: bool = false;

    /// Draws one object. `footing` is what it stands on.
    ///
    /// # Errors
    /// If a range holds (almost) no physical values.
    fn draw(drawing: &mut Drawing<'_>, footing: &Footing) -> Result<Self, DrawError>;
}

/// Names of quantities, and the values that were drawn for one object.
pub type DrawnQuantities = Vec<(&'static str, f64)>;

/// [`Kind::draw`] of one kind.
type DrawObject = fn(&mut Drawing<'_>, &Footing) -> Result<Box<dyn Object>, DrawError>;

/// A group of objects in a scene file, of a kind that is known where the file is read.
#[derive(Clone, Debug)]
pub struct Group<K>(pub Specification, PhantomData<K>);

/// What a scene file says about a group of objects, whatever their kind.
#[derive(Clone, Debug)]
pub struct Specification {
    /// How many there are.
    pub count: u32,
    /// Where they may stand.
    pub place: Placement,
    /// Their ground-truth category: that of the kind, unless the group names another.
    pub category: Category,
    /// Whether the objects must stand on foam blocks.
    pub needs_foam: bool,
    /// The quantities that the kind declares.
    declarations: &'static [Declared],
    /// Their ranges, in the order of their declarations.
    ranges: Vec<Draw>,
    draw_object: DrawObject,
}

impl Specification {
    /// Every range with its name and the physical limits of its values, for validation and error messages.
    pub fn quantities(&self) -> Vec<Limited> {
        let ranges = self.declarations.iter().zip(&self.ranges);
        ranges.map(|(Declared { name, limits, .. }, draw)| Limited { name, draw: *draw, limits: *limits }).collect()
    }

    /// Draws one object. `footing` is what it stands on. Also returns what it has drawn: names and values of quantities.
    ///
    /// # Errors
    /// If a range holds (almost) no physical values.
    pub fn draw(
        &self,
        random: &mut ChaCha8Rng,
        footing: &Footing,
    ) -> Result<(Box<dyn Object>, DrawnQuantities), DrawError> {
        let mut drawing = Drawing { group: self, random, drawn: vec![None; self.declarations.len()] };
        let object = (self.draw_object)(&mut drawing, footing)?;
        let drawn = self.declarations.iter().zip(drawing.drawn);
        Ok((object, drawn.filter_map(|(declared, value)| Some((declared.name, value?))).collect()))
    }

    /// The number and the declaration of the quantity with this name.
    fn declared(&self, name: &str) -> (usize, &'static Declared) {
        let found = self.declarations.iter().enumerate().find(|(_, declared)| declared.name == name);
        found.expect("a kind asks only for quantities that it declares")
    }
}

/// The draw of one object of a group.
pub struct Drawing<'a> {
    group: &'a Specification,
    random: &'a mut ChaCha8Rng,
    /// What was drawn last for each quantity, in the order of the declarations; `None` for one that was not asked for.
    drawn: Vec<Option<f64>>,
}

/// How often an object is drawn again if it is not possible.
const REDRAWS: usize = 100;

impl Drawing<'_> {
    /// Draws an object until `is_possible` holds. If (almost) none of the group is possible, `refusal` says of the last one which
    /// quantity has to be within which limits; a limit that is not given is that of its declaration.
    ///
    /// # Errors
    /// That of a draw, or that of a refusal if none of about a hundred objects is possible.
    pub fn until_possible<T>(
        &mut self,
        draw: impl Fn(&mut Self) -> Result<T, DrawError>,
        is_possible: impl Fn(&T) -> bool,
        refusal: impl FnOnce(&T) -> (&'static str, Option<f64>, Option<f64>),
    ) -> Result<T, DrawError> {
        let mut drawn = draw(self)?;
        for _ in 0..REDRAWS {
            if is_possible(&drawn) {
                return Ok(drawn);
            }
            drawn = draw(self)?;
        }
        let (name, low, high) = refusal(&drawn);
        let (number, Declared { limits, .. }) = self.group.declared(name);
        let draw = self.group.ranges[number];
        Err(DrawError { name, draw, low: low.unwrap_or(limits.min), high: high.unwrap_or(limits.max) })
    }

    /// Draws the quantity with this name.
    ///
    /// # Errors
    /// If its range holds (almost) no physical values.
    pub fn quantity(&mut self, name: &str) -> Result<f64, DrawError> {
        let (number, declared) = self.group.declared(name);
        let value = self.group.ranges[number].draw(self.random, declared.limits);
        let value = value.map_err(|error| DrawError { name: declared.name, ..error })?;
        self.drawn[number] = Some(value);
        Ok(value)
    }

    /// Whether something happens whose probability is the quantity with this name. It counts as drawn with 0 or 1.
    ///
    /// # Errors
    /// If its range holds (almost) no physical values.
    pub fn happens(&mut self, name: &str) -> Result<bool, DrawError> {
        let happens = self.random.next_u32() as f64 / 2f64.powi(32) < self.quantity(name)?;
        self.drawn[self.group.declared(name).0] = Some(f64::from(u8::from(happens)));
        Ok(happens)
    }
}

/// A key of a group.
enum Key<K> {
    Count,
    Place,
    Category,
    Quantity(usize, PhantomData<K>),
}

impl<'de, K: Kind> Deserialize<'de> for Key<K> {
    /// An unknown key is refused here, so that the error is about its line.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        match (key.as_str(), K::QUANTITIES.iter().position(|declared| declared.name == key)) {
            ("count", _) => Ok(Key::Count),
            ("place", _) => Ok(Key::Place),
            ("category", _) => Ok(Key::Category),
            (_, Some(number)) => Ok(Key::Quantity(number, PhantomData)),
            (_, None) => {
                let names: String = K::QUANTITIES.iter().map(|declared| format!(", `{}`", declared.name)).collect();
                Err(D::Error::custom(format!(
                    "unknown field `{key}`, expected one of `count`, `place`, `category`{names}"
                )))
            }
        }
    }
}

impl<'de, K: Kind> Deserialize<'de> for Group<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct GroupVisitor<K>(PhantomData<K>);
        impl<'de, K: Kind> Visitor<'de> for GroupVisitor<K> {
            type Value = Group<K>;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a group of objects: `count`, and the ranges of their quantities")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Group<K>, A::Error> {
                let (mut count, mut place, mut category) = (None, Placement::default(), K::CATEGORY);
                let mut ranges: Vec<Draw> = K::QUANTITIES.iter().map(|declared| declared.default).collect();
                while let Some(key) = map.next_key::<Key<K>>()? {
                    match key {
                        Key::Count => count = Some(map.next_value()?),
                        Key::Place => place = map.next_value()?,
                        Key::Category => category = map.next_value::<Named>()?.0,
                        Key::Quantity(number, _) => ranges[number] = map.next_value()?,
                    }
                }
                let specification = Specification {
                    count: count.ok_or_else(|| A::Error::missing_field("count"))?,
                    place,
                    category,
                    needs_foam: K::NEEDS_FOAM,
                    declarations: K::QUANTITIES,
                    ranges,
                    draw_object: |drawing, footing| Ok(Box::new(K::draw(drawing, footing)?)),
                };
                Ok(Group(specification, PhantomData))
            }
        }
        deserializer.deserialize_map(GroupVisitor(PhantomData))
    }
}

/// The category that a scene file names: that of a kind, or a new one.
struct Named(Category);

impl<'de> Deserialize<'de> for Named {
    /// A name that is not allowed is refused here, so that the error is about its line.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let of_kind = CATEGORIES.iter().copied().find(|category| category.name() == name);
        of_kind.or_else(|| Category::named(&name)).map(Named).ok_or_else(|| {
            D::Error::custom(format!(
                "category \"{name}\"; allowed are up to {} lower-case letters, digits and underscores that begin with a \
                 letter and are not \"none\" and no verdict ({})",
                Category::MAX_NAME_BYTES,
                Category::VERDICTS.join(", ")
            ))
        })
    }
}

impl<K: Kind> JsonSchema for Group<K> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        K::GROUP.0.into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut count = generator.subschema_for::<u32>();
        count.insert("description".into(), "How many.".into());
        let mut place = generator.subschema_for::<Option<Placement>>();
        place.insert("description".into(), "Where they may stand; the scene's workspace if not given.".into());
        let category = json_schema!({
            "type": "string",
            "description": format!("Their category in ground truth; {} if not given.", K::CATEGORY.name()),
            "pattern": format!("^[a-z][a-z0-9_]{{0,{}}}$", Category::MAX_NAME_BYTES - 1),
        });
        let mut properties = json_schema!({ "count": count, "place": place, "category": category });
        for declared in K::QUANTITIES {
            let mut own = schema_within(declared.limits);
            own.insert("description".into(), declared.text.trim().into());
            properties.insert(declared.name.into(), own.into());
        }
        json_schema!({
            "description": K::GROUP.1,
            "type": "object",
            "properties": properties,
            "additionalProperties": false,
            "required": ["count"],
        })
    }
}

/// Declares quantities: `name: default, lowest, highest;`, with what each is as its documentation.
macro_rules! declared {
    ($($(#[doc = $text:literal])+ $name:ident: $default:expr, $low:expr, $high:expr;)+) => {
        &[$($crate::object::group::Declared {
            name: stringify!($name),
            text: concat!($($text),+),
            default: $default,
            limits: underbrush_recording::Limits::new($low, $high, ""),
        },)+]
    };
}
pub(super) use declared;

/// Declares the quantities of a kind of objects once: `name: default, lowest, highest;`, with what it is as its
/// documentation. Makes the type with a value for each, the list of declarations, and how all are drawn, in this order.
macro_rules! quantities {
    ($(#[$attribute:meta])* $visibility:vis struct $drawn:ident {
        $($(#[doc = $text:literal])+ $name:ident: $default:expr, $low:expr, $high:expr;)+
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $visibility struct $drawn {
            $($(#[doc = $text])+ pub $name: f64,)+
        }

        impl $drawn {
            const DECLARED: &'static [$crate::object::group::Declared] =
                $crate::object::group::declared! { $($(#[doc = $text])+ $name: $default, $low, $high;)+ };

            fn draw_all(
                drawing: &mut $crate::object::group::Drawing<'_>,
            ) -> Result<Self, $crate::range::DrawError> {
                Ok($drawn { $($name: drawing.quantity(stringify!($name))?),+ })
            }

            /// The values by name.
            #[allow(dead_code, reason = "not all kinds record just what is drawn")]
            pub(in crate::object) fn values(&self) -> $crate::object::Parameters {
                [$((stringify!($name), self.$name)),+].into()
            }
        }
    };
}
pub(super) use quantities;
