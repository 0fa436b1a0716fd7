// The taxels on the arm, a small plate each, coloured by force or category. They are not shaded, so that their colours are
// those of the legend.

import {
  BufferAttribute, BufferGeometry, Color, FrontSide, Group, Matrix4, Mesh, MeshBasicMaterial, type Object3D, Quaternion, RingGeometry,
  type ShaderMaterial, Vector3,
} from "three";

import type { Reach } from "../reach.ts";
import { tint, tinted } from "./light.ts";
import { placeRow } from "./shapes.ts";

/** Height of a taxel's plate above its place, m. */
const LIFT_M = 0.0012;

/** Corners of a plate, two triangles. */
const CORNERS = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]] as const;

/** Taxels of one patch as one mesh, moved as a whole by the pose of its link. Instances of a plate would be drawn one by one
 * where a processor draws. */
class PatchSkin extends Group {
  readonly plates: Mesh<BufferGeometry, ShaderMaterial>;

  constructor(readonly reach: Reach, readonly patch: number) {
    super();
    const { first_taxel: first, taxels } = reach.header.patches[patch]!;
    const geometry = new BufferGeometry();
    const positions = new Float32Array(12 * taxels);
    const [matrix, corner, index] = [new Matrix4(), new Vector3(), [] as number[]];
    for (let taxel = 0; taxel < taxels; taxel++) {
      const side = 0.86 * Math.sqrt(reach.taxelArea[first + taxel]!);
      matrix.compose(placeOf(reach, first + taxel, LIFT_M), turnOf(reach, first + taxel), new Vector3(side, side, 1));
      CORNERS.forEach(([x, y], at) => corner.set(x, y, 0).applyMatrix4(matrix).toArray(positions, 12 * taxel + 3 * at));
      index.push(...[0, 1, 2, 0, 2, 3].map((at) => 4 * taxel + at));
    }
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("tint", new BufferAttribute(new Uint8Array(16 * taxels), 4, true));
    geometry.setIndex(index);
    this.plates = new Mesh(geometry, tinted(FrontSide));
    this.add(this.plates);
  }

  /** Colours a taxel of the patch. */
  paint(taxel: number, colour: Color): void {
    const colours = this.plates.geometry.getAttribute("tint") as BufferAttribute;
    for (let at = 4 * taxel; at < 4 * taxel + 4; at++) tint(colours.array as Uint8Array, at, colour, 1);
    colours.needsUpdate = true;
  }

  /** Where the middle of a taxel of the patch is drawn, m, world frame, and in which colour. */
  drawn(taxel: number): { position: number[]; colour: string } {
    const { position, tint } = this.plates.geometry.attributes as { position: BufferAttribute; tint: BufferAttribute };
    const [low, high] = [4 * taxel, 4 * taxel + 2].map((at) => new Vector3().fromBufferAttribute(position, at)) as [Vector3, Vector3];
    this.updateWorldMatrix(true, false);
    const middle = low.add(high).multiplyScalar(0.5).applyMatrix4(this.matrixWorld);
    return { position: middle.toArray(), colour: `#${[...tint.array.slice(16 * taxel, 16 * taxel + 3)].map((byte) => byte.toString(16).padStart(2, "0")).join("")}` };
  }
}

function placeOf(reach: Reach, taxel: number, lift: number): Vector3 {
  const normal = new Vector3().fromArray(reach.taxelNormal, 3 * taxel);
  return new Vector3().fromArray(reach.taxelPosition, 3 * taxel).addScaledVector(normal, lift);
}

/** The rotation of a plate: x along the taxel's tangent, z along its normal. */
function turnOf(reach: Reach, taxel: number): Quaternion {
  const normal = new Vector3().fromArray(reach.taxelNormal, 3 * taxel);
  const tangent = new Vector3().fromArray(reach.taxelTangent, 3 * taxel);
  const basis = new Matrix4().makeBasis(tangent, new Vector3().crossVectors(normal, tangent), normal);
  return new Quaternion().setFromRotationMatrix(basis);
}

/** The skin of the whole arm. */
export class Skin extends Group {
  readonly patches: PatchSkin[];
  readonly #ring = new Mesh(new RingGeometry(0.9, 1.15, 24), new MeshBasicMaterial({ depthTest: false, transparent: true }));
  readonly #colour = new Color();
  /** The CSS colour that each taxel has. */
  readonly #painted: string[] = [];

  constructor(readonly reach: Reach) {
    super();
    this.patches = reach.header.patches.map((_, patch) => new PatchSkin(reach, patch));
    if (this.patches.length > 0) this.add(...this.patches);
    this.#ring.renderOrder = 2;
    this.#ring.visible = false;
  }

  /** Puts the patches where their links are in a frame. */
  place(frame: number): void {
    this.patches.forEach((patch, index) => placeRow(patch, this.reach.patchPose, frame * this.patches.length + index));
  }

  /** Colours every taxel; `colourOf` gives a CSS colour. */
  paint(colourOf: (taxel: number) => string): void {
    for (const patch of this.patches) {
      const { first_taxel: first, taxels } = this.reach.header.patches[patch.patch]!;
      for (let index = 0; index < taxels; index++) {
        const colour = colourOf(first + index);
        if (this.#painted[first + index] === colour) continue;
        this.#painted[first + index] = colour;
        patch.paint(index, this.#colour.set(colour));
      }
    }
  }

  /** Puts a ring around the chosen taxel. */
  mark(taxel: number | null, colour: string): void {
    this.#ring.visible = taxel !== null;
    if (taxel === null) return;
    this.#ring.material.color.set(colour);
    this.#ring.scale.setScalar(0.8 * Math.sqrt(this.reach.taxelArea[taxel]!));
    this.#ring.position.copy(placeOf(this.reach, taxel, 3 * LIFT_M));
    this.#ring.quaternion.copy(turnOf(this.reach, taxel));
    this.patches[this.reach.patchOf[taxel]!]!.add(this.#ring);
  }

  /** The taxel of a triangle of a mesh, or null if the mesh is no skin. */
  taxelOf(mesh: Object3D, triangle: number): number | null {
    const patch = this.patches.find((patch) => patch.plates === mesh);
    return patch === undefined ? null : this.reach.header.patches[patch.patch]!.first_taxel + Math.floor(triangle / 2);
  }

  /** Place of a taxel's plate and its colour, as they are drawn. */
  drawn(taxel: number): { position: number[]; colour: string } {
    const patch = this.patches[this.reach.patchOf[taxel]!]!;
    return patch.drawn(taxel - this.reach.header.patches[patch.patch]!.first_taxel);
  }
}
