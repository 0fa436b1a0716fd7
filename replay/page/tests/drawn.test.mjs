// What is drawn is what is stored: the page against the Parquet file, read by another library.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { SCENES, felt, file, finishAll, fullestFrame, launch, makeData, open, program, readRecording, ready, says, seek, serve, settle, storedPose } from "./support.mjs";

let browser;
before(async () => {
  await makeData();
  browser = await launch();
});
after(() => finishAll(browser));

/** Opens the recording of a scene. */
async function openScene(name, ...options) {
  const server = await serve(file(`${name}.parquet`), ...options);
  const page = await open(browser, server.address);
  await ready(page);
  return { page, close: async () => { await page.context().close(); server.close(); } };
}

/** The colour on a skin map at the corner of a taxel's cell, beside the mark, as the page paints it on the canvas. */
function cellColour(page, taxel) {
  return page.evaluate((taxel) => {
    for (const map of window.underbrushReplay.maps()) {
      const place = map.placeOf(taxel);
      if (place === null) continue;
      const canvas = map.box.querySelector("canvas");
      const scale = canvas.width / canvas.clientWidth;
      const [x, y] = [(place[0] - map.side(taxel) * 0.36) * scale, (place[1] - map.side(taxel) * 0.36) * scale];
      return [...canvas.getContext("2d").getImageData(Math.round(x), Math.round(y), 1, 1).data];
    }
    return null;
  }, taxel);
}

/** The ramp of src/colours.ts on a light ground. */
const RAMP = ["#e9edf1", "#fdd98c", "#f79646", "#d9472f", "#9b1b4b", "#4a0d4f"].map((text) => [1, 3, 5].map((at) => Number.parseInt(text.slice(at, at + 2), 16)));

function rampColour(share) {
  const at = Math.sqrt(Math.min(share, 1)) * (RAMP.length - 1);
  const low = Math.min(Math.floor(at), RAMP.length - 2);
  return [0, 1, 2].map((channel) => RAMP[low][channel] + (RAMP[low + 1][channel] - RAMP[low][channel]) * (at - low));
}

function near(found, expected, tolerance, what) {
  found.forEach((value, index) => assert.ok(Math.abs(value - expected[index]) <= tolerance, `${what}: ${found} is not ${expected}`));
}

/** Tests that every taxel of a map has the colour of the force that the file stores for it, and an empty one the empty colour. */
test("the skin maps show the stored forces", async () => {
  for (const scene of SCENES) {
    const { recording, rows } = await readRecording(`${scene}.parquet`);
    const { page, close } = await openScene(scene);
    const frame = fullestFrame(recording, rows);
    await seek(page, frame);
    const taxels = felt(recording, rows[frame]);
    assert.ok(taxels.length > 3, `${scene} has too few taxels in contact for this test`);
    const limit = 3;
    const largest = Math.max(limit, ...rows.flatMap((row) => felt(recording, row).slice(0, 1).map(({ force }) => force)));
    for (const { taxel, force } of taxels.filter(({ force }) => force < limit)) {
      near((await cellColour(page, taxel)).slice(0, 3), rampColour(force / largest), 2, `${scene}, taxel ${taxel}, ${force} N`);
    }
    const quiet = [...Array(recording.layout.patches[0].taxels.length).keys()].find((taxel) => taxels.every((own) => own.taxel !== taxel));
    near((await cellColour(page, quiet)).slice(0, 3), [0xf1, 0xf4, 0xf6], 1, "an empty taxel");
    assert.deepEqual(page.problems, []);
    await close();
  }
});

/** The distance of the farthest point of a shape from its middle, m. */
function extent({ sphere, cylinder, capsule, box, hull }) {
  if (sphere) return sphere.radius_m;
  if (cylinder) return Math.hypot(cylinder.radius_m, cylinder.length_m / 2);
  if (capsule) return capsule.radius_m + capsule.length_m / 2;
  return box ? Math.hypot(...box.size_m) / 2 : Math.max(...hull.points_m.map((point) => Math.hypot(...point)));
}

