//! Motions, forces and inertias of rigid bodies about one point.

use glam::{DMat3, DVec3};

/// A motion (angular velocity, and velocity of the point), or a force (moment about the point, and force).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spatial {
    pub(super) angular: DVec3,
    pub(super) linear: DVec3,
}

impl Spatial {
    /// Power of a force under a motion.
    pub(super) fn dot(&self, other: &Spatial) -> f64 {
        self.angular.dot(other.angular) + self.linear.dot(other.linear)
    }

    pub(super) fn add(&mut self, other: &Spatial) {
        self.angular += other.angular;
        self.linear += other.linear;
    }

    pub(super) fn add_scaled(&mut self, other: &Spatial, factor: f64) {
        self.angular += other.angular * factor;
        self.linear += other.linear * factor;
    }
}

/// The inertia of a body, or of several, about the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia {
    pub(super) mass_kg: f64,
    /// Mass times centre of mass, kg m.
    pub(super) moment: DVec3,
    /// About the point, kg m².
    pub(super) inertia: DMat3,
}

impl Inertia {
    /// Of a body with its centre of mass at `center` and `inertia` about it.
    pub(super) fn new(mass_kg: f64, center: DVec3, inertia: DMat3) -> Self {
        let moment = center * mass_kg;
        let outer = DMat3::from_cols(center * moment.x, center * moment.y, center * moment.z);
        let shift = DMat3::from_diagonal(DVec3::splat(moment.dot(center))) - outer;
        Inertia { mass_kg, moment, inertia: inertia + shift }
    }

    pub(super) fn add(&mut self, other: &Inertia) {
        self.mass_kg += other.mass_kg;
        self.moment += other.moment;
        self.inertia += other.inertia;
    }

    /// The momentum of a motion.
    pub(super) fn times(&self, motion: &Spatial) -> Spatial {
        Spatial {
            angular: self.inertia * motion.angular + self.moment.cross(motion.linear),
            linear: motion.linear * self.mass_kg + motion.angular.cross(self.moment),
        }
    }
}
