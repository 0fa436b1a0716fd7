// The ghost: the arm of another reach of the same draw.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { file, finish, finishAll, hold, launch, makeData, open, readRecording, ready, seek, serve, settle, state, storedPose } from "./support.mjs";

let browser;
let server;
before(async () => {
  await makeData();
  browser = await launch();
  // The first two are of the same draw, by two controllers.
  server = await serve(file("trunk.parquet"), file("mapped.parquet"), file("mixed.parquet"));
});
after(() => finishAll(browser));

async function start(hash) {
  const page = await open(browser, `${server.address}${hash}`);
  await ready(page, Number(/reach=(\d+)/.exec(hash)?.[1] ?? 0));
  return page;
}

/** Waits until the ghost is drawn, or is not. */
const drawn = (page, wanted) => page.waitForFunction((wanted) => {
  const { header } = window.underbrushReplay.loaded().reach;
  return header.bodies.some((_, body) => window.underbrushReplay.drawn().ghost(body) !== null) === wanted;
}, wanted);

/** Turns a point by a quaternion and moves it: from a body's own frame to the world. */
function placed([x, y, z], [px, py, pz, i, j, k, w]) {
  const t = [2 * (j * z - k * y), 2 * (k * x - i * z), 2 * (i * y - j * x)];
  return [px + x + w * t[0] + j * t[2] - k * t[1], py + y + w * t[1] + k * t[0] - i * t[2], pz + z + w * t[2] + i * t[1] - j * t[0]];
}

/** Tests that the reaches of the same draw are offered and no others, that every link of the ghost is where the other recording has
 * it at the same time, also after its end, that it is seen, and that an address brings it back. */
test("a ghost is the other arm at the same time", async () => {
  const { recording, rows } = await readRecording("mapped.parquet");
  const own = await readRecording("trunk.parquet");
  const page = await start("");
  const choice = page.getByLabel("Ghost");
  assert.deepEqual(await choice.locator("option").allTextContents(), ["off", "1: mapped"]);
  await choice.selectOption("1");
  await drawn(page, true);
  assert.match(await page.locator("#legend").textContent(), /orange, seen through: the arm of reach 1: mapped/);
  const links = recording.bodies.flatMap(({ owner, parts }, body) => (owner.link !== undefined && parts.length > 0 ? [body] : []));
  assert.ok(links.length > 2);
  for (const frame of [0, Math.floor(own.rows.length / 2), own.rows.length - 1]) {
    await seek(page, frame);
    const time = own.rows[frame].time_s;
    const other = rows.findLastIndex((row) => row.time_s <= time + 1e-9);
    for (const body of links) {
      const pose = storedPose(recording, rows, body, other);
      const { own, world } = await page.evaluate((body) => window.underbrushReplay.drawn().ghost(body), body);
      for (const at of [0, own.length - 1]) {
        const expected = placed(own[at], pose);
        assert.ok(Math.hypot(...expected.map((value, axis) => value - world[at][axis])) < 1e-4, `link ${body} in frame ${frame}`);
      }
    }
  }
  // The middle of a link is not of the same colour without the ghost.
  const pixels = () => page.evaluate((links) => {
    const drawn = window.underbrushReplay.drawn();
    return links.map((body) => drawn.pixel(...drawn.project(window.middles[body])));
  }, links);
  await page.evaluate((links) => {
    window.middles = Object.fromEntries(links.map((body) => {
      const { world } = window.underbrushReplay.drawn().ghost(body);
      return [body, [0, 1, 2].map((axis) => world.reduce((sum, point) => sum + point[axis], 0) / world.length)];
    }));
  }, links);
  const shown = await pixels();
  await page.waitForFunction(() => location.hash.includes("ghost=1"));
  await choice.selectOption("");
  await drawn(page, false);
  await settle(page);
  assert.notDeepEqual(await pixels(), shown);
  await page.evaluate(() => (location.hash = "#reach=0&t=1&ghost=1"));
  await drawn(page, true);
  await finish(page);
});

/** Tests that an address brings a ghost back while a reach of another draw is shown. */
test("an address with a ghost may be of another reach", async () => {
  const page = await start("#reach=2");
  await page.evaluate(() => (location.hash = "#reach=0&t=1&ghost=1"));
  await ready(page, 0);
  await drawn(page, true);
  assert.ok(await page.locator("#message").isHidden());
  await finish(page);
});

/** Tests that a reach without others of its draw offers no ghost and takes none from an address, and that the ghost goes when
 * another reach is opened. */
test("a reach of another draw is no ghost", async () => {
  const page = await start("#reach=2&ghost=1");
  assert.ok(await page.locator("#ghost-field").isHidden());
  assert.equal((await state(page)).ghost, null);
  await finish(page);
  const other = await start("#reach=0&ghost=1");
  await drawn(other, true);
  await other.locator("#panel-reaches tbody button").nth(1).click();
  await ready(other, 1);
  assert.equal((await state(other)).ghost, null);
  await drawn(other, false);
  assert.deepEqual(await other.getByLabel("Ghost").locator("option").allTextContents(), ["off", "0: cody-2013"]);
  await finish(other);
});

/** Tests that a ghost that was chosen later is not taken away when an earlier choice has been loaded. */
test("the later of two ghosts stays", async () => {
  const three = await serve(file("trunk.parquet"), file("mapped.parquet"), file("mapped.parquet"));
  const page = await open(browser, three.address);
  await ready(page);
  const release = await hold(page, 1);
  for (const number of ["1", "2"]) await page.getByLabel("Ghost").selectOption(number);
  await drawn(page, true);
  await release("continue");
  await drawn(page, true);
  assert.equal((await state(page)).ghost, 2);
  await finish(page);
});
