// The list of mistakes: objects for a touch model, trials for a classifier of trials, against the command line and the recording.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { SCENES, felt, file, finish, finishAll, launch, makeData, open, program, readRecording, ready, serve, settle, state } from "./support.mjs";

let browser;
before(async () => {
  await makeData();
  browser = await launch();
});
after(() => finishAll(browser));

/** What the command line says, as a map from taxel to verdict for each frame, and what each taxel feels. */
async function judged(scene, model, ...options) {
  const { recording, rows } = await readRecording(`${scene}.parquet`);
  const { patches } = recording.layout;
  // A classifier of trials judges the first patch alone and names none.
  const first = (patch = patches[0].name) => patches.slice(0, patches.findIndex(({ name }) => name === patch)).reduce((sum, { taxels }) => sum + taxels.length, 0);
  const lines = program("classify", file(model), file(`${scene}.parquet`), ...options).trim().split("\n").map((line) => JSON.parse(line));
  const said = lines.map(({ taxels }) => new Map(taxels.map(({ patch, taxel, verdict }) => [first(patch) + taxel, verdict])));
  const category = (object) => (object < 0 ? "spurious" : (recording.objects[object].category.name ?? recording.objects[object].category));
  return { recording, rows, category, moments: rows.map((row, frame) => felt(recording, row).filter(({ taxel }) => said[frame].has(taxel)).map((own) => ({ ...own, verdict: said[frame].get(own.taxel) }))) };
}

const most = (counts) => [...counts].sort((a, b) => b[1] - a[1])[0][0];
const count = (map, name, amount = 1) => map.set(name, (map.get(name) ?? 0) + amount);
const isMistake = (judgement) => judgement === "wrong" || judgement === "uncertain";

/** A row of the list from { frame, force, verdict, judgement } in order of time; null unless most verdicts are wrong or uncertain, judged
 * by `judge`. */
function summary(moments, judge) {
  const against = moments.map(({ verdict }) => verdict).filter((verdict) => isMistake(judge(verdict)));
  if (against.length <= moments.length / 2) return null;
  const times = new Map();
  for (const verdict of against) count(times, verdict);
  const wrong = moments.filter(({ judgement }) => judgement === "wrong");
  const runs = [];
  for (const { frame } of wrong.length > 0 ? wrong : moments.filter(({ judgement }) => judgement === "uncertain")) {
    if (runs.at(-1)?.at(-1) === frame - 1) runs.at(-1).push(frame);
    else runs.push([frame]);
  }
  const forces = wrong.map(({ force }) => force);
  const run = runs.sort((a, b) => b.length - a.length)[0];
  return { verdict: most(times), judgement: judge(most(times)), wrong_s: wrong.length / 100, contact_s: moments.length / 100, mean: forces.reduce((sum, force) => sum + force, 0) / (forces.length || 1), peak: Math.max(0, ...forces), run: [run?.[0], run?.at(-1)] };
}

/** The rows that the page must list, the worst first. */
const ordered = (rows) => rows.sort((a, b) => b.wrong_s * b.mean - a.wrong_s * a.mean || a.run[0] - b.run[0]);

/** Opens the list of mistakes of a reach. */
async function openList(scene, model) {
  const server = await serve(file(`${scene}.parquet`), "--model", file(model));
  const page = await open(browser, server.address);
  await ready(page);
  await page.locator("#tab-mistakes").click();
  const texts = await page.locator("#panel-mistakes tbody tr").evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
  return { page, texts, close: async () => { await finish(page); server.close(); } };
}

function compare([object, , truth, verdict, judgement, ...numbers], expected) {
  assert.deepEqual([object, truth, verdict, judgement], [expected.object, expected.truth, expected.verdict, expected.judgement]);
  const values = [expected.wrong_s, expected.contact_s, expected.mean, expected.peak, expected.run[0] / 100];
  numbers.forEach((text, index) => assert.ok(Math.abs(Number(text) - values[index]) <= 0.00501, `${numbers} is not ${values}`));
}

/** Tests that a click on a row goes to its longest wrong run, with the lines at the current time, and shades the run on timeline
 * and strips. */
