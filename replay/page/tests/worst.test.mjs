// The list of the worst mistakes of all reaches.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { SCENES, file, finish, finishAll, launch, makeData, open, program, ready, serve, settle, state } from "./support.mjs";

let browser;
before(async () => {
  await makeData();
  browser = await launch();
});
after(() => finishAll(browser));

const inputs = () => SCENES.map((scene) => file(`${scene}.parquet`));
const cellsOf = (rows) => rows.evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)));

/** Waits until all reaches are read, and gives the texts of the rows. */
async function worstRows(page) {
  await page.locator("#tab-worst").click();
  await page.waitForFunction((count) => document.getElementById("panel-worst").textContent.includes(`worst of all ${count} reaches`), SCENES.length);
  return cellsOf(page.locator("#panel-worst tbody tr"));
}

/** The ten worst rows, put together from the lists of mistakes of the reaches, which mistakes.test.mjs compares with the command
 * line. */
async function expectedRows(page) {
  const all = [];
  for (const [number, scene] of SCENES.entries()) {
    await page.locator("#reach").fill(String(number));
    await page.keyboard.press("Enter");
    await ready(page, number);
    await page.locator("#tab-mistakes").click();
    const mistakes = await page.evaluate(() => window.underbrushReplay.loaded().trials.mistakes.map(({ wrongFrames, meanForce, peakForce, object, taxel, run }) => ({ wrongFrames, meanForce, peakForce, object, taxel, frame: run.first })));
    const texts = await cellsOf(page.locator("#panel-mistakes tbody tr"));
    mistakes.slice(0, texts.length).forEach((own, row) => {
      const [object, , truth, verdict, , wrong, , mean, peak, from] = texts[row];
      if (own.wrongFrames > 0) all.push({ ...own, number, harm: own.wrongFrames * own.meanForce, cells: [String(number), object, truth, verdict, wrong, mean, peak, from, scene] });
    });
  }
  return all.sort((a, b) => b.harm - a.harm || a.number - b.number).slice(0, 10);
}

/** Tests that the list has the worst mistakes of all reaches in order, of a classifier of trials served and
 * of a touch model in a single file, and that a click opens the reach at the longest wrong time with its taxel and object,
 * from another reach and in the same one. */
test("the worst mistakes of all reaches", async () => {
  program("replay", ...inputs(), "--model", file("touch.json"), "--out", file("worst.html"), "--force");
  const server = await serve(...inputs(), "--model", file("model.json"));
  for (const address of [server.address, `file://${file("worst.html")}`]) {
    const page = await open(browser, address);
    await ready(page);
    const expected = await expectedRows(page);
    // The touch model of the tests makes a single mistake.
    const reaches = new Set(expected.map(({ number }) => number)).size;
    assert.ok(reaches > (address === server.address ? 1 : 0), `the worst mistakes are of ${reaches} reaches: too few for this test`);
    assert.deepEqual(await worstRows(page), expected.map(({ cells }) => cells));
    assert.ok(await page.locator("#panel-worst progress").isHidden());
    for (const [row, { number, frame, taxel, object }] of expected.entries()) {
      await page.locator("#panel-worst tbody tr").nth(row).click();
      await ready(page, number);
      await page.waitForFunction(([number, frame]) => window.underbrushReplay.state.reach === number && window.underbrushReplay.state.frame === frame, [number, frame]);
      await settle(page);
      const found = await state(page);
      assert.deepEqual([found.taxel, found.object, found.playing], [taxel, object, false], `row ${row}`);
      assert.equal(await page.locator('#panel-worst tr[aria-current="true"]').count(), 1);
      assert.ok(await page.locator("#timeline .shade").isVisible());
    }
    await finish(page);
  }
  server.close();
});

/** Tests that the search rests while its list is not looked at, and goes on when it is. */
test("the search rests while nobody looks", async () => {
  const server = await serve(...inputs(), "--model", file("touch.json"));
  const page = await open(browser, server.address);
  await ready(page);
  const asked = [];
  // The first reach of the search waits until the list is left.
  let leave;
  const left = new Promise((done) => (leave = done));
  await page.route("**/api/reach/*", async (route) => {
    asked.push(route.request().url());
    await left;
    await route.continue();
  });
  await page.locator("#tab-worst").click();
  await page.waitForFunction(() => document.getElementById("panel-worst").textContent.includes(`0 of 4 reaches are read`));
  await page.locator("#tab-reaches").click();
  leave();
  await page.waitForFunction(() => document.getElementById("panel-worst").textContent.includes(`1 of 4 reaches are read`));
  await settle(page);
  assert.equal(asked.length, 1);
  assert.equal((await worstRows(page)).length > 0, true);
  assert.equal(asked.length, 4);
  await finish(page);
  server.close();
});

/** Tests that without a model the list says that there are no verdicts, and that a single reach has no such list. */
test("no list without verdicts or with one reach", async () => {
  const server = await serve(...inputs());
  const page = await open(browser, server.address);
  await ready(page);
  assert.deepEqual(await worstRows(page), []);
  assert.match(await page.locator("#panel-worst").textContent(), /4 reaches have no verdicts/);
  await finish(page);
  server.close();
  const one = await serve(file("leaf.parquet"), "--model", file("touch.json"));
  const other = await open(browser, one.address);
  await ready(other);
  assert.equal(await other.locator("#tab-worst").count(), 0);
  await finish(other);
  one.close();
});
