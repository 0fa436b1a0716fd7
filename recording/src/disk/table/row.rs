//! The description of a table: the fields of its rows, each with the name, unit and text of its column.

use std::slice::Iter;

use glam::{DQuat, DVec3};

use super::column::{Column, Rows, Type, Value};

/// How many values a row of a column has.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Width {
    /// One, or none.
    One,
    /// A list of any length, or none.
    List,
    /// One for each joint.
    Joints,
    /// One for each of these names.
    Named(&'static [&'static str]),
    /// This many for each taxel of a patch.
    Taxels(usize),
}

/// The description of a column, or of several whose names differ only in `x`, `y`, `z` or in the name of a patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Described {
    /// Name. `PATCH` at its end stands for the name of each patch, `{xyz}` or `{xyzw}` for each axis.
    pub(crate) name: &'static str,
    /// Type of a value.
    pub(crate) value: Type,
    /// Values in a row.
    pub(crate) width: Width,
    /// Whether a row may have no value.
    pub(crate) optional: bool,
    /// Unit, or empty.
    pub(crate) unit: &'static str,
    /// What it holds.
    pub(crate) what: &'static str,
}

impl Described {
    /// Its type in the documents.
    pub(crate) fn kind(&self) -> String {
        let value = self.value.name();
        match self.width {
            Width::One => value.into(),
            Width::List => format!("list of {value}"),
            Width::Joints => format!("{value} × J"),
            Width::Named(names) => format!("{value} × {}", names.len()),
            Width::Taxels(1) => format!("{value} × n"),
            Width::Taxels(each) => format!("{value} × {each}n"),
        }
    }

    /// Whether it describes a column of a file.
    pub(crate) fn covers(&self, name: &str) -> bool {
        match self.name.strip_suffix("PATCH") {
            Some(prefix) => name.starts_with(prefix),
            None => part_names(self).iter().any(|part| part == name),
        }
    }
}

/// The names of the columns that a description without `PATCH` stands for.
pub(crate) fn part_names(described: &Described) -> Vec<String> {
    let name = described.name;
    for axes in ["xyzw", "xyz"] {
        if let Some((before, after)) = name.split_once(&format!("{{{axes}}}")) {
            return axes.chars().map(|axis| format!("{before}{axis}{after}")).collect();
        }
    }
    vec![name.into()]
}

/// The type of a field of a row: a value, or several that have a column each.
pub(crate) trait Field: 'static {
    /// The type of its values.
    const TYPE: Type;
    /// Values in a row of a column.
    const WIDTH: Width = Width::One;
    /// Whether a row may have no value.
    const OPTIONAL: bool = false;

    /// The columns of a field of all rows; `names` are the columns' names.
    fn write<'a>(fields: impl Iterator<Item = &'a Self> + Clone, names: Vec<String>) -> Vec<Column>;

    /// The field in a row of its columns, which are the next ones and were found to be as described.
    fn read(columns: &mut Iter<&Column>, row: usize) -> Self;
}

/// The value in a row of the next column.
fn one<T: Value>(columns: &mut Iter<&Column>, row: usize) -> Option<T> {
    columns.next()?.row::<T>(row)?.first().cloned()
}

impl<T: Value> Field for T {
    const TYPE: Type = T::TYPE;

    fn write<'a>(fields: impl Iterator<Item = &'a Self>, names: Vec<String>) -> Vec<Column> {
        vec![Column::of(names.concat(), fields.cloned())]
    }

    fn read(columns: &mut Iter<&Column>, row: usize) -> Self {
        one(columns, row).unwrap_or_default()
    }
}

impl<T: Value> Field for Option<T> {
    const TYPE: Type = T::TYPE;
    const OPTIONAL: bool = true;

    fn write<'a>(fields: impl Iterator<Item = &'a Self> + Clone, names: Vec<String>) -> Vec<Column> {
        let present = fields.clone().map(Option::is_some).collect();
        let column = Column::of(names.concat(), fields.map(|field| field.clone().unwrap_or_default()));
        vec![Column { rows: Rows::Optional(present), ..column }]
    }

    fn read(columns: &mut Iter<&Column>, row: usize) -> Self {
        one(columns, row)
    }
}

impl<T: Value> Field for Option<Vec<T>> {
    const TYPE: Type = T::TYPE;
    const WIDTH: Width = Width::List;
    const OPTIONAL: bool = true;

