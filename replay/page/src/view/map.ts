// The controller's map: a cage around every obstacle that it believes in, beside the objects as they truly are.

import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments } from "three";

import type { Palette } from "../colours.ts";
import type { MappedObstacle, Reach } from "../reach.ts";

const SIDES = 16;
/** Cages stand this far below their top where nothing says where the ground is, m. */
const DEPTH_M = 0.4;

/** Two circles of radius 1 around z, at heights 0 and 1, with every fourth upright between them. */
function cage(): BufferGeometry {
  const points: number[] = [];
  const at = (side: number, height: number) => [Math.cos((2 * Math.PI * side) / SIDES), Math.sin((2 * Math.PI * side) / SIDES), height];
  for (let side = 0; side < SIDES; side++) {
    for (const height of [0, 1]) points.push(...at(side, height), ...at(side + 1, height));
    if (side % 4 === 0) points.push(...at(side, 0), ...at(side, 1));
  }
  return new BufferGeometry().setAttribute("position", new BufferAttribute(Float32Array.from(points), 3));
}

export class ControllerMap extends Group {
  readonly #cages: LineSegments[] = [];
  readonly #shape = cage();
  readonly #materials = { fixed: new LineBasicMaterial(), doubtful: new LineBasicMaterial(), yielding: new LineBasicMaterial() };

  recolour(palette: Palette): void {
    this.#materials.fixed.color.set(palette.variable("ink"));
    this.#materials.doubtful.color.set(palette.category("uncertain"));
    this.#materials.yielding.color.set(palette.category("leaf"));
  }

  /** Shows the map of a frame. The obstacles stand on ground of this height, m. */
  show(reach: Reach, frame: number, ground: number | null): void {
    const now = reach.mapAt(frame);
    while (this.#cages.length < now.length) {
      const own = new LineSegments(this.#shape, this.#materials.fixed);
      own.frustumCulled = false;
      this.#cages.push(own);
      this.add(own);
    }
    this.#cages.forEach((own, index) => {
      const obstacle: MappedObstacle | undefined = now[index];
      own.visible = obstacle !== undefined;
      if (obstacle === undefined) return;
      const [x, y, top] = obstacle.top_world as [number, number, number];
      const foot = ground === null ? top - DEPTH_M : Math.min(ground, top);
      own.material = this.#materials[obstacle.kind];
      own.position.set(x, y, foot);
      own.scale.set(obstacle.radius_m, obstacle.radius_m, Math.max(top - foot, 0.001));
    });
  }

  /** How many obstacles are drawn. */
  get drawn(): number {
    return this.#cages.filter((own) => own.visible).length;
  }
}
