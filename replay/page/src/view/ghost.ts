// The arm of another reach, seen through.

import { FrontSide } from "three";

import type { Reach } from "../reach.ts";
import { tinted } from "./light.ts";
import { Solids } from "./solids.ts";

const OPACITY = 0.35;

/** The links of the arm of a reach. */
export class Ghost extends Solids {
  constructor(reach: Reach) {
    super(reach, [...reach.header.bodies.keys()].filter((body) => reach.header.bodies[body]!.owner.link !== undefined && reach.header.bodies[body]!.parts.length > 0));
    this.material.dispose();
    this.material = tinted(FrontSide, OPACITY);
    this.castShadow = false;
    // Where both arms are at the same place, only the arm itself is seen.
    Object.assign(this.material, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  }

  /** Puts it where it is at a time of its run, s; after its end, where it has ended. */
  placeAt(time: number): void {
    this.place(this.reach.frameAt(time));
  }
}
