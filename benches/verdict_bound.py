"""How well leaf and trunk can be told apart at the end of a contact, from much more than a touch model reads.

    pip install './python[sklearn]'
    python benches/verdict_bound.py --train SET… --test SET… --model touch.json

Describes every touched contact of a forearm taxel by 375 numbers: the course of the force on the taxel, on its
surroundings and on all skin, the path of the taxel, stiffness, and torques and deflections of all joints.
Gradient-boosted trees and random trees are fitted to the training sets and judge the test sets, as the touch model
does. Contacts are defined as in the benchmark: they begin when a taxel senses more than 0.03 N, have the category that
presses in most of their frames, and are judged at the last frame in which anything presses. Contacts that anything
but a leaf or a trunk ever presses are left out. Prints balanced accuracies over contacts, with 95 % intervals over
resamples of whole reaches.
"""

import argparse

import numpy as np
import underbrush
from sklearn.ensemble import ExtraTreesClassifier, HistGradientBoostingClassifier

THRESHOLD_N = 0.03
LEAF, TRUNK = 0, 1
PATCH = "forearm"


def surroundings(grid, rows, columns, wraps):
    """Sum, maximum, and number of values above the threshold in a window around each taxel of a grid [frames, rows,
    columns]."""
    found = [np.zeros_like(grid), np.zeros_like(grid), np.zeros_like(grid)]
    for row in range(-rows, rows + 1):
        for column in range(-columns, columns + 1):
            moved = grid
            for axis, shift in ((1, row), (2, column)):
                moved = np.roll(moved, shift, axis)
                if shift and not wraps[axis - 1]:
                    edge = [slice(None)] * 3
                    edge[axis] = slice(None, shift) if shift > 0 else slice(shift, None)
                    moved = moved.copy() if moved.base is not None else moved
                    moved[tuple(edge)] = 0
            found[0] += moved
            np.maximum(found[1], moved, out=found[1])
            found[2] += moved > THRESHOLD_N
    return found


def rotated(quaternions, vector):
    """A vector turned by quaternions x y z w."""
    axis, angle = quaternions[:, :3], quaternions[:, 3:]
    return vector + 2 * np.cross(axis, np.cross(axis, vector) + angle * vector)


def stretches(pressed):
    """First and last frames of the runs of true values."""
    changes = np.diff(np.concatenate([[0], pressed.astype(np.int8), [0]]))
    return zip(np.flatnonzero(changes == 1), np.flatnonzero(changes == -1) - 1)


def summary(series, peak):
    """Features of a contact from the courses [quantities, frames] of its quantities."""
    parts = [
        series[:, -1], series.max(1), series.min(1), series.mean(1), series.std(1), series[:, peak],
        series[:, :10].mean(1), series[:, -50:].mean(1), series[:, -1] - series[:, 0],
    ]
    return np.concatenate(parts)


