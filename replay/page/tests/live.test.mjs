// A reach that is watched while it is simulated: it waits for the page, pauses, steps, goes on and ends.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { file, finishAll, launch, makeData, open, ready, settle, watch } from "./support.mjs";

let browser;
before(async () => {
  await makeData();
  browser = await launch();
});
after(() => finishAll(browser));

const frames = (page) => page.evaluate(() => window.underbrushReplay.loaded().reach.frames);

/** Waits until the page shows a number of frames from `least` to `most`, and the last of them. */
function shown(page, least, most = least) {
  return page.waitForFunction(([least, most]) => {
    const { reach } = window.underbrushReplay.loaded();
    return least <= reach.frames && reach.frames <= most && window.underbrushReplay.state.frame === reach.frames - 1;
  }, [least, most]);
}

/** Everything that a page holds of a reach: lengths and sums of its arrays, its trials with verdicts, and its description. */
function contents(page) {
  return page.evaluate(() => {
    const { reach, trials } = window.underbrushReplay.loaded();
    const sum = (values) => {
      let hash = 0;
      for (const byte of new Uint8Array(values.buffer, values.byteOffset, values.byteLength)) hash = (Math.imul(hash, 31) + byte) | 0;
      return hash;
    };
    const arrays = Object.entries({ ...reach, ...trials, ...trials.touch }).filter(([, values]) => ArrayBuffer.isView(values));
    const { from, contacts, ...header } = reach.header;
    return {
      arrays: arrays.map(([name, values]) => `${name}: ${values.length} numbers, ${sum(values)}`),
      trials: trials.all,
      // Those that begin in the same frame are in any order.
      contacts: contacts.map((contact) => JSON.stringify(contact)).sort(),
      header,
    };
  });
}

/** Tests that the page of a running reach asks only for frames that it does not have, that verdicts of either kind of model are
 * there while the reach runs, and that at the end it holds what a page holds that loads the whole reach at once. */
for (const model of ["model.json", "touch.json"]) test(`only what is new is loaded, with verdicts of ${model}`, async () => {
  const { address, pause, close } = await watch("scenes/mixed.toml", "--seed", "3", "--model", file(model));
  assert.equal(await pause(), 200);
  const page = await open(browser, address);
  const asked = [];
  page.on("request", (request) => {
    const from = /api\/reach\/0(?:\?from=(\d+))?$/.exec(request.url());
    if (from !== null) asked.push(Number(from[1] ?? 0));
  });
  await ready(page);
  assert.ok((await page.locator("#facts").textContent()).includes(`model ${model}`));
  // Steps make many pieces, and the contacts begin within the first half of the reach.
  for (let step = 1; step <= 12; step++) {
    await fetch(`${address}api/live/step/100`, { method: "POST", headers: { Origin: new URL(address).origin } });
    await page.waitForFunction((count) => window.underbrushReplay.loaded().reach.frames >= count, 1 + 100 * step);
  }
  const judged = await page.evaluate(() => window.underbrushReplay.loaded().trials.all.filter(({ verdict }) => verdict !== null).length);
  assert.ok(judged > 5, `${judged} trials are judged`);
  assert.ok(await page.locator("#colour input[value=verdict]").isEnabled());
  await page.locator("#live").getByRole("button", { name: "Go on" }).click();
  await page.waitForFunction(() => /of \d+ goals reached/.test(document.getElementById("facts").textContent));
  // The end brings goals and audit, perhaps without a new frame.
  assert.ok(asked.length > 12 && asked.slice(1, -1).every((from, index) => from > asked[index]), `asked from ${asked}`);
  const whole = await open(browser, address);
  await ready(whole);
  assert.deepEqual(await contents(page), await contents(whole));
  assert.deepEqual([...page.problems, ...whole.problems], []);
  await page.context().close();
  await whole.context().close();
  close();
});

/** Tests that the page of a running reach grows with it, that pause and steps are exact, by mouse and by keyboard, and that the
 * whole reach with its goals is there at the end, in the list, too, which before says nothing of how the reach went. */
test("a running reach is shown, paused and stepped", async () => {
  // A reach through leaves takes seconds to simulate, so that it can be paused before it ends.
  const { address, pause, close } = await watch("scenes/leaf.toml", "--seed", "3");
  // It begins when the page is opened, and so stands at its first frame.
  assert.equal(await pause(), 200);
  const page = await open(browser, address);
  await ready(page);
  assert.match(await page.locator("#facts").textContent(), /running/);
  const row = () => page.locator("#panel-reaches tbody tr").first().locator("th, td").allTextContents();
  assert.deepEqual((await row()).slice(5), ["–", "–", "–", "–", "–", "–"]);
  const live = page.locator("#live");
  await page.waitForFunction(() => document.querySelector("#live [role=status]").textContent === "paused after 1 frame");
  const count = await frames(page);
  assert.equal(count, 1);
  await live.getByRole("button", { name: "Simulate 1 frame" }).click();
  await shown(page, count + 1);
  await live.getByRole("button", { name: "Simulate 10 frames" }).focus();
  await page.keyboard.press("Enter");
  await shown(page, count + 11);
  await settle(page);
  // Nothing goes on by itself, and who looks at an earlier frame stays there.
  assert.equal(await frames(page), count + 11);
  await page.keyboard.press("Home");
  await live.getByRole("button", { name: "Simulate 1 frame" }).click();
  await page.waitForFunction((count) => window.underbrushReplay.loaded().reach.frames === count, count + 12);
  assert.equal(await page.evaluate(() => window.underbrushReplay.state.frame), 0);
  await page.keyboard.press("End");
  await live.getByRole("button", { name: "Go on" }).click();
  await shown(page, 20, 1e9);
  await live.getByRole("button", { name: "Pause", exact: true }).click();
  await live.getByRole("button", { name: "Go on" }).click();
  await page.waitForFunction(() => document.querySelector("#live [role=status]").textContent === "The reach has ended.");
  await page.waitForFunction(() => /of \d+ goals reached/.test(document.getElementById("facts").textContent));
  assert.ok((await frames(page)) > count + 12);
  const facts = await page.locator("#facts").textContent();
  const [outcome, goals, length, peak, contacts, audit] = (await row()).slice(5);
  assert.match(outcome, /^(reached|stuck|timed out|aborted)$/);
  assert.ok(facts.includes(`${goals} goals reached`), `${goals}: ${facts}`);
  assert.ok(facts.includes(`${length}\u00a0s`) && facts.includes(`peak contact force ${peak}\u00a0N`), `${length}, ${peak}: ${facts}`);
  assert.match(contacts, /^\d+$/);
  assert.match(audit, /^(within bounds|\d+ exceeded)$/);
  assert.deepEqual(page.problems, []);
  await page.context().close();
  close();
});
