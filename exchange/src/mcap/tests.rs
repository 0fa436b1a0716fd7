use std::collections::BTreeMap;

use super::{Channel, Fault, Item, MAGIC, Map, Reader, Writer, code};

/// A file of three channels. Two of them have so many messages that the file has several chunks.
fn example() -> Vec<u8> {
    let mut writer = Writer::new("a test");
    writer.metadata("facts", &Map::from([("seed".into(), "7".into())]));
    let first = writer.channel("/a", "json", "mine.A", "jsonschema", b"{}");
    let second = writer.channel("/b", "json", "mine.A", "jsonschema", b"{}");
    let third = writer.channel("/c", "cdr", "mine.C", "ros2msg", b"float64 x");
    assert_eq!([first, second, third], [0, 1, 2]);
    for index in 0..5000u64 {
        let text = format!("{{\"number\":{index},\"text\":\"{}\"}}", "x".repeat((index % 700) as usize));
        writer.message((index % 2) as u16, 10 * index, text.as_bytes()).unwrap();
    }
    writer.finish().unwrap()
}

fn u64_at(bytes: &[u8], place: usize) -> u64 {
    u64::from_le_bytes(bytes[place..place + 8].try_into().unwrap())
}

/// Code, content and end of the record at a place.
fn record(bytes: &[u8], place: usize) -> (u8, &[u8], usize) {
    let end = place + 9 + u64_at(bytes, place + 1) as usize;
    (bytes[place], &bytes[place + 9..end], end)
}

/// Tests that schemas, channels and messages come back in their order, and that channels with the same schema name
/// share one schema.
#[test]
fn messages_come_back() {
    let bytes = example();
    let (mut schemas, mut channels, mut messages) = (Vec::new(), Vec::new(), Vec::new());
    let read = Reader::new(&bytes[..]).read(|item| {
        match item {
            Item::Schema(schema) if !schemas.contains(&schema) => schemas.push(schema),
            Item::Channel(channel) if !channels.contains(&channel) => channels.push(channel),
            Item::Message(channel, time_ns, data) => messages.push((channel, time_ns, data.to_vec())),
            _ => {}
        }
        Ok::<(), Fault>(())
    });
    read.unwrap();
    assert_eq!(schemas.iter().map(|schema| schema.name.as_str()).collect::<Vec<_>>(), ["mine.A", "mine.C"]);
    let channel = |id, schema_id, topic: &str, encoding: &str| Channel {
        id,
        schema_id,
        topic: topic.into(),
        message_encoding: encoding.into(),
    };
    let expected = [channel(0, 1, "/a", "json"), channel(1, 1, "/b", "json"), channel(2, 2, "/c", "cdr")];
    assert_eq!(channels, expected);
    assert_eq!(messages.len(), 5000);
    for (index, (channel, time_ns, data)) in messages.iter().enumerate() {
        assert_eq!((*channel as usize, *time_ns as usize), (index % 2, 10 * index));
        assert!(data.starts_with(format!("{{\"number\":{index},").as_bytes()));
    }
}

/// Tests that the summary leads to every chunk, every message index and the metadata, and that its counts are right.
/// The test follows the offsets as a viewer does.
#[test]
fn the_summary_leads_to_everything() {
    let bytes = example();
    assert!(bytes.starts_with(&MAGIC) && bytes.ends_with(&MAGIC));
    let footer = bytes.len() - MAGIC.len() - 29;
    let (code, content, _) = record(&bytes, footer);
    assert_eq!(code, code::FOOTER);
    let (start, offsets) = (u64_at(content, 0) as usize, u64_at(content, 8) as usize);
    let crc = u32::from_le_bytes(content[16..].try_into().unwrap());
    assert_eq!(crc, crc32fast::hash(&bytes[start..footer + 9 + 16]));
    let (mut place, mut chunks, mut messages, mut groups) = (start, 0, 0, BTreeMap::new());
    while place < offsets {
        let (code, content, end) = record(&bytes, place);
        let group = groups.entry(code).or_insert((place, place));
        group.1 = end;
        match code {
            code::CHUNK_INDEX => {
                chunks += 1;
                let (chunk, length) = (u64_at(content, 16) as usize, u64_at(content, 24) as usize);
                let (chunk_code, chunk_content, chunk_end) = record(&bytes, chunk);
                assert_eq!((chunk_code, chunk_end), (code::CHUNK, chunk + length));
                assert_eq!(content[..16], chunk_content[..16], "times of the chunk");
                let size = u64_at(chunk_content, 16) as usize;
                // The text "zstd" and the length of the records come before the records.
                let records = zstd::bulk::decompress(&chunk_content[28 + 8 + 8..], size).unwrap();
                let count = u32::from_le_bytes(content[32..36].try_into().unwrap()) as usize / 10;
                for entry in 0..count {
                    let index = u64_at(content, 36 + 10 * entry + 2) as usize;
                    let (index_code, index_content, _) = record(&bytes, index);
                    assert_eq!(index_code, code::MESSAGE_INDEX);
                    for pair in index_content[6..].chunks_exact(16) {
                        let (message_code, message, _) = record(&records, u64_at(pair, 8) as usize);
                        assert_eq!((message_code, &message[..2]), (code::MESSAGE, &index_content[..2]));
                        assert_eq!(u64_at(message, 6), u64_at(pair, 0));
                        messages += 1;
                    }
                }
            }
            code::METADATA_INDEX => assert_eq!(record(&bytes, u64_at(content, 0) as usize).0, code::METADATA),
            code::STATISTICS => assert_eq!(u64_at(content, 0), 5000),
            _ => {}
        }
        place = end;
    }
    assert!(chunks > 1, "{chunks} chunks");
    assert_eq!(messages, 5000);
    let mut found = BTreeMap::new();
    while place < footer {
        let (code, content, end) = record(&bytes, place);
        assert_eq!(code, code::SUMMARY_OFFSET);
        found.insert(content[0], (u64_at(content, 1) as usize, (u64_at(content, 1) + u64_at(content, 9)) as usize));
        place = end;
    }
    assert_eq!(found, groups);
}

/// Tests that a file that is cut off anywhere, or has a changed chunk, is refused and not silently read in part.
#[test]
fn a_damaged_file_is_refused() {
    let bytes = example();
    let read = |bytes: &[u8]| Reader::new(bytes).read(|_| Ok::<(), Fault>(()));
    for cut in (0..bytes.len()).step_by(997) {
        assert!(matches!(read(&bytes[..cut]), Err(Fault::Broken(_))), "cut at {cut}");
    }
    let mut changed = bytes.clone();
    // In the first chunk.
    changed[2000] ^= 1;
    assert!(matches!(read(&changed), Err(Fault::Broken(_))));
    let mut lz4 = bytes;
    let place = lz4.windows(4).position(|window| window == b"zstd").unwrap();
    lz4[place..place + 4].copy_from_slice(b"lz4f");
    assert!(matches!(read(&lz4), Err(Fault::Compression(name)) if name == "lz4f"));
}
