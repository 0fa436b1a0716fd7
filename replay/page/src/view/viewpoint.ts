// Where the 3-D view looks from: the four views, a hand that is followed, and turning by pointer and keys.

import { Box3, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import type { CameraKind } from "../state.ts";

/** A hand that is followed stays at this distance, m. */
const HAND_DISTANCE_M = 0.75;
/** Angle from the bottom of a wide view to its top, degrees. */
const FIELD_DEG = 38;

/** What each key does: turn about the vertical and over the horizontal, rad, and a factor of the distance. */
const TURNS: Record<string, [number, number, number]> = {
  ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, -0.1, 1], ArrowDown: [0, 0.1, 1],
  "+": [0, 0, 0.9], "=": [0, 0, 0.9], "-": [0, 0, 1.1],
};

export class Viewpoint {
  readonly camera = new PerspectiveCamera(FIELD_DEG, 1, 0.01, 100);
  readonly #controls: OrbitControls;
  #kind: CameraKind | null = null;
  /** What is to be seen as a whole. */
  #whole = new Box3();
  /** Whether a reader has turned the view, so that it stays in a window of another size. */
  #own = false;
  /** Whether a pointer turns the view. */
  turning = false;

  /** `moved` is called when the view has changed. */
  constructor(canvas: HTMLCanvasElement, readonly moved: () => void) {
    this.camera.up.set(0, 0, 1);
    this.#controls = new OrbitControls(this.camera, canvas);
    this.#controls.addEventListener("change", moved);
    this.#controls.addEventListener("start", () => (this.turning = this.#own = true));
    this.#controls.addEventListener("end", () => {
      this.turning = false;
      moved();
    });
    this.#controls.minDistance = 0.03;
    canvas.addEventListener("keydown", (event) => {
      const turn = TURNS[event.key];
      if (turn === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation();
      this.#turn(...turn);
    });
  }

  /** Turns the camera about its target, rad, and scales its distance. */
  #turn(around: number, over: number, distance: number): void {
    const offset = this.camera.position.clone().sub(this.#controls.target);
    const flat = Math.hypot(offset.x, offset.y);
    const azimuth = Math.atan2(offset.y, offset.x) + around;
    const height = Math.min(Math.max(Math.atan2(offset.z, flat) - over, -1.5), 1.5);
    const length = offset.length() * distance;
    offset.set(Math.cos(azimuth) * Math.cos(height), Math.sin(azimuth) * Math.cos(height), Math.sin(height)).multiplyScalar(length);
    this.camera.position.copy(this.#controls.target).add(offset);
    this.#own = true;
    this.#controls.update();
    this.moved();
  }

  /** Takes a new view, of what is in this box, m. */
  show(whole: Box3): void {
    this.#whole = whole;
    this.#controls.maxDistance = Math.max(6, 3 * whole.min.distanceTo(whole.max));
    this.#kind = null;
  }

  /** Looks as this kind of view does: where it begins if it is new, and after the hand if it follows it. */
  look(kind: CameraKind, tip: Vector3): void {
    if (kind !== this.#kind) {
      this.#kind = kind;
      this.#own = false;
      this.#aim(tip);
    }
    if (kind !== "hand") return;
    const step = tip.sub(this.#controls.target);
    this.#controls.target.add(step);
    this.camera.position.add(step);
    this.#controls.update();
  }

  #aim(tip: Vector3): void {
    const directions: Record<CameraKind, Vector3> = {
      free: new Vector3(-0.35, -1.25, 0.75), hand: new Vector3(-0.2, -1, 0.55), top: new Vector3(0, -0.001, 1), side: new Vector3(0, -1, 0),
    };
    const direction = directions[this.#kind!].normalize();
    const target = this.#kind === "hand" ? tip : this.#whole.getCenter(new Vector3());
    this.camera.position.copy(target).add(direction);
    this.camera.lookAt(target);
    this.camera.position.addScaledVector(direction, (this.#kind === "hand" ? HAND_DISTANCE_M : this.#distance()) - 1);
    this.#controls.target.copy(target);
    this.#controls.update();
  }

  /** How far from the middle of the box the camera must stand to see all its corners, m; it stands 1 m from there. */
  #distance(): number {
    this.camera.updateMatrixWorld();
    const high = Math.tan((this.camera.fov / 2) * (Math.PI / 180));
    const { min, max } = this.#whole;
    const distances = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => {
      const place = new Vector3(corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y, corner & 4 ? max.z : min.z);
      const { x, y, z } = place.applyMatrix4(this.camera.matrixWorldInverse);
      return 1 + z + Math.max(Math.abs(x) / this.camera.aspect, Math.abs(y)) / high;
    });
    // A little farther, so that nothing stands at the very edge.
    return 1.05 * Math.max(...distances);
  }

  /** Fits a view of this size, CSS pixels. A narrow one keeps its width. */
  fit(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.fov = width > height ? FIELD_DEG : Math.min(2 * Math.atan(Math.tan(0.33) * (height / width)) * (180 / Math.PI), 75);
    this.camera.updateProjectionMatrix();
    if (!this.#own && this.#kind !== null && this.#kind !== "hand") this.#aim(new Vector3());
  }
}
