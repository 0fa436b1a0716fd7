//! Reads the triangles of a mesh file: STL (binary and text), OBJ, and COLLADA (DAE).
//!
//! Only corners matter here. Crates for meshes also read normals, textures and materials, in single precision and with a
//! second XML reader, which is a hundred times as much code as this.

use std::cell::Cell;
use std::collections::HashMap;
use std::path::Path;

use glam::{DMat4, DQuat, DVec3, DVec4};
use roxmltree::{Document, Node};
use underbrush_recording::limits::MESH_BYTES;
use underbrush_recording::{InputError, read_bytes};

use super::limits::PLACE_M;

/// Nodes of a COLLADA scene within each other. Choice: files of arms have one or two levels.
const MAX_DEPTH: usize = 32;
/// Nodes of a COLLADA scene, and its triangles. Nodes may be placed many times, so a short file could have any number.
const MAX_NODES: usize = 100_000;
const MAX_TRIANGLES: usize = 4_000_000;

const ALLOWED: &str = "a mesh in STL, OBJ or COLLADA (.stl, .obj, .dae)";
const REMEDY: &str = "export the mesh again, or give the link another collision shape";

/// The corners of a triangle.
pub type Triangle = [DVec3; 3];

/// The triangles of a mesh file, in its own frame and unit; COLLADA's unit is turned into metres.
///
/// # Errors
/// When the file cannot be read, or is no mesh of a known kind.
pub fn read_triangles(path: &Path) -> Result<Vec<Triangle>, InputError> {
    let bytes = read_bytes(path, &MESH_BYTES, ALLOWED, "check the path, or give --package NAME=FOLDER")?;
    let fault = |found: &str| InputError::new(path, "mesh", found, ALLOWED, REMEDY);
    let text = || std::str::from_utf8(&bytes).map_err(|_| fault("bytes that are not UTF-8 text"));
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let triangles = match extension.as_str() {
        "stl" => match binary_stl(&bytes) {
            Some(triangles) => triangles,
            None => text().ok().and_then(text_stl).ok_or_else(|| fault("neither a binary nor a text STL file"))?,
        },
        "obj" => obj(text()?).ok_or_else(|| fault("a vertex or face that is no OBJ"))?,
        "dae" => collada(text()?).map_err(|found| fault(&found))?,
        other => return Err(fault(&format!("extension {other:?}"))),
    };
    // A mesh in millimetres gets its size from the URDF's scale.
    match triangles.iter().flatten().all(|corner| corner.abs().max_element() <= 1e4 * PLACE_M.max) {
        _ if triangles.is_empty() => Err(fault("no triangles")),
        true => Ok(triangles),
        false => Err(fault("corners that are no numbers or far away")),
    }
}

/// `None` if the file is not as long as its number of triangles says.
fn binary_stl(bytes: &[u8]) -> Option<Vec<Triangle>> {
    let count = u32::from_le_bytes(*bytes.get(80..)?.first_chunk()?) as usize;
    let triangles = &bytes[84..];
    if triangles.len() != count.checked_mul(50)? {
        return None;
    }
    let number = |bytes: &[u8]| bytes.first_chunk().map_or(f64::NAN, |bytes| f64::from(f32::from_le_bytes(*bytes)));
    let corner = |bytes: &[u8]| DVec3::new(number(bytes), number(&bytes[4..]), number(&bytes[8..]));
    // Each begins with its normal.
    Some(triangles.chunks_exact(50).map(|own| [12, 24, 36].map(|at| corner(&own[at..]))).collect())
}

fn text_stl(text: &str) -> Option<Vec<Triangle>> {
    let corners = text.lines().filter_map(|line| line.trim_start().strip_prefix("vertex"));
    let corners: Vec<DVec3> = corners.map(|line| place(line.split_whitespace())).collect::<Option<_>>()?;
    let is_stl = text.trim_start().starts_with("solid");
    is_stl.then(|| corners.chunks_exact(3).map(|own| [own[0], own[1], own[2]]).collect())
}