def contacts(reach, model):
    """Features, truth and the touch model's answer for each touched contact of one reach."""
    skin = reach.skin
    rows, columns = skin.grid(PATCH)
    sensed = reach.sensed_force_n(PATCH).astype(np.float64)
    category = reach.column(f"truth.category.{PATCH}")
    flipper = reach.sensed_force_n("flipper")
    state, action = reach.joint_angle_rad, reach.equilibrium_angle_rad
    torque = reach.column("observation.torque")
    velocity = reach.column("observation.velocity")
    pose = reach.column(f"observation.patch_pose.{PATCH}")
    positions, normals = skin.positions_link(PATCH), skin.normals_link(PATCH)
    grid = sensed.reshape(len(sensed), rows, columns)
    # The forearm's skin is closed around its axis. The normals show along which axis of the grid it is closed.
    by_place = normals.reshape(rows, columns, 3)
    wraps = [by_place[-1, 0] @ by_place[0, 0] > by_place[rows // 2, 0] @ by_place[0, 0],
             by_place[0, -1] @ by_place[0, 0] > by_place[0, columns // 2] @ by_place[0, 0]]
    windows = [part.reshape(len(sensed), -1) for size in (1, 2, 4) for part in surroundings(grid, size, size, wraps)]
    everywhere = [sensed.sum(1), (sensed > THRESHOLD_N).sum(1), flipper.sum(1), flipper.max(1), (flipper > THRESHOLD_N).sum(1)]
    everywhere += [*np.abs(torque).T, *(action - state).T, np.abs(velocity).sum(1)]

    answers = {}
    if model is not None:
        online = model.online(skin)
        for frame in range(len(reach)):
            for touch in online.update(reach.frame(frame)):
                answers[frame, touch["taxel"]] = touch["probabilities"]["trunk"] > touch["probabilities"]["leaf"]

    found = []
    for taxel in np.flatnonzero((sensed > THRESHOLD_N).any(0)):
        truth = category[:, taxel]
        for first, last in stretches(sensed[:, taxel] > THRESHOLD_N):
            pressing = np.flatnonzero(np.isin(truth[first:last + 1], (LEAF, TRUNK)))
            if len(pressing) == 0 or (truth[first:last + 1] > TRUNK).any():
                continue
            objects = truth[first:last + 1][pressing]
            is_trunk = (objects == TRUNK).sum() * 2 > len(objects)
            last = first + pressing[-1]
            frames = slice(first, last + 1)
            force = sensed[frames, taxel]
            peak = int(force.argmax())
            place = pose[frames, :3] + rotated(pose[frames, 3:], positions[taxel])
            inward = -rotated(pose[first:first + 1, 3:], normals[taxel])[0]
            way = place - place[0]
            pressed = way @ inward
            across = np.linalg.norm(way - np.outer(pressed, inward), axis=1)
            step = np.linalg.norm(np.diff(place, axis=0, prepend=place[:1]), axis=1)
            depth = np.maximum(pressed - pressed.min(), 1e-5)
            around = np.array([window[frames, taxel] for window in windows])
            own = np.array([
                force, np.abs(np.diff(force, prepend=force[0])), pressed, across, np.cumsum(step), step,
                force / (depth + 1e-3), around[3] / (depth + 1e-3), np.cumsum(force * np.diff(pressed, prepend=0)),
                force / (around[3] + 1e-3),
            ])
            course = np.concatenate([own, around, np.array([series[frames] for series in everywhere])])
            onset = np.array([series[max(first - 1, 0)] for series in everywhere])
            features = np.concatenate([summary(course, peak), onset, [len(force), peak, peak / len(force), taxel]])
            found.append((features, is_trunk, answers.get((last, taxel), False)))
    return found


def read(sets, model=None):
    """Features, truth, the model's answers and the number of the reach, for all contacts of the sets; and the number of
    reaches."""
    features, truth, answers, reaches, count = [], [], [], [], 0
    for path in sets:
        for reach in underbrush.Dataset(path):
            for row, is_trunk, answer in contacts(reach, model):
                features.append(row.astype(np.float32))
                truth.append(is_trunk)
                answers.append(answer)
                reaches.append(count)
            count += 1
    return np.array(features), np.array(truth), np.array(answers), np.array(reaches), count


def balanced(right, truth, weight):
    return np.mean([np.average(right[truth == kind], weights=weight[truth == kind]) for kind in (False, True)])


def show(name, answers, truth, reaches, count):
    right = answers == truth
    random = np.random.default_rng(0)
    draws = []
    for _ in range(1000):
        drawn = np.bincount(random.integers(count, size=count), minlength=count)
        weight = drawn[reaches].astype(float)
        if all(weight[truth == kind].sum() > 0 for kind in (False, True)):
            draws.append(balanced(right, truth, weight))
    low, high = np.percentile(draws, [2.5, 97.5])
    value = balanced(right, truth, np.ones(len(truth)))
    wrong = [(~right[truth == kind]).sum() for kind in (False, True)]
    by_reach = np.sort(np.bincount(reaches[~right], minlength=count))[::-1]
    print(f"{name:34} {100 * value:5.1f} ({100 * low:.1f} to {100 * high:.1f})   wrong: {wrong[0]} leaf, {wrong[1]} trunk contacts, "
          f"{by_reach[:5].sum() / max(by_reach.sum(), 1):.0%} of them in five reaches", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--train", nargs="+", required=True, help="data sets to fit the trees to")
    parser.add_argument("--test", nargs="+", required=True, help="data sets to judge")
    parser.add_argument("--model", help="touch model to judge beside them")
    given = parser.parse_args()
    features, truth, _, _, count = read(given.train)
    print(f"training: {count} reaches, {(~truth).sum()} leaf and {truth.sum()} trunk contacts, {features.shape[1]} features")
    model = underbrush.TouchModel.load(given.model) if given.model else None
    test, test_truth, answers, *test_reaches = read(given.test, model)
    print(f"test: {test_reaches[1]} reaches, {(~test_truth).sum()} leaf and {test_truth.sum()} trunk contacts")
    if model:
        show("touch model", answers, test_truth, *test_reaches)
    weight = np.where(truth, 0.5 / truth.mean(), 0.5 / (~truth).mean())
    boosted = HistGradientBoostingClassifier(max_iter=400, learning_rate=0.05, l2_regularization=1.0, random_state=0)
    random = ExtraTreesClassifier(500, min_samples_leaf=3, n_jobs=-1, random_state=0)
    shares = []
    for name, trees in (("gradient-boosted trees", boosted), ("extremely randomized trees", random)):
        trees.fit(features, truth, sample_weight=weight)
        shares.append(trees.predict_proba(test)[:, 1])
        show(name, shares[-1] > 0.5, test_truth, *test_reaches)
    show("both", np.mean(shares, 0) > 0.5, test_truth, *test_reaches)


if __name__ == "__main__":
    main()