/** Tests that links, trunks and rolls are drawn at their stored poses, and that the hinges of a leaf are its pieces' origins. */
test("links and objects are drawn at their stored poses", async () => {
  for (const scene of SCENES) {
    const { recording, rows } = await readRecording(`${scene}.parquet`);
    const { page, close } = await openScene(scene);
    let [bodies, leaves] = [0, 0];
    for (const frame of [0, Math.floor(rows.length / 3), rows.length - 1]) {
      await seek(page, frame);
      const [all, hingesOf] = await page.evaluate(([bodies, objects]) => {
        const { body, hinges } = window.underbrushReplay.drawn();
        return [Array.from({ length: bodies }, (_, index) => body(index)), Array.from({ length: objects }, (_, index) => hinges(index))];
      }, [recording.bodies.length, recording.objects.length]);
      for (const [body, { owner, parts }] of recording.bodies.entries()) {
        const drawn = all[body];
        const pose = storedPose(recording, rows, body, frame);
        if (drawn !== null) {
          const length = Math.hypot(...pose.slice(3));
          const unit = [...pose.slice(0, 3), ...pose.slice(3).map((value) => value / length)];
          assert.ok(drawn.own.length >= 8, `body ${body} has ${drawn.own.length} vertices`);
          drawn.own.forEach((place, vertex) => near(drawn.world[vertex], transform(unit, place), 1e-6, `${scene}, frame ${frame}, body ${body}, vertex ${vertex}`));
          // The vertices are those of the stored shapes: none lies outside.
          const reach = Math.max(...parts.map(({ shape, pose_body: { position } }) => Math.hypot(...position) + extent(shape)));
          const far = Math.max(...drawn.own.map((place) => Math.hypot(...place)));
          assert.ok(far <= reach + 1e-6 && far > 0.5 * reach - 1e-6, `${scene}, body ${body}: ${far} m, not ${reach} m`);
          bodies++;
        } else if (parts.length > 0) {
          const own = hingesOf[owner.object].find((hinge) => Math.hypot(...hinge.map((value, axis) => value - pose[axis])) < 1e-6);
          assert.ok(own, `${scene}, frame ${frame}: no hinge of leaf ${owner.object} is at ${pose.slice(0, 3)}`);
          leaves++;
        }
      }
    }
    assert.ok(bodies > 15, `${bodies} bodies in ${scene}`);
    assert.ok(scene === "trunk" || scene === "outlier" || leaves > 20, `${leaves} pieces of leaves in ${scene}`);
    assert.deepEqual(page.problems, []);
    await close();
  }
});

/** Tests that a pressed taxel is drawn on the arm where its link's pose puts it, in the colour that the map has for it. */
test("taxels on the arm have their place and colour", async () => {
  const { recording, rows } = await readRecording("mixed.parquet");
  const { page, close } = await openScene("mixed");
  const frame = fullestFrame(recording, rows);
  await seek(page, frame);
  for (const { taxel, patch, index } of felt(recording, rows[frame]).slice(0, 8)) {
    const drawn = await page.evaluate((taxel) => window.underbrushReplay.drawn().taxel(taxel), taxel);
    const layout = recording.layout.patches.find(({ name }) => name === patch).taxels[index];
    const pose = rows[frame][`observation.patch_pose.${patch}`];
    // 1.2 mm above the skin, along the normal.
    const place = layout.position_link.map((value, axis) => value + 0.0012 * layout.normal_link[axis]);
    near(drawn.position, transform(pose, place), 1e-5, `taxel ${taxel}`);
    near([1, 3, 5].map((at) => Number.parseInt(drawn.colour.slice(at, at + 2), 16)), (await cellColour(page, taxel)).slice(0, 3), 1, `taxel ${taxel}`);
  }
  await close();
});

function transform([x, y, z, i, j, k, w], [px, py, pz]) {
  const [a, b, c] = [2 * (j * pz - k * py), 2 * (k * px - i * pz), 2 * (i * py - j * px)];
  return [x + px + w * a + j * c - k * b, y + py + w * b + k * a - i * c, z + pz + w * c + i * b - j * a];
}

