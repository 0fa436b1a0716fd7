//! Lists of numbers in messages: arrays of `std_msgs` in CDR, Foxglove's grids, and any list in JSON.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::Value;

/// How to find the numbers in a message.
pub(super) enum Decoder {
    /// `std_msgs/msg/Float64MultiArray` or, if `single`, `Float32MultiArray`.
    MultiArray { single: bool },
    /// `foxglove.Grid` as JSON: the field of its cells with this name.
    Grid { field: String },
    /// A list of numbers in JSON, at this path of keys.
    Json { keys: Vec<String> },
}

/// What was found, and what is allowed.
type Fault = (String, String);

/// The decoder for messages of an encoding and a schema; `from` is the field with the numbers. An error says what is
/// allowed.
pub(super) fn decoder(encoding: &str, schema: &str, from: &str) -> Result<Decoder, String> {
    match (encoding, schema) {
        ("cdr", "std_msgs/msg/Float64MultiArray" | "std_msgs/msg/Float32MultiArray") if from == "data" => {
            Ok(Decoder::MultiArray {
                single: schema.ends_with("Float32MultiArray"),
            })
        }
        ("json", "foxglove.Grid") => Ok(Decoder::Grid { field: from.into() }),
        ("json", _) => Ok(Decoder::Json {
            keys: from.split('.').map(str::to_owned).collect(),
        }),
        _ => Err(
            "a topic of JSON messages, or of std_msgs/msg/Float64MultiArray or Float32MultiArray in CDR with `from = \"data\"`"
                .into(),
        ),
    }
}

impl Decoder {
    /// Puts the numbers of a message into `readings`.
    pub(super) fn decode(&self, bytes: &[u8], readings: &mut Vec<f64>) -> Result<(), Fault> {
        readings.clear();
        match self {
            Decoder::MultiArray { single } => multi_array(bytes, *single, readings).ok_or_else(|| {
                let found = format!("{} bytes that are no such array", bytes.len());
                (found, "an array in CDR, little-endian".into())
            }),
            Decoder::Grid { field } => grid(bytes, field, readings),
            Decoder::Json { keys } => json(bytes, keys, readings),
        }
    }
}

/// A message in CDR that is being decoded.
struct Cdr<'a> {
    /// The message without its first four bytes, which name the encoding. Alignment counts from the start of this
    /// slice.
    bytes: &'a [u8],
    place: usize,
}

impl<'a> Cdr<'a> {
    /// The message after the bytes of its encapsulation; `None` if it is not plain little-endian CDR.
    fn new(bytes: &'a [u8]) -> Option<Self> {
        let bytes = bytes.strip_prefix(&[0, 1])?.get(2..)?;
        Some(Cdr { bytes, place: 0 })
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.place.checked_add(count)?;
        let taken = self.bytes.get(self.place..end)?;
        self.place = end;
        Some(taken)
    }

    fn align(&mut self, to: usize) {
        self.place = self.place.next_multiple_of(to);
    }

    fn u32(&mut self) -> Option<u32> {
        self.align(4);
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }
}

fn multi_array(bytes: &[u8], single: bool, readings: &mut Vec<f64>) -> Option<()> {
    let mut message = Cdr::new(bytes)?;
    for _ in 0..message.u32()? {
        // A dimension: its label, size and stride.
        let label = message.u32()? as usize;
        message.take(label)?;
        message.u32()?;
        message.u32()?;
    }
    // The offset of the data in the array, which no known publisher uses.
    message.u32()?;
    for _ in 0..message.u32()? {
        readings.push(if single {
            f32::from_le_bytes(message.take(4)?.try_into().ok()?).into()
        } else {
            message.align(8);
            f64::from_le_bytes(message.take(8)?.try_into().ok()?)
        });
    }
    Some(())
}

