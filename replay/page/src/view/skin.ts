// The taxels on the arm, one instance each, coloured by force or category. They are not shaded, so that their colours are
// those of the legend.

import {
  BoxGeometry, Color, Group, InstancedMesh, Matrix4, Mesh, MeshBasicMaterial, Quaternion, RingGeometry, Vector3,
} from "three";

import type { Reach } from "../reach.ts";
import { placeRow } from "./shapes.ts";

/** Height of a taxel's plate above its place, m. */
const LIFT_M = 0.0012;
const THICKNESS_M = 0.001;

/** Taxels of one patch, moved as a whole by the pose of its link. */
class PatchSkin extends Group {
  readonly plates: InstancedMesh;

  constructor(readonly reach: Reach, readonly patch: number) {
    super();
    const { first_taxel: first, taxels } = reach.header.patches[patch]!;
    this.plates = new InstancedMesh(new BoxGeometry(1, 1, THICKNESS_M), new MeshBasicMaterial(), taxels);
    this.plates.frustumCulled = false;
    const matrix = new Matrix4();
    for (let index = 0; index < taxels; index++) {
      const side = 0.86 * Math.sqrt(reach.taxelArea[first + index]!);
      matrix.compose(placeOf(reach, first + index, LIFT_M), turnOf(reach, first + index), new Vector3(side, side, 1));
      this.plates.setMatrixAt(index, matrix);
    }
    this.add(this.plates);
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
    for (const { plates, patch } of this.patches) {
      const { first_taxel: first, taxels } = this.reach.header.patches[patch]!;
      for (let index = 0; index < taxels; index++) plates.setColorAt(index, this.#colour.set(colourOf(first + index)));
      if (plates.instanceColor !== null) plates.instanceColor.needsUpdate = true;
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

  /** The taxel of an instance. */
  taxelOf(plates: InstancedMesh, instance: number): number | null {
    const patch = this.patches.find((patch) => patch.plates === plates);
    return patch === undefined ? null : this.reach.header.patches[patch.patch]!.first_taxel + instance;
  }

  /** Place of a taxel's plate and its colour, as they are drawn. */
  drawn(taxel: number): { position: number[]; colour: string } {
    const patch = this.patches[this.reach.patchOf[taxel]!]!;
    const index = taxel - this.reach.header.patches[patch.patch]!.first_taxel;
    const [matrix, colour] = [new Matrix4(), new Color()];
    patch.plates.getMatrixAt(index, matrix);
    patch.plates.getColorAt(index, colour);
    patch.updateWorldMatrix(true, false);
    const position = new Vector3().setFromMatrixPosition(matrix).applyMatrix4(patch.matrixWorld);
    return { position: position.toArray(), colour: `#${colour.getHexString()}` };
  }
}
