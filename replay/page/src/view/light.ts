// Light and colours of what is drawn. Where a processor draws, a shader that computes light for every pixel takes most of a
// frame, so light is computed here for every vertex that has moved, and the shader only passes colours on.

import { type Color, ShaderMaterial, type Side } from "three";

/** Direction of the lamp, of length 1, world frame: from the left behind the viewer of the first view. */
const LAMP = [-0.2242, -0.5231, 0.8222] as const;
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

/** A material that shows the attribute `tint`, four bytes a vertex, as it is. */
export function tinted(side: Side): ShaderMaterial {
  return new ShaderMaterial({
    side,
    vertexShader: "attribute vec4 tint; varying vec3 shown; void main() { shown = tint.rgb; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
    fragmentShader: "varying vec3 shown; void main() { gl_FragColor = vec4(shown, 1.0); }",
  });
}

/** Writes a colour under a light into the bytes of a vertex. */
export function tint(bytes: Uint8Array, vertex: number, colour: Color, light: number): void {
  bytes[4 * vertex] = shown(colour.r * light);
  bytes[4 * vertex + 1] = shown(colour.g * light);
  bytes[4 * vertex + 2] = shown(colour.b * light);
}
