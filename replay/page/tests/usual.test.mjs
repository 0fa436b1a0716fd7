// What is usual for regions of a category, without a browser.

import assert from "node:assert/strict";
import { dirname, resolve } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { runnerImport } from "vite";

const SOURCE = resolve(dirname(fileURLToPath(import.meta.url)), "../src/usual.ts");
const { module: { UsualFeatures } } = await runnerImport(SOURCE, { configFile: false });

/** A reach of this many frames in which taxels 0 and 1 are one region and taxel 2 another one. Taxel 0 is pressed by a leaf with 1 N,
 * taxel 1 by a trunk with `trunk_n`, and taxel 2 reads something without an object. The one feature of the first region is the frame,
 * that of the second minus the frame. */
function made(frames, trunk_n) {
  const objects = [0, 1, -1];
  const reach = {
    header: { verdicts: { features: ["frame"] } },
    sensed: Float32Array.from({ length: 3 * frames }, (_, row) => [1, trunk_n, 0.2][row % 3]),
    readingObject: Int16Array.from({ length: 3 * frames }, (_, row) => objects[row % 3]),
    reading: (taxel, frame) => 3 * frame + taxel,
    category: (object) => ["leaf", "trunk"][object] ?? "spurious",
  };
  const every = (count) => Uint32Array.from({ length: frames + 1 }, (_, frame) => count * frame);
  const touch = {
    start: every(2),
    ofVerdict: Uint16Array.from({ length: 3 * frames }, (_, row) => [0, 0, 1][row % 3]),
    features: Float32Array.from({ length: 2 * frames }, (_, row) => (row % 2 === 0 ? row / 2 : -(row - 1) / 2)),
  };
  const verdictTaxel = Uint32Array.from({ length: 3 * frames }, (_, row) => row % 3);
  return new UsualFeatures(reach, { touch, verdictStart: every(3), verdictTaxel });
}

/** Tests the tenth and nine tenths of the values, and that a region has the category that presses on its strongest taxel. */
test("the usual range of a category is from a tenth to nine tenths", () => {
  const leaf = made(101, 0.5);
  assert.deepEqual(leaf.of("leaf"), [[10, 90]]);
  assert.deepEqual(leaf.of("spurious"), [[-90, -10]]);
  assert.equal(leaf.of("trunk"), null);
  assert.deepEqual(made(101, 2).of("trunk"), [[10, 90]]);
});

/** Tests that nothing is called usual after few regions. */
test("few regions say nothing about what is usual", () => {
  assert.equal(made(19, 0.5).of("leaf"), null);
  assert.notEqual(made(20, 0.5).of("leaf"), null);
});
