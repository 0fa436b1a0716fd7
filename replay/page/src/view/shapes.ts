// Geometry of collision shapes.

import { BoxGeometry, BufferGeometry, CapsuleGeometry, CylinderGeometry, type Object3D, SphereGeometry, Vector3 } from "three";
import { ConvexGeometry } from "three/addons/geometries/ConvexGeometry.js";

import type { Body, Pose, Reach, Shape } from "../reach.ts";

/** The geometry of a shape, centred on its frame; cylinders and capsules along z, as in the data. */
export function geometryOf(shape: Shape): BufferGeometry {
  if (shape.sphere !== undefined) return new SphereGeometry(shape.sphere.radius_m, 14, 9);
  if (shape.cylinder !== undefined) {
    const { radius_m, length_m } = shape.cylinder;
    return new CylinderGeometry(radius_m, radius_m, length_m, 18).rotateX(Math.PI / 2);
  }
  if (shape.capsule !== undefined) {
    const { radius_m, length_m } = shape.capsule;
    return new CapsuleGeometry(radius_m, length_m, 3, 14).rotateX(Math.PI / 2);
  }
  if (shape.box !== undefined) return new BoxGeometry(...(shape.box.size_m as [number, number, number]));
  if (shape.hull !== undefined) return new ConvexGeometry(shape.hull.points_m.map((point) => new Vector3(...(point as [number, number, number]))));
  return new BufferGeometry();
}

/** Places an object by a pose from the header. */
export function place(target: Object3D, pose: Pose): void {
  target.position.fromArray(pose.position);
  target.quaternion.fromArray(pose.orientation as [number, number, number, number]).normalize();
}

/** Places an object by row `row` of an array with seven numbers a pose. */
export function placeRow(target: Object3D, poses: Float32Array, row: number): void {
  target.position.fromArray(poses, 7 * row);
  target.quaternion.fromArray(poses, 7 * row + 3).normalize();
}

/** Places an object where a body is in a frame. */
export function placeBody(target: Object3D, reach: Reach, body: number, frame: number): void {
  const row = reach.track(body, frame);
  if (row < 0) place(target, reach.header.bodies[body]!.rest_pose_world);
  else placeRow(target, reach.trackPose, row);
}

/** Whether a body is a piece of a blade: one thin box that begins at its hinge and stands along z. */
export function isBladePiece(body: Body): boolean {
  const [part] = body.parts;
  const size = part?.shape.box?.size_m;
  if (body.parts.length !== 1 || part === undefined || size === undefined) return false;
  const [thick, wide, long] = size as [number, number, number];
  const [x, y, z] = part.pose_body.position as [number, number, number];
  return thick < 0.2 * wide && Math.abs(z - long / 2) < 1e-6 && Math.hypot(x, y) < 1e-6;
}
