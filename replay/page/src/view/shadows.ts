// Soft shadows of one lamp, on the bodies and on the ground.

import { DirectionalLight, Group, Mesh, PCFShadowMap, PlaneGeometry, ShadowMaterial, type WebGLRenderer } from "three";

import { LAMP } from "./light.ts";

/** Where shadows are: a square on the ground as large as the grid, its middle and its side, m. */
export const GROUND = { x: 0.6, y: -0.2, side_m: 2 } as const;
/** Pixels of the shadow map in each direction: 2 mm each. */
const PIXELS = 1024;
/** How dark a shadow is on the ground. */
const DARKNESS = 0.22;
/** A surface does not shade itself by less than this share of the depth of what is lit. */
const BIAS = 0.0015;
/** Distance of the lamp from the middle of the ground, m. */
const LAMP_M = 2;

export class Shadows extends Group {
  readonly #lamp = new DirectionalLight();
  readonly #ground = new Mesh(new PlaneGeometry(GROUND.side_m, GROUND.side_m), new ShadowMaterial({ opacity: DARKNESS, depthWrite: false }));

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
    const half = GROUND.side_m / 2;
    Object.assign(shadow.camera, { left: -half, right: half, top: half, bottom: -half, near: LAMP_M - 1.5, far: LAMP_M + 1.5 });
    this.#ground.receiveShadow = true;
    this.add(this.#lamp, this.#lamp.target, this.#ground);
  }

  /** Puts the ground at a height, m; null for none. */
  lay(height: number | null): void {
    this.#laid = height !== null;
    this.#ground.position.set(GROUND.x, GROUND.y, (height ?? 0) - 0.0005);
    this.#lamp.target.position.set(GROUND.x, GROUND.y, height ?? 0);
    this.#lamp.position.fromArray(LAMP).multiplyScalar(LAMP_M).add(this.#lamp.target.position);
  }

  /** Casts shadows anew where everything is now, or none. */
  cast(wanted: boolean): void {
    this.#lamp.castShadow = wanted;
    this.#ground.visible = wanted && this.#laid;
    this.renderer.shadowMap.needsUpdate = wanted;
  }
}
