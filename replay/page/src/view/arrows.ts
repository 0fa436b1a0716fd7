// Arrows of the contact forces, with their newtons beside them.

import { type Camera, ConeGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, Vector3 } from "three";

import { element, newtons, say } from "../dom.ts";
import type { Push } from "../series.ts";

/** Length of an arrow, m per newton, and its largest length, m. */
export const METRES_PER_NEWTON = 0.04;
export const LONGEST_M = 0.25;
const SHORTEST_M = 0.012;
const HEAD_M = 0.016;
/** Weaker contacts have no arrow, N. */
export const WEAKEST_N = 0.02;

/** Width and height of a label, px: enough for "12.34 N". */
const LABEL_PX: [number, number] = [56, 18];

interface Arrow {
  group: Group;
  shaft: Mesh;
  label: HTMLElement;
  tail: Vector3;
  /** Where the label is, CSS pixels; null outside the view. */
  place: [number, number] | null;
}

export class Arrows extends Group {
  readonly #arrows: Arrow[] = [];
  readonly #plain = new MeshBasicMaterial();
  readonly #over = new MeshBasicMaterial();
  readonly #shaft = new CylinderGeometry(0.0025, 0.0025, 1, 8).translate(0, 0.5, 0);
  readonly #head = new ConeGeometry(0.007, HEAD_M, 12).translate(0, HEAD_M / 2, 0);

  constructor(readonly labels: HTMLElement) {
    super();
  }

  recolour(plain: string, over: string): void {
    this.#plain.color.set(plain);
    this.#over.color.set(over);
  }

  /** Shows these forces. The head of an arrow is at the skin and the tail away from it. `texts` brings their texts up to date. */
  show(pushes: Push[], limit: number | null, texts: boolean): void {
    const shown = pushes.filter((push) => Math.hypot(...push.force) >= WEAKEST_N);
    while (this.#arrows.length < shown.length) this.#add();
    this.#arrows.forEach((arrow, index) => {
      const push = shown[index];
      arrow.group.visible = push !== undefined;
      const appeared = arrow.label.hidden;
      arrow.label.hidden = push === undefined;
      if (push === undefined) return;
      const force = Math.hypot(...push.force);
      const over = limit !== null && push.largest > limit;
      const length = Math.min(Math.max(force * METRES_PER_NEWTON, SHORTEST_M), LONGEST_M);
      const direction = new Vector3(...push.force).normalize();
      arrow.tail.set(...push.place).addScaledVector(direction, -length - HEAD_M);
      arrow.group.position.copy(arrow.tail);
      arrow.group.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), direction);
      arrow.shaft.scale.y = length;
      for (const child of arrow.group.children as Mesh[]) child.material = over ? this.#over : this.#plain;
      (arrow.group.children[1] as Mesh).position.y = length;
      if (!texts && !appeared) return;
      arrow.label.classList.toggle("over", over);
      say(arrow.label, newtons(force));
    });
  }

  #add(): void {
    const group = new Group();
    const shaft = new Mesh(this.#shaft, this.#plain);
    group.add(shaft, new Mesh(this.#head, this.#plain));
    const label = element("span", { class: "force-label", "aria-hidden": "true" });
    this.labels.append(label);
    this.#arrows.push({ group, shaft, label, tail: new Vector3(), place: null });
    this.add(group);
  }

  /** Puts the labels where the tails are on the screen, one above the other where they would overlap. */
  placeLabels(camera: Camera, width: number, height: number): void {
    const taken: [number, number][] = [];
    for (const arrow of this.#arrows) {
      const { group, label, tail } = arrow;
      arrow.place = null;
      if (!group.visible) continue;
      const at = tail.clone().project(camera);
      const inside = Math.abs(at.x) < 1 && Math.abs(at.y) < 1 && at.z < 1;
      label.style.visibility = inside ? "visible" : "hidden";
      if (!inside) continue;
      const x = Math.min(Math.max(((at.x + 1) / 2) * width, LABEL_PX[0] / 2), width - LABEL_PX[0] / 2);
      let y = Math.max(((1 - at.y) / 2) * height, LABEL_PX[1]);
      for (let turn = 0; turn < taken.length; turn++) {
        const other = taken.find(([ox, oy]) => Math.abs(ox - x) < LABEL_PX[0] && Math.abs(oy - y) < LABEL_PX[1]);
        if (other === undefined) break;
        y = other[1] - LABEL_PX[1];
      }
      taken.push([x, y]);
      arrow.place = [x, y];
      label.style.transform = `translate(${x}px, ${y}px) translate(-50%, -100%)`;
    }
  }

  /** Writes the labels on a picture of the view. */
  write(context: CanvasRenderingContext2D, ground: string): void {
    context.font = "600 12px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const { label, place } of this.#arrows) {
      if (place === null) continue;
      const text = label.textContent ?? "";
      const width = context.measureText(text).width + 8;
      context.fillStyle = ground;
      context.fillRect(place[0] - width / 2, place[1] - 18, width, 18);
      context.fillStyle = getComputedStyle(label).color;
      context.fillText(text, place[0], place[1] - 9);
    }
  }
}
