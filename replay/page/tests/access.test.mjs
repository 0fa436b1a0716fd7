// For everyone: accessibility, sizes, themes, a browser without WebGL, and no request to any other host.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { file, finishAll, launch, makeData, open, program, ready, seek, serious, serve, settle } from "./support.mjs";

let browser;
let server;
before(async () => {
  await makeData();
  browser = await launch();
  server = await serve(file("mixed.parquet"), file("blind.parquet"), "--model", file("model.json"));
});
after(() => finishAll(browser));

/** Tests that axe-core finds nothing at three sizes in both themes, that nothing is wider than the screen, and that the page
 * asks no other host. */
test("axe-core finds nothing at any size or theme", async () => {
  for (const width of [390, 1100, 1920]) {
    for (const colorScheme of ["light", "dark"]) {
      const page = await open(browser, `${server.address}#reach=0&t=3&taxel=forearm.100`, { viewport: { width, height: 900 }, colorScheme, bypassCSP: true });
      await ready(page);
      assert.deepEqual(await serious(page), [], `${width} px, ${colorScheme}`);
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(overflow <= 0, `${overflow} px too wide at ${width} px`);
      assert.deepEqual(page.problems, []);
      await page.context().close();
    }
  }
});

/** Tests that nothing is wider than its place after the window has become narrower, as the 3-D view once was. */
test("the page follows a narrower window", async () => {
  const page = await open(browser, server.address);
  await ready(page);
  for (const width of [700, 390]) {
    await page.setViewportSize({ width, height: 900 });
    await page.waitForFunction(() => {
      const [view, panel] = [document.querySelector(".view"), document.querySelector(".stage")].map((element) => element.getBoundingClientRect());
      return view.right < panel.right && document.documentElement.scrollWidth <= document.documentElement.clientWidth;
    });
  }
  assert.deepEqual(page.problems, []);
  await page.context().close();
});

/** Tests that a page in the dark theme is printed in light colours, with a picture of the 3-D view, and is dark again afterwards. */
test("print is light and has the 3-D view", async () => {
  const page = await open(browser, `${server.address}#reach=0&t=3`, { colorScheme: "dark" });
  await ready(page);
  const empty = () => page.evaluate(() => {
    const canvas = document.querySelector(".skin-map");
    const [x, y] = window.underbrushReplay.maps()[0].placeOf(200);
    return canvas.getContext("2d").getImageData(x, y, 1, 1).data[0];
  });
  const dark = await empty();
  await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
  assert.ok((await empty()) > dark + 100, "the map is still dark");
  await page.emulateMedia({ media: "print" });
  const [colours, shown] = await page.locator("img.print").evaluate(async (image) => {
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
    return [new Set(new Uint32Array(data.buffer)).size, image.checkVisibility()];
  });
  assert.ok(shown && colours > 100, `${colours} colours`);
  for (const control of [".scrubber", "#play", "#shadows-field"]) assert.ok(await page.locator(control).isHidden(), control);
  assert.match(await page.locator("#clock").textContent(), /^3\.00 s/);
  assert.ok(await page.locator("#clock").isVisible(), "print does not say the moment");
  await page.emulateMedia({ media: "screen" });
  await page.evaluate(() => dispatchEvent(new Event("afterprint")));
  await settle(page);
  assert.equal(await empty(), dark);
  assert.deepEqual(page.problems, []);
  await page.context().close();
});

/** Tests that the list of trials, the help and two reaches side by side are accessible too. */
test("other states of the page are accessible", async () => {
  const page = await open(browser, `${server.address}#reach=0&beside=1&t=4`, { bypassCSP: true });
  await ready(page);
  await page.waitForSelector("body.compared");
  await page.getByRole("tab", { name: "Contact trials" }).click();
  assert.deepEqual(await serious(page), []);
  await page.keyboard.press("?");
  assert.ok(await page.getByRole("dialog").isVisible());
  assert.deepEqual(await serious(page), []);
  await page.context().close();
});

/** Tests that a browser without WebGL says so and still has maps, strips and plots. */
test("without WebGL the maps and plots remain", async () => {
  const plain = await launch("--disable-3d-apis");
  const page = await open(plain, server.address);
  page.problems.length = 0;
  await ready(page);
  assert.ok(await page.getByText("cannot draw in 3-D").isVisible());
  await seek(page, 300);
  const painted = await page.locator(".skin-map").first().evaluate((canvas) => new Set(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data).size);
  assert.ok(painted > 10, "the map is empty");
  assert.match(await page.locator('[data-plot="force"] output').textContent(), /sensed \d/);
  // Three.js reports the missing context; nothing else may be wrong.
  assert.deepEqual(page.problems.filter((text) => !/WebGL/i.test(text)), []);
  await plain.close();
});

/** Tests that the single file opens from disk and shows the same, without any request. */
test("the single file opens from disk", async () => {
  program("replay", file("trunk.parquet"), "--out", file("trunk.html"));
  const page = await open(browser, `file://${file("trunk.html")}`);
  await ready(page);
  await settle(page);
  assert.match(await page.locator("#title").textContent(), /^trunk, seed 3/);
  assert.ok(await page.locator("#reach-controls").isHidden(), "a single reach needs no choice");
  assert.deepEqual(page.problems, []);
  await page.context().close();
});