/// The parts of `foxglove.Grid` that are needed.
#[derive(Deserialize)]
struct GridMessage {
    column_count: usize,
    /// Bytes of a row. Further bytes may follow its cells.
    row_stride: usize,
    /// Bytes of a cell.
    cell_stride: usize,
    fields: Vec<Field>,
    data: String,
}

/// Foxglove's `PackedElementField`.
#[derive(Deserialize)]
struct Field {
    name: String,
    offset: usize,
    #[serde(rename = "type")]
    number: u32,
}

/// Decodes the number at the start of some bytes, given its type in `PackedElementField`. `None` for an unknown type or
/// too few bytes.
fn packed(number: u32, bytes: &[u8]) -> Option<f64> {
    fn start<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
        bytes.get(..N)?.try_into().ok()
    }
    Some(match number {
        1 => u8::from_le_bytes(start(bytes)?).into(),
        2 => i8::from_le_bytes(start(bytes)?).into(),
        3 => u16::from_le_bytes(start(bytes)?).into(),
        4 => i16::from_le_bytes(start(bytes)?).into(),
        5 => u32::from_le_bytes(start(bytes)?).into(),
        6 => i32::from_le_bytes(start(bytes)?).into(),
        7 => f32::from_le_bytes(start(bytes)?).into(),
        8 => f64::from_le_bytes(start(bytes)?),
        _ => return None,
    })
}

fn grid(bytes: &[u8], name: &str, readings: &mut Vec<f64>) -> Result<(), Fault> {
    let allowed = || format!("a foxglove.Grid with the field {name:?}");
    let grid: GridMessage = serde_json::from_slice(bytes).map_err(|error| (error.to_string(), allowed()))?;
    let names: Vec<&str> = grid.fields.iter().map(|field| field.name.as_str()).collect();
    let field = grid.fields.iter().find(|field| field.name == name);
    let field = field.ok_or_else(|| (format!("the fields {}", names.join(", ")), allowed()))?;
    let cells = STANDARD.decode(&grid.data).map_err(|error| (error.to_string(), "data in base64".to_string()))?;
    if grid.cell_stride == 0 || grid.row_stride == 0 {
        return Err(("cells or rows of 0 bytes".into(), allowed()));
    }
    let of_cells = grid.column_count.checked_mul(grid.cell_stride);
    if of_cells.is_none_or(|of_cells| grid.row_stride < of_cells) {
        let found =
            format!("rows of {} bytes for {} cells of {}", grid.row_stride, grid.column_count, grid.cell_stride);
        return Err((found, "rows at least as long as their cells".into()));
    }
    if !cells.len().is_multiple_of(grid.row_stride) {
        let found = format!("{} bytes in rows of {}", cells.len(), grid.row_stride);
        return Err((found, "complete rows".into()));
    }
    let rows = cells.chunks_exact(grid.row_stride);
    for cell in rows.flat_map(|row| row.chunks_exact(grid.cell_stride).take(grid.column_count)) {
        let number = cell.get(field.offset..).and_then(|bytes| packed(field.number, bytes));
        readings.push(number.ok_or_else(|| {
            let found = format!("type {} at byte {} of cells of {}", field.number, field.offset, grid.cell_stride);
            (found, "a number within each cell".to_string())
        })?);
    }
    Ok(())
}

fn json(bytes: &[u8], keys: &[String], readings: &mut Vec<f64>) -> Result<(), Fault> {
    let allowed = || format!("a list of numbers at {}", keys.join("."));
    let message: Value = serde_json::from_slice(bytes).map_err(|error| (error.to_string(), allowed()))?;
    let found = keys.iter().try_fold(&message, |value, key| value.get(key));
    let found = found.ok_or_else(|| ("a message without this field".to_string(), allowed()))?;
    let list = found.as_array().ok_or_else(|| ("something else than a list".to_string(), allowed()))?;
    for number in list {
        readings.push(number.as_f64().ok_or_else(|| (number.to_string(), allowed()))?);
    }
    Ok(())
}
