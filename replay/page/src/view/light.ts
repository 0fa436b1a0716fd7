// Light and colours of what is drawn. Where a processor draws, a shader that computes light for every pixel takes most of a
// frame, so light is computed here for every vertex that has moved, and the shader only passes colours on.

import { type Color, ShaderMaterial, type Side, UniformsLib, UniformsUtils } from "three";

/** Direction of the lamp, of length 1, world frame: from the left behind the viewer of the first view. */
export const LAMP = [-0.2242, -0.5231, 0.8222] as const;
/** Light from all around: from above, and from below as a share of it. */
const AROUND = 0.74;
const BELOW = 0.72;
/** Light of the lamp on a surface that faces it. */
const DIRECT = 0.68;

/** Steps of the table from linear light to what a screen shows. */
const STEPS = 2048;
const SHOWN = Uint8Array.from({ length: STEPS + 1 }, (_, step) => {
  const light = step / STEPS;
  return Math.round(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055));
});

/** A colour of linear light as a screen shows it, 0 to 255. */
export function shown(light: number): number {
  return SHOWN[light >= 1 ? STEPS : Math.round(light * STEPS)]!;
}

/** The light on a surface with this normal, which need not have length 1. A thin surface is lit from the side that is nearer. */
export function lightOn(x: number, y: number, z: number, thin: boolean): number {
  const length = Math.sqrt(x * x + y * y + z * z) || 1;
  const [up, facing] = [z / length, (x * LAMP[0] + y * LAMP[1] + z * LAMP[2]) / length];
  if (thin) return AROUND * (0.5 + 0.5 * BELOW) + DIRECT * Math.abs(facing);
  return AROUND * (BELOW + (1 - BELOW) * (0.5 + 0.5 * up)) + DIRECT * Math.max(facing, 0);
}

/** A material that shows the attribute `tint`, four bytes a vertex, as it is; seen through if `opacity` is below 1. */
export function tinted(side: Side, opacity = 1): ShaderMaterial {
  return new ShaderMaterial({
    side,
    transparent: opacity < 1,
    vertexShader: "attribute vec4 tint; varying vec3 shown; void main() { shown = tint.rgb; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
    fragmentShader: `varying vec3 shown; void main() { gl_FragColor = vec4(shown, ${opacity.toFixed(2)}); }`,
  });
}

/** As `tinted`, darker where something is between the lamp and the surface: there the colour is multiplied by the fourth byte. */
export function shaded(side: Side): ShaderMaterial {
  return new ShaderMaterial({
    side,
    lights: true,
    uniforms: UniformsUtils.merge([UniformsLib.lights]),
    vertexShader: `
      #include <common>
      #include <shadowmap_pars_vertex>
      attribute vec4 tint;
      varying vec4 shown;
      void main() {
        shown = tint;
        vec4 worldPosition = modelMatrix * vec4(position, 1.0);
        vec4 mvPosition = viewMatrix * worldPosition;
        gl_Position = projectionMatrix * mvPosition;
        #include <shadowmap_vertex>
      }`,
    fragmentShader: `
      #include <common>
      #include <bsdfs>
      #include <lights_pars_begin>
      #include <shadowmap_pars_fragment>
      #include <shadowmask_pars_fragment>
      varying vec4 shown;
      void main() {
        gl_FragColor = vec4(shown.rgb * mix(shown.a, 1.0, getShadowMask()), 1.0);
      }`,
  });
}

/** The share of a colour that is left on a surface with this light when the lamp is hidden, as a screen shows it. */
export function inShade(x: number, y: number, z: number, thin: boolean): number {
  const up = z / (Math.sqrt(x * x + y * y + z * z) || 1);
  const around = AROUND * (thin ? 0.5 + 0.5 * BELOW : BELOW + (1 - BELOW) * (0.5 + 0.5 * up));
  return (around / lightOn(x, y, z, thin)) ** (1 / 2.4);
}

/** Writes a colour under a light into the bytes of a vertex. */
export function tint(bytes: Uint8Array, vertex: number, colour: Color, light: number): void {
  bytes[4 * vertex] = shown(colour.r * light);
  bytes[4 * vertex + 1] = shown(colour.g * light);
  bytes[4 * vertex + 2] = shown(colour.b * light);
}
