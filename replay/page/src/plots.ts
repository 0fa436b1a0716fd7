// Plots over time, one below the other on the time axis of the scrubber.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";

import { LEFT, RIGHT } from "./axis.ts";
import type { Palette } from "./colours.ts";
import { element, say, seconds, short } from "./dom.ts";

/** Before the name of a category, whose colour a line then has. */
export const CATEGORY = "category ";

/** One line of a plot. */
export interface Curve {
  name: string;
  /** A variable of the style sheet, a category or a CSS colour. */
  colour: string;
  /** Drawn dashed. */
  dash?: boolean;
  values: ArrayLike<number | null>;
}

export interface PlotData {
  id: string;
  title: string;
  /** Null for pure numbers, such as probabilities. */
  unit: string | null;
  time: Float64Array;
  curves: Curve[];
  /** A horizontal line with its name. */
  level?: { value: number; name: string } | null;
  /** Whether the vertical axis begins at 0. */
  fromZero: boolean;
}

const HEIGHT = 92;
const AXIS = 24;

class Plot {
  readonly box: HTMLElement;
  readonly #value = element("output", { class: "value", "aria-live": "off" });
  #entries: HTMLElement[] = [];
  readonly #place = element("div", { role: "img" });
  readonly #head = element("div", { class: "playhead" });
  #plot: uPlot | null = null;
  #data: PlotData | null = null;
  #frame = 0;