async function follows(page, row, { run, duration }) {
  await page.locator("#panel-mistakes tbody tr").nth(row).click();
  await settle(page);
  assert.equal((await state(page)).frame, run[0]);
  assert.equal(await page.locator('#panel-mistakes tr[aria-current="true"]').count(), 1);
  for (const place of ["#timeline", "#strips"]) {
    const shade = await page.locator(`${place} .shade`).boundingBox();
    const canvas = await page.locator(`${place} canvas`).boundingBox();
    // The time axis leaves 74 px on the left and 10 px on the right.
    const x = (frame) => canvas.x + 74 + (frame / 100 / duration) * (canvas.width - 84);
    assert.ok(Math.abs(shade.x - x(run[0])) < 1.5, `${place}: the shade begins at ${shade.x}, not ${x(run[0])}`);
    const width = Math.max(x(run[1] + 1) - x(run[0]), 3);
    assert.ok(Math.abs(shade.width - width) < 2.5, `${place}: the shade is ${shade.width} px wide, not ${width}`);
    if (place === "#timeline") continue;
    // The plots share the axis of the strips.
    const heads = await page.locator(".playhead:visible").evaluateAll((lines) => lines.map((line) => line.getBoundingClientRect().x));
    assert.ok(heads.length > 4 && heads.every((head) => Math.abs(head - x(run[0])) < 2), `the lines at the current time are at ${heads}, not ${x(run[0])}`);
  }
}

/** Tests that a touch model has one row for each object that it judged wrongly for most of the time, with the times and forces
 * that follow from the command line, that a click leads to its moment, and that the features of its region are unfolded. */
test("mistakes of a touch model are objects", async () => {
  let all = 0;
  for (const scene of SCENES) {
    const { recording, rows, category, moments } = await judged(scene, "touch.json");
    const right = (truth) => (["leaf", "trunk"].includes(truth) ? truth : "unknown");
    const expected = recording.objects.map((_, object) => {
      const truth = category(object);
      const judge = (verdict) => (verdict === right(truth) ? "right" : verdict === "uncertain" ? "uncertain" : "wrong");
      const own = moments.flatMap((taxels, frame) => {
        const pressed = taxels.filter((taxel) => taxel.object === object);
        if (pressed.length === 0) return [];
        const forces = new Map();
        for (const { verdict, force } of pressed) count(forces, verdict, force);
        return [{ frame, force: pressed.reduce((sum, { force }) => sum + force, 0), verdict: most(forces), judgement: judge(most(forces)) }];
      });
      const found = summary(own, judge);
      return found && { ...found, index: object, object: `${recording.objects[object].kind.replace(/_/g, " ")} ${object}`, truth, duration: rows.at(-1).time_s };
    }).filter((row) => row !== null);
    const { page, texts, close } = await openList(scene, "touch.json");
    assert.equal(texts.length, expected.length, scene);
    for (const [row, own] of ordered(expected).entries()) {
      compare(texts[row], own);
      await follows(page, row, own);
      assert.equal((await state(page)).object, own.index);
      assert.ok(await page.locator(".features dd").first().isVisible(), "the features are folded");
      all++;
    }
    await close();
  }
  assert.ok(all > 0, "the model makes no mistake: the test needs one");
});

/** Tests that a classifier of trials has one row for each trial whose verdict was wrong or uncertain for most of its time, with
 * the times and forces that follow from the command line, and that a click leads to its moment. */
test("mistakes of a classifier of trials are trials", async () => {
  const { rows, category, moments } = await judged("mixed", "model.json", "--online");
  const { page, texts, close } = await openList("mixed", "model.json");
  const trials = await page.evaluate(() => {
    const { reach, trials } = window.underbrushReplay.loaded();
    return trials.all.map(({ taxel, first, last, object }) => ({ taxel, first, last, object, name: reach.objectName(object) }));
  });
  const judge = (truth, verdict) => (truth === "spurious" ? truth : verdict === truth ? "right" : verdict === "uncertain" ? "uncertain" : "wrong");
  const expected = trials.flatMap(({ taxel, first, last, object, name }) => {
    const own = moments.slice(first, last + 1).flatMap((taxels, index) => {
      const found = taxels.find((other) => other.taxel === taxel);
      return found === undefined ? [] : [{ ...found, frame: first + index, judgement: judge(category(found.object), found.verdict) }];
    });
    const truth = category(object);
    const found = summary(own, (verdict) => judge(truth, verdict));
    return found === null ? [] : [{ ...found, object: name, truth, duration: rows.at(-1).time_s }];
  });
  assert.ok(expected.length > 3, "the model makes too few mistakes for this test");
  assert.equal(texts.length, Math.min(expected.length, 50));
  ordered(expected).slice(0, 5).forEach((own, row) => compare(texts[row], own));
  await follows(page, 0, expected[0]);
  await page.keyboard.press("Escape");
  await settle(page);
  assert.ok(await page.locator("#timeline .shade").isHidden());
  await close();
});
