// Rigid bodies at their stored poses: links of the arm, trunks, foam and rolls.

import { FrontSide, Matrix4, Quaternion, Vector3 } from "three";

import type { Reach } from "../reach.ts";
import { Batch } from "./batch.ts";
import { geometryOf } from "./shapes.ts";

interface Solid {
  body: number;
  /** Its vertices in the batch. */
  first: number;
  count: number;
  /** Row of the stored pose that it has; -1 at rest, -2 before it was placed. */
  row: number;
}

/** Vertices of a body in its own frame. */
function partsOf(reach: Reach, body: number) {
  const found = { positions: [] as number[], normals: [] as number[], index: [] as number[] };
  for (const { shape, pose_body: pose } of reach.header.bodies[body]!.parts) {
    const turn = new Quaternion(...(pose.orientation as [number, number, number, number])).normalize();
    const place = new Vector3(...(pose.position as [number, number, number]));
    const geometry = geometryOf(shape).applyMatrix4(new Matrix4().compose(place, turn, new Vector3(1, 1, 1)));
    const [position, normal] = [geometry.getAttribute("position"), geometry.getAttribute("normal")];
    if (position === undefined || normal === undefined) continue;
    const first = found.positions.length / 3;
    const count = geometry.index?.count ?? position.count;
    for (let at = 0; at < count; at++) found.index.push(first + (geometry.index?.getX(at) ?? at));
    for (let at = 0; at < position.count; at++) {
      found.positions.push(position.getX(at), position.getY(at), position.getZ(at));
      found.normals.push(normal.getX(at), normal.getY(at), normal.getZ(at));
    }
    geometry.dispose();
  }
  return found;
}

export class Solids extends Batch {
  readonly #solids: Solid[] = [];
  /** Places and normals of all vertices in the frames of their bodies. */
  readonly #own: Float32Array;
  readonly #ownNormals: Float32Array;

  /** The bodies with these numbers. */
  constructor(readonly reach: Reach, bodies: number[]) {
    const all = bodies.map((body) => ({ body, owner: reach.header.bodies[body]!.owner.object ?? -1, ...partsOf(reach, body) }));
    const owners = all.flatMap(({ owner, positions }) => Array.from({ length: positions.length / 3 }, () => owner));
    const [solids, index, first] = [[] as Solid[], [] as number[], { vertex: 0 }];
    for (const { body, positions, index: own } of all) {
      solids.push({ body, first: first.vertex, count: positions.length / 3, row: -2 });
      for (const vertex of own) index.push(first.vertex + vertex);
      first.vertex += positions.length / 3;
    }
    super(Int16Array.from(owners), index, FrontSide);
    this.#solids = solids;
    this.#own = Float32Array.from(all.flatMap(({ positions }) => positions));
    this.#ownNormals = Float32Array.from(all.flatMap(({ normals }) => normals));
  }

  /** Puts all bodies where they are in a frame. */
  place(frame: number): void {
    for (const solid of this.#solids) {
      const row = this.reach.track(solid.body, frame);
      if (row === solid.row) continue;
      solid.row = row;
      this.#move(solid);
    }
  }

  #move({ body, first, count, row }: Solid): void {
    const { position, orientation } = this.reach.header.bodies[body]!.rest_pose_world;
    const pose = row < 0 ? [...position, ...orientation] : this.reach.trackPose.subarray(7 * row, 7 * row + 7);
    const [px, py, pz] = [pose[0]!, pose[1]!, pose[2]!];
    const length = Math.hypot(pose[3]!, pose[4]!, pose[5]!, pose[6]!);
    const [i, j, k, w] = [pose[3]! / length, pose[4]! / length, pose[5]! / length, pose[6]! / length];
    // The rotation as a matrix.
    const [xx, xy, xz] = [1 - 2 * (j * j + k * k), 2 * (i * j - k * w), 2 * (i * k + j * w)];
    const [yx, yy, yz] = [2 * (i * j + k * w), 1 - 2 * (i * i + k * k), 2 * (j * k - i * w)];
    const [zx, zy, zz] = [2 * (i * k - j * w), 2 * (j * k + i * w), 1 - 2 * (i * i + j * j)];
    const turn = (from: Float32Array, to: Float32Array, dx: number, dy: number, dz: number) => {
      for (let at = 3 * first; at < 3 * (first + count); at += 3) {
        const [x, y, z] = [from[at]!, from[at + 1]!, from[at + 2]!];
        to[at] = xx * x + xy * y + xz * z + dx;
        to[at + 1] = yx * x + yy * y + yz * z + dy;
        to[at + 2] = zx * x + zy * y + zz * z + dz;
      }
    };
    turn(this.#own, this.positions, px, py, pz);
    turn(this.#ownNormals, this.normals, 0, 0, 0);
    this.moved(first, count);
  }

  /** The vertices of a body in its own frame and where they are drawn, m, or null if it is not here. */
  drawn(body: number): { own: number[][]; world: number[][] } | null {
    const solid = this.#solids.find((solid) => solid.body === body);
    if (solid === undefined) return null;
    const rows = (values: ArrayLike<number>) => Array.from({ length: solid.count }, (_, at) => [0, 1, 2].map((axis) => values[3 * (solid.first + at) + axis]!));
    return { own: rows(this.#own), world: rows(this.positions) };
  }
}
