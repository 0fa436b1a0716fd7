// Truncated, torn and foreign data give a clear message on the page.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync, cpSync, readdirSync, rmSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { deflateSync, inflateSync } from "node:zlib";

import { file, finishAll, launch, makeData, open, program, ready, serve } from "./support.mjs";

let browser;
before(async () => {
  await makeData();
  browser = await launch();
});
after(() => finishAll(browser));

/** The message of a single file after this change of its text. */
async function messageOf(name, change) {
  program("replay", file("trunk.parquet"), "--out", file("whole.html"), "--force");
  writeFileSync(file(`${name}.html`), change(readFileSync(file("whole.html"), "utf8")));
  const page = await open(browser, `file://${file(`${name}.html`)}`);
  const message = page.locator("#message");
  await page.waitForSelector("body[data-failed]");
  const text = await message.textContent();
  assert.ok(await message.isVisible());
  assert.deepEqual(page.problems, []);
  await page.context().close();
  return text;
}

const DATA = '<script type="application/octet-stream" id="underbrush-reach-0">';

/** Replaces the compressed bytes of the reach. */
function withCompressed(text, change) {
  const start = text.indexOf(DATA) + DATA.length;
  const end = text.indexOf("</script>", start);
  const bytes = Buffer.from(text.slice(start, end), "base64");
  return text.slice(0, start) + Buffer.from(change(bytes)).toString("base64") + text.slice(end);
}

/** Replaces the packed bytes of the reach. */
function withBytes(text, change) {
  return withCompressed(text, (bytes) => deflateSync(change(inflateSync(bytes))));
}

/** Tests the message for a file that was cut off in its data, as by a full disk or a broken download. */
test("a file that is cut off says so", async () => {
  for (const share of [0.6, 0.9]) {
    const text = await messageOf("cut", (text) => {
      const start = text.indexOf(DATA);
      return text.slice(0, start + Math.floor((text.length - start) * share));
    });
    assert.match(text, /cut off/);
  }
  assert.match(await messageOf("short", (text) => withBytes(text, (bytes) => bytes.subarray(0, bytes.length - 1000))), /cut off: [\d,]+ of [\d,]+ bytes/);
});

/** Tests that a file that was cut off before its data shows its message, although it has no script that runs. */
test("a file that is cut off in the script says so", async () => {
  program("replay", file("trunk.parquet"), "--out", file("whole.html"), "--force");
  writeFileSync(file("half.html"), readFileSync(file("whole.html"), "utf8").slice(0, 300_000));
  const page = await open(browser, `file://${file("half.html")}`);
  assert.match(await page.locator("#message").textContent(), /cut off/);
  assert.ok(await page.locator("#message").isVisible());
  await page.context().close();
});

/** Tests the messages for data with a flipped bit anywhere, of another version, and of another kind. */
test("damaged and foreign data are refused", async () => {
  for (const place of [13, 30, 5000, -1]) {
    const flipped = await messageOf("flipped", (text) => withBytes(text, (bytes) => {
      bytes[place < 0 ? bytes.length + place : place] ^= 4;
      return bytes;
    }));
    assert.match(flipped, /damaged/, `byte ${place}`);
  }
  assert.match(await messageOf("newer", (text) => withBytes(text, (bytes) => { bytes[8] = 9; return bytes; })), /version 9.*version 2/);
  assert.match(await messageOf("foreign", (text) => withBytes(text, () => readFileSync(file("trunk.parquet")))), /not the data of a reach/);
  for (const place of [0, 5000, -1]) {
    const flipped = await messageOf("flipped", (text) => withCompressed(text, (bytes) => {
      bytes[place < 0 ? bytes.length + place : place] ^= 4;
      return bytes;
    }));
    assert.match(flipped, /damaged/, `compressed byte ${place}`);
  }
  assert.match(await messageOf("torn", (text) => text.replace(DATA, `${DATA}§§§`)), /damaged/);
});

/** Tests that a data set that was damaged after the server had opened it gives the program's message for that reach, and that
 * the other reach still opens. */
test("a data set that is damaged while it is served says so", async () => {
  cpSync(file("set"), file("torn-set"), { recursive: true });
  const server = await serve(file("torn-set"));
  const poses = join(file("torn-set"), "truth/poses");
  const [chunk] = readdirSync(poses);
  const [table] = readdirSync(join(poses, chunk));
  const path = join(poses, chunk, table);
  const bytes = readFileSync(path);
  writeFileSync(path, bytes.subarray(0, bytes.length - 100));
  const page = await open(browser, server.address);
  await page.waitForSelector("body[data-failed]");
  const text = await page.locator("#message").textContent();
  assert.match(text, /truth\/poses/);
  writeFileSync(path, bytes);
  await page.locator("#panel-reaches tbody button").nth(1).click();
  await ready(page, 1);
  assert.ok(await page.locator("#message").isHidden());
  server.close();
  await page.context().close();
  rmSync(file("torn-set"), { recursive: true });
});

/** Tests that a reach that does not exist, and a server that has ended, are messages too. */
test("an address that leads nowhere says so", async () => {
  const server = await serve(file("trunk.parquet"));
  const page = await open(browser, `${server.address}#reach=7`);
  await page.waitForSelector("body[data-failed]");
  const message = page.locator("#message");
  assert.match(await message.textContent(), /no reach 7/);
  // The first reach is shown, and a number that is typed later has the same message.
  await ready(page);
  await page.waitForFunction(() => location.hash.startsWith("#reach=0&"));
  await page.evaluate(() => (location.hash = "#reach=0&t=1"));
  await page.waitForFunction(() => document.getElementById("message").hidden);
  await page.evaluate(() => (location.hash = "#reach=42"));
  await page.waitForFunction(() => location.hash.startsWith("#reach=0&t=1"));
  assert.match(await message.textContent(), /no reach 42/);
  assert.ok(await message.isVisible());
  await page.evaluate(() => (location.hash = "#reach=0&beside=9"));
  await page.waitForFunction(() => document.getElementById("message").textContent.includes("no reach 9"));
  await page.context().close();
  const two = await serve(file("trunk.parquet"), file("mixed.parquet"));
  const other = await open(browser, two.address);
  await ready(other);
  two.close();
  await other.waitForTimeout(200);
  await other.locator("#next-reach").click();
  await other.waitForSelector("body[data-failed]");
  assert.match(await other.locator("#message").textContent(), /server does not answer/);
  await other.context().close();
  server.close();
});
