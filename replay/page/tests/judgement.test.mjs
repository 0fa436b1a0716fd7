// How verdicts compare with the truth, without a browser.

import assert from "node:assert/strict";
import { dirname, resolve } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { runnerImport } from "vite";

const SOURCE = resolve(dirname(fileURLToPath(import.meta.url)), "../src/judgement.ts");
const { module: { judge } } = await runnerImport(SOURCE, { configFile: false });

/** How verdicts on these truths are judged, of a model that knows leaves and trunks. */
function judged(truths, verdict, touch) {
  return truths.map((truth) => judge(truth, verdict, { categories: ["leaf", "trunk"], touch }));
}

const TRUTHS = ["leaf", "outlier", "bottle", "block", "spurious"];

/** Tests the rule of `evaluate` for classifiers of trials: outlier is right for categories that the model does not know, and
 * nothing for foam blocks. */
test("an outlier is right where a classifier of trials does not know the category", () => {
  assert.deepEqual(judged(TRUTHS, "outlier", null), ["wrong", "right", "right", "wrong", "spurious"]);
  assert.deepEqual(judged(TRUTHS, "leaf", null), ["right", "wrong", "wrong", "wrong", "spurious"]);
  assert.deepEqual(judged(TRUTHS, "uncertain", null), ["uncertain", "uncertain", "uncertain", "uncertain", "spurious"]);
});

/** Tests that unknown is right for all categories that a touch model does not know, and nothing for readings without an object. */
test("unknown is right where a touch model does not know the category", () => {
  assert.deepEqual(judged(TRUTHS, "unknown", {}), ["wrong", "right", "right", "right", "wrong"]);
  assert.deepEqual(judged(TRUTHS, "nothing", {}), ["wrong", "wrong", "wrong", "wrong", "right"]);
});
