"""One leaf that a forearm pushes aside until it slides off: here, in MuJoCo, and as an elastica.

    pip install -r benches/peers/requirements.txt
    python benches/peers/slide.py

Run it from the root of the workspace; it takes minutes. The forearm passes at a constant speed over a leaf that faces
it, and, with its axis tilted, over a rotated leaf, where the direction of friction is not known beforehand. Both
engines have the same bodies, hinges, springs, shapes and friction. All forces are those on the forearm, as means over
frames of 10 ms.
"""

import platform
import subprocess
import sys
import time

try:
    import mujoco
    import numpy as np
except ImportError as missing:
    sys.exit(f"{missing}: install the peers first, `pip install -r benches/peers/requirements.txt`")

from elastica import Blade
from engines import IMPEDANCE, Peer, our_run, ours
from mujoco_model import Builder, text

# Rotation of the leaf and slope of the forearm's axis, degrees.
CASES = {"facing": (0, 0), "oblique": (30, 20)}
SPEED_M_PER_S = 0.1
# Numbers of hinges of the blade, the default first.
SEGMENTS = [4, 8, 16]
# This project's steps, s, the default first; and the step used when something else is varied.
OUR_STEPS = [0.005, 0.0025, 0.001, 0.0005]
FINE = 0.001
# Number of drawn leaves that the whole arm meets, one at a time, and MuJoCo's step for them, s.
DRAWN, PEER_DRAWN_STEP = 5, 0.0005
# MuJoCo's settings, and what each variant changes. A pair has no second contact, because that would stay on the blade's
# face when the forearm already rolls over the edge of the tip.
PEER = {"step_s": 0.0001, "contact_hz": 100, "impratio": 1, "cone": "elliptic", "multiccd": "disable", "capsule": False}
PEER_VARIANTS = {
    "step of 0.05 ms": {"step_s": 0.00005},
    "step of 0.5 ms": {"step_s": 0.0005},
    "contacts at 50 Hz": {"contact_hz": 50},
    "contacts at 200 Hz": {"contact_hz": 200, "step_s": 0.00005},
    "impratio 10": {"impratio": 10},
    "pyramidal cones": {"cone": "pyramidal"},
    "a capsule as forearm": {"capsule": True},
    "several contacts a pair": {"multiccd": "enable"},
}


class SlideBuilder(Builder):
    """Builds a model in which the forearm slides freely."""

    def joint(self, body, name, joint, is_arm):
        if is_arm:
            self.add(body, "joint", name=name, type="slide", axis=text(joint["direction"]))
        else:
            super().joint(body, name, joint, is_arm)


def here(segments, step_s, case, speed=SPEED_M_PER_S, skin=True):
    """The bodies and joints, and our force in each frame, N."""
    found = ours("slide", segments, step_s, *CASES[case], speed, str(skin).lower())
    found["duration_s"] = len(found["force_world_n"]) * step_s
    return found, in_frames(found["force_world_n"], step_s, found)


def there(setup, **changed):
    """MuJoCo's force in each frame, N."""
    given = {**PEER, **changed}
    forearm = setup["trees"][-1][-1]
    weightless = {**forearm, "gravity_scale": 0.0}
    leaf, (origin, _) = setup["trees"]
    setup = {**setup, "arm": {"bodies": [forearm["body"]]}, "trees": [leaf, [origin, weightless]]}
    options = {"timestep": given["step_s"], "integrator": "implicitfast", "solver": "Newton", "cone": given["cone"],
               "impratio": given["impratio"]}
    flags = {"sleep": "disable", "multiccd": given["multiccd"]}
    xml = SlideBuilder(setup, options, flags, IMPEDANCE, False, given["contact_hz"]).xml()
    if given["capsule"]:
        xml = xml.replace('type="cylinder"', 'type="capsule"')
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    body = model.body(f"body{forearm['body']}")
    first = body.dofadr[0]
    data.qvel[first:first + 3] = data.xmat[body.id].reshape(3, 3).T @ [setup["speed_m_per_s"], 0, 0]
    forces, wrench = [], np.zeros(6)
    for _ in range(round(setup["duration_s"] / given["step_s"])):
        mujoco.mj_step(model, data)
        total = np.zeros(3)
        for number in range(data.ncon):
            contact = data.contact[number]
            mujoco.mj_contactForce(model, data, number, wrench)
            # The force acts on the body of the second shape.
            sign = 1 if model.geom_bodyid[contact.geom[1]] == body.id else -1
            total += sign * contact.frame.reshape(3, 3).T @ wrench[:3]
        forces.append(total)
    return in_frames(forces, given["step_s"], setup)


def in_frames(forces, step_s, setup):
    """Means over frames, from the forces in each step."""
    steps = round(setup["frame_period_s"] / step_s)
    whole = len(forces) // steps * steps
    return np.array(forces)[:whole].reshape(-1, steps, 3).mean(axis=1)


def blade(setup):
    """The positions of the forearm, m, and the elastica's forces on it, N, for a leaf that faces it."""
    leaf, forearm = setup["trees"][0][-1]["colliders"][0], setup["trees"][-1][-1]["colliders"][0]
    return Blade(
        setup["leaf"],
        leaf["shape"]["box"]["half_size_m"][0],
        forearm["shape"]["cylinder_z"]["radius_m"],
        setup["start_m"][2],
        (leaf["friction"] + forearm["friction"]) / 2,
        setup["gravity_m_per_s2"],
    ).forces(0.005)


def at_frames(found, setup):
    """The elastica's force in the middle of each frame, N."""
    places, forces = found
    period_s = setup["frame_period_s"]
    frames = round(setup["duration_s"] / period_s)
    passed = setup["start_m"][0] + setup["speed_m_per_s"] * period_s * (np.arange(frames) + 0.5)
    across, up = (np.interp(passed, places, forces[:, axis], left=0, right=0) for axis in (0, 1))
    return np.column_stack([across, np.zeros(frames), up])


