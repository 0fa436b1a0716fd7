// Shared by the tests: recordings made by the program, the program as a server, and a browser.

import assert from "node:assert/strict";
import { execFile, execFileSync, spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { request } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";

import { parquetReadObjects, parquetMetadata } from "hyparquet";
import { compressors } from "hyparquet-compressors";
import { chromium } from "playwright-core";

const ROOT = resolve(dirname(fileURLToPath(import.meta.url)), "../../..");
const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const PROGRAM = process.env.UNDERBRUSH ?? join(process.env.CARGO_TARGET_DIR ?? join(ROOT, "target"), "release/underbrush");
const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";
const FLAGS = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--use-angle=swiftshader-webgl", "--enable-unsafe-swiftshader",
];

export const folder = process.env.REPLAY_DATA ?? mkdtempSync(join(tmpdir(), "underbrush-replay-"));
export const SCENES = ["leaf", "trunk", "mixed", "outlier"];

export function program(...options) {
  // Verdicts on all frames of a reach are megabytes.
  return execFileSync(PROGRAM, options.map(String), { cwd: ROOT, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"], maxBuffer: 1e9 });
}

/** A file of the tests' folder. */
export function file(name) {
  return join(folder, name);
}

const run = promisify(execFile);

/** Makes recordings of the four scenes, a data set, a model of trials and a touch model, once for all tests. A recording uses one
 * core, so they are made side by side. */
export async function makeData() {
  if (existsSync(file("done"))) return;
  const reach = (name, scene, ...more) => run(PROGRAM, ["reach", `scenes/${scene}.toml`, "--seed", "3", ...more, "--out", file(`${name}.parquet`)], { cwd: ROOT });
  const model = async () => {
    await run(PROGRAM, ["generate", "scenes/leaf.toml", "scenes/trunk.toml", "--reaches", "1", "--seed", "1", "--jobs", "1", "--out", file("set")], { cwd: ROOT });
    await run(PROGRAM, ["train", file("set"), "--out", file("model.json"), "--states", "3", "--jobs", "1"], { cwd: ROOT });
  };
  await Promise.all([...SCENES.map((scene) => reach(scene, scene)), reach("blind", "mixed", "--controller", "blind"), reach("mapped", "trunk", "--controller", "mapped"), model()]);
  // A touch model needs more reaches, and how well it judges does not matter here.
  const reaches = ["set", "leaf.parquet", "trunk.parquet", "mixed.parquet", "blind.parquet"].map(file);
  await run(PROGRAM, ["train", ...reaches, "--classifier", "touch", "--out", file("touch.json"), "--jobs", "2"], { cwd: ROOT });
  writeFileSync(file("done"), "");
}

/** Whether a text has a number after a label that is this value to two decimals. */
export function says(text, label, value) {
  const found = new RegExp(`${label}[^\\d-]*(-?\\d+\\.\\d\\d)`).exec(text);
  // The page holds numbers in single precision, which may round to the other side.
  return found !== null && Math.abs(Number(found[1]) - value) <= 0.00501;
}

/** Servers that run. A failed test must not leave one behind, or the test process would wait for it. */
const servers = new Set();

/** Ends what the tests of a file have started, and removes their data. */
export async function finishAll(browser) {
  for (const child of servers) child.kill();
  await browser?.close();
  if (process.env.REPLAY_DATA === undefined) rmSync(folder, { recursive: true, force: true });
}

/** Starts the server on these inputs; gives its address and a way to end it. */
export async function serve(...options) {
  const child = spawn(PROGRAM, ["replay", ...options.map(String), "--no-open", "--json"], { stdio: ["ignore", "pipe", "inherit"] });
  servers.add(child);
  const [line] = await new Promise((found, failed) => {
    createInterface({ input: child.stdout }).once("line", (line) => found([line]));
    child.once("exit", (status) => failed(new Error(`the program ended with ${status}`)));
  });
  return { address: JSON.parse(line).address, pid: child.pid, close: () => child.kill() };
}

/** Starts a reach that waits for its page; gives the page's address and a way to end it. */
export async function watch(...options) {
  const child = spawn(PROGRAM, ["reach", ...options, "--watch"], { cwd: ROOT, stdio: ["ignore", "ignore", "pipe"] });
  servers.add(child);
  const address = await new Promise((found, failed) => {
    createInterface({ input: child.stderr }).on("line", (line) => {
      const match = /http:\/\/127\.0\.0\.1:\d+\/\w+\//.exec(line);
      if (match !== null) found(match[0]);
    });
    child.once("exit", (status) => failed(new Error(`the program ended with ${status}`)));
  });
  const pause = () => new Promise((done, failed) => {
    const headers = { Origin: new URL(address).origin };
    request(`${address}api/live/pause`, { method: "POST", headers }, (answer) => answer.resume().on("end", () => done(answer.statusCode))).on("error", failed).end();
  });
  return { address, pause, close: () => child.kill() };
}

export function launch(...more) {
  return chromium.launch({ executablePath: CHROMIUM, args: [...FLAGS, ...(process.env.CHROMIUM_FLAGS ?? "").split(" ").filter(Boolean), ...more] });
}

/** Opens a page. `page.problems` lists errors and requests to other hosts; `before` runs in the page before its own script. */
export async function open(browser, address, { before = null, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1100, height: 900 }, reducedMotion: "reduce", ...options });
  const page = await context.newPage();
  if (before !== null) await page.addInitScript(before);
  page.setDefaultTimeout(LONG_MS);
  page.problems = [];
  page.on("pageerror", (error) => page.problems.push(`page error: ${error.message}`));
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && !isDriverRemark(message.text()) && page.problems.push(`console: ${message.text()}`));
  const own = address.startsWith("file:") ? "file:" : new URL(address).origin;
  page.on("request", (request) => !/^(data|blob):/.test(request.url()) && !request.url().startsWith(own) && page.problems.push(`request: ${request.url()}`));
  // While the page is being changed: the built page, without building the program anew.
  const fresh = process.env.REPLAY_PAGE;
  if (fresh !== undefined && own !== "file:") await page.route(address.replace(/#.*/, ""), (route) => route.fulfill({ path: fresh, contentType: "text/html; charset=utf-8" }));
  await page.goto(address);
  return page;
}

/** Chromium says this when a processor draws WebGL, and when the tests read pixels. */
function isDriverRemark(text) {
  return /GPU stall due to ReadPixels|Multiple readback operations|Automatic fallback to software WebGL/.test(text);
}

/** A busy machine on which a processor draws needs long. */
const LONG_MS = 240_000;

/** Waits until a reach is drawn. */
export async function ready(page, number = 0) {
  await page.waitForSelector(`body[data-ready="${number}"][data-frame]`, { timeout: LONG_MS });
  await settle(page);
}

/** Waits until everything that was asked for is drawn. */
export function settle(page) {
  return page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));
}

