//! Columns in memory: typed values, and how they belong to the rows.

use std::sync::Arc;

use parquet::basic::{LogicalType, Type as Physical};

/// Text, which several rows may share.
pub type Text = Arc<str>;

macro_rules! types {
    ($($variant:ident($value:ty), $name:literal, ($physical:ident, $logical:expr), ($arrow:literal, $fields:expr);)*) => {
        /// The type of a value.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Type {
            $($variant,)*
        }

        impl Type {
            /// Its name in the documents.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Type::$variant => $name,)*
                }
            }

            /// What it is in Parquet.
            pub(crate) fn parquet(self) -> (Physical, Option<LogicalType>) {
                match self {
                    $(Type::$variant => (Physical::$physical, $logical),)*
                }
            }

            /// The number of its type in Arrow's format, and the numbers in the fields of that type.
            pub(crate) fn arrow(self) -> (i64, &'static [i64]) {
                match self {
                    $(Type::$variant => ($arrow, &$fields),)*
                }
            }
        }

        /// The values of a column, all of one type.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Values {
            $(
                #[doc = concat!("Values of type `", $name, "`.")]
                $variant(Vec<$value>),
            )*
        }

        impl Values {
            /// Their type.
            pub(crate) fn type_of(&self) -> Type {
                match self {
                    $(Values::$variant(_) => Type::$variant,)*
                }
            }

            /// One of them as text.
            fn shown(&self, place: usize) -> String {
                match self {
                    $(Values::$variant(values) => values[place].to_string(),)*
                }
            }

            /// Their number.
            pub(crate) fn len(&self) -> usize {
                match self {
                    $(Values::$variant(values) => values.len(),)*
                }
            }
        }

        $(impl Value for $value {
            const TYPE: Type = Type::$variant;

            fn of(values: &Values) -> Option<&[Self]> {
                match values {
                    Values::$variant(values) => Some(values),
                    _ => None,
                }
            }

            fn all(values: Vec<Self>) -> Values {
                Values::$variant(values)
            }
        })*
    };
}
types! {
    Int8(i8), "int8", (INT32, integer(8, true)), (2, [8, 1]);
    Int16(i16), "int16", (INT32, integer(16, true)), (2, [16, 1]);
    Int32(i32), "int32", (INT32, None), (2, [32, 1]);
    Int64(i64), "int64", (INT64, None), (2, [64, 1]);
    Uint32(u32), "uint32", (INT32, integer(32, false)), (2, [32, 0]);
    Uint64(u64), "uint64", (INT64, integer(64, false)), (2, [64, 0]);
    Float32(f32), "float32", (FLOAT, None), (3, [1]);
    Float64(f64), "float64", (DOUBLE, None), (3, [2]);
    Bool(bool), "bool", (BOOLEAN, None), (6, []);
    Text(Text), "text", (BYTE_ARRAY, Some(LogicalType::String)), (5, []);
}

/// Integers of other widths than Parquet's own, or without a sign.
fn integer(bit_width: i8, is_signed: bool) -> Option<LogicalType> {
    Some(LogicalType::integer(bit_width, is_signed))
}

/// A value that a column can hold.
pub(crate) trait Value: Clone + Default + 'static {
    /// Its type.
    const TYPE: Type;
    /// The values of a column, if they are of this type.
    fn of(values: &Values) -> Option<&[Self]>;
    /// The values of a column.
    fn all(values: Vec<Self>) -> Values;
}

/// How values belong to rows.
#[derive(Clone, Debug, PartialEq)]
pub enum Rows {
    /// This many values in each row.
    Fixed(usize),
    /// One value in each row. It means nothing where this is `false`: the row has none.
    Optional(Vec<bool>),
    /// A list in each row.
    Lists {
        /// The end of each list among the values. It begins where the list before it ends.
        ends: Vec<usize>,
        /// Whether the row has a list.
        present: Vec<bool>,
    },
}

/// A column of a table. All columns may have missing values, so that the schema does not depend on the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its values, row after row.
    pub values: Values,
    /// Their rows.
    pub rows: Rows,
}

impl Column {
    /// A column with `width` values in each row.
    pub(crate) fn fixed<T: Value>(name: impl Into<String>, width: usize, values: Vec<T>) -> Self {
        Column { name: name.into(), values: T::all(values), rows: Rows::Fixed(width) }
    }

    /// A column with one value in each row.
    pub(crate) fn of<T: Value>(name: impl Into<String>, values: impl Iterator<Item = T>) -> Self {
        Column::fixed(name, 1, values.collect())
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        match &self.rows {
            Rows::Fixed(width) => self.values.len() / width.max(&1),
            Rows::Optional(present) => present.len(),
            Rows::Lists { ends, .. } => ends.len(),
        }
    }

    /// Number of values in each row; `None` for lists of any length.
    pub(crate) fn width(&self) -> Option<usize> {
        match self.rows {
            Rows::Fixed(width) => Some(width),
            Rows::Optional(_) => Some(1),
            Rows::Lists { .. } => None,
        }
    }

    /// Whether its type in a file is a list.
    pub(crate) fn has_lists(&self) -> bool {
        self.width().is_none_or(|width| width > 1)
    }

    /// The values of a row; none if the row has no value.
    pub(crate) fn row<T: Value>(&self, row: usize) -> Option<&[T]> {
        let place = match &self.rows {
            Rows::Fixed(width) => row * width..(row + 1) * width,
            Rows::Optional(present) => present.get(row)?.then_some(row..row + 1)?,
            Rows::Lists { ends, present } => {
                let start = row.checked_sub(1).map_or(0, |before| ends[before]);
                present.get(row)?.then_some(start..ends[row])?
            }
        };
        T::of(&self.values)?.get(place)
    }

    /// Whether a row of a plain column has no value.
    pub(crate) fn is_missing(&self, row: usize) -> bool {
        matches!(&self.rows, Rows::Optional(present) if !present[row])
    }

    /// The value in a row of a plain column as text; empty if it is missing.
    pub(crate) fn shown(&self, row: usize) -> String {
        if self.is_missing(row) { String::new() } else { self.values.shown(row) }
    }

    /// Number of rows without a value.
    pub(crate) fn missing(&self) -> usize {
        match &self.rows {
            Rows::Fixed(_) => 0,
            Rows::Optional(present) | Rows::Lists { present, .. } => present.iter().filter(|there| !**there).count(),
        }
    }

    /// Its type, as errors name it.
    pub(crate) fn kind(&self) -> String {
        kind_of(self.values.type_of(), self.width())
    }

    /// Whether it has values of this type, so many in each row (`None` for lists of any length), and misses none unless
    /// `optional`; otherwise what it is and what is allowed.
    pub(crate) fn fits(&self, value: Type, width: Option<usize>, optional: bool) -> Result<(), (String, String)> {
        let (is_of_type, missing) = (self.values.type_of() == value, self.missing());
        let found = if is_of_type && missing > 0 && !optional {
            format!("{missing} nulls")
        } else if is_of_type && self.width() == width {
            return Ok(());
        } else {
            format!("a column of {}", self.kind())
        };
        let without = if optional { "" } else { " without nulls" };
        Err((found, format!("a column of {}{without}", kind_of(value, width))))
    }
}

/// A type with the number of values in each row, as errors name it.
fn kind_of(value: Type, width: Option<usize>) -> String {
    let name = value.name();
    match width {
        Some(1) => name.into(),
        Some(width) => format!("{width} {name} in each row"),
        None => format!("lists of {name}"),
    }
}