def figures(forces, period_s):
    """Impulse, N s; mean force while they touch, N; largest force, N; time of the last touch, s."""
    size = np.linalg.norm(forces, axis=1)
    touched = np.flatnonzero(size > 1e-3)
    return np.linalg.norm(forces.sum(axis=0)) * period_s, size[touched].mean(), size.max(), (touched[-1] + 1) * period_s


def show(name, forces, reference, setup):
    """Prints a row: the figures, their differences from those of the reference, the RMS of the difference of the forces
    divided by the RMS of the reference, and the median and 90th percentile of the angle between both forces."""
    period_s = setup["frame_period_s"]
    own, other = figures(forces, period_s), figures(reference, period_s)
    relative = [100 * (a / b - 1) for a, b in zip(own, other)]
    rms = 100 * np.sqrt(((forces - reference)**2).sum() / (reference**2).sum())
    sizes = [np.linalg.norm(side, axis=1) for side in (forces, reference)]
    both = (sizes[0] > 0.01) & (sizes[1] > 0.01)
    crossed = np.linalg.norm(np.cross(forces, reference), axis=1)[both]
    angles = np.degrees(np.arctan2(crossed, (forces * reference).sum(axis=1)[both]))
    cells = [f"{value:.{digits}f} ({difference:+.2f} %)" for value, difference, digits in zip(own, relative, (3, 3, 3, 2))]
    angle = f"{np.median(angles):.2f}° / {np.percentile(angles, 90):.2f}°"
    print(f"| {name} | {' | '.join(cells)} | {rms:.2f} % | {angle} |", flush=True)


def head(title):
    print(f"\n| {title} | impulse / N s | mean / N | peak / N | last touch / s | RMS | angle, median / 90 % |\n"
          "|---|---|---|---|---|---|---|")


def compare(case):
    setup, default = here(SEGMENTS[0], OUR_STEPS[0], case)
    reference = there(setup)
    head(f"{case}, {SEGMENTS[0]} hinges, against MuJoCo")
    show("MuJoCo itself", reference, reference, setup)
    show(f"underbrush, {1e3 * OUR_STEPS[0]:g} ms (default)", default, reference, setup)
    for step_s in OUR_STEPS[1:]:
        show(f"underbrush, {1e3 * step_s:g} ms", here(SEGMENTS[0], step_s, case)[1], reference, setup)
    hard = here(SEGMENTS[0], FINE, case, skin=False)[1]
    show(f"underbrush, {1e3 * FINE:g} ms, a forearm ten times as hard", hard, reference, setup)
    for name, changed in PEER_VARIANTS.items():
        show(f"MuJoCo, {name}", there(setup, **changed), reference, setup)
    head(f"{case}, each against MuJoCo with as many hinges")
    for segments in SEGMENTS[1:]:
        setup, forces = here(segments, FINE, case)
        show(f"underbrush, {segments} hinges, {1e3 * FINE:g} ms", forces, there(setup), setup)


def compare_elastica():
    found = blade(here(SEGMENTS[0], OUR_STEPS[0], "facing")[0])
    head(f"facing, {1e3 * FINE:g} ms, against the elastica")
    for segments in SEGMENTS:
        setup, forces = here(segments, FINE, "facing")
        show(f"{segments} hinges", forces, at_frames(found, setup), setup)
    setup, forces = here(segments, FINE, "facing", skin=False)
    show(f"{segments} hinges, a forearm ten times as hard", forces, at_frames(found, setup), setup)
    # The same number of steps over five times the time.
    setup, forces = here(segments, 5 * FINE, "facing", SPEED_M_PER_S / 5)
    show(f"{segments} hinges, at a fifth of the speed and {5e3 * FINE:g} ms", forces, at_frames(found, setup), setup)


def compare_drawn():
    """The whole arm with one drawn leaf, there and back, as in `compare.py`: total force on the arm."""
    print("\n| drawn leaf | ours / N | MuJoCo: mean; median distance | the same with impratio 20 |\n|---|---|---|---|")
    for layout in range(DRAWN):
        setup = ours("setup", 1, layout)
        forces = np.array(our_run(1, layout, FINE, False)["force_on_links_n"]).sum(axis=1)
        mean = np.linalg.norm(forces, axis=1).mean()
        cells = []
        for impratio in ("1", "20"):
            options = {"integrator": "implicitfast", "solver": "Newton", "cone": "elliptic", "impratio": impratio}
            peer = Peer(setup, PEER_DRAWN_STEP, options, {"sleep": "disable", "multiccd": "disable"}).forces().sum(axis=1)
            size = np.linalg.norm(peer, axis=1)
            touching = (size > 0.01) | (np.linalg.norm(forces, axis=1) > 0.01)
            distance = np.median(np.linalg.norm(peer - forces, axis=1)[touching])
            cells.append(f"{100 * (size.mean() / mean - 1):+.2f} %; {1e3 * distance:.1f} mN")
        print(f"| {layout} | {mean:.4f} | {' | '.join(cells)} |", flush=True)


def main():
    subprocess.run(["cargo", "build", "--release", "--example", "foliage_peer"], check=True)
    setup, _ = here(SEGMENTS[0], OUR_STEPS[0], "facing")
    print(f"{setup['engine']} against MuJoCo {mujoco.__version__}, Python {platform.python_version()}, "
          f"{time.strftime('%Y-%m-%d')}")
    compare_elastica()
    for case in CASES:
        compare(case)
    compare_drawn()


if __name__ == "__main__":
    main()
