// Playback, jumps, lists and settings, by mouse and by keyboard.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { felt, finish, fullestFrame, hold, mixedSite, readRecording, ready, seek, settle, state } from "./support.mjs";

const { begin, end, start } = mixedSite();
before(begin);
after(end);

/** Tests the step, first and last buttons and their keys, and that neither end can be passed. */
test("steps by mouse and keyboard", async () => {
  const page = await start();
  const press = async (key) => { await page.keyboard.press(key); await settle(page); return (await state(page)).frame; };
  const click = async (name) => { await page.getByRole("button", { name, exact: true }).click(); await settle(page); return (await state(page)).frame; };
  assert.equal(await click("One frame on"), 1);
  assert.equal(await click("One frame back"), 0);
  assert.equal(await click("One frame back"), 0);
  const last = await click("Last frame");
  assert.ok(last > 1000);
  assert.equal(await click("One frame on"), last);
  assert.equal(await click("First frame"), 0);
  await page.locator("body").click({ position: { x: 2, y: 2 } });
  assert.equal(await press("ArrowRight"), 1);
  assert.equal(await press("Shift+ArrowRight"), 11);
  assert.equal(await press("ArrowLeft"), 10);
  assert.equal(await press("Shift+ArrowLeft"), 0);
  assert.equal(await press("End"), last);
  assert.equal(await press("Home"), 0);
  await page.locator(".scrubber").focus();
  assert.equal(await press("ArrowRight"), 1);
  assert.match(await page.locator(".scrubber").getAttribute("aria-valuetext"), /^0\.01 s, frame 1 of/);
  await finish(page);
});

/** Tests that playing moves time at the chosen rate, stops at the end and begins anew from there. */
test("plays at a rate and stops at the end", async () => {
  const page = await start();
  await page.locator("#rate").selectOption("10");
  await page.locator("body").click({ position: { x: 2, y: 2 } });
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.underbrushReplay.state.frame > 100);
  assert.equal(await page.locator("#play").textContent(), "Pause");
  await page.waitForFunction(() => !window.underbrushReplay.state.playing, null, { timeout: 60_000 });
  const { frame } = await state(page);
  assert.equal(frame, await page.evaluate(() => window.underbrushReplay.loaded().reach.frames - 1));
  await page.locator("#play").click();
  await page.waitForFunction((last) => window.underbrushReplay.state.frame < last, frame);
  await page.keyboard.press("k");
  // Slower, by key.
  for (const rate of [5, 2, 1, 0.5, 0.25, 0.1, 0.1]) {
    await page.keyboard.press(",");
    assert.equal((await state(page)).rate, rate);
  }
  await page.keyboard.press(".");
  assert.equal((await state(page)).rate, 0.25);
  await finish(page);
});

