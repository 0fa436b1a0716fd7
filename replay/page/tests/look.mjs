// Takes pictures of the page for a person to look at: four scenes at three sizes in both themes, as a whole and as the screen
// shows them first, and in print.
// node tests/look.mjs FOLDER

import { join } from "node:path";

import { SCENES, felt, file, finishAll, fullestFrame, launch, makeData, open, readRecording, ready, serve, settle } from "./support.mjs";

const folder = process.argv[2] ?? ".";
await makeData();
const browser = await launch();
for (const scene of SCENES) {
  const { recording, rows } = await readRecording(`${scene}.parquet`);
  const frame = fullestFrame(recording, rows);
  const [strongest] = felt(recording, rows[frame]);
  const server = await serve(file(`${scene}.parquet`), "--model", file("model.json"));
  for (const [width, height] of [[390, 844], [1100, 900], [1920, 1080]]) {
    for (const colorScheme of ["light", "dark"]) {
      const hash = `#reach=0&t=${rows[frame].time_s.toFixed(2)}&taxel=${strongest.patch}.${strongest.index}`;
      const page = await open(browser, `${server.address}${hash}`, { viewport: { width, height }, colorScheme });
      await ready(page);
      await settle(page);
      const path = (kind) => join(folder, `${scene}-${width}-${colorScheme}${kind}.png`);
      await page.screenshot({ path: path("") });
      // The playback stands at the bottom of the screen, so the screen is made as high as the page.
      await page.setViewportSize({ width, height: await page.evaluate(() => document.documentElement.scrollHeight) });
      await settle(page);
      await page.screenshot({ path: path("-whole") });
      if (width === 1100) {
        await page.emulateMedia({ media: "print", colorScheme });
        await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
        await page.screenshot({ path: path("-print"), fullPage: true });
      }
      await page.context().close();
    }
  }
  server.close();
}
await finishAll(browser);
