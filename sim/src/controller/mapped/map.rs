//! What the arm has touched: upright obstacles, each with place, radius and their uncertainty.
//!
//! An obstacle is a capsule with a vertical axis. The state x, y of the axis and radius r has a normal distribution. A
//! touch at a point p of the skin, with the horizontal outward normal n and the tangent t, measures
//!
//! n · (c − p) − r = 0 and t · (c − p) = 0
//!
//! with c = (x, y), both linear in the state, so a Kalman filter is exact. Touches from two sides give the radius.

use glam::{DVec2, DVec3};
use nalgebra::{Matrix3, RowVector3, Vector3};

use super::arm_shapes::ArmShapes;
use crate::geometry::Capsule;
use underbrush_recording::{MappedObstacle, ObstacleKind, Pose, math};

/// Radius of an obstacle before it is known, and its standard deviation, m. Choice: stems of 2 to 5 cm in diameter, as
/// thick as a hand that reaches between them minds.
const RADIUS_M: [f64; 2] = [0.018, 0.006];
/// Smallest and largest radius, m: a twig, and twice the thickest stem of the prior.
const RADII_M: [f64; 2] = [0.005, 0.05];
/// Standard deviation of the place before a touch, m: far more than a touch leaves.
const ANYWHERE_M: f64 = 1.0;
/// Standard deviation of a touch along its normal, m: how deep a skin of a centimetre gives way.
const ALONG_NORMAL_M: f64 = 0.006;
/// Standard deviation of a touch across its normal, m: half the pitch of the coarsest skin that ships.
const ACROSS_NORMAL_M: f64 = 0.012;
/// Standard deviations never fall below this, m: touches of one place share their errors.
const LEAST_M: f64 = 0.004;
/// A normal that is steeper than this says nothing about where the axis is: sine of 12°.
const LEAST_HORIZONTAL: f64 = 0.2;
/// A touch belongs to an obstacle whose surface it is this close to, m. Choice: the diameter of a stem.
const SAME_M: f64 = 0.036;
/// A touch that moves an obstacle by less than this tells nothing new, m.
const NEW_M: f64 = 0.005;
/// What an obstacle grows by if it stops the arm where it was known, m: less than the error of a touch.
const GROWTH_M: f64 = 0.004;
/// An obstacle that was touched is at least this much higher than the touch, m: half a hand's breadth.
const ABOVE_TOUCH_M: f64 = 0.04;
/// Touches of one obstacle closer in time than this are one touch, s.
const ONE_TOUCH_S: f64 = 0.5;
/// An obstacle that reaches this deep into the arm without being felt is not there, m. Choice: more than the error of a
/// touch.
const DEEP_M: f64 = 0.02;

/// A touch of the skin: the middle of some contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Where the skin was touched, m, world frame.
    pub position_world: DVec3,
    /// Outward normal of the skin, world frame.
    pub outward_normal_world: DVec3,
    /// What touched it.
    pub kind: ObstacleKind,
    /// Time, s.
    pub time_s: f64,
}

/// An upright obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// What it is.
    pub kind: ObstacleKind,
    /// x and y of the axis in the world frame and radius, m.
    pub mean_m: Vector3<f64>,
    /// Their covariance, m².
    pub covariance_m2: Matrix3<f64>,
    /// Height of the highest touch, m, world frame; of a known obstacle, of its top.
    pub touched_height_m: f64,
    /// When it was last touched, s.
    pub touched_s: f64,
    /// Whether it was known from the start.
    pub is_known: bool,
    /// Whether the arm has pushed it aside. Then it is no obstacle for this goal, whatever it was called.
    pub has_given_way: bool,
}

/// How cautiously obstacles are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Caution {
    /// Obstacles are as thin as a standard deviation of place and radius allows.
    pub is_thin: bool,
    /// Obstacles end a little above the highest touch.
    pub is_low: bool,
}

impl Obstacle {
    /// The obstacle after its first touch.
    fn new(touch: &Touch) -> Self {
        let [radius_m, deviation_m] = RADIUS_M;
        let deviations_m = Vector3::new(ANYWHERE_M, ANYWHERE_M, deviation_m);
        let mut own = Obstacle {
            kind: touch.kind,
            mean_m: Vector3::new(touch.position_world.x, touch.position_world.y, radius_m),
            covariance_m2: Matrix3::from_diagonal(&deviations_m.component_mul(&deviations_m)),
            touched_height_m: touch.position_world.z,
            touched_s: touch.time_s,
            is_known: false,
            has_given_way: false,
        };
        own.measure(touch);
        own
    }