    fn write<'a>(fields: impl Iterator<Item = &'a Self> + Clone, names: Vec<String>) -> Vec<Column> {
        let mut values = Vec::new();
        let mut ends = Vec::new();
        for field in fields.clone() {
            values.extend(field.iter().flatten().cloned());
            ends.push(values.len());
        }
        let present = fields.map(Option::is_some).collect();
        vec![Column { rows: Rows::Lists { ends, present }, ..Column::fixed(names.concat(), 1, values) }]
    }

    fn read(columns: &mut Iter<&Column>, row: usize) -> Self {
        columns.next()?.row(row).map(<[T]>::to_vec)
    }
}

/// Fields with a column for each of their components.
macro_rules! components {
    ($($field:ty: $count:literal $value:ty, $to:expr, $from:expr;)*) => {
        $(impl Field for $field {
            const TYPE: Type = <$value as Field>::TYPE;
            const OPTIONAL: bool = <$value as Field>::OPTIONAL;

            fn write<'a>(fields: impl Iterator<Item = &'a Self> + Clone, names: Vec<String>) -> Vec<Column> {
                let to: fn(&$field) -> [$value; $count] = $to;
                let part = |(axis, name): (usize, String)| {
                    let parts: Vec<$value> = fields.clone().map(|field| to(field)[axis]).collect();
                    <$value as Field>::write(parts.iter(), vec![name])
                };
                names.into_iter().enumerate().flat_map(part).collect()
            }

            fn read(columns: &mut Iter<&Column>, row: usize) -> Self {
                let from: fn([$value; $count]) -> $field = $from;
                from(std::array::from_fn(|_| <$value as Field>::read(columns, row)))
            }
        })*
    };
}
components! {
    DVec3: 3 f64, DVec3::to_array, DVec3::from_array;
    Option<DVec3>: 3 Option<f64>, |field| field.map_or([None; 3], |vector| vector.to_array().map(Some)),
        |[x, y, z]| Some(DVec3::new(x?, y?, z?));
    DQuat: 4 f64, DQuat::to_array, DQuat::from_array;
    [f32; 3]: 3 f32, |field| *field, |parts| parts;
    [f32; 4]: 4 f32, |field| *field, |parts| parts;
}

/// A row of a table.
pub(crate) trait Row: Sized {
    /// The columns.
    const COLUMNS: &'static [Described];
    /// The columns of some rows.
    fn write(rows: &[Self]) -> Vec<Column>;
    /// A row of columns, which were found to be as described.
    fn read(columns: &[&Column], row: usize) -> Self;
}

/// Declares the rows of a table: for each field its type, and name (if it is not that of the field), unit and
/// description of its column.
macro_rules! row {
    (name $field:ident) => { stringify!($field) };
    (name $field:ident $name:literal) => { $name };
    ($(#[$doc:meta])* $row:ident { $($field:ident: $type:ty $(= $name:literal)?, $unit:literal, $what:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default)]
        pub(crate) struct $row {
            $(pub(crate) $field: $type,)*
        }

        impl $crate::disk::table::row::Row for $row {
            const COLUMNS: &'static [$crate::disk::table::row::Described] = &[$($crate::disk::table::row::Described {
                name: $crate::disk::table::row::row!(name $field $($name)?),
                value: <$type as $crate::disk::table::row::Field>::TYPE,
                width: <$type as $crate::disk::table::row::Field>::WIDTH,
                optional: <$type as $crate::disk::table::row::Field>::OPTIONAL,
                unit: $unit,
                what: $what,
            }),*];

            fn write(rows: &[Self]) -> Vec<$crate::disk::table::column::Column> {
                use $crate::disk::table::row::{Field, part_names};
                let mut names = Self::COLUMNS.iter().map(part_names);
                let mut columns = Vec::new();
                $(columns.extend(<$type as Field>::write(
                    rows.iter().map(|row| &row.$field),
                    names.next().unwrap_or_default(),
                ));)*
                columns
            }

            fn read(columns: &[&$crate::disk::table::column::Column], row: usize) -> Self {
                let mut columns = columns.iter();
                $row {
                    $($field: <$type as $crate::disk::table::row::Field>::read(&mut columns, row),)*
                }
            }
        }
    };
}
pub(crate) use row;
