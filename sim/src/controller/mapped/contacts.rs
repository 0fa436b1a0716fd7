//! The contacts of one instant as the mapped controller sees them: what kind they are, how hard they may be pressed, and
//! where the skin was touched.

use glam::DVec3;
use nalgebra::Vector3;
use underbrush_recording::ObstacleKind;

use super::arm_shapes::distance_rad;
use super::map::Touch;
use crate::controller::{TaxelContact, Touched};

/// Readings below this are no touch, N: ten times the noise of the skin that ships.
const TOUCH_N: f64 = 0.3;
/// Taxels closer to each other than this belong to one touch, m: a little more than the thickest stem of the prior.
const ONE_TOUCH_M: f64 = 0.05;
/// A motion that takes the taxel away from what presses on it at more than this, m/rad, is no motion into the contact.
const AWAY_M_PER_RAD: f64 = 0.02;

/// A contact with its kind and its limit.
#[derive(Clone, Copy)]
pub(super) struct Judged<'a> {
    pub(super) contact: &'a TaxelContact,
    pub(super) kind: ObstacleKind,
    pub(super) limit_n: f64,
}

/// What gives way may be pressed by so many times the usual limit, as leaves may. Choice: so may what a model does not call
/// fixed, although it is not certain what it is or does not know it, because fixed objects are soon called so.
pub(super) const GIVES_WAY: f64 = 2.0;

/// The kinds and limits of contacts. `usual_n` is the limit where no verdict gives another. An object that is to be
/// pressed less than that is fixed, one that may be pressed as much or more gives way. `knows_all` says that all fixed
/// objects are known, so everything else gives way.
pub(super) fn judged(contacts: &[TaxelContact], usual_n: f64, knows_all: bool) -> Vec<Judged<'_>> {
    contacts.iter().map(|contact| judge(contact, usual_n, knows_all)).collect()
}

fn judge(contact: &TaxelContact, usual_n: f64, knows_all: bool) -> Judged<'_> {
    let TaxelContact { verdict, allowed_force_n, .. } = contact;
    let is_named = matches!(verdict, Some(verdict) if matches!(verdict.touched, Touched::Category(_)));
    let (kind, limit_n) = match *allowed_force_n {
        Some(allowed_n) if is_named && allowed_n < usual_n => (ObstacleKind::Fixed, allowed_n),
        Some(allowed_n) if is_named => (ObstacleKind::Yielding, allowed_n),
        _ if knows_all => (ObstacleKind::Yielding, GIVES_WAY * usual_n),
        Some(allowed_n) => (ObstacleKind::Doubtful, allowed_n),
        None if verdict.is_some() && !is_named => (ObstacleKind::Doubtful, GIVES_WAY * usual_n),
        None => (ObstacleKind::Doubtful, usual_n),
    };
    Judged { contact, kind, limit_n }
}

/// The largest force as a share of its limit, of the contacts into which a change of the joint angles moves; of all
/// contacts if there is no change.
pub(super) fn largest_share(judged: &[Judged], change_rad: &[f64]) -> f64 {
    let size = distance_rad(change_rad, &vec![0.0; change_rad.len()]);
    let is_into = |own: &&Judged| {
        let normal = own.contact.inward_normal_world;
        let push = own.contact.position_jacobian.tr_mul(&Vector3::new(normal.x, normal.y, normal.z));
        let along: f64 = push.iter().zip(change_rad).map(|(push, change)| push * change).sum();
        size < 1e-9 || along / size < AWAY_M_PER_RAD
    };
    judged.iter().filter(is_into).map(|own| own.contact.force_n / own.limit_n).fold(0.0, f64::max)
}

/// The touches of contacts of one kind, the strongest first, each with the largest force of a taxel, N.
pub(super) fn touches(judged: &[Judged], kind: ObstacleKind, time_s: f64) -> Vec<(f64, Touch)> {
    let felt = judged.iter().filter(|own| own.kind == kind && own.contact.force_n > TOUCH_N);
    let mut left: Vec<&TaxelContact> = felt.map(|own| own.contact).collect();
    left.sort_by(|a, b| b.force_n.total_cmp(&a.force_n));
    let mut touches = Vec::new();
    while let Some(strongest) = left.first().copied() {
        let is_near = |own: &&TaxelContact| own.position_world.distance(strongest.position_world) < ONE_TOUCH_M;
        let (near, far): (Vec<_>, Vec<_>) = left.into_iter().partition(is_near);
        let total_n: f64 = near.iter().map(|own| own.force_n).sum();
        let position_world = near.iter().map(|own| own.position_world * own.force_n).sum::<DVec3>() / total_n;
        let normal = near.iter().map(|own| -own.inward_normal_world * own.force_n).sum::<DVec3>();
        let outward_normal_world = normal.normalize_or(-strongest.inward_normal_world);
        touches.push((strongest.force_n, Touch { position_world, outward_normal_world, kind, time_s }));
        left = far;
    }
    touches
}