    /// Position of the axis, m, world frame.
    pub fn axis_world(&self) -> DVec2 {
        DVec2::new(self.mean_m.x, self.mean_m.y)
    }

    /// Radius, m.
    pub fn radius_m(&self) -> f64 {
        self.mean_m.z.clamp(RADII_M[0], RADII_M[1])
    }

    /// Takes in a touch; returns how far the axis moved and the radius grew, m.
    fn measure(&mut self, touch: &Touch) -> f64 {
        let before = self.mean_m;
        let normal = touch.outward_normal_world;
        let point = touch.position_world;
        let length = math::hypot(normal.x, normal.y);
        // A steep normal has no direction along which the axis is known better. The deviations are then those of the world's x
        // and y, so what such a touch tells depends on how the base is turned. Both are far below the diameter of a stem.
        let rows = match length < LEAST_HORIZONTAL {
            true => [(RowVector3::new(1.0, 0.0, 0.0), point.x), (RowVector3::new(0.0, 1.0, 0.0), point.y)],
            false => {
                let [x, y] = [normal.x / length, normal.y / length];
                [
                    (RowVector3::new(x, y, -1.0), x * point.x + y * point.y),
                    (RowVector3::new(-y, x, 0.0), -y * point.x + x * point.y),
                ]
            }
        };
        for ((row, measured), deviation_m) in rows.into_iter().zip([ALONG_NORMAL_M, ACROSS_NORMAL_M]) {
            let gain = self.covariance_m2 * row.transpose();
            let variance = (row * gain).x + deviation_m * deviation_m;
            self.mean_m += gain * ((measured - (row * self.mean_m).x) / variance);
            self.covariance_m2 -= gain * gain.transpose() / variance;
        }
        for axis in 0..3 {
            self.covariance_m2[(axis, axis)] = self.covariance_m2[(axis, axis)].max(LEAST_M * LEAST_M);
        }
        self.mean_m.z = self.radius_m();
        (self.mean_m - before).norm()
    }

    /// The obstacle as a planner sees it. It stands on the ground; its top is at `top_m`, world frame, or a little above
    /// the highest touch if that is higher, unless it is seen as low or known.
    pub fn capsule(&self, caution: Caution, top_m: f64) -> Capsule {
        let is_thin = caution.is_thin && !self.is_known;
        let thinner_m = if is_thin { self.covariance_m2.diagonal().max().sqrt() } else { 0.0 };
        let radius_m = (self.radius_m() - thinner_m).max(RADII_M[0]);
        let least_m = self.touched_height_m + ABOVE_TOUCH_M;
        let top_m = match (self.is_known, caution.is_low) {
            (true, _) => self.touched_height_m,
            (false, true) => least_m,
            (false, false) => top_m.max(least_m),
        };
        let at = |height_m: f64| DVec3::new(self.mean_m.x, self.mean_m.y, height_m);
        Capsule { start: at(top_m - DEPTH_M), end: at(top_m - radius_m), radius_m }
    }
}

/// How far an obstacle reaches down from its top, m: beyond any table.
const DEPTH_M: f64 = 2.0;

/// The obstacles that are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map {
    /// The obstacles, the one that was touched last at the end.
    pub obstacles: Vec<Obstacle>,
}

