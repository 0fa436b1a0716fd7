// The views: colours, selection, the 3-D view and the address, by mouse and by keyboard.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { felt, finish, fullestFrame, mixedSite, readRecording, says, seek, settle, state } from "./support.mjs";

const { begin, end, start } = mixedSite();
before(begin);
after(end);

/** Tests that the switch changes colours on the map and on the arm together, by mouse and by key. */
test("one switch colours map and arm", async () => {
  const { recording, rows } = await readRecording("mixed.parquet");
  const page = await start();
  const frame = fullestFrame(recording, rows);
  await seek(page, frame);
  const [{ taxel }] = felt(recording, rows[frame]).filter(({ object, patch }) => object >= 0 && patch === "forearm");
  const colours = [];
  for (const name of ["force", "truth", "verdict"]) {
    await page.locator("#colour").getByText(name).click();
    await settle(page);
    colours.push((await page.evaluate((taxel) => window.underbrushReplay.drawn().taxel(taxel), taxel)).colour);
  }
  assert.notEqual(colours[0], colours[1]);
  // Truth: the colour of the object's category.
  const { category } = recording.objects[felt(recording, rows[frame]).find((own) => own.taxel === taxel).object];
  assert.equal(colours[1], { leaf: "#1b8a4b", trunk: "#6b4423", block: "#a8904a" }[category]);
  await page.locator("body").click({ position: { x: 2, y: 2 } });
  for (const [key, colour] of [["1", "force"], ["2", "truth"], ["3", "verdict"]]) {
    await page.keyboard.press(key);
    assert.equal((await state(page)).colour, colour);
  }
  for (const camera of ["hand", "top", "side", "free"]) {
    await page.keyboard.press("v");
    assert.equal((await state(page)).camera, camera);
  }
  await finish(page);
});

/** Tests that a taxel chosen on the map is chosen everywhere: details, plots, strips and address; by mouse and by keyboard. */
test("a taxel is chosen in all views at once", async () => {
  const { recording, rows } = await readRecording("mixed.parquet");
  const page = await start();
  const frame = fullestFrame(recording, rows);
  await seek(page, frame);
  const [strongest] = felt(recording, rows[frame]).filter(({ patch }) => patch === "forearm");
  const map = page.locator('.skin-map[data-patch="forearm"]');
  const [x, y] = await page.evaluate((taxel) => window.underbrushReplay.maps()[0].placeOf(taxel), strongest.taxel);
  await map.hover({ position: { x, y } });
  await settle(page);
  const name = `forearm row ${Math.floor(strongest.index / 24)}, column ${strongest.index % 24}`;
  const under = await page.locator(".under").textContent();
  assert.ok(under.startsWith(`${name}: `) && says(under, `${name}:`, strongest.force) && /: \d+\.\d\d N sensed/.test(under), under);
  await map.click({ position: { x, y } });
  await settle(page);
  assert.equal((await state(page)).taxel, strongest.taxel);
  const details = await page.locator("#details").textContent();
  assert.ok(details.includes(name) && says(details, "sensed force", strongest.force), details);
  assert.ok(details.includes("score of leaf") && details.includes("contact motion so far"), details);
  assert.ok(await page.locator('[data-plot="taxel"]').isVisible() && await page.locator('[data-plot="scores"]').isVisible());
  assert.ok(says(await page.locator('[data-plot="taxel"] output').textContent(), "sensed", strongest.force));
  await page.waitForFunction((index) => location.hash.includes(`taxel=forearm.${index}`), strongest.index);
  // By keyboard: one taxel to the right on the map, then Enter.
  await map.focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  const { taxel } = await state(page);
  assert.equal(taxel, strongest.index % 24 === 23 ? strongest.taxel : strongest.taxel + 1);
  await page.keyboard.press("Escape");
  assert.equal((await state(page)).taxel, null);
  await finish(page);
});

/** Tests that what is read does not flicker: the text of a taxel stays until the pointer leaves the map, and details that do not
 * change stay the same elements. */
test("what is pointed at stays", async () => {
  const page = await start();
  const map = page.locator('.skin-map[data-patch="flipper"]');
  const [x, y] = await page.evaluate(() => {
    const own = window.underbrushReplay.maps()[1];
    const { first_taxel } = window.underbrushReplay.loaded().reach.header.patches[1];
    return own.placeOf(first_taxel);
  });
  await map.hover({ position: { x, y } });
  await settle(page);
  const under = page.locator(".under").first();
  assert.match(await under.textContent(), /^flipper taxel 0: /);
  await map.hover({ position: { x: 1, y: 1 } });
  await settle(page);
  assert.match(await under.textContent(), /^flipper taxel 0: /);
  await page.mouse.move(1, 1);
  await settle(page);
  assert.equal(await under.textContent(), "Point at a taxel to read it.");
  await map.click({ position: { x, y } });
  await settle(page);
  const first = await page.locator("#details > *").first().elementHandle();
  for (const colour of ["truth", "verdict"]) {
    await page.locator("#colour").getByText(colour).click();
    await settle(page);
  }
  assert.ok(await first.evaluate((own) => own.isConnected));
  // Two patches, of which a model judges one.
  assert.match(await page.locator("#legend").textContent(), /judges the patch forearm alone/);
  await finish(page);
});

