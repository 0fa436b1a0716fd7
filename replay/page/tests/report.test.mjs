// The report that `underbrush reproduce` writes.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { file, finish, finishAll, launch, open, program, serious } from "./support.mjs";

let browser;
before(async () => {
  program("reproduce", "--quick", "--out", file("reproduced"));
  browser = await launch();
});
after(() => finishAll(browser));

/** Tests that axe-core finds nothing at two sizes in both themes with all sections open, and that nothing is wider than the screen. */
test("axe-core finds nothing in the report", async () => {
  for (const width of [390, 1280]) {
    for (const colorScheme of ["light", "dark"]) {
      const page = await open(browser, `file://${file("reproduced/report/index.html")}`, { viewport: { width, height: 900 }, colorScheme });
      const sections = await page.$$eval("details", (all) => all.map((own) => (own.open = true)).length);
      assert.ok(sections > 5, `${sections} sections`);
      assert.deepEqual(await serious(page), [], `${width} px, ${colorScheme}`);
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(overflow <= 0, `${overflow} px too wide at ${width} px`);
      await finish(page);
    }
  }
});
