// The path of the hand as a line up to the moment.

import { BufferAttribute, BufferGeometry, Line, LineBasicMaterial } from "three";

import type { Reach } from "../reach.ts";

/** The line has points at this distance, m. */
const STEP_M = 0.002;

export class Path extends Line<BufferGeometry, LineBasicMaterial> {
  /** Points of the path up to each frame. */
  #lengths = new Uint32Array();

  constructor() {
    super(new BufferGeometry(), new LineBasicMaterial());
    this.frustumCulled = false;
  }

  /** Takes the path of a reach, without the frames in which the hand hardly moves. */
  load(reach: Reach): void {
    const kept: number[] = [];
    this.#lengths = new Uint32Array(reach.frames);
    for (let frame = 0; frame < reach.frames; frame++) {
      const [x, y, z] = [0, 1, 2].map((axis) => reach.tip[7 * frame + axis]!) as [number, number, number];
      const [a, b, c] = kept.slice(-3) as [number, number, number];
      if (kept.length === 0 || Math.hypot(x - a, y - b, z - c) > STEP_M) kept.push(x, y, z);
      this.#lengths[frame] = kept.length / 3;
    }
    this.geometry.dispose();
    this.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(Float32Array.from(kept), 3));
    this.geometry.computeBoundingSphere();
  }

  /** Shows the path up to a frame. */
  show(frame: number): void {
    this.geometry.setDrawRange(0, this.#lengths[frame]!);
  }
}
