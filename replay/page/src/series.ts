// Numbers over time that are computed from a reach once, when it is loaded.

import { NO_OBJECT, type Reach } from "./reach.ts";

export interface Series {
  /** Largest sensed force of a taxel, N. */
  largest: Float64Array;
  /** Largest true force of a taxel, N. */
  largestTrue: Float64Array;
  /** Area of the taxels in contact, cm². */
  area: Float64Array;
  /** Distance of the end effector from the goal, cm. */
  distance: Float64Array;
  /** Torque of each joint, N m. */
  torque: Float64Array[];
}

export function seriesOf(reach: Reach): Series {
  const { frames } = reach;
  const joints = reach.header.joint_names.length;
  const series: Series = {
    largest: new Float64Array(frames),
    largestTrue: new Float64Array(frames),
    area: new Float64Array(frames),
    distance: new Float64Array(frames),
    torque: Array.from({ length: joints }, () => new Float64Array(frames)),
  };
  for (let frame = 0; frame < frames; frame++) {
    for (let row = reach.readingStart[frame]!; row < reach.readingStart[frame + 1]!; row++) {
      const sensed = reach.sensed[row]!;
      series.largest[frame] = Math.max(series.largest[frame]!, sensed);
      series.largestTrue[frame] = Math.max(series.largestTrue[frame]!, reach.trueForce[row]!);
      if (sensed > reach.header.threshold_n) series.area[frame]! += 1e4 * reach.taxelArea[reach.readingTaxel[row]!]!;
    }
    const [tip, goal] = [7 * frame, 3 * frame];
    const square = [0, 1, 2].reduce((sum, axis) => sum + (reach.tip[tip + axis]! - reach.goalPosition[goal + axis]!) ** 2, 0);
    series.distance[frame] = 100 * Math.sqrt(square);
    for (let joint = 0; joint < joints; joint++) series.torque[joint]![frame] = reach.jointTorque[joints * frame + joint]!;
  }
  return series;
}

/** The force of one object on one patch in a frame. */
export interface Push {
  patch: number;
  object: number;
  /** Sum of the true forces on the taxels, N, world frame. */
  force: [number, number, number];
  /** Mean place of these taxels, weighted by normal force, m, world frame. */
  place: [number, number, number];
  /** Largest sensed force of these taxels, N. */
  largest: number;
}

export type Triple = [number, number, number];

export function cross(a: Triple, b: Triple): Triple {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** Rotates a vector by the quaternion at `at` + 3 of `poses`. */
export function rotate(poses: Float32Array, at: number, [x, y, z]: Triple): Triple {
  const [i, j, k, w] = [poses[at + 3]!, poses[at + 4]!, poses[at + 5]!, poses[at + 6]!];
  const [a, b, c] = [2 * (j * z - k * y), 2 * (k * x - i * z), 2 * (i * y - j * x)];
  return [x + w * a + j * c - k * b, y + w * b + k * a - i * c, z + w * c + i * b - j * a];
}

export function triple(values: Float32Array, index: number): Triple {
  return [values[3 * index]!, values[3 * index + 1]!, values[3 * index + 2]!];
}

/** The forces of all objects on the skin in a frame, from the true forces on the taxels; of a log nobody knows them. */
export function pushesAt(reach: Reach, frame: number): Push[] {
  if (reach.isLog) return [];
  const found = new Map<number, Push & { weight: number }>();
  const patches = reach.header.patches.length;
  for (let row = reach.readingStart[frame]!; row < reach.readingStart[frame + 1]!; row++) {
    const object = reach.readingObject[row]!;
    const force = reach.trueForce[row]!;
    if (object === NO_OBJECT || force <= 0) continue;
    const taxel = reach.readingTaxel[row]!;
    const patch = reach.patchOf[taxel]!;
    const key = object * patches + patch;
    let push = found.get(key);
    if (push === undefined) {
      push = { patch, object, force: [0, 0, 0], place: [0, 0, 0], largest: 0, weight: 0 };
      found.set(key, push);
    }
    const [normal, tangent] = [triple(reach.taxelNormal, taxel), triple(reach.taxelTangent, taxel)];
    const binormal = cross(normal, tangent);
    const [along, across] = [reach.shear[2 * row]!, reach.shear[2 * row + 1]!];
    const pose = 7 * (frame * patches + patch);
    const local = [0, 1, 2].map((axis) => -force * normal[axis]! + along * tangent[axis]! + across * binormal[axis]!) as Triple;
    const world = rotate(reach.patchPose, pose, local);
    const place = rotate(reach.patchPose, pose, triple(reach.taxelPosition, taxel));
    for (let axis = 0; axis < 3; axis++) {
      push.force[axis]! += world[axis]!;
      push.place[axis]! += force * (place[axis]! + reach.patchPose[pose + axis]!);
    }
    push.weight += force;
    push.largest = Math.max(push.largest, reach.sensed[row]!);
  }
  for (const push of found.values()) push.place = push.place.map((sum) => sum / push.weight) as Triple;
  return [...found.values()];
}
