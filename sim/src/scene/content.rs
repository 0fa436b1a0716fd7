//! A hash of what a scene file says of its objects, for the random numbers of scenes that name no stream.

use blake3::Hasher;
use toml::{Table, Value};

/// Hexadecimal BLAKE3 of the key `objects`, without comments, the order of keys, the way in which numbers are written and
/// the names of categories. A key that a later version adds does not change it.
pub(super) fn objects_hash(text: &str) -> String {
    let table: Table = toml::from_str(text).unwrap_or_default();
    let mut hasher = Hasher::new();
    if let Some(objects) = table.get("objects") {
        add(objects, &mut hasher);
    }
    hasher.finalize().to_hex().to_string()
}

/// Adds a value, with a letter for its kind and the number of its parts.
fn add(value: &Value, hasher: &mut Hasher) {
    let mut put = |kind: u8, parts: usize, bytes: &[u8]| {
        hasher.update(&[kind]).update(&(parts as u64).to_le_bytes()).update(bytes);
    };
    match value {
        Value::Integer(whole) => put(b'n', 1, &(*whole as f64).to_le_bytes()),
        Value::Float(real) => put(b'n', 1, &real.to_le_bytes()),
        Value::Boolean(yes) => put(b'b', usize::from(*yes), &[]),
        Value::String(text) => put(b't', text.len(), text.as_bytes()),
        Value::Datetime(time) => add(&time.to_string().into(), hasher),
        Value::Array(values) => {
            put(b'a', values.len(), &[]);
            values.iter().for_each(|value| add(value, hasher));
        }
        Value::Table(table) => {
            put(b'o', table.len() - usize::from(table.contains_key("category")), &[]);
            // What a group is called does not change how it is drawn.
            let mut keys: Vec<&String> = table.keys().filter(|key| *key != "category").collect();
            keys.sort();
            for key in keys {
                add(&key.as_str().into(), hasher);
                add(&table[key], hasher);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::objects_hash;

    const LEAF: &str = "summary = \"a\"\n[[objects.leaf]]\ncount = 2\nheight_m = 0.50\n";

    /// Tests that only what the file says of the objects changes the hash, without the names of their categories.
    #[test]
    fn only_objects_count() {
        let same = "# A comment\nsummary = \"b\"\nsensor = { noise_n = 0.0 }\n[[objects.leaf]]\ncategory = \"stalk\"\nheight_m = 5e-1\n\
             count = 2\n";
        assert_eq!(objects_hash(LEAF), objects_hash(same));
        for other in [("count = 2", "count = 3"), ("0.50", "0.51"), ("leaf", "trunk"), ("height_m", "width_m")] {
            assert_ne!(objects_hash(LEAF), objects_hash(&LEAF.replace(other.0, other.1)), "{other:?}");
        }
    }
}