/** Tests that jumps go to the contacts, peaks, goals and mistakes that the data hold, forwards and back. */
test("jumps to contacts, peaks, goals and mistakes", async () => {
  const { recording, rows } = await readRecording("mixed.parquet");
  const page = await start();
  await page.locator("body").click({ position: { x: 2, y: 2 } });
  const press = async (key) => { await page.keyboard.press(key); await settle(page); return (await state(page)).frame; };
  const firsts = [...new Set(recording.contacts.map((contact) => contact.first_frame))].filter((frame) => frame > 0).sort((a, b) => a - b);
  assert.deepEqual([await press("c"), await press("c"), await press("Shift+C")], [firsts[0], firsts[1], firsts[0]]);
  await page.getByRole("button", { name: "Next contact" }).click();
  assert.equal((await state(page)).frame, firsts[1]);
  await page.getByRole("button", { name: "Previous contact" }).click();
  assert.equal((await state(page)).frame, firsts[0]);
  for (const [jump, key] of [["goal", "g"], ["peak", "p"], ["mistake", "m"]]) {
    await press("Home");
    const byKey = [await press(key), await press(key), await press(`Shift+${key.toUpperCase()}`)];
    await press("Home");
    const byMouse = [];
    for (const name of [`Next ${jump}`, `Next ${jump}`, `Previous ${jump}`]) {
      await page.getByRole("button", { name, exact: true }).click();
      byMouse.push((await state(page)).frame);
    }
    assert.deepEqual(byMouse, byKey, jump);
    // Several peaks or mistakes can be in one frame.
    const later = jump === "goal" ? byKey[1] > byKey[0] : byKey[1] >= byKey[0];
    assert.ok(byKey[0] > 0 && later && byKey[2] === byKey[0], `${jump}: ${byKey}`);
  }
  await press("Home");
  const second = recording.goals[1].start_time_s;
  await press("g");
  const time = rows[(await state(page)).frame].time_s;
  assert.ok(Math.abs(time - second) <= 0.0101, `${time}, ${second}`);
  /** Presses a key until nothing changes; gives frame, taxel and object after each. */
  const all = async (key) => {
    await press("Home");
    await press("Escape");
    const found = [];
    for (let turn = 0; turn < 500; turn++) {
      await press(key);
      const { frame, taxel, object } = await state(page);
      const place = `${frame} ${taxel} ${object}`;
      if (found.at(-1) === place) break;
      found.push(place);
    }
    return found;
  };
  const peaks = (await all("p")).map((place) => Number.parseInt(place));
  const forces = rows.map((row) => felt(recording, row)[0]?.force ?? 0);
  assert.ok(peaks.includes(forces.indexOf(Math.max(...forces))), "the largest peak is not among the peaks");
  const mistakes = await page.evaluate(() => window.underbrushReplay.loaded().trials.mistakes.map(({ taxel, object, run }) => `${run.first} ${taxel} ${object < 0 ? null : object}`));
  assert.ok(new Set(mistakes.map((place) => Number.parseInt(place))).size < mistakes.length, "no two mistakes begin in one frame: the test needs some");
  assert.deepEqual((await all("m")).sort(), mistakes.sort());
  await press("Home");
  await press("m");
  const { taxel, frame } = await state(page);
  const starts = await page.evaluate(() => window.underbrushReplay.loaded().trials.mistakes.map(({ taxel, run }) => ({ taxel, frame: run.first })));
  assert.equal(frame, Math.min(...starts.map((start) => start.frame)));
  assert.ok(starts.some((start) => start.taxel === taxel && start.frame === frame));
  await finish(page);
});

/** Tests that the list of reaches sorts, filters and opens, and that a second reach stands beside the first, locked in time. */
test("reaches are listed, filtered, opened and compared", async () => {
  const page = await start();
  const names = () => page.locator("#panel-reaches tbody tr td:nth-child(2)").allTextContents();
  assert.deepEqual(await names(), ["mixed", "mixed", "trunk"]);
  await page.locator("#panel-reaches thead").getByRole("button", { name: "length / s" }).click();
  const lengths = (await page.locator("#panel-reaches tbody tr td:nth-child(8)").allTextContents()).map(Number);
  assert.deepEqual(lengths, [...lengths].sort((a, b) => a - b));
  await page.getByLabel("Scene").selectOption("trunk");
  assert.deepEqual(await names(), ["trunk"]);
  await page.locator("#panel-reaches tbody button").first().click();
  await ready(page, 2);
  assert.match(await page.locator("#title").textContent(), /^trunk, seed 3/);
  await page.keyboard.press("[");
  await ready(page, 1);
  await page.locator("#beside").fill("0");
  await page.keyboard.press("Enter");
  await page.waitForSelector("body.compared");
  await seek(page, 500);
  assert.equal(await page.locator(".view").count(), 2);
  const maps = await page.$$eval(".skin-map", (maps) => maps.map((map) => map.getAttribute("aria-label")));
  assert.ok(maps.length === 4 && new Set(maps).size === 4, maps.join());
  assert.ok(maps.slice(2).every((name) => /^Second reach/.test(name) && !/Enter/.test(name)), maps.join());
  assert.match(await page.locator('[data-plot="force"] output').textContent(), /beside \d/);
  await page.waitForFunction(() => location.hash.includes("beside=0"));
  await finish(page);
});

