"""The quasi-static force of a smooth elastic blade on a round forearm that passes it: Euler's elastica with its own
weight, a springy root and Coulomb friction. It has no hinges, no inertia and no contact solver."""

import math

import numpy as np

STEPS = 40


class Blade:
    """A blade that stands upright at x = 0 and a forearm of radius `radius_m` at the height `forearm_height_m`, whose axis is
    at right angles to the plane x, z. Angles are from the vertical towards x."""

    def __init__(self, leaf, half_thickness_m, radius_m, forearm_height_m, friction, gravity_m_per_s2):
        self.height = leaf["height_m"]
        self.rigidity = leaf["flexural_rigidity_n_m2"]
        self.root_compliance = 1 / leaf["root_stiffness_nm_per_rad"]
        self.weight_n_per_m = gravity_m_per_s2 * leaf["mass_per_area_kg_per_m2"] * leaf["width_m"]
        self.half_thickness, self.radius, self.forearm_height = half_thickness_m, radius_m, forearm_height_m
        self.friction = friction

    def slopes(self, s, state, force):
        """Derivatives along the blade, upwards, of its angle, its bending moment, and its position x, z."""
        angle, moment = state[:2]
        sine, cosine = math.sin(angle), math.cos(angle)
        down = force[1] - self.weight_n_per_m * (self.height - s)
        return np.array([moment / self.rigidity, sine * down - cosine * force[0], sine, cosine])

    def integrate(self, state, start, end, force):
        step = (end - start) / STEPS
        for number in range(STEPS):
            s = start + number * step
            first = self.slopes(s, state, force)
            second = self.slopes(s + step / 2, state + step / 2 * first, force)
            third = self.slopes(s + step / 2, state + step / 2 * second, force)
            fourth = self.slopes(s + step, state + step * third, force)
            state = state + step / 6 * (first + 2 * second + 2 * third + fourth)
        return state

    def solve(self, tip_angle, normal_force, place):
        """Integrates from the tip to the root. `place` says where the forearm touches: if negative, on the face, that
        far from the tip in m; if positive, at the tip's edge, with the forearm's surface at that angle to the face.
        Returns the forearm's middle, the force on the forearm, and the angle by which the root misses the equilibrium
        of its spring, rad."""
        state = np.array([tip_angle, 0.0, 0.0, 0.0])
        at = self.height + min(place, 0)
        state = self.integrate(state, self.height, at, (0.0, 0.0))
        angle = state[0]
        out = np.array([math.cos(angle), -math.sin(angle)])
        surface = angle + max(place, 0)
        normal = np.array([math.cos(surface), -math.sin(surface)])
        # The blade slides towards its root, so that friction pulls it towards its tip.
        force = normal_force * (normal + self.friction * np.array([math.sin(surface), math.cos(surface)]))
        arm = -self.half_thickness * out
        middle = state[2:] + arm - self.radius * normal
        state[1] += arm[1] * force[0] - arm[0] * force[1]
        root = self.integrate(state, at, 0.0, force)
        return middle - root[2:], -force, root[0] - self.root_compliance * root[1]

    def misses(self, unknowns, x):
        middle, _, miss = self.solve(*unknowns)
        return np.array([middle[0] - x, middle[1] - self.forearm_height, miss])

    def forces(self, step_m):
        """Positions x of the forearm's middle, m, in steps from the first touch, and the force on it, N, along x and z,
        until there is no equilibrium and the blade slips off. The last position is within a thousandth of a step of
        that point."""
        first = -self.radius - self.half_thickness
        unknowns = np.array([0.0, 0.0, self.forearm_height - self.height])
        places, forces, step = [first], [np.zeros(2)], step_m
        before = unknowns
        while step > 1e-3 * step_m:
            x = places[-1] + step
            # Extrapolates from the last two solutions.
            guess = unknowns + (unknowns - before) * (step / max(places[-1] - places[-2], step) if len(places) > 1 else 0)
            found = self.newton(guess, x)
            if found is None:
                step /= 2
                continue
            before, unknowns = unknowns, found
            places.append(x)
            forces.append(self.solve(*found)[1])
        return np.array(places), np.array(forces)

    def newton(self, unknowns, x):
        for _ in range(30):
            miss = self.misses(unknowns, x)
            if np.abs(miss).max() < 1e-9:
                return unknowns if unknowns[1] >= 0 else None
            steps = 1e-7 * np.eye(3)
            slopes = np.array([(self.misses(unknowns + step, x) - miss) / 1e-7 for step in steps]).T
            change = np.linalg.solve(slopes, -miss)
            unknowns = unknowns + change * min(1, 0.1 / np.abs(change).max())
        return None