/** Tests that the pixels of the 3-D view show the goal in its colour where the stored goal is, and not where it is not. */
test("the 3-D view draws the goal where it is stored", async () => {
  const { rows } = await readRecording("trunk.parquet");
  const { page, close } = await openScene("trunk");
  await page.getByText("top", { exact: true }).click();
  await seek(page, 0);
  const goal = rows[0].goal_position;
  const [there, aside, accent] = await page.evaluate((goal) => {
    const { project, pixel } = window.underbrushReplay.drawn();
    const probe = document.createElement("span");
    probe.style.color = "var(--accent)";
    document.body.append(probe);
    const [x, y] = project(goal);
    return [pixel(x, y), pixel(x + 60, y + 60), getComputedStyle(probe).color.match(/\d+/g).map(Number)];
  }, goal);
  near(there.slice(0, 3), accent, 3, "the goal");
  assert.ok(Math.abs(aside[2] - accent[2]) > 20, `${aside} is too near the colour of the goal`);
  await close();
});

/** Tests that the numbers beside the plots are those of the file at the frame of the scrubber. */
test("the plots show the stored values", async () => {
  const { recording, rows } = await readRecording("mixed.parquet");
  const { page, close } = await openScene("mixed");
  const frame = fullestFrame(recording, rows);
  await seek(page, frame);
  const row = rows[frame];
  const value = async (plot) => page.locator(`[data-plot="${plot}"] output`).textContent();
  const taxels = felt(recording, row);
  assert.ok(says(await value("force"), "^sensed", taxels[0].force), await value("force"));
  const [tip, goal] = [row["observation.tip_pose"], row.goal_position];
  const distance = 100 * Math.hypot(...goal.map((value, axis) => value - tip[axis]));
  assert.ok(says(await value("distance"), "distance", distance), `${await value("distance")}, ${distance}`);
  const area = taxels.filter(({ force }) => force > 0.03).reduce((sum, { patch, index }) => {
    return sum + 1e4 * recording.layout.patches.find(({ name }) => name === patch).taxels[index].area_m2;
  }, 0);
  assert.ok(says(await value("area"), "area", area), `${await value("area")}, ${area}`);
  const torques = await value("torque");
  for (const [joint, torque] of row["observation.torque"].entries()) assert.ok(says(torques, recording.joint_names[joint].replace(/_/g, " "), torque), torques);
  await close();
});

/** Tests that the verdicts on the page are those that `underbrush classify --online` prints for the same recording. */
test("verdicts are those of the program", async () => {
  const lines = program("classify", file("model.json"), file("mixed.parquet"), "--online").trim().split("\n").map((line) => JSON.parse(line));
  const { page, close } = await openScene("mixed", "--model", file("model.json"));
  const frame = lines.reduce((best, line, index) => (line.taxels.length > lines[best].taxels.length ? index : best), 0);
  await page.getByText("verdict", { exact: true }).first().click();
  await seek(page, frame);
  assert.ok(lines[frame].taxels.length > 5);
  for (const { taxel, samples, verdict, scores } of lines[frame].taxels) {
    const shown = await page.evaluate(([taxel, frame]) => {
      const { reach, trials } = window.underbrushReplay.loaded();
      const found = trials.verdict(taxel, frame);
      const { categories } = reach.header.verdicts;
      return { ...found, scores: Object.fromEntries(categories.map((name, index) => [name, trials.verdictScore[found.row * categories.length + index]])) };
    }, [taxel, frame]);
    assert.equal(shown.name, verdict);
    assert.equal(shown.samples, samples);
    for (const [name, score] of Object.entries(scores)) assert.ok(Math.abs(shown.scores[name] - score) <= 1e-5 * Math.abs(score) + 1e-6, `${name}: ${shown.scores[name]}, ${score}`);
  }
  assert.deepEqual(page.problems, []);
  await close();
});

/** Tests that the page draws the controller's map of each frame, and says so in the legend. */
test("the map of the frame is drawn", async () => {
  const { recording } = await readRecording("mapped.parquet");
  assert.ok(recording.map.length > 0);
  const { page, close } = await openScene("mapped");
  assert.match(await page.locator("#legend").textContent(), /controller's map/);
  for (const { first_frame: frame } of recording.map) {
    for (const at of [frame - 1, frame]) {
      await seek(page, at);
      const expected = recording.map.filter(({ first_frame, last_frame }) => first_frame <= at && at <= last_frame).length;
      assert.equal(await page.evaluate(() => window.underbrushReplay.drawn().obstacles), expected);
    }
  }
  await close();
});
