//! Contact regions of a patch, followed from frame to frame.

use glam::{DMat3, DVec3};
use underbrush_recording::Pose;

use super::contact_history::{Course, Measure};
use crate::frequency::largest;
use crate::trial::{PatchImage, neighbours_of_patch};

/// A region continues the region of the last frame that gets the most votes. Each taxel votes with its force for the
/// region that it belonged to, and with this share of its force for the region of each neighbour.
const NEIGHBOUR_WEIGHT: f64 = 0.1;

/// Neighbouring taxels in contact.
#[derive(Clone, Debug)]
pub struct Region {
    /// Number of the contact. A contact keeps its number while it slides over the skin.
    pub contact: u64,
    /// Its forces and motions since the contact began.
    pub course: Course,
    /// The range of its taxels in [`RegionTracker::taxels`].
    pub(super) taxels: std::ops::Range<usize>,
}

/// The contact regions of a patch. Nothing is allocated after the first frames.
#[derive(Clone, Debug)]
pub(super) struct RegionTracker {
    /// The neighbours of each taxel.
    pub neighbours: Vec<Vec<usize>>,
    /// Region of each taxel, now and in the last frame.
    region_of: Vec<Option<usize>>,
    region_before: Vec<Option<usize>>,
    /// The regions of the last frame.
    pub regions: Vec<Region>,
    /// The regions of the frame before the last one.
    before: Vec<Region>,
    /// The taxels of one region after the other.
    pub taxels: Vec<usize>,
    /// The votes of a region for each region of the last frame, N.
    votes: Vec<f64>,
    /// For each region of the last frame: the region with the most votes for it, and these votes, N.
    heirs: Vec<(usize, f64)>,
    contacts: u64,
}

impl RegionTracker {
    /// Regions of the patch of an image, none so far.
    pub fn new(image: &PatchImage) -> Self {
        let neighbours = neighbours(image);
        let count = neighbours.len();
        RegionTracker {
            neighbours,
            region_of: vec![None; count],
            region_before: vec![None; count],
            regions: Vec::with_capacity(count),
            before: Vec::with_capacity(count),
            taxels: Vec::with_capacity(count),
            votes: Vec::with_capacity(count),
            heirs: Vec::with_capacity(count),
            contacts: 0,
        }
    }

    /// Finds the regions of the frame that the image holds, which was sensed at `time_s`. `motion` is the motion of the
    /// patch since the last frame.
    pub fn update(&mut self, image: &PatchImage, motion: &Motion, time_s: f64) {
        std::mem::swap(&mut self.regions, &mut self.before);
        std::mem::swap(&mut self.region_of, &mut self.region_before);
        self.find(image);
        self.continue_contacts(image);
        let pose = image.pose_world();
        for region in &mut self.regions {
            let taxels = &self.taxels[region.taxels.clone()];
            region.course.push(&measure(image, taxels, motion, &pose), time_s);
        }
    }

    fn find(&mut self, image: &PatchImage) {
        self.region_of.fill(None);
        self.regions.clear();
        self.taxels.clear();
        for first in 0..self.neighbours.len() {
            if self.region_of[first].is_some() || !image.is_in_contact(first) {
                continue;
            }
            let region = self.regions.len();
            let start = self.taxels.len();
            self.region_of[first] = Some(region);
            self.taxels.push(first);
            let mut next = start;
            while let Some(taxel) = self.taxels.get(next).copied() {
                next += 1;
                for &neighbour in &self.neighbours[taxel] {
                    if self.region_of[neighbour].is_none() && image.is_in_contact(neighbour) {
                        self.region_of[neighbour] = Some(region);
                        self.taxels.push(neighbour);
                    }
                }
            }
            self.regions.push(Region { contact: 0, course: Course::default(), taxels: start..next });
        }
    }

