// The links of the arm and the objects, at their stored poses.

import { Color, Group, type Object3D } from "three";

import type { Palette } from "../colours.ts";
import type { Reach } from "../reach.ts";
import { Leaves } from "./leaf.ts";
import { isBladePiece } from "./shapes.ts";
import { Solids } from "./solids.ts";

const WHITE = new Color(0xffffff);
/** How much of the accent colour the chosen object has. */
const CHOSEN = 0.6;

/** All bodies of a reach. */
export class Bodies extends Group {
  readonly #solids: Solids;
  readonly #leaves: Leaves;
  #painted: { palette: Palette; chosen: number | null } | null = null;

  constructor(readonly reach: Reach) {
    super();
    const blades = new Map<number, number[]>();
    const solids: number[] = [];
    reach.header.bodies.forEach((body, index) => {
      const object = body.owner.object;
      if (object === undefined || !isBladePiece(body)) solids.push(index);
      else blades.set(object, [...(blades.get(object) ?? []), index]);
    });
    // A blade of one piece does not bend.
    for (const [object, bodies] of blades) {
      if (bodies.length > 1) continue;
      solids.push(...bodies);
      blades.delete(object);
    }
    this.#solids = new Solids(reach, solids.filter((index) => reach.header.bodies[index]!.parts.length > 0));
    this.#leaves = new Leaves(reach, blades);
    this.add(this.#solids, this.#leaves);
  }

  /** Puts everything where it is in a frame. */
  place(frame: number): void {
    this.#solids.place(frame);
    this.#leaves.place(frame);
  }

  recolour(palette: Palette, chosen: number | null): void {
    if (this.#painted?.palette === palette && this.#painted.chosen === chosen) return;
    this.#painted = { palette, chosen };
    const [arm, accent] = [new Color(palette.variable("arm")), new Color(palette.variable("accent"))];
    const colours = this.reach.header.objects.map((_, object) => {
      const colour = new Color(palette.category(this.reach.category(object)));
      // In the shade of the lamp the colour is darker than in the legend.
      if (!palette.dark) colour.lerp(WHITE, 0.05);
      // Neighbours of one category differ a little in lightness.
      colour.offsetHSL(0, 0, 0.05 * ((object % 3) - 1));
      return object === chosen ? colour.lerp(accent, CHOSEN) : colour;
    });
    for (const batch of [this.#solids, this.#leaves]) batch.paint((object) => colours[object] ?? arm);
  }

  /** The object that a triangle of a mesh belongs to; -1 for the arm, null if the mesh is not from here. */
  objectOf(mesh: Object3D, triangle: number): number | null {
    const batch = [this.#solids, this.#leaves].find((batch) => batch === mesh);
    return batch === undefined ? null : batch.objectOf(triangle);
  }

  /** The vertices of a rigid body in its own frame and where they are drawn, m; null for a piece of a leaf. */
  drawn(body: number): { own: number[][]; world: number[][] } | null {
    return this.#solids.drawn(body);
  }

  /** Hinges and tip of the leaf that is this object. */
  hinges(object: number): number[][] | null {
    return this.#leaves.hinges(object);
  }
}
