// The scrubber, with marks of goals, contacts and mistakes above it.

import { LEFT, RIGHT, TimeAxis } from "./axis.ts";
import { drawMark, look, type Palette } from "./colours.ts";
import { element, plural, prepare, say, seconds } from "./dom.ts";
import type { Run } from "./mistakes.ts";
import type { Reach } from "./reach.ts";
import { Shade } from "./shade.ts";
import type { Trials } from "./trials.ts";

const ROW = 17;

export class Timeline {
  readonly input: HTMLInputElement;
  readonly #canvas = element("canvas", { role: "img" });
  readonly #shade = new Shade();
  #axis = new TimeAxis(1, 1);

  constructor(readonly box: HTMLElement, readonly key: HTMLElement, seek: (frame: number) => void) {
    this.input = element("input", { type: "range", min: 0, max: 0, step: 1, value: 0, "aria-label": "Time in the reach", class: "scrubber" });
    this.input.addEventListener("input", () => seek(Number(this.input.value)));
    // The thumb is 14 px wide and its middle must stand at the time.
    this.input.style.marginLeft = `${LEFT - 7}px`;
    this.input.style.width = `calc(100% - ${LEFT + RIGHT - 14}px)`;
    box.append(element("div", { class: "timed" }, this.#canvas, this.#shade.box), this.input);
  }

  load(reach: Reach): void {
    this.input.max = String(reach.frames - 1);
  }

  show(reach: Reach, frame: number, run: Run | null): void {
    this.#shade.show(this.#axis, reach, run);
    this.input.value = String(frame);
    this.input.setAttribute("aria-valuetext", `${seconds(reach.time[frame]!)}, frame ${frame} of ${reach.frames}`);
  }

  /** Draws the marks. They do not depend on the frame. */
  draw(reach: Reach, trials: Trials, palette: Palette): void {
    const axis = (this.#axis = new TimeAxis(this.box.clientWidth, reach.duration));
    const { goals, contacts, verdicts } = reach.header;
    // A log has no goals, and a table of trials names no contacts of objects.
    const rows = [
      ...(reach.isLog ? [] : [{ name: "goals", count: plural(goals.length, "goal") }]),
      ...(reach.isTable ? [] : [{ name: "contacts", count: plural(contacts.length, "contact") }]),
      ...(verdicts === null ? [] : [{ name: "mistakes", count: plural(trials.mistakes.length, "mistake") }]),
    ];
    const top = (name: string) => ROW * rows.findIndex((row) => row.name === name);
    const context = prepare(this.#canvas, axis.width, rows.length * ROW + 2);
    const [ink, quiet] = [palette.variable("ink"), palette.variable("quiet")];
    context.font = "12px system-ui, sans-serif";
    context.textBaseline = "middle";
    rows.forEach(({ name }, row) => {
      context.fillStyle = quiet;
      context.textAlign = "right";
      context.fillText(name, LEFT - 8, (row + 0.5) * ROW);
      context.fillStyle = palette.variable("line");
      context.fillRect(LEFT, (row + 0.5) * ROW - 0.5, axis.span, 1);
    });
    context.textAlign = "left";
    goals.forEach((goal, index) => {
      const [start, end] = [axis.x(goal.start_time_s), axis.x(goal.end_time_s)];
      const reached = goal.outcome === "reached";
      context.fillStyle = palette.variable(reached ? "accent-soft" : "over-soft");
      context.fillRect(start + 1, 2, Math.max(end - start - 2, 1), ROW - 4);
      context.fillStyle = ink;
      context.save();
      context.beginPath();
      context.rect(start, 0, Math.max(end - start, 0), ROW);
      context.clip();
      const long = `${index + 1} ${goal.outcome.replace("_", " ")}`;
      const room = end - start - 8;
      const text = [long, String(index + 1)].find((text) => context.measureText(text).width <= room) ?? "";
      context.fillText(text, start + 5, 0.5 * ROW + 0.5);
      context.restore();
    });
    for (const contact of contacts) {
      context.fillStyle = palette.category(reach.category(contact.object));
      context.globalAlpha = 0.75;
      const [from, to] = [axis.x(reach.time[contact.first_frame]!), axis.x(reach.time[contact.last_frame]!)];
      // Each category in its own third of the row.
      const names = reach.categories;
      const part = (ROW - 5) / Math.max(names.length, 1);
      context.fillRect(from, top("contacts") + 2 + names.indexOf(reach.category(contact.object)) * part, Math.max(to - from, 1.5), Math.max(part - 1, 1.5));
    }
    context.globalAlpha = 1;
    if (verdicts !== null) {
      const places = new Set<number>();
      for (const { run, judgement } of trials.mistakes) {
        const x = Math.round(axis.x(reach.time[run.first]!));
        if (places.has(Math.round(x / 4))) continue;
        places.add(Math.round(x / 4));
        context.fillStyle = context.strokeStyle = palette.variable("over");
        drawMark(context, look(judgement === "wrong" ? "outlier" : "uncertain").mark, x, top("mistakes") + 0.5 * ROW, 4);
      }
    }
    this.#canvas.hidden = rows.length === 0;
    this.#canvas.setAttribute("aria-label", rows.map(({ count }) => count).join(", "));
    const order = contacts.length > 0 && reach.categories.length > 1 ? `The playback bar shows contacts from top to bottom with ${reach.categories.join(", ")}.` : "";
    const crosses = verdicts === null ? "" : "A mistake is marked where its longest wrong time begins: × wrong, ○ uncertain. That time is shaded for the chosen one.";
    say(this.key, `${order} ${crosses}`.trim());
  }
}
