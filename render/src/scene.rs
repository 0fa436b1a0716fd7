//! What is drawn at one moment, and drawing it.

use glam::{DMat3, Vec3};
use underbrush_recording::Pose;

use crate::camera::{NEAREST_M, View};
use crate::colour::{self, LAMP, light_on};
use crate::mesh::Mesh;
use crate::raster::{Buffer, NOTHING};
use crate::shadow::Shadows;
use crate::{Camera, RenderError, Size};

/// Points of a picture for each of its pixels, along each axis.
const SAMPLES: usize = 2;
/// Rows that are drawn at once. Choice: they fit into the cache of a core; a multiple of the samples.
const ROWS: usize = 64;
/// Distance of the lines on the table, m.
const GRID_M: f32 = 0.1;
/// Width of these lines, m.
const LINE_M: f32 = 0.003;
/// How much darker these lines are, as a share.
const DARKER: f32 = 0.16;

/// What kind of surface it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The outside of a body.
    Solid,
    /// A blade, which is seen and lit from both sides.
    Thin,
    /// The table, which casts no shadow.
    Table,
    /// A mark, as of a taxel: it is only in coloured pictures, and always has its own colour.
    Mark,
}

#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub kind: Kind,
    /// Linear light.
    pub colour: Vec3,
    /// What a picture of segmentation shows.
    pub label: u16,
}

/// A corner of a triangle, with the light from all around and from the lamp.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub place: Vec3,
    light: [f32; 2],
}

/// All surfaces at one moment, in the world frame.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    corners: Vec<Corner>,
    triangles: Vec<([u32; 3], u32)>,
    surfaces: Vec<Surface>,
}

/// A triangle in the picture.
struct Face<'a> {
    surface: &'a Surface,
    corners: [Vec3; 3],
    /// Normal of the side that can be lit.
    normal: Vec3,
    /// Light from all around and from the lamp: at the origin of the picture, and its change to the right and down.
    light: [Vec3; 2],
}

impl Scene {
    /// Adds a mesh at this pose.
    pub(crate) fn add(&mut self, mesh: &Mesh, pose: &Pose, surface: Surface) {
        let first = self.corners.len() as u32;
        let (turn, thin) = (DMat3::from_quat(pose.orientation), surface.kind == Kind::Thin);
        let mark = surface.kind == Kind::Mark;
        self.corners.extend(mesh.vertices.iter().map(|(place, normal)| Corner {
            place: (turn * *place + pose.position).as_vec3(),
            light: if mark { [1.0, 0.0] } else { light_on((turn * *normal).as_vec3(), thin) },
        }));
        let own = self.surfaces.len() as u32;
        let corners = mesh.triangles.iter().map(|corners| corners.map(|corner| first + corner));
        self.triangles.extend(corners.map(|corners| (corners, own)));
        self.surfaces.push(surface);
    }

    /// The triangles whose surfaces are of some kind.
    pub(crate) fn triangles(&self, of: impl Fn(Kind) -> bool) -> impl Iterator<Item = (&Surface, [Corner; 3])> {
        self.triangles.iter().filter_map(move |(corners, own)| {
            let surface = &self.surfaces[*own as usize];
            of(surface.kind).then(|| (surface, corners.map(|corner| self.corners[corner as usize])))
        })
    }

    /// A coloured picture: red, green and blue of each pixel, row by row from the top.
    ///
    /// # Errors
    /// [`RenderError::Size`] and [`RenderError::Camera`].
    pub fn rgb(&self, camera: &Camera, size: Size) -> Result<Vec<u8>, RenderError> {
        let view = camera.view(size, SAMPLES)?;
        let faces = self.faces(&view, |_| true);
        let casting = self.triangles(|kind| matches!(kind, Kind::Solid | Kind::Thin));
        let casting: Vec<[Vec3; 3]> = casting.map(|(_, corners)| corners.map(|corner| corner.place)).collect();
        let shadows = Shadows::of(&casting, 3 * size.width.max(size.height) / 2);
        let ground = colour::linear(colour::GROUND);
        let (width, height) = (SAMPLES * size.width, SAMPLES * size.height);
        let mut picture = Vec::with_capacity(3 * size.width * size.height);
        for top in (0..height).step_by(ROWS) {
            let rows = top..(top + ROWS).min(height);
            let buffer = Buffer::of(width, rows.clone(), faces.iter().map(|face| face.corners));
            for pixel in 0..size.width * rows.len() / SAMPLES {
                let (x, y) = (SAMPLES * (pixel % size.width), SAMPLES * (pixel / size.width));
                let (mut sum, mut last) = (Vec3::ZERO, (NOTHING, ground));
                for (row, column) in (y..y + SAMPLES).flat_map(|row| (x..x + SAMPLES).map(move |column| (row, column)))
                {
                    let place = row * width + column;
                    // Within a pixel a triangle has one colour, which saves most of the work.
                    if buffer.face[place] != last.0 {
                        let at = [column as f32 + 0.5, (top + row) as f32 + 0.5];
                        let face = faces.get(buffer.face[place] as usize);
                        let colour = face.map(|face| face.colour(&view, at, buffer.near[place], &shadows));
                        last = (buffer.face[place], colour.unwrap_or(ground));
                    }
                    sum += last.1;
                }
                picture.extend(colour::shown(sum / (SAMPLES * SAMPLES) as f32));
            }
        }
        Ok(picture)
    }

