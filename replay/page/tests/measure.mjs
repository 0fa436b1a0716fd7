// Measures, without deciding: how long a list and a reach take to open, what a frame costs while the reach plays, and how much
// memory the server needs for all reaches one after the other. Times depend on what else the machine does, so CPU times and
// the load are given too.
// node tests/measure.mjs INPUT [INPUT …] [--model FILE]

import { readFileSync, readdirSync } from "node:fs";
import { cpus, loadavg } from "node:os";

import { finishAll, launch, open, ready, serve } from "./support.mjs";

/** How long a reach plays at each size, ms. */
const PLAYED_MS = 6000;

/** CPU time so far of each process of the browser, ms, by its number; they are descendants of this process. */
function browserCpu() {
  const parents = new Map();
  const found = [];
  for (const pid of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const [, name, rest] = /\((.*)\) (.*)/.exec(readFileSync(`/proc/${pid}/stat`, "utf8"));
      const fields = rest.split(" ");
      parents.set(pid, fields[1]);
      const kind = /--type=([a-z-]+)/.exec(readFileSync(`/proc/${pid}/cmdline`, "utf8"))?.[1] ?? "browser";
      // In ticks of 10 ms.
      if (/chrom/.test(name)) found.push({ pid, kind, time: 10 * (Number(fields[11]) + Number(fields[12])) });
    } catch {
      // The process has ended.
    }
  }
  const own = (pid) => pid !== undefined && pid !== "0" && (pid === String(process.pid) || own(parents.get(pid)));
  return found.filter(({ pid }) => own(pid));
}

/** CPU time since an earlier call, ms: in all, and by kind of process in words. */
function cpuSince(before) {
  const kinds = new Map();
  for (const { pid, kind, time } of browserCpu()) {
    const used = time - (before.find((other) => other.pid === pid)?.time ?? 0);
    kinds.set(kind, (kinds.get(kind) ?? 0) + used);
  }
  return kinds;
}

function total(kinds) {
  return [...kinds.values()].reduce((sum, time) => sum + time, 0);
}

function memory(pid, what) {
  return Math.round(Number(new RegExp(`${what}:\\s+(\\d+)`).exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) / 1000);
}

const load = () => `load ${loadavg()[0].toFixed(1)} on ${cpus().length} cores`;

/** Adds up the time that the page's own code takes in animation frames, and their number. */
function countFrames() {
  window.spent = { frames: 0, time: 0, longest: 0 };
  const original = window.requestAnimationFrame.bind(window);
  let last = -1;
  window.requestAnimationFrame = (callback) => original((now) => {
    const start = performance.now();
    callback(now);
    const time = performance.now() - start;
    if (now !== last) window.spent.frames++;
    last = now;
    window.spent.time += time;
    window.spent.longest = Math.max(window.spent.longest, time);
  });
}

const inputs = process.argv.slice(2);
const begin = performance.now();
const server = await serve(...inputs);
console.log(`server ready after ${(performance.now() - begin).toFixed(0)} ms, ${memory(server.pid, "VmRSS")} MB, ${load()}`);
const browser = await launch();
const warm = await open(browser, server.address);
await ready(warm);
await warm.context().close();
for (const [width, height] of [[390, 844], [1100, 900], [1920, 1080]]) {
  const busy = browserCpu();
  const start = performance.now();
  const page = await open(browser, server.address, { viewport: { width, height }, before: countFrames });
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const threadTime = async () => 1000 * (await session.send("Performance.getMetrics")).metrics.find(({ name }) => name === "TaskDuration").value;
  await page.waitForSelector("#panel-reaches tbody tr");
  const [listed, thread] = [performance.now() - start, await threadTime()];
  await ready(page);
  const shown = performance.now() - start;
  const used = total(cpuSince(busy));
  const reaches = await page.locator("#panel-reaches [role=status]").textContent();
  // From the moment in which the new page begins to load until the list is on the screen.
  const [mark, first] = await page.evaluate(() => ["listed", "drawn"].map((name) => performance.getEntriesByName(name)[0].startTime));
  console.log(`${width} px: ${reaches} listed after ${listed.toFixed(0)} ms (${mark.toFixed(0)} ms from the start of its loading; ${thread.toFixed(0)} ms of CPU in the page's thread), reach after ${shown.toFixed(0)} ms (${first.toFixed(0)} ms from the start; ${(await threadTime()).toFixed(0)} ms; ${used} ms in all processes); ${load()}`);
  const before = browserCpu();
  const [{ frames, time, longest }, wall, drawn, ratio] = await page.evaluate((played) => new Promise((done) => {
    window.spent = { frames: 0, time: 0, longest: 0 };
    const start = performance.now();
    const first = window.underbrushReplay.state.frame;
    document.getElementById("play").click();
    setTimeout(() => done([window.spent, performance.now() - start, window.underbrushReplay.state.frame - first, document.querySelector("canvas.view").width / document.querySelector("canvas.view").clientWidth]), played);
  }), PLAYED_MS);
  const kinds = cpuSince(before);
  const cpu = [...kinds].filter(([, spent]) => spent > 0).map(([kind, spent]) => `${kind} ${(spent / frames).toFixed(0)}`).join(", ");
  console.log(`${width} px: ${((1000 * frames) / wall).toFixed(0)} frames a second (${(drawn / 100).toFixed(2)} s of the reach in ${(wall / 1000).toFixed(2)} s); a frame takes ${(time / frames).toFixed(1)} ms of script (longest ${longest.toFixed(0)}) and ${(total(kinds) / frames).toFixed(0)} ms of CPU in all processes (${cpu}); 3-D at ${ratio.toFixed(2)} pixels per CSS pixel; ${load()}`);
  await page.context().close();
}
await browser.close();
const count = await fetch(`${server.address}api/reaches`).then(async (answer) => (await answer.json()).length);
const opened = performance.now();
let bytes = 0;
for (let number = 0; number < count; number++) {
  bytes += (await (await fetch(`${server.address}api/reach/${number}`)).arrayBuffer()).byteLength;
}
const each = (performance.now() - opened) / count;
console.log(`${count} reaches one after the other, ${(bytes / 1e6 / count).toFixed(1)} MB and ${each.toFixed(0)} ms each: the server has ${memory(server.pid, "VmRSS")} MB, at most ${memory(server.pid, "VmHWM")} MB; ${load()}`);
await finishAll();