/** Tests that a click on the 3-D view chooses the object under the pointer, and that the keyboard turns the view. */
test("the 3-D view can be clicked and turned", async () => {
  const { recording } = await readRecording("mixed.parquet");
  const page = await start("#reach=0&view=top");
  const trunk = recording.objects.findIndex(({ category }) => category === "trunk");
  const { position_world: foot, parameters } = recording.objects[trunk];
  const body = recording.bodies.findIndex(({ owner, parts }) => owner.object === trunk && parts.length > 0);
  const box = await page.locator(".view").boundingBox();
  const [x, y] = await page.evaluate(([foot, height]) => window.underbrushReplay.drawn().project([foot[0], foot[1], foot[2] + height]), [foot, 0.98 * parameters.height_m]);
  assert.ok(body >= 0);
  await page.mouse.click(box.x + x, box.y + y);
  await settle(page);
  assert.equal((await state(page)).object, trunk);
  assert.match(await page.locator("#details").textContent(), new RegExp(`trunk ${trunk}`));
  const before = await page.evaluate(() => window.underbrushReplay.drawn().project([0.5, 0, 0]));
  await page.locator(".view").focus();
  await page.keyboard.press("ArrowLeft");
  await settle(page);
  const after = await page.evaluate(() => window.underbrushReplay.drawn().project([0.5, 0, 0]));
  assert.ok(Math.hypot(after[0] - before[0], after[1] - before[1]) > 2, "the view did not turn");
  assert.equal((await state(page)).frame, 0, "the key also moved time");
  await finish(page);
});

/** Tests that the whole, the upper and the side view show all of every object, in a wide and in a narrow window. */
test("the views show everything", async () => {
  for (const width of [1280, 390]) {
    const page = await start("", { viewport: { width, height: 900 } });
    for (const camera of ["free", "top", "side"]) {
      await page.locator(`#camera input[value=${camera}]`).check({ force: true });
      await settle(page);
      const view = await page.locator(".view").boundingBox();
      const places = await page.evaluate(() => {
        const { drawn, loaded } = window.underbrushReplay;
        return loaded().reach.header.bodies.flatMap((_, body) => drawn().body(body)?.world ?? []).map((place) => drawn().project(place));
      });
      assert.ok(places.length > 100 && places.every(([x, y]) => x >= 0 && x <= view.width && y >= 0 && y <= view.height), `${camera} at ${width} px`);
    }
    await finish(page);
  }
});

/** Tests that the 3-D view turns when it is dragged, and zooms by the wheel and by the plus and minus keys. */
test("the 3-D view can be dragged and zoomed", async () => {
  const page = await start();
  const box = await page.locator(".view").boundingBox();
  /** Where two points of the world are on the screen, px. */
  const places = () => page.evaluate(() => [[0.4, 0, 0], [0.6, 0, 0]].map((point) => window.underbrushReplay.drawn().project(point)));
  const apart = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);
  const before = await places();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 60, box.y + box.height / 2, { steps: 3 });
  await page.mouse.up();
  await settle(page);
  const turned = await places();
  assert.ok(Math.hypot(turned[0][0] - before[0][0], turned[0][1] - before[0][1]) > 2, "the view did not turn");
  assert.deepEqual([(await state(page)).taxel, (await state(page)).object], [null, null], "a drag selected something");
  await page.mouse.wheel(0, -300);
  await page.waitForFunction((size) => {
    const [a, b] = [[0.4, 0, 0], [0.6, 0, 0]].map((point) => window.underbrushReplay.drawn().project(point));
    return Math.hypot(a[0] - b[0], a[1] - b[1]) > 1.02 * size;
  }, apart(turned));
  const zoomed = apart(await places());
  await page.locator(".view").focus();
  await page.keyboard.press("-");
  const out = apart(await places());
  await page.keyboard.press("+");
  assert.ok(out < 0.97 * zoomed && apart(await places()) > 1.03 * out);
  await finish(page);
});