/** Keeps back the bytes of a reach, which the page asks the server for, until the function that is given back is called with what to
 * do with the request. */
export async function hold(page, number) {
  let release;
  const released = new Promise((done) => (release = done));
  const address = new RegExp(`/api/reach/${number}$`);
  await page.route(address, async (route) => (await released)(route));
  return async (answer) => {
    const done = page.waitForEvent(answer === "abort" ? "requestfailed" : "requestfinished", (request) => address.test(request.url()));
    release((route) => route[answer]());
    await done;
    await settle(page);
  };
}

/** Goes to a frame with the scrubber. */
export async function seek(page, frame) {
  await page.locator(".scrubber").evaluate((input, value) => {
    input.value = String(value);
    input.dispatchEvent(new Event("input"));
  }, frame);
  await settle(page);
}

/** All rows of a recording, read by another library than the program's, and what its metadata say. */
export async function readRecording(name) {
  const bytes = readFileSync(file(name));
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const metadata = parquetMetadata(buffer);
  const text = metadata.key_value_metadata.find(({ key }) => key === "underbrush.recording").value;
  const rows = await parquetReadObjects({ file: buffer, compressors });
  return { recording: JSON.parse(text), rows };
}

/** The pose of a body in a frame: the last one that moved it, as docs/data.md says. */
export function storedPose(recording, rows, body, frame) {
  for (let at = frame; at >= 0; at--) {
    const moved = rows[at]["truth.moved_body"].indexOf(body);
    if (moved >= 0) return rows[at]["truth.moved_pose"].slice(7 * moved, 7 * moved + 7);
  }
  const { position, orientation } = recording.bodies[body].rest_pose_world;
  return [...position, ...orientation];
}

/** Taxels with a force in a row, strongest first: their index in all patches and their force. */
export function felt(recording, row) {
  const found = [];
  let first = 0;
  for (const patch of recording.layout.patches) {
    row[`observation.tactile.${patch.name}`].forEach((force, index) => {
      if (force > 0) found.push({ patch: patch.name, index, taxel: first + index, force, truth: row[`truth.normal_force.${patch.name}`][index], object: row[`truth.object.${patch.name}`][index] });
    });
    first += patch.taxels.length;
  }
  return found.sort((a, b) => b.force - a.force);
}

/** The frame in which the most taxels feel something. */
export function fullestFrame(recording, rows) {
  const counts = rows.map((row) => felt(recording, row).length);
  return counts.indexOf(Math.max(...counts));
}

/** A browser and a server of a reach in mixed clutter, the same reach by a blind controller, and one among trunks, with a model.
 * `begin` makes them, `start` opens the page at an address, and `end` removes everything. */
export function mixedSite() {
  let browser;
  let server;
  return {
    begin: async () => {
      await makeData();
      browser = await launch();
      server = await serve(file("mixed.parquet"), file("blind.parquet"), file("trunk.parquet"), "--model", file("model.json"));
    },
    end: () => finishAll(browser),
    start: async (hash = "", options = {}) => {
      const page = await open(browser, `${server.address}${hash}`, options);
      await ready(page, Number(/reach=(\d+)/.exec(hash)?.[1] ?? 0));
      return page;
    },
  };
}

/** What axe-core finds, but for what is minor. */
export async function serious(page) {
  // A page's policy allows no script from outside, so it is added by the driver.
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  return violations.filter(({ impact }) => ["serious", "critical", "moderate"].includes(impact)).map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).slice(0, 3).join(" | ")}`);
}

/** What the page shows: its state. */
export function state(page) {
  return page.evaluate(() => ({ ...window.underbrushReplay.state }));
}

/** Ends a test: nothing may have gone wrong on the page. */
export async function finish(page) {
  assert.deepEqual(page.problems, []);
  await page.context().close();
}
