// How large the ground is, without a browser.

import assert from "node:assert/strict";
import { dirname, resolve } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { Box3, Vector3 } from "three";
import { runnerImport } from "vite";

const SOURCE = resolve(dirname(fileURLToPath(import.meta.url)), "../src/view/shadows.ts");
const { module: { Shadows } } = await runnerImport(SOURCE, { configFile: false });

/** Tests that grid and shadows have the usual 2 m if everything is within, and otherwise reach as far as what stands outside. */
test("the ground is under everything", () => {
  const shadows = new Shadows({ shadowMap: {} });
  const lamp = shadows.children.find((child) => child.isLight);
  const box = (...far) => new Box3(new Vector3(0, -0.5, 0), new Vector3(...far));
  for (const [whole, side] of [[new Box3(), 2], [box(0.7, 0.2, 1), 2], [box(2.05, 0.2, 1), 3], [box(0.7, 4, 1), 8.4], [box(500, 0, 0), 20]]) {
    const grid = shadows.lay(whole, -0.5);
    grid.geometry.computeBoundingBox();
    const { min, max } = grid.geometry.boundingBox;
    assert.ok(Math.abs(max.x - min.x - side) < 1e-6, `${max.x - min.x} in place of ${side}`);
    assert.ok(Math.abs(grid.geometry.attributes.position.count / 4 - 1 - 10 * side) < 1e-6, "lines are 10 cm apart");
    assert.deepEqual(grid.position.toArray(), [0.6, -0.2, -0.5]);
    const { left, right, near, far } = lamp.shadow.camera;
    const distance = lamp.position.distanceTo(lamp.target.position);
    assert.ok(Math.abs(right - left - side) < 1e-6 && near < distance && distance < far, `${[left, right, near, distance, far]}`);
  }
});