/** Tests that an address brings back reach, moment, colours, view, rate and taxel, and that nonsense in it is ignored. */
test("an address brings a finding back", async () => {
  const page = await start("#reach=1&t=4.21&colour=truth&view=side&rate=0.5&taxel=flipper.7");
  const found = await state(page);
  assert.deepEqual([found.reach, found.colour, found.camera, found.rate], [1, "truth", "side", 0.5]);
  assert.match(await page.locator("#clock").textContent(), /^4\.21 s/);
  assert.match(await page.locator("#details").textContent(), /flipper taxel 7/);
  await page.evaluate(() => (location.hash = "#reach=1&t=2"));
  await page.waitForFunction(() => document.getElementById("clock").textContent.startsWith("2.00 s"));
  const plain = await state(page);
  assert.deepEqual([plain.colour, plain.camera, plain.rate, plain.taxel], ["force", "free", 1, null], "what an address leaves out is as at the beginning");
  await page.locator("#play").click();
  await page.evaluate(() => (location.hash = "#reach=1&t=3&taxel=flipper.7"));
  await page.waitForFunction(() => document.getElementById("clock").textContent.startsWith("3.00 s") && !window.underbrushReplay.state.playing);
  await page.locator(".skip").focus();
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => location.hash.includes("taxel=flipper.7"));
  assert.notEqual((await state(page)).taxel, null, "the link to the playback changes what is shown");
  await finish(page);
  const odd = await start("#reach=0&t=-5&colour=pink&view=moon&rate=99&taxel=forearm.99999&object=77777&beside=12");
  const kept = await state(odd);
  assert.deepEqual([kept.frame, kept.colour, kept.camera, kept.rate, kept.taxel, kept.object], [0, "force", "free", 1, null, null]);
  await finish(odd);
});

/** Tests that an address counts that a reader changes at the moment when the page is about to write its own. */
test("the address of a reader wins over the page's", async () => {
  const page = await start("#reach=1");
  await page.locator("#colour").getByText("truth").click();
  await settle(page);
  await page.evaluate(() => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => (location.hash = "#reach=1&t=2");
    port2.postMessage(null);
    // Longer than the page waits before it writes. It then writes after the address has changed and before it hears of it.
    const end = performance.now() + 600;
    while (performance.now() < end);
  });
  await page.waitForFunction(() => document.getElementById("clock").textContent.startsWith("2.00 s"));
  await finish(page);
});

/** Tests that shadows are off where the processor draws until they are asked for, that links then darken the ground where the line
 * from the lamp through them meets it, that nothing becomes lighter, and that taxels keep their colours. */
test("the lamp casts shadows", async () => {
  const { recording, rows } = await readRecording("mixed.parquet");
  const page = await start("#reach=0&view=top");
  const frame = fullestFrame(recording, rows);
  await seek(page, frame);
  const box = page.getByLabel("Shadows");
  assert.ok(!(await box.isChecked()));
  const lamp = [-0.2242, -0.5231, 0.8222];
  const ground = Math.min(...recording.objects.map(({ position_world: [, , z] }) => z));
  const links = recording.bodies.flatMap(({ owner, parts }, body) => (owner.link !== undefined && parts.length > 0 ? [body] : []));
  const taxels = felt(recording, rows[frame]).map(({ taxel }) => taxel);
  /** Brightness at the ends of the lines through the middles of the links, and the number of
   * pressed taxels that are seen in their colour. */
  const look = () => page.evaluate(([lamp, ground, links, taxels]) => {
    const drawn = window.underbrushReplay.drawn();
    const bright = (point) => drawn.pixel(...drawn.project(point)).slice(0, 3).reduce((sum, value) => sum + value);
    const ends = links.map((body) => {
      const { world } = drawn.body(body);
      const middle = [0, 1, 2].map((axis) => world.reduce((sum, point) => sum + point[axis], 0) / world.length);
      return middle.map((value, axis) => value - (lamp[axis] * (middle[2] - ground)) / lamp[2]);
    });
    // Taxels that the view does not show have no pixel of their colour.
    const seen = taxels.map((taxel) => drawn.taxel(taxel)).filter(({ position, colour }) => {
      const pixel = drawn.pixel(...drawn.project(position));
      return [1, 3, 5].every((at, channel) => Math.abs(Number.parseInt(colour.slice(at, at + 2), 16) - pixel[channel]) < 2);
    });
    return { ends: ends.map(bright), seen: seen.length };
  }, [lamp, ground, links, taxels]);
  const before = await look();
  await box.check();
  await settle(page);
  const after = await look();
  assert.ok(after.ends.some((value, at) => value < before.ends[at] - 20), `${before.ends} becomes ${after.ends}`);
  assert.ok(after.ends.every((value, at) => value <= before.ends[at] + 3), `${before.ends} becomes ${after.ends}`);
  assert.ok(before.seen > 0 && after.seen === before.seen, `${before.seen} taxels have their colour, then ${after.seen}`);
  await box.uncheck();
  await settle(page);
  assert.deepEqual(await look(), before);
  await finish(page);
});

/** Tests that there are shadows from the beginning where a graphics card draws. */
test("a graphics card casts shadows at once", async () => {
  const page = await start("#reach=0", {
    before: () => {
      const original = WebGL2RenderingContext.prototype.getParameter;
      WebGL2RenderingContext.prototype.getParameter = function (name) {
        // UNMASKED_RENDERER_WEBGL
        return name === 0x9246 ? "a graphics card" : original.call(this, name);
      };
    },
  });
  assert.ok(await page.getByLabel("Shadows").isChecked());
  await finish(page);
});
