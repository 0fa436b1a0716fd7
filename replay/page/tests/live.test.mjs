// A reach that is watched while it is simulated: it waits for the page, pauses, steps, goes on and ends.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { finishAll, launch, open, ready, settle, watch } from "./support.mjs";

let browser;
before(async () => {
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

/** Pins that the page of a running reach grows with it, that pause and steps are exact, by mouse and by keyboard, and that the
 * whole reach with its goals is there at the end. */
test("a running reach is shown, paused and stepped", async () => {
  const { address, pause, close } = await watch("scenes/mixed.toml", "--seed", "3");
  // It begins when the page is opened, and so stands at its first frame.
  assert.equal(await pause(), 200);
  const page = await open(browser, address);
  await ready(page);
  assert.match(await page.locator("#facts").textContent(), /running/);
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
  assert.deepEqual(page.problems, []);
  await page.context().close();
  close();
});
