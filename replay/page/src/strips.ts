// Strips over time: what truly touched the skin, and below it what the model said, as shares of the taxels in contact.

import { LEFT, TimeAxis } from "./axis.ts";
import { drawMark, look, type Palette } from "./colours.ts";
import { element, prepare, say, seconds } from "./dom.ts";
import type { Run } from "./mistakes.ts";
import type { Reach } from "./reach.ts";
import { Shade } from "./shade.ts";
import type { Trials } from "./trials.ts";

const EXPLAINED: Record<string, string> = {
  spurious: "spurious (hatched; a reading that no object causes)",
  nothing: "nothing (hatched; the verdict that no object causes the reading)",
  unknown: "unknown (unlike all categories that the model knows)",
};
const HEIGHT = 22;
const GAP = 4;

interface Strip {
  label: string;
  /** Whether it is about the chosen taxel alone. */
  own?: boolean;
  count: (frame: number, add: (name: string) => void) => void;
}

export class Strips {
  readonly #canvas = element("canvas", { role: "img", class: "strips" });
  readonly #key = element("p", { class: "key" });
  readonly #head = element("div", { class: "playhead" });
  readonly #shade = new Shade();
  #axis = new TimeAxis(1, 1);

  constructor(readonly box: HTMLElement, seek: (time: number) => void) {
    box.classList.add("timed");
    box.append(element("h3", {}, "What touches the skin"), element("div", { class: "timed" }, this.#canvas, this.#shade.box, this.#head), this.#key);
    const drag = (event: PointerEvent) => event.buttons === 1 && seek(this.#axis.time(event.offsetX));
    this.#canvas.addEventListener("pointerdown", drag);
    this.#canvas.addEventListener("pointermove", drag);
  }

  /** Moves the line at the current time and shades the run of the chosen mistake. */
  show(reach: Reach, frame: number, run: Run | null): void {
    this.#head.style.transform = `translateX(${this.#axis.x(reach.time[frame]!)}px)`;
    this.#shade.show(this.#axis, reach, run);
  }

  #strips(reach: Reach, trials: Trials, taxel: number | null): Strip[] {
    const { verdicts, threshold_n: threshold } = reach.header;
    const judged = verdicts === null ? null : verdicts.patches;
    const truth: Strip = {
      label: "truth",
      count: (frame, add) => {
        for (let row = reach.readingStart[frame]!; row < reach.readingStart[frame + 1]!; row++) {
          const own = judged === null || judged.includes(reach.patchOf[reach.readingTaxel[row]!]!);
          if (own && reach.sensed[row]! > threshold) add(reach.category(reach.readingObject[row]!));
        }
      },
    };
    const strips = [truth];
    if (verdicts !== null) {
      strips.push({
        label: "verdict",
        count: (frame, add) => {
          for (let row = trials.verdictStart![frame]!; row < trials.verdictStart![frame + 1]!; row++) add(verdicts.verdicts[trials.verdictCode[row]!]!);
        },
      });
    }
    if (taxel !== null) {
      strips.push({
        label: "its truth",
        own: true,
        count: (frame, add) => {
          const row = reach.reading(taxel, frame);
          if (row >= 0 && reach.sensed[row]! > threshold) add(reach.category(reach.readingObject[row]!));
        },
      });
      if (judged !== null && judged.includes(reach.patchOf[taxel]!)) {
        strips.push({
          label: "its verdict",
          own: true,
          count: (frame, add) => {
            const found = trials.verdict(taxel, frame);
            if (found !== null) add(found.name);
          },
        });
      }
    }
    return strips;
  }

  draw(reach: Reach, trials: Trials, palette: Palette, taxel: number | null): void {
    this.#axis = new TimeAxis(this.box.clientWidth, reach.duration);
    const strips = this.#strips(reach, trials, taxel);
    const context = prepare(this.#canvas, this.#axis.width, strips.length * (HEIGHT + GAP));
    context.font = "12px system-ui, sans-serif";
    const common: { label: string; columns: Map<string, number> }[] = [];
    strips.forEach((strip, index) => {
      const top = index * (HEIGHT + GAP);
      context.fillStyle = palette.variable("cell");
      context.fillRect(LEFT, top, this.#axis.span, HEIGHT);
      context.fillStyle = palette.variable("quiet");
      context.textAlign = "right";
      context.textBaseline = "middle";
      context.fillText(strip.label, LEFT - 8, top + HEIGHT / 2);
      const columns = this.#fill(context, reach, strip, top, palette);
      if (strip.own !== true) common.push({ label: strip.label, columns });
    });
    const where = reach.judgedAlone ?? "all patches";
    const seen = new Set(common.flatMap(({ columns }) => [...columns.keys()]));
    // Of a log, nobody knows what its labels leave out.
    const explained: Record<string, string> = reach.isLog ? { ...EXPLAINED, spurious: "spurious (hatched; labelled nothing, or not at all)" } : EXPLAINED;
    const names = [...seen].sort(byName).map((name) => explained[name] ?? name);
    const nothing = reach.taxels === 0 ? "This arm has no skin." : `Nothing touches ${reach.judgedAlone ?? "the skin"} in this reach.`;
    say(this.#key, names.length === 0 ? nothing : `Shares of the taxels in contact on ${where}, from the bottom: ${names.join(", ")}.`);
    const said = common.map(({ label, columns }) => {
      const times = [...columns].map(([name, count]) => `${name} ${seconds((count / this.#axis.span) * reach.duration)}`);
      return `${label}: ${times.join(", ") || "nothing"}`;
    });
    this.#canvas.setAttribute("aria-label", `Time in contact on ${where}. ${said.join("; ")}`);
  }

  /** Draws a strip. Returns in how many columns of pixels each name is. */
  #fill(context: CanvasRenderingContext2D, reach: Reach, strip: Strip, top: number, palette: Palette): Map<string, number> {
    const seen = new Map<string, number>();
    const runs = new Map<string, { start: number; end: number }>();
    let before = 0;
    for (let x = 0; x < this.#axis.span; x++) {
      const end = Math.min(reach.frameAt(this.#axis.time(LEFT + x + 1)) + 1, reach.frames);
      // Taxels by name in this column of pixels.
      const counts = new Map<string, number>();
      let total = 0;
      // Where a frame is wider than a pixel, it is in several columns.
      for (let frame = Math.min(before, end - 1); frame < end; frame++) {
        strip.count(frame, (name) => {
          counts.set(name, (counts.get(name) ?? 0) + 1);
          total++;
        });
      }
      before = end;
      let bottom = top + HEIGHT;
      for (const name of [...counts.keys()].sort(byName)) {
        const height = (HEIGHT * counts.get(name)!) / total;
        context.fillStyle = palette.category(name);
        if (name === "spurious" || name === "nothing") hatch(context, LEFT + x, bottom - height, height);
        else context.fillRect(LEFT + x, bottom - height, 1, height);
        bottom -= height;
        seen.set(name, (seen.get(name) ?? 0) + 1);
        const run = runs.get(name);
        if (run !== undefined && run.end === x - 1 && height > HEIGHT * 0.6) run.end = x;
        else if (height > HEIGHT * 0.6) runs.set(name, { start: x, end: x });
        const done = runs.get(name);
        // A mark every 60 pixels where a category prevails, for readers who cannot tell the colours apart.
        if (done !== undefined && done.end - done.start === 30) {
          context.fillStyle = context.strokeStyle = palette.variable("panel");
          drawMark(context, look(name).mark, LEFT + x - 15, top + HEIGHT / 2, 5);
        }
        if (done !== undefined && done.end - done.start >= 60) runs.delete(name);
      }
    }
    return seen;
  }
}

/** One column of oblique lines. */
function hatch(context: CanvasRenderingContext2D, x: number, top: number, height: number): void {
  for (let y = Math.floor(top); y < top + height; y++) if ((x + y) % 6 < 2) context.fillRect(x, y, 1, 1);
}

const ORDER = ["leaf", "trunk", "block", "outlier", "unknown", "uncertain", "spurious", "nothing"];

function byName(a: string, b: string): number {
  const place = (name: string) => (ORDER.includes(name) ? ORDER.indexOf(name) : 3.5);
  return place(a) - place(b) || a.localeCompare(b);
}
