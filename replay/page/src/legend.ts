// What the colours and marks mean.

import { drawMark, look, type Palette } from "./colours.ts";
import { element, prepare, short } from "./dom.ts";
import type { Reach } from "./reach.ts";
import type { ColourBy } from "./state.ts";
import { LONGEST_M, METRES_PER_NEWTON, WEAKEST_N } from "./view/arrows.ts";

function swatch(palette: Palette, name: string): HTMLElement {
  const canvas = element("canvas", { "aria-hidden": "true" });
  const context = prepare(canvas, 16, 16);
  context.fillStyle = palette.category(name);
  context.fillRect(0, 0, 16, 16);
  context.fillStyle = context.strokeStyle = palette.variable("panel");
  drawMark(context, look(name).mark, 8, 8, 5);
  return element("span", { class: "entry" }, canvas, name);
}

/** The colour bar of forces, with ticks in newtons; its scale follows the square root. */
export function colourBar(palette: Palette, largest: number, limit: number | null): HTMLElement {
  const [width, height] = [220, 34];
  const canvas = element("canvas", { role: "img", class: "colour-bar", "aria-label": `Colours of the sensed force from 0 to ${largest.toFixed(1)} N on a square-root scale` });
  const context = prepare(canvas, width, height);
  const [left, span] = [8, width - 36];
  for (let x = 0; x < span; x++) {
    context.fillStyle = palette.forceText((x / (span - 1)) ** 2);
    context.fillRect(left + x, 2, 1, 12);
  }
  context.fillStyle = context.strokeStyle = palette.variable("quiet");
  context.font = "11px system-ui, sans-serif";
  context.textAlign = "center";
  const ticks = [0, 0.1, 0.5, 1, 2, 3, 5, 8, 12, 17, 30, 50, 100, 200, 500, 1000, 2000, 5000, 10_000].filter((tick) => tick <= largest);
  let last = Number.NEGATIVE_INFINITY;
  for (const tick of ticks) {
    const x = left + Math.sqrt(tick / largest) * (span - 1);
    if (x - last < Math.max(20, context.measureText(String(tick)).width + 6)) continue;
    last = x;
    context.fillRect(x, 14, 1, 4);
    context.fillText(String(tick), x, 29);
  }
  context.textAlign = "left";
  context.fillText("N", left + span + 10, 13);
  if (limit !== null && limit <= largest) {
    context.fillStyle = palette.variable("over");
    context.fillRect(left + Math.sqrt(limit / largest) * (span - 1) - 1, 0, 2, 16);
  }
  return canvas;
}

/** All entries for a way of colouring. `ghost` is the name of the ghost, if there is one. */
export function drawLegend(box: HTMLElement, reach: Reach, palette: Palette, colour: ColourBy, largest: number, ghost: string | null): void {
  const { verdicts, force_limit_n: limit } = reach.header;
  const entries: HTMLElement[] = [];
  const text = (words: string) => element("span", { class: "entry" }, words);
  if (colour === "force") {
    entries.push(element("span", { class: "entry" }, "sensed force", colourBar(palette, largest, limit)));
    if (limit !== null) entries.push(text(`red line and frame: above the controller's limit of ${short(limit)} N`));
    entries.push(text(reach.isLog ? "slash: labelled nothing, or not at all" : "slash: a reading that no object causes"));
  } else {
    const names = colour === "truth" ? [...reach.categories, "spurious"] : (verdicts?.verdicts ?? []);
    entries.push(...names.map((name) => swatch(palette, name)));
    if (colour === "verdict") entries.push(text("dashed red frame: the verdict is wrong or uncertain"));
    const judged = reach.judgedAlone;
    if (colour === "verdict" && judged !== null) entries.push(text(`the model judges the ${judged} alone`));
  }
  const objects = reach.categories.map((name) => swatch(palette, name));
  if (colour !== "truth" && objects.length > 0) entries.push(element("span", { class: "entries" }, "objects:", ...objects));
  // A log has neither true forces nor goals.
  if (!reach.isLog) {
    const cm = 100 * METRES_PER_NEWTON;
    const over = limit === null ? "" : `; red if one taxel of the contact reads more than the controller's limit of ${short(limit)} N`;
    if (reach.header.map.length > 0) entries.push(text("cages: the controller's map: dark for what is fixed, blue for what is doubtful, green for what gives way"));
    const longest = LONGEST_M / METRES_PER_NEWTON;
    entries.push(text(`arrows: force of a whole contact from ${WEAKEST_N} N, ${cm} cm per newton up to ${longest} N${over}`), text("blue: goal and path of the hand; grid of 10 cm"));
  }
  if (ghost !== null) entries.push(text(`orange, seen through: the arm of reach ${ghost}`));
  box.replaceChildren(...entries);
}
