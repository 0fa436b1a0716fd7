// Where things stand, and whether figures say what they are.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { felt, file, finish, finishAll, launch, makeData, open, readRecording, ready, seek, serve, settle } from "./support.mjs";

let browser;
let server;
before(async () => {
  await makeData();
  browser = await launch();
  server = await serve(file("outlier.parquet"), "--model", file("touch.json"));
});
after(() => finishAll(browser));

/** Tests that the largest force of a taxel is named, that labels of arrows are forces alone, red where a taxel is above the limit,
 * and that the legend says what red means. */
test("forces say what they are", async () => {
  const { recording, rows } = await readRecording("outlier.parquet");
  const page = await open(browser, server.address);
  await ready(page);
  const forces = rows.map((row) => felt(recording, row).filter(({ object }) => object >= 0)[0]?.force ?? 0);
  const frame = forces.indexOf(Math.max(...forces));
  assert.ok(forces[frame] > 3, "no taxel is above the limit of 3 N: the test needs one");
  await seek(page, frame);
  const largest = felt(recording, rows[frame])[0].force;
  assert.ok((await page.locator("#clock").textContent()).endsWith(`largest taxel ${largest.toFixed(2)} N`));
  const labels = await page.locator(".force-label:not([hidden])").allTextContents();
  assert.ok(labels.length > 0 && labels.every((text) => /^\d+\.\d\d N$/.test(text)), labels.join());
  assert.ok((await page.locator(".force-label.over:not([hidden])").count()) > 0);
  assert.match(await page.locator("#legend").textContent(), /force of a whole contact.*red if one taxel of the contact reads more than the controller's limit of 3 N/);
  await finish(page);
});

/** Tests that the 3-D view has at least 55 % of the height of a phone's screen. */
test("the 3-D view is large on a phone", async () => {
  const page = await open(browser, server.address, { viewport: { width: 390, height: 844 } });
  await ready(page);
  const { height } = await page.locator(".view-box").boundingBox();
  assert.ok(height >= 0.55 * 844, `${height} px`);
  await finish(page);
});

/** Tests that the playback covers nothing of a low window: it stands in the page, and can be scrolled to. */
test("in a low window the playback scrolls with the page", async () => {
  for (const [width, height] of [[844, 390], [320, 256]]) {
    const page = await open(browser, server.address, { viewport: { width, height } });
    await ready(page);
    assert.ok((await page.locator("#play").boundingBox()).y > height, `${width} px: the playback lies over the page`);
    await page.locator("#play").scrollIntoViewIfNeeded();
    const { y } = await page.locator("#play").boundingBox();
    assert.ok(y >= 0 && y < height, `${width} px: ${y} px`);
    await finish(page);
  }
});

/** Tests that at 1280 px panels side by side are equally high, also with a long description of the selection, and that the view
 * fills its panel. */
test("no empty stripe lies between the panels", async () => {
  const page = await open(browser, server.address, { viewport: { width: 1280, height: 800 } });
  await ready(page);
  const box = (selector) => page.locator(selector).boundingBox();
  const bottom = async (selector) => (({ y, height }) => y + height)(await box(selector));
  for (const chosen of [false, true]) {
    if (chosen) {
      await page.locator("#tab-mistakes").click();
      await page.locator("#panel-mistakes tbody tr").first().click();
      await settle(page);
    }
    assert.ok(Math.abs((await bottom(".stage")) - (await bottom(".skin"))) < 1);
    assert.ok(Math.abs((await bottom(".time")) - (await bottom(".details"))) < 1);
    assert.ok((await box("#legend")).y - (await bottom(".view-box")) < 12);
    assert.ok((await bottom(".time")) - (await bottom("#plots")) < 20, "there is room below the plots");
  }
  await finish(page);
});

/** Tests that a browser without WebGL shows its message in place of the 3-D view, no higher than its text, with no empty stripe
 * below it, and no choice of views. */
test("without WebGL there is no empty view", async () => {
  for (const width of [390, 1280, 1600]) {
    const before = () => {
      HTMLCanvasElement.prototype.getContext = ((original) => function (kind, ...more) {
        return kind === "webgl2" ? null : original.call(this, kind, ...more);
      })(HTMLCanvasElement.prototype.getContext);
    };
    const page = await open(browser, server.address, { viewport: { width, height: 900 }, before });
    await ready(page);
    const box = (selector) => page.locator(selector).boundingBox();
    assert.match(await page.locator(".no-webgl").textContent(), /cannot draw in 3-D/);
    const [message, panes, stage, legend] = await Promise.all([".no-webgl", "#panes", ".stage", "#legend"].map(box));
    assert.ok(panes.height - message.height < 2 && legend.y - message.y - message.height < 12, `${width} px: the view is empty`);
    const next = await box(width < 1560 ? ".time" : ".list");
    assert.ok(next.y - stage.y - stage.height < 20, `${width} px: an empty stripe below the message`);
    assert.ok(await page.locator("#camera").isHidden(), "the view can be turned");
    await finish(page);
  }
});