/** Tests that a second reach that was given up while it was loaded is not shown. */
test("a second reach that was given up is not shown", async () => {
  const page = await start();
  const release = await hold(page, 1);
  for (const number of ["1", ""]) {
    await page.locator("#beside").fill(number);
    await page.keyboard.press("Enter");
    await settle(page);
  }
  await release("continue");
  assert.equal(await page.locator(".view").count(), 1);
  assert.equal((await state(page)).beside, null);
  await finish(page);
});

/** Tests that nothing is said of a reach that could not be loaded once another one is shown. */
test("the error of a reach that nobody waits for is not told", async () => {
  const page = await start();
  const release = await hold(page, 1);
  await page.keyboard.press("]");
  await page.evaluate(() => (location.hash = "#reach=2"));
  await ready(page, 2);
  await release("abort");
  assert.ok(await page.locator("#message").isHidden());
  page.problems = page.problems.filter((problem) => !problem.includes("net::ERR_FAILED"));
  await finish(page);
});

/** Tests that of a list of a thousand reaches one page is shown, that its buttons turn pages, that sorting starts from the first
 * page, and that the page with a reach is shown when that reach is opened. */
test("long lists are shown by pages", async () => {
  const page = await start("", { before: makeListLong });
  const count = page.locator("#panel-reaches [role=status]");
  const numbers = async () => (await page.locator("#panel-reaches tbody th").allTextContents()).map(Number);
  const range = (first, last) => Array.from({ length: last - first + 1 }, (_, index) => first + index);
  assert.equal(await count.textContent(), "1000 reaches, 1 to 50 shown");
  assert.deepEqual(await numbers(), range(0, 49));
  const [back, on] = ["Previous", "Next"].map((name) => page.getByRole("button", { name: `${name} page of reaches` }));
  assert.ok(await back.isDisabled());
  await on.click();
  assert.deepEqual(await numbers(), range(50, 99));
  await page.locator("#panel-reaches thead").getByRole("button", { name: "#" }).click();
  await page.locator("#panel-reaches thead").getByRole("button", { name: "#" }).click();
  assert.deepEqual(await numbers(), range(950, 999).reverse());
  await page.getByLabel("Scene").selectOption("other");
  assert.equal(await count.textContent(), "60 of 1000 reaches, 1 to 50 shown");
  await on.click();
  assert.deepEqual((await numbers()).length, 10);
  assert.ok(await on.isDisabled());
  await page.getByLabel("Scene").selectOption("");
  await page.locator("#reach").fill("2");
  await page.keyboard.press("Enter");
  await ready(page, 2);
  assert.equal(await page.locator('#panel-reaches tr[aria-current="true"] th').textContent(), "2");
  await finish(page);
});

/** Runs in the page: the list of the server has its three reaches and 997 more. */
function makeListLong() {
  const original = window.fetch;
  window.fetch = async (address, ...more) => {
    const answer = await original(address, ...more);
    if (!String(address).endsWith("api/reaches")) return answer;
    const list = await answer.json();
    for (let number = list.length; number < 1000; number++) list.push({ ...list[0], number, reach_index: number, scene: number < 940 ? "mixed" : "other" });
    return new Response(JSON.stringify(list));
  };
}

/** Tests that a click on strips and plots goes to that time, that the choice of reach and its buttons open reaches, and that the
 * tabs and rows of the lists work by keyboard. */