    /// Gives each region the course of the region that it continues. If several continue the same region, all get its
    /// course, and the one with the most votes also gets its number.
    fn continue_contacts(&mut self, image: &PatchImage) {
        self.heirs.clear();
        self.heirs.resize(self.before.len(), (usize::MAX, 0.0));
        for (index, region) in self.regions.iter_mut().enumerate() {
            self.votes.clear();
            self.votes.resize(self.before.len(), 0.0);
            for &taxel in &self.taxels[region.taxels.clone()] {
                let force_n = image.sensed_force_n(taxel);
                if let Some(before) = self.region_before[taxel] {
                    self.votes[before] += force_n;
                }
                for before in self.neighbours[taxel].iter().filter_map(|neighbour| self.region_before[*neighbour]) {
                    self.votes[before] += NEIGHBOUR_WEIGHT * force_n;
                }
            }
            let most = largest(self.votes.iter().copied().enumerate());
            if let Some((before, votes)) = most.filter(|(_, votes)| *votes > 0.0) {
                region.course = self.before[before].course;
                if votes > self.heirs[before].1 {
                    self.heirs[before] = (index, votes);
                }
            }
        }
        for (before, (heir, _)) in self.before.iter().zip(&self.heirs) {
            if let Some(region) = self.regions.get_mut(*heir) {
                region.contact = before.contact;
            }
        }
        for region in self.regions.iter_mut().filter(|region| region.contact == 0) {
            self.contacts += 1;
            region.contact = self.contacts;
        }
    }
}

/// The neighbours of each taxel of a patch: those of its grid or, without a grid, taxels that face the same side and are
/// nearly as close as the nearest one.
fn neighbours(image: &PatchImage) -> Vec<Vec<usize>> {
    if let Ok(of_grid) = neighbours_of_patch(image) {
        return of_grid.into_iter().map(|own| own.into_iter().flatten().collect()).collect();
    }
    let taxels = &image.patch().taxels;
    let distance = |one: usize, other: usize| {
        let faces = taxels[one].normal_link.dot(taxels[other].normal_link) > 0.0;
        if faces && one != other {
            taxels[one].position_link.distance(taxels[other].position_link)
        } else {
            f64::INFINITY
        }
    };
    let nearest_to = |one| (0..taxels.len()).map(|other| distance(one, other)).fold(f64::INFINITY, f64::min);
    let nearest: Vec<f64> = (0..taxels.len()).map(nearest_to).collect();
    let near =
        |one: usize, other: usize| distance(one, other) <= NEARLY * nearest[one].max(nearest[other]).min(f64::MAX);
    (0..taxels.len()).map(|one| (0..taxels.len()).filter(|other| near(one, *other)).collect()).collect()
}

/// How much farther than the nearest taxel a neighbour may be, on a patch without a grid. Choice: the diagonal of a square
/// counts, twice the distance does not.
const NEARLY: f64 = 1.5;

/// Forces and motion of a region in one frame.
fn measure(image: &PatchImage, taxels: &[usize], motion: &Motion, now: &Pose) -> Measure {
    let mut measure = Measure { taxels: taxels.len() as f64, ..Measure::default() };
    let (mut step, mut center, mut normal) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for &taxel in taxels {
        let force_n = image.sensed_force_n(taxel);
        let place = &image.patch().taxels[taxel];
        let moved = motion.of(place.position_link);
        let pressed_m = moved.dot(place.normal_link);
        measure.largest_force_n = measure.largest_force_n.max(force_n);
        measure.force_n += force_n;
        measure.press_m += force_n * pressed_m;
        step += force_n * (moved - place.normal_link * pressed_m);
        center += force_n * place.position_link;
        normal += force_n * place.normal_link;
    }
    let center_link = center / measure.force_n;
    let square = |taxel: &usize| {
        let place = image.patch().taxels[*taxel].position_link;
        image.sensed_force_n(*taxel) * place.distance_squared(center_link)
    };
    measure.extent_m = (taxels.iter().map(square).sum::<f64>() / measure.force_n).sqrt();
    measure.press_m /= measure.force_n;
    measure.slide_m = step.length() / measure.force_n;
    measure.center_link = center_link;
    measure.center_world = now.transform_point(center_link);
    measure.normal_world = now.transform_vector(normal / measure.force_n);
    measure
}

/// The motion of a link between two frames, in the axes of the link at the later frame. These are enough for lengths
/// and for components along normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    turn: DMat3,
    shift_link: DVec3,
}

impl Motion {
    pub(super) fn between(before: &Pose, now: &Pose) -> Self {
        let to_link = now.orientation.inverse();
        Motion {
            turn: DMat3::IDENTITY - DMat3::from_quat(to_link * before.orientation),
            shift_link: to_link * (now.position - before.position),
        }
    }

    /// How far a point that is fixed to the link has moved, m.
    pub(super) fn of(&self, point_link: DVec3) -> DVec3 {
        self.turn * point_link + self.shift_link
    }
}
