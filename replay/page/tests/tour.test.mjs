// The tour: first contact, its forces, a verdict and a mistake, by mouse and by keyboard.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { file, finish, finishAll, launch, makeData, open, program, readRecording, ready, serious, serve, settle, state } from "./support.mjs";

let browser;
before(async () => {
  await makeData();
  browser = await launch();
});
after(() => finishAll(browser));

const caption = (page) => page.locator("#tour-caption p").textContent();

async function begin(recording, ...options) {
  const server = await serve(file(recording), ...options);
  const page = await open(browser, server.address, { bypassCSP: true });
  await ready(page);
  await page.locator("#tour").focus();
  await page.keyboard.press("Enter");
  await settle(page);
  return { page, close: async () => { await finish(page); server.close(); } };
}

const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];

/** The size of the force of an object on a patch: the sum of the true forces on its taxels, N. */
function pressure(recording, row, object, patch) {
  const { name, taxels } = recording.layout.patches[patch];
  const sum = [0, 0, 0];
  row[`truth.object.${name}`].forEach((own, index) => {
    if (own !== object) return;
    const { normal_link: normal, tangent_link: tangent } = taxels[index];
    const shear = [...row[`truth.shear_force.${name}`]].flat();
    const binormal = cross(normal, tangent);
    const force = row[`truth.normal_force.${name}`][index];
    for (let axis = 0; axis < 3; axis++) sum[axis] += -force * normal[axis] + shear[2 * index] * tangent[axis] + shear[2 * index + 1] * binormal[axis];
  });
  return Math.hypot(...sum);
}

/** Tests that the tour goes to the first contact, to its strongest moment, to the first verdict on an object that names a category
 * and to the first row of the list of mistakes, by keyboard alone, and that each sentence stays until the next step. */
test("the tour has four steps", async () => {
  const { recording, rows } = await readRecording("outlier.parquet");
  const { page, close } = await begin("outlier.parquet", "--model", file("touch.json"));
  const [contact] = recording.contacts.filter(({ patch }) => patch !== null).sort((a, b) => a.first_frame - b.first_frame);
  assert.match(await caption(page), /^1 of 4: The first contact/);
  assert.deepEqual([(await state(page)).frame, (await state(page)).object], [contact.first_frame, contact.object]);
  assert.deepEqual(await serious(page), []);
  await page.keyboard.press("Enter");
  await settle(page);
  const forces = rows.slice(contact.first_frame, contact.last_frame + 1).map((row) => pressure(recording, row, contact.object, contact.patch));
  const largest = Math.max(...forces);
  assert.equal((await state(page)).frame, contact.first_frame + forces.indexOf(largest));
  assert.ok((await caption(page)).includes(`${largest.toFixed(2)} N`), await caption(page));
  assert.ok((await page.locator(".force-label:visible").allTextContents()).includes(`${largest.toFixed(2)} N`));
  await page.keyboard.press("Enter");
  await settle(page);
  const lines = program("classify", file("touch.json"), file("outlier.parquet")).trim().split("\n").map((line) => JSON.parse(line));
  const named = lines.findIndex(({ taxels }, frame) => taxels.some(({ patch, taxel, verdict }) => ["leaf", "trunk"].includes(verdict) && rows[frame][`truth.object.${patch}`][taxel] >= 0));
  assert.equal((await state(page)).frame, named);
  assert.equal((await state(page)).colour, "verdict");
  assert.match(await caption(page), /^3 of 4: The first verdict that names a category: (leaf|trunk)\. The truth is \w+\.$/);
  // The sentence stays while the reach is looked at.
  const kept = await caption(page);
  await page.locator("body").press("ArrowRight");
  await settle(page);
  assert.equal(await caption(page), kept);
  await page.locator("#tour-caption").getByRole("button", { name: "Next" }).click();
  await settle(page);
  await page.locator("#tab-mistakes").click();
  const first = await page.locator("#panel-mistakes tbody tr").first().locator("th, td").allTextContents();
  assert.equal((await state(page)).frame, Math.round(100 * Number(first.at(-1))));
  assert.ok((await caption(page)).includes(`${first[0]} is called ${first[3]}; the verdict is wrong for ${first[5]} s`), await caption(page));
  assert.ok(await page.locator("#timeline .shade").isVisible());
  assert.ok(await page.locator("#tour-caption").getByRole("button", { name: "Next" }).isHidden());
  await page.locator("#tour-caption").getByRole("button", { name: "End" }).click();
  assert.ok(await page.locator("#tour-caption").isHidden());
  assert.equal(await page.evaluate(() => document.activeElement.id), "tour");
  await close();
});

/** Tests that without a model there is neither a step for a verdict nor for a mistake, and that Escape ends the tour first and
 * takes the selection away only then. */
test("the tour has no step for what a reach lacks", async () => {
  const { page, close } = await begin("mixed.parquet");
  assert.match(await caption(page), /^1 of 2/);
  await page.keyboard.press("Enter");
  await settle(page);
  assert.match(await caption(page), /^2 of 2/);
  assert.ok(await page.locator("#tour-caption").getByRole("button", { name: "Next" }).isHidden());
  await page.keyboard.press("Escape");
  await settle(page);
  assert.ok(await page.locator("#tour-caption").isHidden());
  assert.notEqual((await state(page)).object, null);
  await page.keyboard.press("Escape");
  await settle(page);
  assert.equal((await state(page)).object, null);
  await close();
});

/** Tests that the tour of a table of trials, which has no arrows, leads to the first contact alone. */
test("the tour of a table has one step", async () => {
  const rows = Array.from({ length: 20 }, (_, index) => `0,towel,0,palm,5,${(index / 100).toFixed(2)},0.5`);
  writeFileSync(file("tour.csv"), ["trial,category,reach,patch,taxel,time_s,force_n", ...rows, ""].join("\n"));
  const { page, close } = await begin("tour.csv");
  assert.equal(await caption(page), "1 of 1: The first contact is on palm taxel 5 at 0.00 s.");
  assert.equal((await state(page)).taxel, 5);
  await page.keyboard.press("Enter");
  assert.ok(await page.locator("#tour-caption").isHidden(), "Enter on the button End does not end the tour");
  await close();
});