impl Map {
    /// The obstacle that a touch belongs to.
    fn at(&self, touch: &Touch) -> Option<usize> {
        let place = DVec2::new(touch.position_world.x, touch.position_world.y);
        let gaps_m = self.obstacles.iter().map(|own| own.axis_world().distance(place) - own.radius_m());
        let nearest = gaps_m.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, gap_m)| *gap_m < SAME_M).map(|(index, _)| index)
    }

    /// Takes in that what is touched has given way.
    pub(super) fn give_way(&mut self, touch: &Touch) {
        if let Some(index) = self.at(touch) {
            self.obstacles[index].has_given_way |= !self.obstacles[index].is_known;
        }
    }

    /// Takes in a touch; returns whether it tells something new. What stopped the arm has not given way.
    pub fn learn(&mut self, touch: &Touch, has_stopped: bool) -> bool {
        let Some(index) = self.at(touch) else {
            self.obstacles.push(Obstacle::new(touch));
            return true;
        };
        if self.obstacles[index].is_known {
            return false;
        }
        let mut own = self.obstacles.remove(index);
        if own.has_given_way {
            // It is where it was touched last, wherever the arm has pushed it.
            self.obstacles.push(Obstacle { has_given_way: !has_stopped, ..Obstacle::new(touch) });
            return has_stopped;
        }
        let is_one_touch = !has_stopped && touch.time_s - own.touched_s < ONE_TOUCH_S;
        // A later verdict corrects an earlier one; a stop without a verdict does not.
        let is_corrected = touch.kind != ObstacleKind::Doubtful && touch.kind != own.kind;
        if is_corrected {
            own.kind = touch.kind;
        }
        own.touched_height_m = own.touched_height_m.max(touch.position_world.z);
        own.touched_s = touch.time_s;
        let moved_m = if is_one_touch { 0.0 } else { own.measure(touch) };
        let mut is_news = is_corrected || moved_m >= NEW_M;
        if has_stopped && !is_news && own.mean_m.z < RADII_M[1] {
            // It stopped the arm where it was known: it is larger than it seemed.
            own.mean_m.z = (own.mean_m.z + GROWTH_M).min(RADII_M[1]);
            is_news = true;
        }
        self.obstacles.push(own);
        is_news
    }

    /// Forgets what gives way: a new goal begins.
    pub fn begin_goal(&mut self) {
        self.obstacles.retain(|own| own.kind != ObstacleKind::Yielding && !own.has_given_way);
    }

    /// Forgets one obstacle, what gives way first, then what is doubtful, and of these the one that was touched longest
    /// ago. The obstacle that was touched last is kept, because the arm would run into it at once. Returns whether one
    /// was forgotten.
    pub fn forget_one(&mut self) -> bool {
        let learnt = (0..self.obstacles.len().saturating_sub(1)).filter(|index| !self.obstacles[*index].is_known);
        let first = learnt.min_by_key(|index| (self.obstacles[*index].kind, *index));
        first.map(|index| self.obstacles.remove(index)).is_some()
    }

    /// Takes in that the arm is in a posture. An obstacle cannot be where the arm is: one that it feels has given way, and
    /// one that it does not feel has moved or was never there, and is forgotten.
    pub fn visit(&mut self, shapes: &ArmShapes, link_poses: &[Pose], top_m: f64, time_s: f64) {
        let is_felt = |own: &Obstacle| time_s - own.touched_s < ONE_TOUCH_S;
        self.obstacles.retain_mut(|own| {
            let core = Capsule { radius_m: (own.radius_m() - DEEP_M).max(0.0), ..own.capsule(Caution::NONE, top_m) };
            let low = Capsule { end: core.end.with_z(own.touched_height_m.min(core.end.z)), ..core };
            let is_inside = !own.is_known && shapes.distance_m(link_poses, &low) <= 0.0;
            own.has_given_way |= is_inside && is_felt(own);
            !is_inside || is_felt(own)
        });
    }

    /// The obstacles as a planner sees them.
    pub fn capsules(&self, caution: Caution, top_m: f64) -> Vec<Capsule> {
        self.obstacles.iter().filter(|own| !own.has_given_way).map(|own| own.capsule(caution, top_m)).collect()
    }

    /// The obstacles in the form that recordings hold, without those that have given way.
    pub(super) fn described(&self, top_m: f64) -> Vec<MappedObstacle> {
        let describe = |own: &Obstacle| {
            let capsule = own.capsule(Caution::NONE, top_m);
            MappedObstacle {
                kind: own.kind,
                top_world: capsule.end + DVec3::Z * capsule.radius_m,
                radius_m: capsule.radius_m,
                deviation_m: own.covariance_m2.fixed_view::<2, 2>(0, 0).symmetric_eigenvalues().max().max(0.0).sqrt(),
                first_frame: 0,
                last_frame: 0,
            }
        };
        self.obstacles.iter().filter(|own| !own.has_given_way).map(describe).collect()
    }
}

impl Caution {
    /// Obstacles as they are estimated.
    pub const NONE: Caution = Caution { is_thin: false, is_low: false };
}
