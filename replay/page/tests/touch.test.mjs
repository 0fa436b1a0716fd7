// Verdicts of a touch model: nothing, a category, uncertain or unknown for every taxel in contact, with probabilities.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { SCENES, felt, file, finish, finishAll, fullestFrame, launch, makeData, open, program, readRecording, ready, seek, serve, settle, state } from "./support.mjs";

let browser;
let server;
/** What the command line says about each frame of each recording. */
let told;
before(async () => {
  await makeData();
  browser = await launch();
  server = await serve(...SCENES.map((scene) => file(`${scene}.parquet`)), "--model", file("touch.json"));
  told = SCENES.map((scene) => program("classify", file("touch.json"), file(`${scene}.parquet`)).trim().split("\n").map((line) => JSON.parse(line)));
});
after(() => finishAll(browser));

async function start(hash, options = {}) {
  const page = await open(browser, `${server.address}${hash}`, options);
  await ready(page, Number(/reach=(\d+)/.exec(hash)?.[1] ?? 0));
  return page;
}

/** Tests that the page has the verdicts, probabilities and regions that the command line gives, in every frame of every reach. */
test("the page has the verdicts of the command line", async () => {
  for (const [number, lines] of told.entries()) {
    const page = await start(`#reach=${number}`);
    const found = await page.evaluate(() => {
      const { reach, trials } = window.underbrushReplay.loaded();
      const { scores, verdicts } = reach.header.verdicts;
      return Array.from({ length: reach.frames }, (_, frame) => {
        const rows = [];
        for (let row = trials.verdictStart[frame]; row < trials.verdictStart[frame + 1]; row++) {
          const { contact, shareBeyond, verdict, touchedTaxels } = trials.region(row, frame);
          const probabilities = Object.fromEntries(scores.map((name, index) => [name, trials.verdictScore[scores.length * row + index]]));
          rows.push({ taxel: trials.verdictTaxel[row], verdict: verdicts[trials.verdictCode[row]], probabilities, region: { contact, shareBeyond, verdict, touchedTaxels } });
        }
        return rows;
      });
    });
    assert.equal(found.length, lines.length);
    const { patches } = (await readRecording(`${SCENES[number]}.parquet`)).recording.layout;
    // Taxels are numbered through all patches.
    const numberOf = ({ patch, taxel }) => taxel + patches.slice(0, patches.findIndex(({ name }) => name === patch)).reduce((sum, { taxels }) => sum + taxels.length, 0);
    const count = Object.fromEntries(patches.map(({ name }) => [name, 0]));
    for (const [frame, { taxels, regions }] of lines.entries()) {
      const expected = taxels.toSorted((a, b) => numberOf(a) - numberOf(b));
      assert.deepEqual(found[frame].map(({ taxel, verdict }) => [taxel, verdict]), expected.map((own) => [numberOf(own), own.verdict]), `frame ${frame}`);
      for (const [row, { patch, contact, nothing, probabilities }] of expected.entries()) {
        const own = found[frame][row];
        const region = regions.find((region) => region.patch === patch && region.contact === contact);
        for (const [name, share] of Object.entries({ nothing, ...probabilities })) assert.ok(Math.abs(own.probabilities[name] - share) < 1e-6);
        assert.deepEqual([own.region.contact, own.region.verdict, own.region.touchedTaxels], [contact, region.verdict, region.touched_taxels]);
        assert.ok(Math.abs(own.region.shareBeyond - region.share_beyond) < 1e-6);
        count[patch]++;
      }
    }
    for (const [patch, verdicts] of Object.entries(count)) assert.ok(verdicts > 100, `${SCENES[number]}: only ${verdicts} verdicts on ${patch}`);
    await finish(page);
  }
});

/** Tests what a reader sees of a chosen taxel: its verdict with probabilities, its contact region with the features that the
 * model sees, which stay unfolded when time goes on, and a plot of the probabilities without a unit. */
test("a chosen taxel shows probabilities and its region", async () => {
  const { recording, rows } = await readRecording("mixed.parquet");
  const frame = fullestFrame(recording, rows);
  const [strongest] = felt(recording, rows[frame]).filter(({ patch }) => patch === "forearm");
  const page = await start(`#reach=${SCENES.indexOf("mixed")}&t=${rows[frame].time_s.toFixed(2)}&taxel=forearm.${strongest.index}&colour=verdict`);
  const own = told[SCENES.indexOf("mixed")][frame].taxels.find(({ patch, taxel }) => patch === "forearm" && taxel === strongest.taxel);
  const details = await page.locator("#details").textContent();
  assert.match(await page.locator("#facts").textContent(), /model touch\.json \(touch\)/);
  for (const [name, share] of Object.entries({ nothing: own.nothing, ...own.probabilities })) {
    const shown = Number(new RegExp(`probability of ${name}(\\d\\.\\d{3})`).exec(details)?.[1]);
    assert.ok(Math.abs(shown - share) < 0.00051, `${name} ${share}: ${details}`);
  }
  assert.ok(details.includes(`verdict now${own.verdict} after`) && details.includes(`Contact region ${own.contact}`), details);
  assert.equal(await page.locator(".features dd").first().isVisible(), false);
  await page.locator(".features summary").press("Space");
  assert.equal((await state(page)).playing, false);
  assert.equal(await page.locator(".features dd").count(), 30);
  // Marks are of values outside the range that is written beside them.
  assert.match(await page.locator(".features .key").textContent(), /middle 80 % of the regions of this reach that are truly \w+/);
  for (const text of await page.locator(".features dd strong").allTextContents()) {
    const [, value, mark, low, high] = /^(-?[\d.]+) ([▲▼]) (-?[\d.]+) to (-?[\d.]+)$/.exec(text);
    assert.ok(mark === "▲" ? Number(value) >= Number(high) : Number(value) <= Number(low), text);
  }
  await seek(page, frame + 1);
  assert.ok(await page.locator(".features dd").first().isVisible(), "the features folded up");
  assert.match(await page.locator('[data-plot="scores"] h3').textContent(), /^Probabilities of forearm row \d+, column \d+$/);
  for (const name of ["nothing", "leaf", "trunk", "uncertain", "unknown"]) {
    assert.ok(await page.locator("#legend").getByText(name, { exact: true }).first().isVisible(), name);
  }
  assert.match(await page.locator("#strips .key").textContent(), /nothing \(hatched/);
  await finish(page);
});

/** Tests how the trials of a touch model are judged: a spurious reading that it calls nothing is right. */
test("trials are judged by what a touch model can say", async () => {
  const page = await start(`#reach=${SCENES.indexOf("outlier")}`);
  const trials = await page.evaluate(() => window.underbrushReplay.loaded().trials.all.map(({ truth, verdict, judgement }) => ({ truth, verdict, judgement })));
  for (const { truth, verdict, judgement } of trials.filter(({ verdict }) => verdict !== null)) {
    const right = { spurious: "nothing", outlier: "unknown", leaf: "leaf", trunk: "trunk" }[truth];
    const expected = verdict === right ? "right" : verdict === "uncertain" && truth !== "spurious" ? "uncertain" : "wrong";
    assert.equal(judgement, expected, `${truth} called ${verdict}`);
  }
  assert.ok(trials.some(({ truth, judgement }) => truth === "spurious" && judgement === "right"));
  await finish(page);
});
