// Checks every page of the built site in Chromium: axe-core finds nothing serious, nothing is wider than the screen, no script
// fails, and no other host is asked. Each page is seen on a phone in light colours, and on a desk in dark ones.
//
//     node docs/site/check.mjs FOLDER_OF_THE_SITE
//
// axe-core and Playwright are those of the tests of the replay page: `npm ci` in replay/page installs them.

import { readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const require = createRequire(new URL("../../replay/page/package.json", import.meta.url));
const { chromium } = require("playwright-core");
const AXE = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const SITE = resolve(process.argv[2]);
const LOOKS = [[390, "light"], [1280, "dark"]];

// The pages of `cargo doc` are another program's.
const pages = readdirSync(SITE, { recursive: true }).filter((name) => name.endsWith(".html") && !name.startsWith("rust/"));
if (pages.length < 20) throw new Error(`${SITE} has ${pages.length} pages: is it the site?`);
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
const found = [];

/** Checks all pages in one window. */
async function look([width, colorScheme]) {
  const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme, reducedMotion: "reduce" });
  const page = await context.newPage();
  page.setDefaultTimeout(240_000);
  let name;
  const report = (text) => found.push(`${name}, ${width} px, ${colorScheme}: ${text}`);
  page.on("pageerror", (error) => report(`error: ${error.message}`));
  page.on("request", (request) => /^(file|data|blob):/.test(request.url()) || report(`request: ${request.url()}`));
  for (name of pages) {
    await page.goto(pathToFileURL(join(SITE, name)).href);
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    if (overflow > 0) report(`${overflow} px too wide`);
    await page.evaluate(AXE);
    const { violations } = await page.evaluate(() => window.axe.run({ resultTypes: ["violations"] }));
    for (const { id, nodes } of violations.filter(({ impact }) => ["serious", "critical"].includes(impact))) {
      report(`${id}, ${nodes.length} times, first ${nodes[0].html.slice(0, 200)}: ${nodes[0].failureSummary}`);
    }
  }
  await context.close();
}

await Promise.all(LOOKS.map(look));
await browser.close();
for (const line of found) console.error(line);
console.log(`${pages.length} pages, ${found.length} findings`);
process.exitCode = found.length > 0 ? 1 : 0;
