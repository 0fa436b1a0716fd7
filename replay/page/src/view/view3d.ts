// The 3-D view of one reach: arm, skin, objects, contact forces, goal and path of the hand.

import {
  BufferAttribute, BufferGeometry, GridHelper, Line, LineBasicMaterial, Mesh,
  MeshBasicMaterial, OctahedronGeometry, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import type { Palette } from "../colours.ts";
import { element, prepare } from "../dom.ts";
import type { Reach } from "../reach.ts";
import { pushesAt } from "../series.ts";
import type { CameraKind } from "../state.ts";
import { Arrows } from "./arrows.ts";
import { Bodies } from "./bodies.ts";
import { Quality, drawsInSoftware } from "./quality.ts";
import { Skin } from "./skin.ts";

/** What is shown besides the reach and the frame. */
export interface Shown {
  palette: Palette;
  camera: CameraKind;
  taxel: number | null;
  object: number | null;
  /** Whether the texts beside the arrows are brought up to date. */
  texts: boolean;
  /** The CSS colour of each taxel. */
  colourOf: (taxel: number) => string;
}

/** What a click hit. */
export interface Hit {
  taxel: number | null;
  object: number | null;
}

/** A hand that is followed stays at this distance, m. */
const HAND_DISTANCE_M = 0.75;
/** The path of the hand is drawn with points at this distance, m. */
const PATH_STEP_M = 0.002;

const SIZE = new Vector2();

export class View3D {
  readonly box: HTMLElement;
  readonly #renderer: WebGLRenderer;
  readonly #scene = new Scene();
  readonly #camera = new PerspectiveCamera(38, 1, 0.02, 20);
  readonly #controls: OrbitControls;
  readonly #labels = element("div", { class: "force-labels" });
  readonly #arrows = new Arrows(this.#labels);
  readonly #goal = new Mesh(new OctahedronGeometry(0.016), new MeshBasicMaterial());
  readonly #path = new Line(new BufferGeometry(), new LineBasicMaterial());
  #grid: GridHelper | null = null;
  #bodies: Bodies | null = null;
  #skin: Skin | null = null;
  #reach: Reach | null = null;
  #frame = 0;
  #view: CameraKind | null = null;
  /** The theme whose colours everything has. */
  #painted: Palette | null = null;
  /** Points of the path up to each frame. */
  #pathLength = new Uint32Array();
  /** Width and height of the view, CSS pixels. */
  #size: [number, number] = [0, 0];
  readonly #quality: Quality;
  /** Whether a pointer turns the view. */
  #turning = false;

  /** Throws if the browser cannot make WebGL. */
  constructor(name: string, readonly redraw: () => void, picked: (hit: Hit) => void) {
    const label = `${name}. Drag to turn, scroll to zoom. With the keyboard: arrow keys turn, plus and minus zoom.`;
    const canvas = element("canvas", { tabindex: 0, role: "img", "aria-label": label, class: "view" });
    this.#quality = new Quality(drawsInSoftware());
    this.#renderer = new WebGLRenderer({ canvas, antialias: !this.#quality.software, alpha: true, powerPreference: "high-performance" });
    this.box = element("div", { class: "view-box" }, canvas, this.#labels);
    this.#camera.up.set(0, 0, 1);
    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#controls.addEventListener("change", redraw);
    this.#controls.addEventListener("start", () => (this.#turning = true));
    this.#controls.addEventListener("end", () => {
      this.#turning = false;
      redraw();
    });
    this.#controls.maxDistance = 6;
    this.#controls.minDistance = 0.08;
    this.#scene.add(this.#arrows, this.#goal, this.#path);
    this.#path.frustumCulled = false;
    this.#listen(canvas, picked);
    new ResizeObserver(([entry]) => {
      this.#size = [entry!.contentRect.width, entry!.contentRect.height];
      redraw();
    }).observe(this.box);
  }

  #listen(canvas: HTMLCanvasElement, picked: (hit: Hit) => void): void {
    let down = [0, 0];
    canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      const moved = Math.hypot(event.clientX - down[0]!, event.clientY - down[1]!);
      if (moved < 4) picked(this.#pick(event));
    });
    canvas.addEventListener("keydown", (event) => {
      const turns: Record<string, [number, number, number]> = {
        ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, -0.1, 1], ArrowDown: [0, 0.1, 1],
        "+": [0, 0, 0.9], "=": [0, 0, 0.9], "-": [0, 0, 1.1],
      };
      const turn = turns[event.key];
      if (turn === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation();
      this.turn(...turn);
    });
  }

  /** Turns the camera about its target, rad, and scales its distance. */
  turn(around: number, over: number, distance: number): void {
    const offset = this.#camera.position.clone().sub(this.#controls.target);
    const flat = Math.hypot(offset.x, offset.y);
    const azimuth = Math.atan2(offset.y, offset.x) + around;
    const height = Math.min(Math.max(Math.atan2(offset.z, flat) - over, -1.5), 1.5);
    const length = offset.length() * distance;
    offset.set(Math.cos(azimuth) * Math.cos(height), Math.sin(azimuth) * Math.cos(height), Math.sin(height)).multiplyScalar(length);
    this.#camera.position.copy(this.#controls.target).add(offset);
    this.#controls.update();
    this.redraw();
  }

  #pick(event: PointerEvent): Hit {
    const bounds = this.#renderer.domElement.getBoundingClientRect();
    const at = new Vector2(((event.clientX - bounds.left) / bounds.width) * 2 - 1, 1 - ((event.clientY - bounds.top) / bounds.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.#camera);
    const targets = [this.#bodies, this.#skin].filter((target) => target !== null);
    for (const found of ray.intersectObjects(targets, true)) {
      const taxel = this.#skin?.taxelOf(found.object, found.faceIndex ?? 0) ?? null;
      if (taxel !== null) return { taxel, object: null };
      const object = this.#bodies?.objectOf(found.object, found.faceIndex ?? 0) ?? -1;
      // Not a link: the skin on it lies a little above.
      if (object >= 0) return { taxel: null, object };
    }
    return { taxel: null, object: null };
  }

  /** Shows another reach, or the same one with more frames, for which the camera stays. */
  load(reach: Reach, grown = false): void {
    for (const old of [this.#bodies, this.#skin, this.#grid]) {
      old?.removeFromParent();
      old?.traverse((node) => node instanceof Mesh && node.geometry.dispose());
    }
    this.#reach = reach;
    this.#bodies = new Bodies(reach);
    this.#skin = new Skin(reach);
    this.#scene.add(this.#bodies, this.#skin);
    this.#path.geometry.dispose();
    this.#path.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(this.#tips(reach), 3));
    const feet = reach.header.objects.map((object) => object.position_world[2]!);
    this.#grid = new GridHelper(2, 20);
    this.#grid.rotation.x = Math.PI / 2;
    this.#grid.position.set(0.6, -0.2, feet.length > 0 ? Math.min(...feet) : 0);
    this.#grid.visible = feet.length > 0;
    (this.#grid.material as LineBasicMaterial).vertexColors = false;
    this.#scene.add(this.#grid);
    this.#painted = null;
    if (!grown) this.#view = null;
  }

  /** The path of the hand, without the frames in which it hardly moves. */
  #tips(reach: Reach): Float32Array {
    const kept: number[] = [];
    this.#pathLength = new Uint32Array(reach.frames);
    for (let frame = 0; frame < reach.frames; frame++) {
      const [x, y, z] = reach.tip.subarray(7 * frame, 7 * frame + 3) as unknown as [number, number, number];
      const [a, b, c] = kept.slice(-3) as [number, number, number];
      if (kept.length === 0 || Math.hypot(x - a, y - b, z - c) > PATH_STEP_M) kept.push(x, y, z);
      this.#pathLength[frame] = kept.length / 3;
    }
    return Float32Array.from(kept);
  }

  /** Whether the processor draws, so that every change on the screen costs time. */
  get software(): boolean {
    return this.#quality.software;
  }

  /** Moves everything to a frame and colours it. */
  show(frame: number, shown: Shown): void {
    const { palette } = shown;
    this.#frame = frame;
    if (this.#reach === null || this.#bodies === null || this.#skin === null) return;
    if (this.#painted !== palette) this.#recolour(palette);
    this.#bodies.place(frame);
    this.#bodies.recolour(palette, shown.object);
    this.#skin.place(frame);
    this.#skin.paint(shown.colourOf);
    this.#skin.mark(shown.taxel, palette.variable("ink"));
    this.#arrows.show(pushesAt(this.#reach, frame), this.#reach.header.force_limit_n, shown.texts);
    this.#goal.position.fromArray(this.#reach.goalPosition, 3 * frame);
    this.#path.geometry.setDrawRange(0, this.#pathLength[frame]!);
    if (shown.camera !== this.#view) this.#aim(shown.camera);
    if (shown.camera === "hand") this.#follow();
  }

  /** Takes over the colours of a theme. */
  #recolour(palette: Palette): void {
    this.#painted = palette;
    this.#arrows.recolour(palette.variable("ink"), palette.variable("over"));
    this.#goal.material.color.set(palette.variable("accent"));
    this.#path.material.color.set(palette.variable("accent"));
    (this.#grid?.material as LineBasicMaterial | undefined)?.color.set(palette.variable("grid"));
  }

  #tip(): Vector3 {
    return new Vector3().fromArray(this.#reach!.tip, 7 * this.#frame);
  }

  /** Moves the camera to where a view begins. */
  #aim(view: CameraKind): void {
    this.#view = view;
    const tips = this.#path.geometry;
    tips.computeBoundingSphere();
    const centre = tips.boundingSphere!.center.clone();
    // The shoulder is near the origin of the world; the middle of what is seen lies between it and the goals.
    const middle = new Vector3(centre.x * 0.62, centre.y * 0.8, centre.z);
    const places: Record<CameraKind, [Vector3, Vector3]> = {
      free: [middle, new Vector3(-0.35, -1.25, 0.75)],
      hand: [this.#tip(), new Vector3(-0.2, -1, 0.55).normalize().multiplyScalar(HAND_DISTANCE_M)],
      top: [middle, new Vector3(0, -0.001, 1.6)],
      side: [middle, new Vector3(0, -1.6, 0)],
    };
    const [target, offset] = places[view];
    this.#controls.target.copy(target);
    this.#camera.position.copy(target).add(offset);
    this.#controls.update();
  }

  /** Keeps the hand in the middle of the view. */
  #follow(): void {
    const step = this.#tip().sub(this.#controls.target);
    this.#controls.target.add(step);
    this.#camera.position.add(step);
    this.#controls.update();
  }

  /** Draws. Called once per animation frame at most; `playing` says that the next frame follows at once. */
  render(playing: boolean): void {
    const [width, height] = this.#size;
    if (width === 0 || height === 0) return;
    const moving = playing || this.#turning;
    const ratio = this.#quality.ratio(moving, performance.now());
    const size = this.#renderer.getSize(SIZE);
    if (size.x !== width || size.y !== height || this.#renderer.getPixelRatio() !== ratio) {
      this.#renderer.setPixelRatio(ratio);
      // The style sheet gives the canvas its size on the page, so that it shrinks with the page.
      this.#renderer.setSize(width, height, false);
      this.#camera.aspect = width / height;
      // A narrow view keeps its width.
      this.#camera.fov = width > height ? 38 : Math.min(2 * Math.atan(Math.tan(0.33) * (height / width)) * (180 / Math.PI), 75);
      this.#camera.updateProjectionMatrix();
    }
    this.#renderer.render(this.#scene, this.#camera);
    this.#arrows.placeLabels(this.#camera, width, height);
  }

  /** The picture as it is now with the texts beside the arrows, for print. */
  picture(palette: Palette): string {
    this.render(false);
    const drawn = this.#renderer.domElement;
    const canvas = document.createElement("canvas");
    const [width, height] = this.#size;
    const context = prepare(canvas, width, height);
    // At once: the drawing is kept only until the browser shows it.
    context.drawImage(drawn, 0, 0, width, height);
    this.#arrows.write(context, palette.variable("panel"));
    return canvas.toDataURL("image/png");
  }

  /** What is drawn where: for tests and for scripts of a reader. */
  get drawn() {
    const project = (point: number[]): number[] => {
      const at = new Vector3(...(point as [number, number, number])).project(this.#camera);
      return [((at.x + 1) / 2) * this.#size[0], ((1 - at.y) / 2) * this.#size[1]];
    };
    const pixel = (x: number, y: number): number[] => {
      this.#renderer.render(this.#scene, this.#camera);
      const gl = this.#renderer.getContext();
      const out = new Uint8Array(4);
      const ratio = this.#renderer.getPixelRatio();
      const [px, py] = [x * ratio, (this.#size[1] - y) * ratio];
      gl.readPixels(Math.floor(px), Math.floor(py), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, out);
      return [...out];
    };
    return {
      body: (body: number) => this.#bodies?.drawn(body) ?? null,
      hinges: (object: number) => this.#bodies?.hinges(object) ?? null,
      taxel: (taxel: number) => this.#skin?.drawn(taxel) ?? null,
      project,
      pixel,
    };
  }
}
