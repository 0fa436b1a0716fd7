// The size of a single file, and that nothing is lost in it.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { inflateSync } from "node:zlib";

import { file, finishAll, makeData, program, serve } from "./support.mjs";

before(makeData);
after(() => finishAll());

/** Tests that the page of a reach in mixed clutter with the verdicts of a touch model is smaller than 3 MB, and that the
 * bytes of the reach in it are those that the server sends. */
test("a reach with verdicts takes less than 3 MB", async () => {
  program("replay", file("mixed.parquet"), "--model", file("touch.json"), "--out", file("small.html"), "--force");
  const text = readFileSync(file("small.html"), "utf8");
  assert.ok(text.length < 3e6, `${text.length} bytes`);
  const packed = inflateSync(Buffer.from(/id="underbrush-reach-0">([^<]*)</.exec(text)[1], "base64"));
  const server = await serve(file("mixed.parquet"), "--model", file("touch.json"));
  const sent = await (await fetch(`${server.address}api/reach/0`)).arrayBuffer();
  assert.ok(packed.equals(Buffer.from(sent)));
  server.close();
});
