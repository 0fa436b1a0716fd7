// The 3-D view of one reach: arm, skin, objects, contact forces, goal and path of the hand.

import { Box3, Color, type GridHelper, Mesh, MeshBasicMaterial, OctahedronGeometry, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";

import type { Palette } from "../colours.ts";
import { element, prepare } from "../dom.ts";
import type { Reach } from "../reach.ts";
import { pushesAt } from "../series.ts";
import type { CameraKind } from "../state.ts";
import { Arrows } from "./arrows.ts";
import { Bodies } from "./bodies.ts";
import { Ghost } from "./ghost.ts";
import { ControllerMap } from "./map.ts";
import { Path } from "./path.ts";
import { prepareWebGL, Quality } from "./quality.ts";
import { Shadows } from "./shadows.ts";
import { Skin } from "./skin.ts";
import { Viewpoint } from "./viewpoint.ts";

/** What is shown besides the reach and the frame. */
export interface Shown {
  palette: Palette;
  camera: CameraKind;
  taxel: number | null;
  object: number | null;
  /** Whether there are shadows; null for where the processor does not draw. */
  shadows: boolean | null;
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

const SIZE = new Vector2();
/** The view shows the skin where it is at so many moments of the reach. */
const MOMENTS = 10;

export class View3D {
  readonly box: HTMLElement;
  readonly #renderer: WebGLRenderer;
  readonly #scene = new Scene();
  readonly #viewpoint: Viewpoint;
  readonly #labels = element("div", { class: "force-labels" });
  readonly #arrows = new Arrows(this.#labels);
  readonly #goal = new Mesh(new OctahedronGeometry(0.016), new MeshBasicMaterial());
  readonly #path = new Path();
  readonly #map = new ControllerMap();
  #grid: GridHelper | null = null;
  #bodies: Bodies | null = null;
  #skin: Skin | null = null;
  #reach: Reach | null = null;
  #ghost: Ghost | null = null;
  /** The theme whose colours everything has. */
  #painted: Palette | null = null;
  /** Width and height of the view, CSS pixels. */
  #size: [number, number] = [0, 0];
  readonly #quality: Quality;
  readonly #shadows: Shadows;

  /** Throws if the browser cannot make WebGL. */
  constructor(name: string, redraw: () => void, picked: (hit: Hit) => void) {
    const label = `${name}. Drag to turn, scroll to zoom. With the keyboard: arrow keys turn, plus and minus zoom.`;
    const { canvas, context, software } = prepareWebGL(() => element("canvas", { tabindex: 0, role: "img", "aria-label": label, class: "view" }));
    this.#quality = new Quality(software);
    this.#renderer = new WebGLRenderer({ canvas, context, alpha: false });
    // Drawn in the order in which they were added; sorting would find the size of everything that has moved, in every frame.
    this.#renderer.sortObjects = false;
    this.box = element("div", { class: "view-box" }, canvas, this.#labels);
    this.#viewpoint = new Viewpoint(canvas, redraw);
    this.#shadows = new Shadows(this.#renderer);
    this.#scene.add(this.#shadows, this.#arrows, this.#goal, this.#path, this.#map);
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
  }

  #pick(event: PointerEvent): Hit {
    const bounds = this.#renderer.domElement.getBoundingClientRect();
    const at = new Vector2(((event.clientX - bounds.left) / bounds.width) * 2 - 1, 1 - ((event.clientY - bounds.top) / bounds.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.#viewpoint.camera);
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
    this.haunt(null);
    this.#reach = reach;
    this.#bodies = new Bodies(reach);
    this.#skin = new Skin(reach);
    this.#scene.add(this.#bodies, this.#skin);
    this.#path.load(reach);
    // Of a log, nobody knows where the hand is.
    this.#path.visible = !reach.isLog;
    // Of a log, nobody knows where the objects stand either.
    const feet = reach.isLog ? [] : reach.header.objects.map((object) => object.position_world[2]!);
    const height = feet.length > 0 ? Math.min(...feet) : null;
    this.#painted = null;
    this.#bodies.place(0);
    const whole = new Box3().expandByObject(this.#bodies, true);
    // Objects may have moved.
    this.#bodies.place(reach.frames - 1);
    this.#grid = this.#shadows.lay(whole.clone().expandByObject(this.#bodies, true), height);
    this.#scene.add(this.#grid);
    if (grown) return;
    if (this.#path.visible) whole.expandByObject(this.#path, true);
    for (let moment = 0; moment < MOMENTS; moment++) {
      this.#skin.place(Math.round((moment / (MOMENTS - 1)) * (reach.frames - 1)));
      whole.expandByObject(this.#skin, true);
    }
    if (whole.isEmpty()) whole.expandByPoint(new Vector3());
    this.#viewpoint.show(whole);
  }

  /** Shows the arm of another reach, too, or of none. */
  haunt(reach: Reach | null): void {
    this.#ghost?.removeFromParent();
    this.#ghost?.geometry.dispose();
    this.#ghost = reach === null ? null : new Ghost(reach);
    if (this.#ghost !== null) this.#scene.add(this.#ghost);
    this.#painted = null;
  }

  /** Whether the processor draws, so that every change on the screen costs time. */
  get software(): boolean {
    return this.#quality.software;
  }

  /** Moves everything to a frame and colours it. */
  show(frame: number, shown: Shown): void {
    const { palette } = shown;
    if (this.#reach === null || this.#bodies === null || this.#skin === null) return;
    if (this.#painted !== palette) this.#recolour(palette);
    this.#bodies.place(frame);
    this.#bodies.recolour(palette, shown.object);
    this.#ghost?.placeAt(this.#reach.time[frame]!);
    this.#skin.place(frame);
    this.#skin.paint(shown.colourOf);
    this.#skin.mark(shown.taxel, palette.variable("ink"));
    this.#arrows.show(pushesAt(this.#reach, frame), this.#reach.header.force_limit_n, shown.texts);
    this.#goal.position.fromArray(this.#reach.goalPosition, 3 * frame);
    this.#goal.visible = this.#reach.header.goals.length > 0;
    this.#path.show(frame);
    this.#map.show(this.#reach, frame, this.#grid?.visible === true ? this.#grid.position.z : null);
    this.#shadows.cast(shown.shadows ?? !this.software);
    this.#viewpoint.look(shown.camera, new Vector3().fromArray(this.#reach.tip, 7 * frame));
  }

  /** Takes over the colours of a theme. */
  #recolour(palette: Palette): void {
    this.#painted = palette;
    this.#renderer.setClearColor(palette.variable("view"));
    this.#arrows.recolour(palette.variable("ink"), palette.variable("over"));
    this.#map.recolour(palette);
    const second = new Color(palette.variable("second"));
    this.#ghost?.paint(() => second);
    this.#goal.material.color.set(palette.variable("accent"));
    this.#path.material.color.set(palette.variable("accent"));
    this.#grid?.material.color.set(palette.variable("grid"));
  }

  /** Draws. Called once per animation frame at most; `playing` says that the next frame follows at once. */
  render(playing: boolean): void {
    const [width, height] = this.#size;
    if (width === 0 || height === 0) return;
    const ratio = this.#quality.ratio(playing || this.#viewpoint.turning, performance.now());
    const size = this.#renderer.getSize(SIZE);
    if (size.x !== width || size.y !== height || this.#renderer.getPixelRatio() !== ratio) {
      this.#renderer.setPixelRatio(ratio);
      // The style sheet gives the canvas its size on the page, so that it shrinks with the page.
      this.#renderer.setSize(width, height, false);
      this.#viewpoint.fit(width, height);
    }
    this.#renderer.render(this.#scene, this.#viewpoint.camera);
    this.#arrows.placeLabels(this.#viewpoint.camera, width, height);
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
    const { camera } = this.#viewpoint;
    const project = (point: number[]): number[] => {
      const at = new Vector3(...(point as [number, number, number])).project(camera);
      return [((at.x + 1) / 2) * this.#size[0], ((1 - at.y) / 2) * this.#size[1]];
    };
    const pixel = (x: number, y: number): number[] => {
      this.#renderer.render(this.#scene, camera);
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
      ghost: (body: number) => this.#ghost?.drawn(body) ?? null,
      obstacles: this.#map.drawn,
      taxel: (taxel: number) => this.#skin?.drawn(taxel) ?? null,
      project,
      pixel,
    };
  }
}
