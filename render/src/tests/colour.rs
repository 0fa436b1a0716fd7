//! Tests of colours.

use glam::Vec3;

use crate::colour::{LAMP, TABLE, linear, shown};

/// Tests that colours and lamp are those of the replay page.
#[test]
fn colours_are_those_of_the_page() {
    let read = |path: &str| std::fs::read_to_string(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let page = ["colours.ts", "view/light.ts", "style.css"].map(|file| read(&format!("../replay/page/src/{file}")));
    let (page, own) = (page.concat(), read("src/colour.rs"));
    let colours: Vec<&str> = own.match_indices("\"#").filter_map(|(at, _)| own.get(at + 1..at + 8)).collect();
    let colours: Vec<&&str> =
        colours.iter().filter(|colour| colour[1..].chars().all(|digit| digit.is_ascii_hexdigit())).collect();
    assert!(colours.len() > 15);
    for colour in colours {
        // The page has no table.
        assert!(*colour == TABLE || page.contains(*colour), "{colour} is not on the page");
    }
    let [x, y, z] = LAMP.to_array();
    assert!(page.contains(&format!("LAMP = [{x}, {y}, {z}]")));
    assert!((LAMP.length() - 1.0).abs() < 1e-4);
}

/// Tests that a colour that is turned to linear light is shown as it was, and that light is limited.
#[test]
fn colours_survive_the_turn_to_light() {
    for byte in 0..=255_u8 {
        let colour = format!("#{byte:02x}{:02x}80", 255 - byte);
        assert_eq!(shown(linear(&colour)), [byte, 255 - byte, 0x80]);
    }
    assert_eq!(shown(Vec3::new(-1.0, 7.0, 0.0)), [0, 255, 0]);
}
