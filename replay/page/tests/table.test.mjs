// A table of contact trials, as `underbrush import` makes it of a robot's log.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { file, finishAll, launch, open, program, ready, seek, serve, settle } from "./support.mjs";

let browser;
before(async () => {
  browser = await launch();
});
after(() => finishAll(browser));

const HEAD = "trial,category,reach,patch,taxel,time_s,force_n";

/** Rows of a contact of one taxel from sample `first` to `last`, 10 ms apart unless told. */
function rows(trial, taxel, first, last, rate_hz = 100) {
  return Array.from({ length: last - first + 1 }, (_, index) => `${trial},towel,0,palm,${taxel},${((first + index) / rate_hz).toFixed(6)},${0.5 + taxel}`);
}

/** Tests what the page says of a table: no arm, no goals and no true forces, the taxels by their numbers, and a strip that has the
 * category as long as the contacts last, although frames are wider than pixels. */
test("a table of trials is shown without what it does not know", async () => {
  const path = file("trials.csv");
  writeFileSync(path, [HEAD, ...rows(0, 5, 0, 49), ...rows(1, 2, 100, 119), ""].join("\n"));
  const server = await serve(path);
  const page = await open(browser, `${server.address}#reach=0&taxel=palm.5`);
  await ready(page);
  await seek(page, 20);
  assert.equal(await page.textContent("#title"), "trials, reach 0");
  // The taxels fill the 3-D view, however small the skin is, in a window of another size, too.
  for (const width of [1100, 700]) {
    await page.setViewportSize({ width, height: 900 });
    await settle(page);
    const view = await page.locator(".view").boundingBox();
    const places = await page.evaluate(() => Array.from({ length: 6 }, (_, taxel) => window.underbrushReplay.drawn().project(window.underbrushReplay.drawn().taxel(taxel).position)));
    const spans = [0, 1].map((axis) => Math.max(...places.map((place) => place[axis])) - Math.min(...places.map((place) => place[axis])));
    assert.ok(Math.max(spans[0] / view.width, spans[1] / view.height) > 0.3, `${spans} of ${view.width} by ${view.height}`);
  }
  assert.match(await page.textContent("#facts"), /^a table of contact trials · 1\.2\s*s$/);
  const row = await page.locator("#panel-reaches tbody tr").first().locator("th, td").allTextContents();
  assert.deepEqual(row, ["0", "trials", "–", "0", "–", "–", "–", "1.2", "–", "–", "–"]);
  const plots = await page.$$eval("[data-plot]:not([hidden])", (found) => found.map((plot) => plot.dataset.plot));
  assert.deepEqual(plots, ["force", "taxel"]);
  const text = await page.innerText("body");
  assert.match(text, /palm taxel 5: 5\.50\s*N sensed, towel/);
  assert.doesNotMatch(text, /NaN|true normal force|Pressing now|arrows|path of the hand/);
  assert.doesNotMatch(await page.textContent("#timeline-key"), /contacts/);
  assert.ok(await page.locator("#timeline canvas").isHidden(), "rows of goals and contacts");
  assert.ok(await page.locator("#jump-contact").isHidden() && (await page.locator("#jump-goal").isHidden()));
  const truth = await page.getAttribute("canvas.strips", "aria-label");
  const [, seconds] = /towel ([\d.]+)/.exec(truth);
  assert.ok(Math.abs(Number(seconds) - 0.7) < 0.03, truth);
  assert.deepEqual(page.problems, []);
  await page.context().close();
  server.close();
});

/** Tests that the address of a frame of a fast table brings back that frame, also where its time is rounded down. */
test("an address brings back a frame of a fast table", async () => {
  const path = file("fast.csv");
  writeFileSync(path, [HEAD, ...rows(0, 1, 0, 29, 300), ""].join("\n"));
  const server = await serve(path);
  for (const frame of [7, 8, 10]) {
    const page = await open(browser, server.address);
    await ready(page);
    await seek(page, frame);
    await page.waitForFunction((time) => location.hash.includes(`t=${time}`), (frame / 300).toFixed(4));
    const other = await open(browser, `${server.address}${await page.evaluate(() => location.hash)}`);
    await ready(other);
    assert.equal(await other.evaluate(() => window.underbrushReplay.state.frame), frame);
    for (const own of [page, other]) {
      assert.deepEqual(own.problems, []);
      await own.context().close();
    }
  }
  server.close();
});

