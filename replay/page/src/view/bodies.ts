// The links of the arm and the objects, at their stored poses.

import { Color, DoubleSide, Group, Mesh, MeshLambertMaterial, type Object3D } from "three";

import type { Palette } from "../colours.ts";
import type { Reach } from "../reach.ts";
import { Leaf } from "./leaf.ts";
import { geometryOf, isBladePiece, place, placeBody } from "./shapes.ts";

const WHITE = new Color(0xffffff);

interface Moving {
  body: number;
  group: Group;
  row: number;
}

/** All bodies of a reach. */
export class Bodies extends Group {
  readonly #moving: Moving[] = [];
  readonly #leaves: Leaf[] = [];
  readonly #arm = new MeshLambertMaterial();
  readonly #objects: MeshLambertMaterial[];

  constructor(readonly reach: Reach) {
    super();
    this.#objects = reach.header.objects.map(() => new MeshLambertMaterial({ side: DoubleSide }));
    const pieces = new Map<number, number[]>();
    reach.header.bodies.forEach((body, index) => {
      const object = body.owner.object;
      if (object !== undefined && isBladePiece(body)) {
        const others = pieces.get(object);
        if (others === undefined) pieces.set(object, [index]);
        else others.push(index);
      } else if (body.parts.length > 0) this.#addBody(index, object);
    });
    for (const [object, bodies] of pieces) {
      if (bodies.length === 1) this.#addBody(bodies[0]!, object);
      else this.#addLeaf(object, bodies);
    }
  }

  #addBody(index: number, object: number | undefined): void {
    const group = new Group();
    const material = object === undefined ? this.#arm : this.#objects[object]!;
    for (const part of this.reach.header.bodies[index]!.parts) {
      const mesh = new Mesh(geometryOf(part.shape), material);
      place(mesh, part.pose_body);
      mesh.userData["object"] = object ?? null;
      group.add(mesh);
    }
    this.#moving.push({ body: index, group, row: -2 });
    this.add(group);
  }

  #addLeaf(object: number, bodies: number[]): void {
    const leaf = new Leaf(this.reach, bodies, this.#objects[object]!);
    leaf.userData["object"] = object;
    this.#leaves.push(leaf);
    this.add(leaf);
  }

  /** Puts everything where it is in a frame. */
  place(frame: number): void {
    for (const moving of this.#moving) {
      const row = this.reach.track(moving.body, frame);
      if (row === moving.row) continue;
      moving.row = placeBody(moving.group, this.reach, moving.body, frame);
    }
    for (const leaf of this.#leaves) leaf.update(this.reach, frame);
  }

  recolour(palette: Palette, chosen: number | null): void {
    this.#arm.color.set(palette.variable("arm"));
    const accent = new Color(palette.variable("accent"));
    this.#objects.forEach((material, object) => {
      material.color.set(palette.category(this.reach.category(object)));
      // In the shade of the lamp the colour is darker than in the legend.
      if (!palette.dark) material.color.lerp(WHITE, 0.05);
      // Neighbours of one category differ a little in lightness.
      material.color.offsetHSL(0, 0, 0.05 * ((object % 3) - 1));
      material.emissive.copy(accent).multiplyScalar(object === chosen ? 0.55 : 0);
    });
  }

  /** Where a body is drawn: its position and quaternion, or the hinges of a leaf. */
  drawn(body: number): { position: number[]; quaternion: number[] } | null {
    const moving = this.#moving.find((moving) => moving.body === body);
    if (moving === undefined) return null;
    const target: Object3D = moving.group;
    return { position: target.position.toArray(), quaternion: target.quaternion.toArray() as number[] };
  }

  /** Hinges and tip of the leaf that is this object. */
  hinges(object: number): number[][] | null {
    return this.#leaves.find((leaf) => leaf.userData["object"] === object)?.knots ?? null;
  }
}
