// A leaf as a smooth blade: the curve through its hinges, along which the rigid pieces of the simulation lie.

import { BufferAttribute, BufferGeometry, Mesh, type MeshLambertMaterial, Object3D, Vector3 } from "three";

import type { Reach } from "../reach.ts";
import { placeBody } from "./shapes.ts";

/** Points of the curve between two hinges. */
const STEPS = 5;
/** The last part of a blade is rounded, as a share of its length. */
const ROUNDED = 0.08;

/**
 * A ribbon of the leaf's width through the hinges and the tip. Between two of them the curve is a cubic whose direction at a
 * hinge is the mean of the directions of the two pieces that meet there. Where the blade bends by an angle Δ at both ends of a
 * piece, the curve leaves the piece by about tan(Δ/2)/4 of its length: a fifteenth at 30 degrees.
 */
export class Leaf extends Mesh<BufferGeometry, MeshLambertMaterial> {
  readonly #pieces: { body: number; length: number }[];
  readonly #width: number;
  readonly #rows: Int32Array;
  readonly #piece = new Object3D();
  readonly #points: Vector3[];
  readonly #directions: Vector3[];
  readonly #sides: Vector3[];

  constructor(reach: Reach, bodies: number[], material: MeshLambertMaterial) {
    super(new BufferGeometry(), material);
    const sizes = bodies.map((body) => reach.header.bodies[body]!.parts[0]!.shape.box!.size_m);
    this.#pieces = bodies.map((body, index) => ({ body, length: sizes[index]![2]! }));
    this.#width = sizes[0]![1]!;
    this.#rows = new Int32Array(bodies.length).fill(-2);
    const knots = bodies.length + 1;
    this.#points = Array.from({ length: knots }, () => new Vector3());
    this.#directions = Array.from({ length: bodies.length }, () => new Vector3());
    this.#sides = Array.from({ length: bodies.length }, () => new Vector3());
    // Three vertices across: the middle one lies a little off the plane, so that light shows the midrib.
    const across = bodies.length * STEPS + 1;
    this.geometry.setAttribute("position", new BufferAttribute(new Float32Array(9 * across), 3));
    const index: number[] = [];
    for (let row = 0; row + 1 < across; row++) {
      for (const side of [0, 1]) {
        const [a, b, c, d] = [3 * row + side, 3 * row + side + 1, 3 * row + side + 3, 3 * row + side + 4];
        index.push(a, b, c, b, d, c);
      }
    }
    this.geometry.setIndex(index);
    this.frustumCulled = false;
  }

  /** Bends the blade as it is in a frame. */
  update(reach: Reach, frame: number): void {
    const rows = this.#pieces.map(({ body }) => reach.track(body, frame));
    if (rows.every((row, index) => row === this.#rows[index])) return;
    this.#rows.set(rows);
    for (const [index, { body, length }] of this.#pieces.entries()) {
      placeBody(this.#piece, reach, body, frame);
      this.#points[index]!.copy(this.#piece.position);
      this.#directions[index]!.set(0, 0, 1).applyQuaternion(this.#piece.quaternion);
      this.#sides[index]!.set(0, 1, 0).applyQuaternion(this.#piece.quaternion);
      this.#points[index + 1]!.copy(this.#piece.position).addScaledVector(this.#directions[index]!, length);
    }
    this.#bend();
  }

  #bend(): void {
    const position = this.geometry.getAttribute("position") as BufferAttribute;
    const total = this.#pieces.reduce((sum, piece) => sum + piece.length, 0);
    const [point, side, front] = [new Vector3(), new Vector3(), new Vector3()];
    let [row, passed] = [0, 0];
    for (const [index, { length }] of this.#pieces.entries()) {
      const last = index + 1 === this.#pieces.length;
      const [start, end] = [this.#tangent(index), this.#tangent(index + 1)];
      for (let step = 0; step < STEPS + (last ? 1 : 0); step++) {
        const t = step / STEPS;
        hermite(point, this.#points[index]!, start, this.#points[index + 1]!, end, length, t);
        side.copy(this.#sides[index]!).lerp(this.#sides[Math.min(index + 1, this.#sides.length - 1)]!, t).normalize();
        front.crossVectors(side, this.#directions[index]!).multiplyScalar(0.06 * this.#width);
        const left = 1 - (passed + t * length) / total;
        const half = (this.#width / 2) * Math.sqrt(1 - Math.max(0, 1 - left / ROUNDED) ** 2);
        position.setXYZ(3 * row, point.x - half * side.x, point.y - half * side.y, point.z - half * side.z);
        position.setXYZ(3 * row + 1, point.x + front.x, point.y + front.y, point.z + front.z);
        position.setXYZ(3 * row + 2, point.x + half * side.x, point.y + half * side.y, point.z + half * side.z);
        row++;
      }
      passed += length;
    }
    position.needsUpdate = true;
    this.geometry.computeVertexNormals();
    this.geometry.computeBoundingSphere();
  }

  /** The direction of the curve at a hinge. */
  #tangent(knot: number): Vector3 {
    const [before, after] = [this.#directions[knot - 1], this.#directions[knot]];
    if (before === undefined) return after!;
    if (after === undefined) return before;
    return before.clone().add(after).normalize();
  }

  /** The hinges and the tip, for tests. */
  get knots(): number[][] {
    return this.#points.map((point) => point.toArray());
  }
}

function hermite(out: Vector3, a: Vector3, u: Vector3, b: Vector3, v: Vector3, length: number, t: number): void {
  const [t2, t3] = [t * t, t * t * t];
  out.copy(a).multiplyScalar(2 * t3 - 3 * t2 + 1);
  out.addScaledVector(u, (t3 - 2 * t2 + t) * length);
  out.addScaledVector(b, -2 * t3 + 3 * t2);
  out.addScaledVector(v, (t3 - t2) * length);
}
