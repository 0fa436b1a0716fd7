//! The Arrow schema of a file with columns of a fixed width. Parquet knows only lists of any length. With this entry of
//! the metadata, Arrow's and Polars' readers give such a column its width, and so `to_numpy` an array of two dimensions.
//!
//! The entry is a message of Arrow's interprocess format, a FlatBuffer: tables that refer to each other by offsets.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::column::Column;

/// Metadata key of the schema.
const KEY: &str = "ARROW:schema";

/// A part of a FlatBuffer.
enum Part {
    /// A table with some of its fields, each by its number in the format's definition.
    Table(Vec<(usize, Part)>),
    Vector(Vec<Part>),
    Text(String),
    /// A number or truth value within a table.
    Number(i64),
}

/// Appends a part and returns its place. Parts that it refers to follow it. A number takes eight bytes, whatever its
/// type, which is little-endian.
fn append(bytes: &mut Vec<u8>, part: Part) -> usize {
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    let mut references = Vec::new();
    let place = match part {
        Part::Table(fields) => {
            // The list of the places of the fields comes first.
            let slots = fields.iter().map(|(slot, _)| slot + 1).max().unwrap_or(0);
            let list = bytes.len();
            let mut places = vec![0_u16; slots];
            for (nth, (slot, _)) in fields.iter().enumerate() {
                places[*slot] = 8 + 8 * nth as u16;
            }
            let sizes = [4 + 2 * slots as u16, 8 + 8 * fields.len() as u16];
            bytes.extend(sizes.iter().chain(&places).flat_map(|number| number.to_le_bytes()));
            bytes.resize(bytes.len().next_multiple_of(8), 0);
            let place = bytes.len();
            bytes.extend(((place - list) as i64).to_le_bytes());
            for (_, field) in fields {
                if let Part::Number(number) = field {
                    bytes.extend(number.to_le_bytes());
                } else {
                    references.push((bytes.len(), field));
                    bytes.extend([0; 8]);
                }
            }
            place
        }
        Part::Vector(parts) => {
            let place = bytes.len();
            bytes.extend((parts.len() as u32).to_le_bytes());
            for part in parts {
                references.push((bytes.len(), part));
                bytes.extend([0; 4]);
            }
            place
        }
        Part::Text(text) => {
            let place = bytes.len();
            bytes.extend((text.len() as u32).to_le_bytes());
            bytes.extend(text.as_bytes());
            bytes.push(0);
            place
        }
        Part::Number(_) => bytes.len(),
    };
    for (from, part) in references {
        let distance = append(bytes, part) - from;
        bytes[from..from + 4].copy_from_slice(&(distance as u32).to_le_bytes());
    }
    place
}

/// A field of a schema: name, nullable, number of its type and the numbers in that type's fields, fields within it.
fn field(name: &str, (kind, numbers): (i64, &[i64]), children: Vec<Part>) -> Part {
    Part::Table(vec![
        (0, Part::Text(name.to_owned())),
        (1, Part::Number(1)),
        (2, Part::Number(kind)),
        (3, Part::Table(numbers.iter().copied().map(Part::Number).enumerate().collect())),
        (5, Part::Vector(children)),
    ])
}

/// The entry of the metadata; `None` if no column has a fixed width.
pub(super) fn entry(columns: &[Column]) -> Option<(&'static str, String)> {
    let is_wide = |column: &Column| column.width().is_some_and(|width| width > 1);
    if !columns.iter().any(is_wide) {
        return None;
    }
    let fields = columns.iter().map(|column| {
        let value = column.values.type_of().arrow();
        let item = |value| vec![field("item", value, Vec::new())];
        match column.width() {
            Some(1) => field(&column.name, value, Vec::new()),
            Some(width) => field(&column.name, (16, &[width as i64]), item(value)),
            None => field(&column.name, (12, &[]), item(value)),
        }
    });
    let schema = Part::Table(vec![(1, Part::Vector(fields.collect()))]);
    // Version 5 of the format; the header is a schema.
    let message = Part::Table(vec![(0, Part::Number(4)), (1, Part::Number(1)), (2, schema)]);
    let mut buffer = vec![0; 8];
    let root = append(&mut buffer, message);
    buffer[..4].copy_from_slice(&(root as u32).to_le_bytes());
    buffer.resize(buffer.len().next_multiple_of(8), 0);
    let start = [u32::MAX.to_le_bytes(), (buffer.len() as u32).to_le_bytes()].concat();
    Some((KEY, BASE64_STANDARD.encode([start, buffer].concat())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(bytes: &[u8], at: usize) -> usize {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
    }

    /// The place to which the bytes at a place refer.
    fn followed(bytes: &[u8], at: usize) -> usize {
        at + word(bytes, at)
    }

    /// The place of a field of a table.
    fn field_of(bytes: &[u8], table: usize, slot: usize) -> usize {
        let list = table - word(bytes, table);
        let place = &bytes[list + 4 + 2 * slot..];
        table + usize::from(u16::from_le_bytes([place[0], place[1]]))
    }

    /// Tests that the fields of the schema have the names, types and widths of the columns, and that a file without
    /// columns of a fixed width has no schema.
    #[test]
    fn the_schema_has_names_types_and_widths() {
        let plain = Column::of("index", [1_i64].into_iter());
        assert!(entry(std::slice::from_ref(&plain)).is_none());
        let (_, text) = entry(&[plain, Column::fixed("pose", 7, vec![0.0; 7])]).unwrap();
        let message = BASE64_STANDARD.decode(text).unwrap();
        assert_eq!((word(&message, 0), word(&message, 4)), (u32::MAX as usize, message.len() - 8));
        let bytes = &message[8..];
        let schema = followed(bytes, field_of(bytes, followed(bytes, 0), 2));
        let fields = followed(bytes, field_of(bytes, schema, 1));
        let found = |nth: usize| {
            let field = followed(bytes, fields + 4 + 4 * nth);
            let name = followed(bytes, field_of(bytes, field, 0));
            let name = &bytes[name + 4..name + 4 + word(bytes, name)];
            let content = followed(bytes, field_of(bytes, field, 3));
            (name, word(bytes, field_of(bytes, field, 2)), word(bytes, field_of(bytes, content, 0)))
        };
        assert_eq!(word(bytes, fields), 2);
        // A number of 64 bits, and a list of seven.
        assert_eq!(found(0), (&b"index"[..], 2, 64));
        assert_eq!(found(1), (&b"pose"[..], 16, 7));
    }
}