/** Tests that readings without a label are not said to have no cause. */
test("a table without categories does not say what causes its readings", async () => {
  const path = file("unlabelled.csv");
  writeFileSync(path, [HEAD, ...rows(0, 1, 0, 29).map((row) => row.replace("towel", "")), ""].join("\n"));
  const server = await serve(path);
  const page = await open(browser, server.address);
  await ready(page);
  const key = await page.textContent("#strips");
  assert.match(key, /labelled nothing, or not at all/);
  assert.doesNotMatch(key, /no object causes/);
  assert.deepEqual(page.problems, []);
  await page.context().close();
  server.close();
});

/** Tests that a recording of a robot's log, which has neither seed, controller, goals, an audit, torques nor true forces, does not speak of
 * them. */
test("a recording of a log says nothing that nobody knows", async () => {
  const frames = Array.from({ length: 60 }, (_, k) => `${(k / 100).toFixed(2)},${k > 10 && k < 50 ? 0.5 : 0},0,towel,0`);
  writeFileSync(file("log.csv"), ["t,f_0,f_1,label,run", ...frames, ""].join("\n"));
  writeFileSync(file("taxels.csv"), "x_m,y_m,z_m,normal_x,normal_y,normal_z,area_m2\n0,0,0,0,0,1,0.0001\n0.02,0,0,0,0,1,0.0001\n");
  const tables = ['[time]\nfrom = "t"\nunit = "s"', '[force]\nfrom = "f_{taxel}"\ntaxels = 2\nunit = "N"'];
  tables.push("[grid]\nrows = 1\ncolumns = 2");
  tables.push('[trial]\npatch = "palm"\ncategory_from = "label"\nreach_from = "run"', '[skin]\ntaxels = "taxels.csv"\n');
  writeFileSync(file("log.toml"), tables.join("\n"));
  program("import", file("log.csv"), "--mapping", file("log.toml"), "--out", file("felt"));
  const server = await serve(file("felt/reach-000000.parquet"));
  const page = await open(browser, `${server.address}#reach=0&taxel=palm.0&object=0`);
  await ready(page);
  await seek(page, 20);
  assert.match(await page.textContent("#details"), /0\.50\s*N/);
  // A flat skin has nothing that columns could lie around.
  assert.equal(await page.textContent("#skins figcaption"), "palm 1 row × 2 columns");
  assert.equal(await page.locator(".force-label:not([hidden])").count(), 0, "an arrow that the legend does not explain");
  // Nobody knows where the ground is, so there is nothing between the taxels.
  const between = await page.evaluate(() => {
    const { pixel, project } = window.underbrushReplay.drawn();
    const [x, y] = project([0.01, 0, 0]);
    return [...[-2, -1, 0, 1, 2].map((off) => pixel(x, y + off)), pixel(2, 2)].map(String);
  });
  assert.equal(new Set(between).size, 1, `a line of the ground between the taxels: ${between}`);
  const plots = await page.$$eval("[data-plot]:not([hidden])", (found) => found.map((plot) => plot.dataset.plot));
  assert.deepEqual(plots, ["force", "area", "taxel"]);
  assert.equal(await page.textContent("#title"), "log, reach 0");
  assert.match(await page.textContent("#facts"), /^a robot's log · no goals · 0\.6\s*s/);
  const row = await page.locator("#panel-reaches tbody tr").first().locator("th, td").allTextContents();
  assert.deepEqual(row, ["0", "log", "–", "0", "–", "–", "–", "0.6", "0.50", "1", "–"]);
  assert.doesNotMatch(await page.innerText("body"), /seed \d|unknown|0 of 0|within bounds|true normal force|true 0|foot|Pressing now|arrows|path of the hand/);
  assert.deepEqual(page.problems, []);
  await page.context().close();
  server.close();
});
