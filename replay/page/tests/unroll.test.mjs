// Where taxels lie on the flat map, without a browser.

import assert from "node:assert/strict";
import { dirname, resolve } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { runnerImport } from "vite";

const SOURCE = resolve(dirname(fileURLToPath(import.meta.url)), "../src/unroll.ts");
const { module: { layOut } } = await runnerImport(SOURCE, { configFile: false });

/** A patch without a grid, of taxels at these places that face these ways. */
function patch(places, normals) {
  return {
    header: { patches: [{ name: "finger", link: "finger", grid: null, first_taxel: 0, taxels: places.length }] },
    taxelPosition: Float32Array.from(places.flat()),
    taxelNormal: Float32Array.from(normals.flat()),
    tip: Float32Array.from([0, 0, 0.1, 0, 0, 0, 1]),
    patchPose: Float32Array.from([0, 0, 0, 0, 0, 0, 1]),
  };
}

/** Tests that the map has a size when a taxel has no neighbour on its side: one taxel, one on each side, one of three
 * alone on its side, two in one place. */
test("a taxel without a neighbour has a place on the map", () => {
  const [front, back] = [[0, 1, 0], [0, -1, 0]];
  const patches = [
    patch([[0.01, 0, 0.02]], [front]),
    patch([[0, 0.01, 0.02], [0, -0.01, 0.03]], [front, back]),
    patch([[0.01, 0.01, 0.02], [0.02, 0.01, 0.06], [0.01, -0.01, 0.03]], [front, front, back]),
    patch([[0.01, 0.01, 0.02], [0.01, 0.01, 0.02]], [front, front]),
  ];
  assert.ok(layOut(patch([[0.01, 0, 0.01], [0.01, 0, 0.05]], [front, front]), 0).upwards);
  assert.ok(!layOut(patch([[0.05, 0, 0.1], [-0.05, 0, 0.1]], [front, front]), 0).upwards);
  // A patch that faces one way fills its map.
  for (const facing of [front, back]) {
    const plan = layOut(patch([[0, 0, 0], [0.02, 0, 0], [0, 0, 0.05], [0.02, 0, 0.05]], [facing, facing, facing, facing]), 0);
    assert.ok(!plan.twoSides && Math.max(...plan.cells.map(({ x, size }) => x + size / 2)) > 0.85 * plan.width);
  }
  for (const reach of patches) {
    const { cells, width, height } = layOut(reach, 0);
    assert.equal(cells.length, reach.taxelPosition.length / 3);
    assert.ok(width > 0.005 && width < 1 && height > 0.005 && height < 1, `${width} by ${height}`);
    for (const { x, y, size } of cells) {
      assert.ok(size > 0.005 && x > 0 && x < width && y > 0 && y < height, `${x}, ${y}, ${size} on ${width} by ${height}`);
    }
  }
});

/** Tests that the map of a square pad has upright rows and columns, also on a pad that is turned on its link, and on both sides. */
test("a square pad is not turned on its map", () => {
  for (const angle of [0, 0.5]) {
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const places = Array.from({ length: 16 }, (_, index) => [index % 4, Math.floor(index / 4)]);
    const turned = places.map(([x, y]) => [0.01 * (cos * x - sin * y), 0.01 * (sin * x + cos * y), 0]);
    const both = [...turned, ...turned.map(([x, y]) => [x, y, 0.001])];
    const facing = (side) => places.map(() => [0, 0, side]);
    for (const [pad, columns] of [[patch(turned, facing(1)), 4], [patch(both, [...facing(1), ...facing(-1)]), 8]]) {
      const { cells } = layOut(pad, 0);
      const lines = (axis) => new Set(cells.map((cell) => cell[axis].toFixed(5))).size;
      assert.deepEqual([lines("x"), lines("y")], [columns, 4], JSON.stringify(cells));
    }
  }
});