fn obj(text: &str) -> Option<Vec<Triangle>> {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => corners.push(place(words)?),
            Some("f") => {
                let corner = |word: &str| {
                    // Counted from 1, or backwards from the last one; indices of texture and normal follow a slash.
                    let number: i64 = word.split('/').next()?.parse().ok()?;
                    let index = if number < 0 { corners.len() as i64 + number } else { number - 1 };
                    corners.get(usize::try_from(index).ok()?).copied()
                };
                fan(&words.map(corner).collect::<Option<Vec<DVec3>>>()?, &mut triangles);
            }
            _ => {}
        }
    }
    Some(triangles)
}

fn place<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<DVec3> {
    let mut next = || words.next()?.parse().ok();
    Some(DVec3::new(next()?, next()?, next()?))
}

/// Divides a polygon into triangles.
fn fan(corners: &[DVec3], triangles: &mut Vec<Triangle>) {
    triangles.extend((2..corners.len()).map(|last| [corners[0], corners[last - 1], corners[last]]));
}

/// The triangles of the visual scene, each geometry placed by its nodes. The axis that points up is not regarded, as in RViz:
/// a URDF places the file's own frame.
fn collada(text: &str) -> Result<Vec<Triangle>, String> {
    let document = Document::parse(text).map_err(|error| error.to_string())?;
    let with_id = |node: Node| node.attribute("id").map(|id| (id.to_owned(), node.id()));
    let by_id: HashMap<_, _> = document.descendants().filter_map(with_id).collect();
    let reader = Collada { document: &document, by_id, nodes: Cell::new(0) };
    let unit = document.descendants().find(|node| node.has_tag_name("unit"));
    let metre = unit.and_then(|unit| unit.attribute("meter")?.parse().ok()).unwrap_or(1.0);
    let mut triangles = Vec::new();
    for scene in document.descendants().filter(|node| node.has_tag_name("visual_scene")) {
        reader.place(scene, DMat4::from_scale(DVec3::splat(metre)), 0, &mut triangles)?;
    }
    Ok(triangles)
}

struct Collada<'a> {
    document: &'a Document<'a>,
    by_id: HashMap<String, roxmltree::NodeId>,
    /// How many nodes were placed.
    nodes: Cell<usize>,
}

/// Numbers separated by spaces.
fn listed<T: std::str::FromStr>(node: Node) -> Result<Vec<T>, String> {
    let words = node.text().unwrap_or_default().split_whitespace();
    words.map(|word| word.parse().map_err(|_| format!("{word:?} in <{}>", node.tag_name().name()))).collect()
}

impl<'a> Collada<'a> {
    fn target(&self, node: Node, key: &str) -> Option<Node<'a, 'a>> {
        self.document.get_node(*self.by_id.get(node.attribute(key)?.strip_prefix('#')?)?)
    }