test("strips, plots, reach buttons, tabs and links", async () => {
  const page = await start();
  const { duration, frames } = await page.evaluate(() => ({ duration: window.underbrushReplay.loaded().reach.duration, frames: window.underbrushReplay.loaded().reach.frames }));
  for (const place of [".strips", '[data-plot="force"] .u-over']) {
    const target = page.locator(place);
    await target.scrollIntoViewIfNeeded();
    const { width, height } = await target.boundingBox();
    await target.click({ position: { x: width / 2, y: height / 2 } });
    await settle(page);
    const time = (await state(page)).frame / 100;
    // The strips have the labels of their lines on the left.
    const [left, right] = place === ".strips" ? [74, 10] : [0, 0];
    const expected = ((width / 2 - left) / (width - left - right)) * duration;
    assert.ok(Math.abs(time - expected) <= duration / 100, `${place}: ${time} s, not ${expected} s`);
    await seek(page, 0);
  }
  await page.locator("#next-reach").click();
  await ready(page, 1);
  await page.locator("#previous-reach").click();
  await ready(page, 0);
  // By its number. Digits are also keys for colours, but not where a number is typed, and a number without a reach is taken back.
  await page.locator("#reach").fill("");
  await page.keyboard.type("2");
  await page.keyboard.press("Enter");
  await ready(page, 2);
  await page.locator("#reach").fill("99");
  await page.keyboard.press("Enter");
  assert.equal(await page.locator("#reach").inputValue(), "2");
  assert.equal((await state(page)).colour, "force");
  await page.locator("#beside").fill("99");
  await page.keyboard.press("Enter");
  assert.equal(await page.locator("#beside").inputValue(), "");
  await page.locator("#reach").fill("0");
  await page.keyboard.press("Enter");
  await ready(page, 0);
  // By keyboard: to the tab of trials, into the table, and open its first trial.
  await page.getByRole("tab", { name: "Reaches" }).focus();
  for (let tab = 0; tab < 3; tab++) await page.keyboard.press("ArrowRight");
  assert.equal(await page.getByRole("tab", { name: "Contact trials" }).getAttribute("aria-selected"), "true");
  const row = page.locator("#panel-trials tbody tr").first();
  const [start_s, taxel] = await row.locator("th, td").allTextContents();
  await row.getByRole("button").focus();
  await page.keyboard.press("Enter");
  await settle(page);
  assert.ok((await page.locator("#clock").textContent()).startsWith(`${start_s} s`));
  const details = await page.locator("#details").textContent();
  assert.ok(details.includes(taxel), details);
  // A link in the details: the end of the trial.
  const end = page.locator("#details dd").filter({ hasText: "–" }).getByRole("button").nth(1);
  const end_s = await end.textContent();
  await end.click();
  await settle(page);
  assert.ok((await page.locator("#clock").textContent()).startsWith(end_s));
  // The object that presses now is a link too.
  const { recording, rows } = await readRecording("mixed.parquet");
  assert.equal(rows.length, frames);
  await seek(page, fullestFrame(recording, rows));
  const object = page.locator('#details h3:has-text("Pressing now") + ul').getByRole("button").first();
  const name = await object.textContent();
  await object.click();
  await settle(page);
  assert.equal((await state(page)).object, Number(/ (\d+)$/.exec(name)[1]));
  await finish(page);
});

/** Tests that arrow keys scroll a table that has the focus, and leave the time as it is. */
test("a table is scrolled by keyboard", async () => {
  const page = await start("", { viewport: { width: 390, height: 844 } });
  const table = page.locator("#panel-reaches .scroll");
  await table.focus();
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction((table) => table.scrollLeft > 0, await table.elementHandle());
  assert.equal((await state(page)).frame, 0);
  await finish(page);
});

/** Tests that the theme can be chosen, and that the list of keys opens and closes by keyboard. */
test("theme and help", async () => {
  const page = await start();
  const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const system = await ground();
  await page.locator("#theme").click();
  await page.locator("#theme").click();
  assert.equal(await page.locator("#theme").textContent(), "Theme: dark");
  const dark = await ground();
  assert.notEqual(dark, system);
  await page.reload();
  await ready(page);
  assert.deepEqual([await ground(), await page.locator("#theme").textContent()], [dark, "Theme: dark"]);
  await page.keyboard.press("?");
  assert.ok(await page.getByRole("dialog").isVisible());
  await page.keyboard.press("Escape");
  assert.ok(await page.getByRole("dialog").isHidden());
  await page.getByRole("button", { name: "Keys" }).click();
  await page.getByRole("button", { name: "Close" }).click();
  assert.ok(await page.getByRole("dialog").isHidden());
  // The link before everything leads to the playback, from which the keys work.
  await page.locator(".skip").focus();
  await page.keyboard.press("Enter");
  await page.keyboard.press("ArrowRight");
  await settle(page);
  assert.equal((await state(page)).frame, 1);
  await finish(page);
});
