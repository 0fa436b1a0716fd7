// Leaves as smooth blades: the curve through the hinges, along which the rigid pieces of the simulation lie.

import { DoubleSide, Object3D, Vector3 } from "three";

import type { Reach } from "../reach.ts";
import { Batch } from "./batch.ts";
import { placeBody } from "./shapes.ts";

/** Points of the curve between two hinges. */
const STEPS = 4;
/** The last part of a blade is rounded, as a share of its length. */
const ROUNDED = 0.08;
/** The midrib lies this far off the plane of the edges, as a share of the width, so that light shows it. */
const RIB = 0.06;

/**
 * A ribbon of the leaf's width through the hinges and the tip. Between two of them the curve is a cubic whose direction at a
 * hinge is the mean of the directions of the two pieces that meet there. Where the blade bends by an angle Δ at both ends of a
 * piece, the curve leaves the piece by about tan(Δ/2)/4 of its length: a fifteenth at 30 degrees.
 */
class Leaf {
  readonly #pieces: { body: number; length: number }[];
  readonly #width: number;
  readonly #rows: Int32Array;
  readonly #points: Vector3[];
  readonly #directions: Vector3[];
  readonly #sides: Vector3[];

  /** The pieces `bodies` of object `object`, from the foot to the tip. */
  constructor(reach: Reach, readonly object: number, bodies: number[]) {
    const sizes = bodies.map((body) => reach.header.bodies[body]!.parts[0]!.shape.box!.size_m);
    this.#pieces = bodies.map((body, index) => ({ body, length: sizes[index]![2]! }));
    this.#width = sizes[0]![1]!;
    this.#rows = new Int32Array(bodies.length).fill(-2);
    this.#points = Array.from({ length: bodies.length + 1 }, () => new Vector3());
    this.#directions = Array.from({ length: bodies.length }, () => new Vector3());
    this.#sides = Array.from({ length: bodies.length }, () => new Vector3());
  }

  /** Points along the curve. Each has three vertices: the left edge, the midrib and the right edge. */
  get length(): number {
    return this.#pieces.length * STEPS + 1;
  }

  /** Finds its shape in a frame; false if it has not moved. */
  bend(reach: Reach, frame: number): boolean {
    let same = true;
    for (const [index, { body }] of this.#pieces.entries()) {
      const row = reach.track(body, frame);
      same &&= row === this.#rows[index];
      this.#rows[index] = row;
    }
    if (same) return false;
    for (const [index, { body, length }] of this.#pieces.entries()) {
      placeBody(PIECE, reach, body, frame);
      this.#points[index]!.copy(PIECE.position);
      this.#directions[index]!.set(0, 0, 1).applyQuaternion(PIECE.quaternion);
      this.#sides[index]!.set(0, 1, 0).applyQuaternion(PIECE.quaternion);
      this.#points[index + 1]!.copy(PIECE.position).addScaledVector(this.#directions[index]!, length);
    }
    return true;
  }

  /** Writes its vertices and their normals from vertex `first` on. */
  write(positions: Float32Array, normals: Float32Array, first: number): void {
    const total = this.#pieces.reduce((sum, piece) => sum + piece.length, 0);
    let [at, passed] = [3 * first, 0];
    const put = (place: number, off: number, lift: number, slope: number) => {
      POINT.toArray(positions, place);
      NORMAL.copy(FRONT).addScaledVector(SIDE, slope).toArray(normals, place);
      for (const [axis, name] of (["x", "y", "z"] as const).entries()) positions[place + axis]! += off * SIDE[name] + lift * FRONT[name];
    };
    for (const [index, { length }] of this.#pieces.entries()) {
      const last = index + 1 === this.#pieces.length;
      this.#tangent(START, index);
      this.#tangent(END, index + 1);
      for (let step = 0; step < STEPS + (last ? 1 : 0); step++) {
        const t = step / STEPS;
        hermite(POINT, this.#points[index]!, START, this.#points[index + 1]!, END, length, t);
        SIDE.copy(this.#sides[index]!).lerp(this.#sides[Math.min(index + 1, this.#sides.length - 1)]!, t).normalize();
        ALONG.copy(START).lerp(END, t);
        FRONT.crossVectors(SIDE, ALONG).normalize();
        const left = 1 - (passed + t * length) / total;
        const half = (this.#width / 2) * Math.sqrt(1 - Math.max(0, 1 - left / ROUNDED) ** 2);
        put(at, -half, 0, -2 * RIB);
        put(at + 3, 0, RIB * this.#width, 0);
        put(at + 6, half, 0, 2 * RIB);
        at += 9;
      }
      passed += length;
    }
  }

  /** The direction of the curve at a hinge. */
  #tangent(out: Vector3, knot: number): void {
    const [before, after] = [this.#directions[knot - 1], this.#directions[knot]];
    if (before === undefined) out.copy(after!);
    else if (after === undefined) out.copy(before);
    else out.copy(before).add(after).normalize();
  }

  /** The hinges and the tip, for tests. */
  get knots(): number[][] {
    return this.#points.map((point) => point.toArray());
  }
}

// Used again and again, because a frame bends many leaves.
const PIECE = new Object3D();
const [POINT, SIDE, FRONT, ALONG, NORMAL, START, END] = Array.from({ length: 7 }, () => new Vector3()) as [Vector3, Vector3, Vector3, Vector3, Vector3, Vector3, Vector3];

function hermite(out: Vector3, a: Vector3, u: Vector3, b: Vector3, v: Vector3, length: number, t: number): void {
  const [t2, t3] = [t * t, t * t * t];
  out.copy(a).multiplyScalar(2 * t3 - 3 * t2 + 1);
  out.addScaledVector(u, (t3 - 2 * t2 + t) * length);
  out.addScaledVector(b, -2 * t3 + 3 * t2);
  out.addScaledVector(v, (t3 - t2) * length);
}

/** All leaves of a reach. */
export class Leaves extends Batch {
  readonly #leaves: { leaf: Leaf; first: number }[] = [];

  /** Objects with their pieces. */
  constructor(readonly reach: Reach, pieces: Map<number, number[]>) {
    const leaves = [...pieces].map(([object, bodies]) => new Leaf(reach, object, bodies));
    const [placed, owners, index] = [[] as { leaf: Leaf; first: number }[], [] as number[], [] as number[]];
    for (const leaf of leaves) {
      const first = owners.length;
      placed.push({ leaf, first });
      for (let vertex = 0; vertex < 3 * leaf.length; vertex++) owners.push(leaf.object);
      for (let row = 0; row + 1 < leaf.length; row++) {
        for (const side of [0, 1]) {
          const a = first + 3 * row + side;
          index.push(a, a + 1, a + 3, a + 1, a + 4, a + 3);
        }
      }
    }
    super(Int16Array.from(owners), index, DoubleSide);
    this.#leaves = placed;
  }

  /** Bends all blades as they are in a frame. */
  place(frame: number): void {
    for (const { leaf, first } of this.#leaves) {
      if (!leaf.bend(this.reach, frame)) continue;
      leaf.write(this.positions, this.normals, first);
      this.moved(first, 3 * leaf.length);
    }
  }

  /** Hinges and tip of the leaf that is this object, for tests. */
  hinges(object: number): number[][] | null {
    return this.#leaves.find(({ leaf }) => leaf.object === object)?.leaf.knots ?? null;
  }
}