    /// Adds the triangles below a node, whose frame is `frame`.
    fn place(&self, node: Node, mut frame: DMat4, depth: usize, all: &mut Vec<Triangle>) -> Result<(), String> {
        self.nodes.set(self.nodes.get() + 1);
        if depth > MAX_DEPTH || self.nodes.get() > MAX_NODES || all.len() > MAX_TRIANGLES {
            return Err(format!("more than {MAX_DEPTH} nested nodes, {MAX_NODES} nodes or {MAX_TRIANGLES} triangles"));
        }
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            match name {
                "matrix" | "translate" | "rotate" | "scale" => {
                    frame *= match (name, listed::<f64>(child)?.as_slice()) {
                        ("matrix", values) if values.len() == 16 => DMat4::from_cols_slice(values).transpose(),
                        ("translate", &[x, y, z]) => DMat4::from_translation(DVec3::new(x, y, z)),
                        ("scale", &[x, y, z]) => DMat4::from_scale(DVec3::new(x, y, z)),
                        ("rotate", &[x, y, z, degrees]) => {
                            let axis = DVec3::new(x, y, z).try_normalize().unwrap_or(DVec3::Z);
                            DMat4::from_quat(DQuat::from_axis_angle(axis, degrees.to_radians()))
                        }
                        (_, values) => return Err(format!("{} numbers in <{name}>", values.len())),
                    }
                }
                "node" => self.place(child, frame, depth + 1, all)?,
                "instance_node" => {
                    let target = self.target(child, "url").ok_or("an <instance_node> of no node")?;
                    self.place(target, frame, depth + 1, all)?;
                }
                "instance_geometry" => {
                    let geometry = self.target(child, "url").ok_or("an <instance_geometry> of no geometry")?;
                    for polygons in geometry.descendants() {
                        self.polygons(polygons, &frame, all)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds the triangles of a `<triangles>`, `<polylist>` or `<polygons>`; other elements have none.
    fn polygons(&self, node: Node, frame: &DMat4, all: &mut Vec<Triangle>) -> Result<(), String> {
        if !["triangles", "polylist", "polygons"].contains(&node.tag_name().name()) {
            return Ok(());
        }
        let inputs = || node.children().filter(|child| child.has_tag_name("input"));
        let offset = |input: Node| input.attribute("offset").and_then(|own| own.parse::<usize>().ok()).unwrap_or(0);
        let stride = inputs().map(offset).max().unwrap_or(0).min(64) + 1;
        let vertex = inputs().find(|input| input.attribute("semantic") == Some("VERTEX")).ok_or("no VERTEX")?;
        let vertices = self.target(vertex, "source").ok_or("no <vertices>")?;
        let position = vertices.children().find(|input| input.attribute("semantic") == Some("POSITION"));
        let source = position.and_then(|input| self.target(input, "source")).ok_or("no POSITION")?;
        let array = source.children().find(|child| child.has_tag_name("float_array")).ok_or("no positions")?;
        let places = listed::<f64>(array)?;
        let mut corners = Vec::new();
        let mut list_lengths = Vec::new();
        for list in node.children().filter(|child| child.has_tag_name("p")) {
            let before = corners.len();
            for index in listed::<usize>(list)?.chunks_exact(stride).map(|own| own.get(offset(vertex)).copied()) {
                let own = index.and_then(|index| places.get(index.checked_mul(3)?..)?.first_chunk::<3>());
                let own = own.ok_or("a corner beyond the list of positions")?;
                corners.push((*frame * DVec4::new(own[0], own[1], own[2], 1.0)).truncate());
            }
            list_lengths.push(corners.len() - before);
        }
        let counts = match node.children().find(|child| child.has_tag_name("vcount")) {
            Some(counts) => listed(counts)?,
            None if node.has_tag_name("polygons") => list_lengths,
            None => vec![3; corners.len() / 3],
        };
        let mut rest = corners.as_slice();
        for count in counts {
            let (own, further) = rest.split_at_checked(count).ok_or("more polygons than corners")?;
            fan(own, all);
            rest = further;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The corners and faces of a box of 0.1 × 0.2 × 0.3 m with one corner at the origin, counterclockwise from outside.
    const FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

    fn corner(bits: usize) -> [f64; 3] {
        [0.1 * (bits & 1) as f64, 0.2 * (bits >> 1 & 1) as f64, 0.3 * (bits >> 2) as f64]
    }

    fn read(name: &str, bytes: &[u8]) -> Result<Vec<Triangle>, InputError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
        read_triangles(&folder.path().join(name))
    }

    /// Volume within a closed surface by the divergence theorem, and its centre, m.
    fn volume_and_center(triangles: &[Triangle]) -> (f64, DVec3) {
        let parts = triangles.iter().map(|[a, b, c]| (a.dot(b.cross(*c)) / 6.0, (*a + *b + *c) / 4.0));
        let (volume, moment) =
            parts.fold((0.0, DVec3::ZERO), |(volume, moment), (own, center)| (volume + own, moment + center * own));
        (volume, moment / volume)
    }

    fn triangles_of(face: &[usize; 4]) -> [[usize; 3]; 2] {
        [[face[0], face[1], face[2]], [face[0], face[2], face[3]]]
    }

    fn boxes() -> Vec<(&'static str, Vec<u8>)> {
        let mut binary = [vec![0; 80], 12_u32.to_le_bytes().to_vec()].concat();
        let mut text = String::from("solid box\n");
        for triangle in FACES.iter().flat_map(triangles_of) {
            binary.extend([0; 12]);
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(corner) {
                binary.extend([x, y, z].iter().flat_map(|own| (*own as f32).to_le_bytes()));
                text += &format!("vertex {x} {y} {z}\n");
            }
            binary.extend([0; 2]);
            text += "endloop\nendfacet\n";
        }
        let place = |bits| corner(bits).map(|own| own.to_string()).join(" ");
        let mut obj: String = (0..8).map(|bits| format!("v {}\n", place(bits))).collect();
        obj += &FACES.map(|face| format!("f {}\n", face.map(|own| format!("{}//1", own + 1)).join(" "))).concat();
        vec![("box.stl", binary), ("box.STL", text.into_bytes()), ("box.obj", obj.into_bytes())]
    }

    /// A COLLADA file in centimetres whose node moves a box of unit size by (1, 2, 3) cm and scales it to 10 × 20 × 30 cm.
    fn collada_box() -> String {
        let unit = |bits: usize| format!("{} {} {}", bits & 1, bits >> 1 & 1, bits >> 2);
        let corners: Vec<String> = (0..8).map(unit).collect();
        let indices = FACES.map(|face| face.map(|own| format!("{own} 7")).join(" ")).join(" ");
        format!(
            "<COLLADA xmlns=\"x\"><asset><unit meter=\"0.01\"/></asset><library_geometries><geometry id=\"g\"><mesh>\
             <source id=\"p\"><float_array>{}</float_array></source>\
             <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\
             <polylist><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><input semantic=\"NORMAL\" source=\"#n\" offset=\"1\"/>\
             <vcount>4 4 4 4 4 4</vcount><p>{indices}</p></polylist></mesh></geometry></library_geometries>\
             <library_visual_scenes><visual_scene><node><translate>1 2 3</translate>\
             <node><matrix>10 0 0 0 0 20 0 0 0 0 30 0 0 0 0 1</matrix><instance_geometry url=\"#g\"/></node></node>\
             </visual_scene></library_visual_scenes></COLLADA>",
            corners.join(" ")
        )
    }

    /// Tests that a box is the same in all formats: twelve triangles around 6 litres, with the centre in its middle.
    #[test]
    fn a_box_is_a_box_in_every_format() {
        for (name, bytes) in boxes() {
            let triangles = read(name, &bytes).unwrap();
            let (volume, center) = volume_and_center(&triangles);
            // Binary STL is in single precision.
            assert!((volume - 0.006).abs() < 1e-9 && center.abs_diff_eq(DVec3::new(0.05, 0.1, 0.15), 1e-7), "{name}");
            assert_eq!(triangles.len(), 12);
        }
    }

    /// Tests that an STL file that is cut short is called no STL file, and not one without UTF-8.
    #[test]
    fn a_short_stl_is_none() {
        let (name, bytes) = &boxes()[0];
        let error = read(name, &bytes[..bytes.len() - 1]).unwrap_err();
        assert!(error.found.starts_with("neither a binary nor a text STL"), "{error}");
    }

    /// Tests that the unit of a COLLADA file and the transforms of its nodes are applied.
    #[test]
    fn nodes_place_the_parts_of_a_scene() {
        let (volume, center) = volume_and_center(&read("box.dae", collada_box().as_bytes()).unwrap());
        assert!((volume - 0.006).abs() < 1e-12 && center.abs_diff_eq(DVec3::new(0.06, 0.12, 0.18), 1e-12), "{center}");
    }

    /// Tests that a scene that places itself again and again is refused instead of filling memory and stack.
    #[test]
    fn nodes_that_place_themselves_are_refused() {
        let again = "<instance_node url=\"#n\"/>".repeat(3);
        let text = format!("<COLLADA><visual_scene><node id=\"n\">{again}</node></visual_scene></COLLADA>");
        assert!(read("loop.dae", text.as_bytes()).unwrap_err().found.contains("nested nodes"));
    }

    proptest! {
        /// Tests that files with changed bytes are read or refused, and never panic.
        #[test]
        fn damaged_meshes_do_not_panic(at in 0..2000usize, to in any::<u8>(), cut in 0..4000usize) {
            let dae = ("box.dae", collada_box().into_bytes());
            for (name, mut bytes) in boxes().into_iter().chain([dae]) {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = to;
                }
                bytes.truncate(cut);
                let _ = read(name, &bytes);
            }
        }
    }
}
