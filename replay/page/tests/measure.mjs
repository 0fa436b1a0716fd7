// Measures, without deciding: how long a reach takes to open and to draw, and how long a list takes.
// node tests/measure.mjs INPUT [INPUT …]

import { finishAll, launch, open, ready, serve } from "./support.mjs";

const inputs = process.argv.slice(2);
const begin = performance.now();
const server = await serve(...inputs);
console.log(`server ready after ${(performance.now() - begin).toFixed(0)} ms`);
const browser = await launch();
const warm = await open(browser, server.address);
await ready(warm);
await warm.context().close();
for (const [width, height] of [[390, 844], [1100, 900], [1920, 1080]]) {
  const start = performance.now();
  const page = await open(browser, server.address, { viewport: { width, height } });
  await page.waitForSelector("#panel-reaches tbody tr");
  const listed = performance.now() - start;
  await ready(page);
  const shown = performance.now() - start;
  const [frames, time, drawn] = await page.evaluate(() => new Promise((done) => {
    let count = 0;
    const start = performance.now();
    const first = window.underbrushReplay.state.frame;
    document.getElementById("play").click();
    const tick = () => {
      count++;
      const time = performance.now() - start;
      if (time > 6000) done([count, time, window.underbrushReplay.state.frame - first]);
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }));
  const reaches = await page.locator("#panel-reaches tbody tr").count();
  console.log(`${width} px: list of ${reaches} after ${listed.toFixed(0)} ms, reach after ${shown.toFixed(0)} ms, ${((1000 * frames) / time).toFixed(0)} frames a second, ${(drawn / 100).toFixed(2)} s of the reach in ${(time / 1000).toFixed(2)} s`);
  await page.context().close();
}
await finishAll(browser);