    /// A coloured picture as PNG.
    ///
    /// # Errors
    /// As [`Scene::rgb`], and [`RenderError::Encoding`].
    pub fn png(&self, camera: &Camera, size: Size) -> Result<Vec<u8>, RenderError> {
        png(&self.rgb(camera, size)?, size)
    }

    /// For each pixel its depth, m along the line of sight of the picture's middle, and the place of the name of what is there
    /// in [`crate::Stage::labels`]. Where nothing is, depth is infinite. Marks are left out.
    ///
    /// # Errors
    /// [`RenderError::Size`] and [`RenderError::Camera`].
    pub fn depth_and_labels(&self, camera: &Camera, size: Size) -> Result<(Vec<f32>, Vec<u16>), RenderError> {
        let faces = self.faces(&camera.view(size, 1)?, |kind| kind != Kind::Mark);
        let buffer = Buffer::of(size.width, 0..size.height, faces.iter().map(|face| face.corners));
        let labels = buffer.face.iter().map(|face| faces.get(*face as usize).map_or(0, |face| face.surface.label));
        Ok((buffer.near.iter().map(|near| 1.0 / near).collect(), labels.collect()))
    }

    /// The triangles of some kinds that face the camera, in the picture.
    fn faces(&self, view: &View, of: impl Fn(Kind) -> bool) -> Vec<Face<'_>> {
        let mut faces = Vec::new();
        for (surface, corners) in self.triangles(of) {
            let normal = (corners[1].place - corners[0].place).cross(corners[2].place - corners[0].place);
            let thin = surface.kind == Kind::Thin;
            if !thin && normal.dot(corners[0].place - view.eye) >= 0.0 {
                continue;
            }
            let normal = if thin && normal.dot(LAMP) < 0.0 { -normal } else { normal }.normalize_or_zero();
            let clipped = clip(&corners.map(|corner| (view.seen(corner.place), corner.light)));
            let shown: Vec<_> = clipped.iter().map(|(seen, light)| (view.project(*seen), *light)).collect();
            for last in 2..shown.len() {
                let corners = [shown[0], shown[last - 1], shown[last]];
                let light = [0, 1].map(|which| slope(corners.map(|(place, light)| (place, light[which]))));
                faces.push(Face { surface, corners: corners.map(|corner| corner.0), normal, light });
            }
        }
        faces
    }
}

impl Face<'_> {
    /// Its colour at this point of the picture, which is so near.
    fn colour(&self, view: &View, at: [f32; 2], near: f32, shadows: &Shadows) -> Vec3 {
        let Surface { kind, colour, .. } = *self.surface;
        if kind == Kind::Mark {
            return colour;
        }
        let [around, direct] = self.light.map(|light| light.dot(Vec3::new(1.0, at[0], at[1])));
        let place = view.place(at, near);
        let lit = if direct > 0.0 { direct * shadows.lit(place, self.normal) } else { 0.0 };
        let lined = kind == Kind::Table && self.normal.z > 0.9;
        let line = if lined { DARKER * grid(place, SAMPLES as f32 / (near * view.focal)) } else { 0.0 };
        colour * (around + lit) * (1.0 - line)
    }
}

/// Red, green and blue of each pixel as PNG.
///
/// # Errors
/// [`RenderError::Encoding`].
pub fn png(rgb: &[u8], size: Size) -> Result<Vec<u8>, RenderError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.width as u32, size.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(rgb));
    written.map_err(|error| RenderError::Encoding(error.to_string()))?;
    Ok(bytes)
}

/// The part of a triangle that is before the camera, as a polygon.
fn clip(corners: &[(Vec3, [f32; 2]); 3]) -> Vec<(Vec3, [f32; 2])> {
    let mut kept = Vec::with_capacity(4);
    for (index, (from, light)) in corners.iter().enumerate() {
        let (to, other) = &corners[(index + 1) % 3];
        let (a, b) = (from.z - NEAREST_M, to.z - NEAREST_M);
        if a >= 0.0 {
            kept.push((*from, *light));
        }
        if (a >= 0.0) != (b >= 0.0) {
            let share = a / (a - b);
            let mixed = [0, 1].map(|which| light[which] + (other[which] - light[which]) * share);
            kept.push((*from + (*to - *from) * share, mixed));
        }
    }
    kept
}

/// A number that is known at three points of the picture, as a linear function of it.
fn slope([(a, of_a), (b, of_b), (c, of_c)]: [(Vec3, f32); 3]) -> Vec3 {
    let (u, v) = (b - a, c - a);
    let area = u.x * v.y - v.x * u.y;
    let (p, q) = (of_b - of_a, of_c - of_a);
    if p == 0.0 && q == 0.0 || area == 0.0 {
        return Vec3::new(of_a, 0.0, 0.0);
    }
    let (per_x, per_y) = ((p * v.y - q * u.y) / area, (u.x * q - v.x * p) / area);
    Vec3::new(of_a - per_x * a.x - per_y * a.y, per_x, per_y)
}

/// How much of a pixel of this size, m, is on a line of the table.
fn grid(place: Vec3, pixel_m: f32) -> f32 {
    let line = |along: f32| {
        let off = along - GRID_M * (along / GRID_M).round();
        ((0.5 * LINE_M - off.abs()) / pixel_m + 0.5).clamp(0.0, (LINE_M / pixel_m).min(1.0))
    };
    line(place.x).max(line(place.y))
}
