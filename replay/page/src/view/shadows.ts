// Soft shadows of one lamp, on the bodies and on the ground.

import { type Box3, DirectionalLight, GridHelper, Group, Mesh, PCFShadowMap, PlaneGeometry, ShadowMaterial, type WebGLRenderer } from "three";

import { LAMP } from "./light.ts";

/** The middle of the ground, the square in which grid and shadows are, m. */
const GROUND = { x: 0.6, y: -0.2 } as const;
/** Its side, m: the usual one, a larger one under what is outside of that, and the largest, for what falls from a table and rolls away. */
const SIDES_M = [2, 20] as const;
/** Distance of the lines of the grid, m. */
const GRID_M = 0.1;
/** Pixels of the shadow map in each direction: 2 mm each on the usual ground. */
const PIXELS = 1024;
/** How dark a shadow is on the ground. */
const DARKNESS = 0.22;
/** A surface does not shade itself by less than this share of the depth of what is lit. */
const BIAS = 0.0015;

export class Shadows extends Group {
  readonly #lamp = new DirectionalLight();
  readonly #ground = new Mesh(new PlaneGeometry(), new ShadowMaterial({ opacity: DARKNESS, depthWrite: false }));

  #laid = false;

  constructor(readonly renderer: WebGLRenderer) {
    super();
    renderer.shadowMap.enabled = true;
    // Soft edges: several readings of the map for each pixel.
    renderer.shadowMap.type = PCFShadowMap;
    // A view that only turns keeps its shadows.
    renderer.shadowMap.autoUpdate = false;
    const { shadow } = this.#lamp;
    shadow.mapSize.set(PIXELS, PIXELS);
    shadow.radius = 3;
    shadow.bias = -BIAS;
    this.#ground.receiveShadow = true;
    this.add(this.#lamp, this.#lamp.target, this.#ground);
  }

  /** Puts the ground under all that is in this box, at a height, m; null for none. Gives the grid on it. */
  lay({ min, max }: Box3, height: number | null): GridHelper {
    const half = Math.max(max.x - GROUND.x, GROUND.x - min.x, max.y - GROUND.y, GROUND.y - min.y, SIDES_M[0] / 2);
    const side = Math.min(2 * GRID_M * Math.ceil(half / GRID_M - 1e-6), SIDES_M[1]);
    this.#laid = height !== null;
    this.#ground.scale.setScalar(side);
    this.#ground.position.set(GROUND.x, GROUND.y, (height ?? 0) - 0.0005);
    this.#lamp.target.position.set(GROUND.x, GROUND.y, height ?? 0);
    this.#lamp.position.fromArray(LAMP).multiplyScalar(side).add(this.#lamp.target.position);
    const { camera } = this.#lamp.shadow;
    Object.assign(camera, { left: -side / 2, right: side / 2, top: side / 2, bottom: -side / 2, near: side / 4, far: 1.75 * side });
    camera.updateProjectionMatrix();
    const grid = new GridHelper(side, Math.round(side / GRID_M));
    grid.rotation.x = Math.PI / 2;
    grid.position.copy(this.#lamp.target.position);
    grid.visible = this.#laid;
    grid.material.vertexColors = false;
    return grid;
  }

  /** Casts shadows anew where everything is now, or none. */
  cast(wanted: boolean): void {
    this.#lamp.castShadow = wanted;
    this.#ground.visible = wanted && this.#laid;
    this.renderer.shadowMap.needsUpdate = wanted;
  }
}
