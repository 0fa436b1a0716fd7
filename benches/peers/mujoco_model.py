"""The sweep that `foliage_peer setup` writes, as a MuJoCo model with the same bodies, hinges, springs, shapes and
friction."""

import math
from xml.etree import ElementTree

import numpy as np


# MuJoCo's contacts, critically damped. Choice: this is 2e3 N/m for a leaf of 5 g, about the stiffness of the skin under
# a leaf.
CONTACT_FREQUENCY_HZ = 100.0


def quaternion_matrix(wxyz):
    w, x, y, z = wxyz
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def matrix_quaternion(rotation):
    """Shepperd's method, the largest component first."""
    trace = np.trace(rotation)
    squares = np.array([1 + trace] + [1 - trace + 2 * rotation[i, i] for i in range(3)]) / 4
    largest = int(np.argmax(squares))
    root = math.sqrt(squares[largest])
    r = rotation
    rows = [
        [4 * root * root, r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
        [r[2, 1] - r[1, 2], 4 * root * root, r[1, 0] + r[0, 1], r[0, 2] + r[2, 0]],
        [r[0, 2] - r[2, 0], r[1, 0] + r[0, 1], 4 * root * root, r[2, 1] + r[1, 2]],
        [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[2, 1] + r[1, 2], 4 * root * root],
    ]
    return np.array(rows[largest]) / (4 * root)


class Pose:
    """A rigid transform."""

    def __init__(self, position=(0, 0, 0), rotation=None):
        self.position = np.array(position, float)
        self.rotation = np.eye(3) if rotation is None else rotation

    @staticmethod
    def read(described):
        return Pose(described["position_m"], quaternion_matrix(described["orientation_wxyz"]))

    def __mul__(self, other):
        return Pose(self.position + self.rotation @ other.position, self.rotation @ other.rotation)

    def inverse(self):
        return Pose(-self.rotation.T @ self.position, self.rotation.T)

    def attributes(self):
        return {"pos": text(self.position), "quat": text(matrix_quaternion(self.rotation))}


def text(numbers):
    return " ".join(repr(float(number)) for number in np.ravel(numbers))


class Builder:
    """Writes MJCF. `options` are attributes of <option>, `flags` of <flag>."""

    def __init__(self, setup, options, flags, impedance, sleep, contact_hz=CONTACT_FREQUENCY_HZ):
        self.setup = setup
        self.sleep = sleep
        self.root = ElementTree.Element("mujoco", model="sweep")
        self.add(self.root, "compiler", angle="radian", autolimits="true")
        option = self.add(self.root, "option", gravity=text([0, 0, -setup["gravity_m_per_s2"]]), **options)
        self.add(option, "flag", **flags)
        self.assets = self.add(self.root, "asset")
        self.world = self.add(self.root, "worldbody")
        self.contact = self.add(self.root, "contact")
        self.actuator = self.add(self.root, "actuator")
        self.solver = solver_parameters(impedance, contact_hz)
        self.arm = set(setup["arm"]["bodies"])
        shapes = [shape for tree in setup["trees"] for link in tree if link["body"] not in self.arm
                  for shape in link["colliders"]]
        self.leaf_friction = shapes[0]["friction"] if shapes else 0.0
        for tree in setup["trees"]:
            self.tree(tree)

    def add(self, parent, tag, **attributes):
        return ElementTree.SubElement(parent, tag, {key: str(value) for key, value in attributes.items()})

    def xml(self):
        return ElementTree.tostring(self.root, encoding="unicode")

    def tree(self, tree):
        children = {}
        for index, link in enumerate(tree):
            children.setdefault(link["parent"], []).append(index)
        names = []
        self.link(tree, children, 0, self.world, Pose(), [], names)
        # Parts of one object do not touch each other, and in the sweep neither do links of the arm. MuJoCo itself excludes
        # neighbours in the tree.
        for i, first in enumerate(names):
            for second in names[i + 2:]:
                self.add(self.contact, "exclude", body1=first, body2=second)

    def link(self, tree, children, index, parent, before, waiting, names):
        """Adds a link and all links that hang on it. `before` and `waiting` are the pose and the joints of the massless
        links that are skipped between `parent` and this link: in MuJoCo their hinges are stacked on one body."""
        link = tree[index]
        if link["parent"] is None:
            to_parent = Pose.read(link["pose_world"])
        else:
            to_parent = Pose.read(link["joint_frame_parent"]) * Pose.read(link["joint_frame_child"]).inverse()
        pose = before * to_parent
        joints = [moved(joint, to_parent.inverse()) for joint in waiting]
        joints += [joint_of(link, axis) for axis in link["axes"]]
        following = children.get(index, [])
        if link["mass_kg"] == 0 and not link["colliders"] and link["parent"] is not None and len(following) == 1:
            self.link(tree, children, following[0], parent, pose, joints, names)
            return
        name = f"body{link['body']}"
        body = self.add(parent, "body", name=name, **pose.attributes())
        is_arm = link["body"] in self.arm
        if self.sleep and joints and parent.get("movable") is None:
            body.set("sleep", "never" if is_arm else "init")
        if joints:
            body.set("movable", "yes")
            names.append(name)
            if link["gravity_scale"] != 1:
                body.set("gravcomp", repr(1 - link["gravity_scale"]))
            i = np.reshape(link["inertia_kg_m2"], (3, 3))
            self.add(body, "inertial", pos=text(link["center_of_mass"]), mass=repr(link["mass_kg"]),
                     fullinertia=text([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]))
        for number, joint in enumerate(joints):
            self.joint(body, f"{name}_{number}", joint, is_arm)
        for collider in link["colliders"]:
            self.geom(body, collider, is_arm)
        for child in following:
            self.link(tree, children, child, body, Pose(), [], names)
        if "movable" in body.attrib:
            del body.attrib["movable"]

    def joint(self, body, name, joint, is_arm):
        axis = joint["axis"]
        element = self.add(body, "joint", name=name, type=joint["type"], pos=text(joint["position"]),
                           axis=text(joint["direction"]), damping=repr(axis["damping"]), armature=repr(axis["armature"]))
        if axis["limits"]:
            element.set("range", text(axis["limits"]))
        if is_arm:
            # The springs are actuators, because their torques are limited.
            number = len(self.actuator)
            limit = self.setup["arm"]["torque_limit_nm"][number]
            self.add(self.actuator, "position", name=f"spring_{number}", joint=name, kp=repr(axis["stiffness"]),
                     forcerange=text([-limit, limit]))
        else:
            element.set("stiffness", repr(axis["stiffness"]))
            element.set("springref", repr(axis["rest"]))

    def geom(self, body, collider, is_arm):
        pose = Pose.read(collider["pose_body"])
        (kind, shape), = collider["shape"].items()
        if kind == "sphere":
            given = {"type": "sphere", "size": repr(shape["radius_m"]), **pose.attributes()}
        elif kind == "box":
            given = {"type": "box", "size": text(shape["half_size_m"]), **pose.attributes()}
        elif kind == "cylinder_z":
            given = {"type": "cylinder", "size": text([shape["radius_m"], shape["half_length_m"]]),
                     **pose.attributes()}
        elif kind == "capsule":
            ends = [pose.position + pose.rotation @ np.array(shape[end]) for end in ("start_m", "end_m")]
            given = {"type": "capsule", "size": repr(shape["radius_m"]), "fromto": text(ends)}
        else:
            name = f"hull{len(self.assets)}"
            self.add(self.assets, "mesh", name=name, vertex=text(shape["points_m"]))
            given = {"type": "mesh", "mesh": name, **pose.attributes()}
        # This project's engine takes the mean of both coefficients; in MuJoCo the geom of higher priority decides.
        friction = (collider["friction"] + self.leaf_friction) / 2
        self.add(body, "geom", contype=collider["memberships"] & 0x7FFFFFFF, conaffinity=collider["filter"] & 0x7FFFFFFF,
                 condim=3, priority=int(is_arm), friction=text([friction, 0.005, 0.0001]), mass=0, **self.solver,
                 **given)


def joint_of(link, axis):
    frame = Pose.read(link["joint_frame_child"])
    return {
        "type": "hinge" if axis["axis"] >= 3 else "slide",
        "position": frame.position,
        "direction": frame.rotation[:, axis["axis"] % 3],
        "axis": axis,
    }


def moved(joint, pose):
    return {**joint, "position": pose.position + pose.rotation @ joint["position"],
            "direction": pose.rotation @ joint["direction"]}


def solver_parameters(impedance, contact_hz):
    """Contact springs of the same stiffness m ω² and damping 2 ζ m ω at the effective mass m.

    MuJoCo's constraint pushes with m d/(1 − d) (a_ref − a), a_ref = −b v − k r, b = damping/d, k = stiffness/d
    (its documentation, chapter Computation). So stiffness = (1 − d) ω², damping = 2 (1 − d) ζ ω, whatever the
    impedance d; d then only sets the inertia m d/(1 − d) that the contact adds. Negative numbers stand for stiffness
    and damping given directly.
    """
    omega = 2 * math.pi * contact_hz
    damping = 2 * omega
    d = impedance
    return {"solref": text([-(1 - d) * omega**2, -(1 - d) * damping]), "solimp": text([d, d, 0.001, 0.5, 2])}
