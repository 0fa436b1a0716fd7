// Many bodies as one mesh. Where a processor draws, every draw call costs more than the few triangles of a body, so the vertices
// are moved here and sent at once.

import { BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Mesh, type ShaderMaterial, type Side } from "three";

import { inShade, lightOn, shaded, tint } from "./light.ts";

/** Vertices with a normal and a colour each, which belong to objects. */
export class Batch extends Mesh<BufferGeometry, ShaderMaterial> {
  /** Three numbers a vertex: where it is, m, and its normal, world frame. */
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  readonly #position: BufferAttribute;
  readonly #tint: BufferAttribute;
  readonly #owners: Int16Array;
  readonly #thin: boolean;
  #colours = new Map<number, Color>();

  /** `owners` has the object of each vertex, or -1 for a link of the arm; `index` three vertices a triangle. */
  constructor(owners: Int16Array, index: number[], side: Side) {
    super(new BufferGeometry(), shaded(side));
    this.castShadow = this.receiveShadow = true;
    this.#owners = owners;
    this.#thin = side === DoubleSide;
    this.positions = new Float32Array(3 * owners.length);
    this.normals = new Float32Array(3 * owners.length);
    this.#position = new BufferAttribute(this.positions, 3).setUsage(DynamicDrawUsage);
    this.#tint = new BufferAttribute(new Uint8Array(4 * owners.length), 4, true).setUsage(DynamicDrawUsage);
    this.geometry.setAttribute("position", this.#position).setAttribute("tint", this.#tint);
    this.geometry.setIndex(index);
    this.frustumCulled = false;
  }

  /** Says that vertices from `first` on have moved. */
  moved(first: number, count: number): void {
    this.#position.needsUpdate = true;
    this.#shade(first, count);
    // The next click finds it anew.
    this.geometry.boundingSphere = null;
  }

  /** Gives every vertex the colour of its object, or of the arm for -1. */
  paint(colourOf: (object: number) => Color): void {
    for (const owner of new Set(this.#owners)) this.#colours.set(owner, colourOf(owner));
    this.#shade(0, this.#owners.length);
  }

  #shade(first: number, count: number): void {
    const { normals } = this;
    const bytes = this.#tint.array as Uint8Array;
    for (let vertex = first; vertex < first + count; vertex++) {
      const colour = this.#colours.get(this.#owners[vertex]!);
      if (colour === undefined) continue;
      const [x, y, z] = [normals[3 * vertex]!, normals[3 * vertex + 1]!, normals[3 * vertex + 2]!];
      tint(bytes, vertex, colour, lightOn(x, y, z, this.#thin));
      bytes[4 * vertex + 3] = 255 * inShade(x, y, z, this.#thin);
    }
    this.#tint.needsUpdate = true;
  }

  /** The object that a triangle belongs to, or -1 for the arm. */
  objectOf(triangle: number): number {
    return this.#owners[this.geometry.index!.getX(3 * triangle)]!;
  }
}
