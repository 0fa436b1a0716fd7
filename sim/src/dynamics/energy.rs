//! The energy of a tree.

use super::Tree;

impl Tree {
    /// Kinetic energy, with that of the armatures, J.
    pub fn kinetic_energy_j(&self) -> f64 {
        let links = (1..self.links.len()).map(|index| {
            let link = &self.links[index];
            let center = self.center_of_mass_world(index);
            let [linear, angular] = self.velocity_at(index, center, |at| self.coordinates[at].velocity);
            let angular_link = link.pose_world.inverse_transform_vector(angular);
            link.mass_kg * linear.length_squared() + angular_link.dot(link.inertia_link * angular_link)
        });
        let armatures = self.coordinates.iter().map(|own| own.spring.armature * own.velocity * own.velocity);
        0.5 * (links.sum::<f64>() + armatures.sum::<f64>())
    }

    /// Energy of the springs and their relaxing branches, and of the links in a field of gravity, J.
    pub fn potential_energy_j(&self, gravity_m_per_s2: f64) -> f64 {
        let springs = self.coordinates.iter().map(|own| {
            let branch =
                own.spring.maxwell.map_or(0.0, |branch| branch.stiffness * (own.position - own.dashpot).powi(2));
            0.5 * (own.spring.stiffness * (own.position - own.rest).powi(2) + branch)
        });
        let weights = (1..self.links.len()).map(|link| self.links[link].mass_kg * self.center_of_mass_world(link).z);
        let weight = if self.weighs { gravity_m_per_s2 * weights.sum::<f64>() } else { 0.0 };
        springs.sum::<f64>() + weight
    }
}