  constructor(readonly title: HTMLElement, readonly seek: (time: number) => void) {
    this.box = element("figure", { class: "plot" }, element("figcaption", {}, title, this.#value), this.#place);
  }

  draw(data: PlotData, palette: Palette, width: number, last: boolean): void {
    this.#plot?.destroy();
    this.#data = data;
    say(this.title, data.unit === null ? data.title : `${data.title} / ${data.unit}`);
    this.box.dataset["plot"] = data.id;
    const colour = (name: string) => {
      if (name.startsWith(CATEGORY)) return palette.category(name.slice(CATEGORY.length));
      return name.startsWith("#") ? name : palette.variable(name);
    };
    this.#legend(data, colour, palette);
    const series: uPlot.Series[] = data.curves.map((curve) => ({
      label: curve.name,
      stroke: colour(curve.colour),
      width: 1.4,
      points: { show: false },
      ...(curve.dash === true ? { dash: [4, 3] } : {}),
    }));
    const columns: (ArrayLike<number | null>)[] = data.curves.map((curve) => curve.values);
    if (data.level != null) {
      const { value, name } = data.level;
      series.push({ label: name, stroke: palette.variable("over"), width: 1, dash: [6, 4], points: { show: false } });
      columns.push(new Float64Array(data.time.length).fill(value));
    }
    const axis = { stroke: palette.variable("quiet"), grid: { stroke: palette.variable("line"), width: 1 }, ticks: { show: false }, font: "11px system-ui, sans-serif" };
    const options: uPlot.Options = {
      width,
      height: HEIGHT + (last ? AXIS : 0),
      padding: [6, RIGHT, last ? 0 : 4, 0],
      legend: { show: false },
      cursor: { drag: { x: false, y: false, setScale: false }, y: false, points: { size: 5 } },
      scales: {
        x: { time: false, range: () => [0, data.time[data.time.length - 1]!] },
        y: { range: (_, low, high) => rangeOf(data, low, high) },
      },
      axes: [{ ...axis, show: last, size: AXIS, values: (_, ticks) => ticks.map((tick) => `${tick} s`) }, { ...axis, size: LEFT, gap: 6, space: 18 }],
      series: [{}, ...series],
      // A new plot has no scales, and so no place for the line at the current time, before it is ready.
      hooks: { ready: [() => this.show(this.#frame)], setCursor: [(plot) => this.#say(plot.cursor.idx ?? this.#frame)] },
    };
    this.#plot = new uPlot(options, [data.time, ...columns] as unknown as uPlot.AlignedData, this.#place);
    this.#plot.over.append(this.#head);
    const drag = (event: PointerEvent) => event.buttons === 1 && this.seek(this.#plot!.posToVal(event.clientX - this.#plot!.over.getBoundingClientRect().left, "x"));
    this.#plot.over.addEventListener("pointerdown", drag);
    this.#plot.over.addEventListener("pointermove", drag);
    this.#place.setAttribute("aria-label", summary(data));
  }

  show(frame: number): void {
    this.#frame = frame;
    if (this.#plot === null || this.#data === null) return;
    const at = Math.min(frame, this.#data.time.length - 1);
    this.#head.style.transform = `translateX(${this.#plot.valToPos(this.#data.time[at]!, "x")}px)`;
    if (this.#plot.cursor.idx == null) this.#say(at);
  }

  /** The names of all lines with a piece of each; their values are filled in later. */
  #legend(data: PlotData, colour: (name: string) => string, palette: Palette): void {
    const entry = (name: string, stroke: string, dash: boolean) => {
      const line = element("i", { class: "dash" });
      line.style.borderTop = `2px ${dash ? "dashed" : "solid"} ${stroke}`;
      return element("span", { class: "entry" }, line, element("span", {}, name));
    };
    const entries = data.curves.map((curve) => entry(curve.name, colour(curve.colour), curve.dash === true));
    this.#entries = entries.map((made) => made.lastElementChild as HTMLElement);
    if (data.level != null) entries.push(entry(`${data.level.name} ${short(data.level.value)}`, palette.variable("over"), true));
    this.#value.replaceChildren(...entries.flatMap((made) => [made, " "]), data.unit ?? "");
  }

  /** Says the values at a frame. */
  #say(frame: number): void {
    this.#data?.curves.forEach((curve, index) => {
      const value = curve.values[Math.min(frame, curve.values.length - 1)];
      say(this.#entries[index]!, `${curve.name} ${value == null || Number.isNaN(value) ? "–" : value.toFixed(2)}`);
    });
  }
}

function rangeOf(data: PlotData, low: number, high: number): uPlot.Range.MinMax {
  if (low == null || high == null) return [0, 1];
  const room = 0.06 * (high - low || 1);
  return [data.fromZero ? 0 : low - room, high + room];
}

/** What there is to see, for those who do not see it. */
function summary(data: PlotData): string {
  const unit = data.unit === null ? "" : ` ${data.unit}`;
  const lines = data.curves.map((curve) => {
    let [best, at] = [Number.NEGATIVE_INFINITY, 0];
    for (let index = 0; index < curve.values.length; index++) {
      const value = curve.values[index];
      if (value != null && value > best) [best, at] = [value, index];
    }
    if (best === Number.NEGATIVE_INFINITY) return `${curve.name}: no values`;
    return `${curve.name}: largest ${best.toFixed(2)}${unit} at ${seconds(data.time[at]!)}`;
  });
  const level = data.level == null ? "" : `; ${data.level.name} ${short(data.level.value)}${unit}`;
  return `${data.title} over time. ${lines.join("; ")}${level}`;
}

export class Plots {
  readonly #plots: Plot[] = [];

  constructor(readonly box: HTMLElement, readonly seek: (time: number) => void) {}

  draw(all: PlotData[], palette: Palette): void {
    while (this.#plots.length < all.length) {
      const plot = new Plot(element("h3", {}), this.seek);
      this.#plots.push(plot);
      this.box.append(plot.box);
    }
    const width = this.box.clientWidth;
    this.#plots.forEach((plot, index) => {
      const data = all[index];
      plot.box.hidden = data === undefined;
      if (data !== undefined && width > 0) plot.draw(data, palette, width, index + 1 === all.length);
    });
  }

  show(frame: number): void {
    for (const plot of this.#plots) plot.show(frame);
  }
}
