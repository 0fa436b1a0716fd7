// Colours of forces and categories, in light and dark. Every category also has its own mark.

/** A mark that tells a category apart without its colour. */
export type Mark = "triangle" | "square" | "cross" | "ring" | "diamond" | "disc" | "slash";

export interface Look {
  light: string;
  dark: string;
  mark: Mark;
}

/** The colours of the report (report/src/style.rs), lighter on a dark ground. */
const LOOKS: Record<string, Look> = {
  leaf: { light: "#1b8a4b", dark: "#4cc38a", mark: "triangle" },
  trunk: { light: "#6b4423", dark: "#c89466", mark: "square" },
  block: { light: "#a8904a", dark: "#d6c078", mark: "disc" },
  outlier: { light: "#c8102e", dark: "#ff7285", mark: "cross" },
  uncertain: { light: "#1f5fbf", dark: "#74a8ff", mark: "ring" },
  spurious: { light: "#78828c", dark: "#9aa4ae", mark: "slash" },
};

/** Verdicts of touch models look like what they claim. */
const ALIKE: Record<string, string> = { nothing: "spurious", unknown: "outlier" };

const FURTHER: Look[] = [
  { light: "#8c4fb3", dark: "#c99ae6", mark: "diamond" },
  { light: "#b58900", dark: "#e3c04f", mark: "disc" },
  { light: "#0b7285", dark: "#5cc3d6", mark: "diamond" },
  { light: "#cc79a7", dark: "#eba6ca", mark: "disc" },
];

const further: string[] = [];

/** The look of a category, of a verdict, or of a "spurious" reading that nothing causes. */
export function look(category: string): Look {
  const known = LOOKS[ALIKE[category] ?? category];
  if (known !== undefined) return known;
  if (!further.includes(category)) further.push(category);
  return FURTHER[further.indexOf(category) % FURTHER.length]!;
}

/** Forces from none to the largest; lightness falls on a light ground and rises on a dark one. */
const RAMP = {
  light: ["#e9edf1", "#fdd98c", "#f79646", "#d9472f", "#9b1b4b", "#4a0d4f"],
  dark: ["#2b333b", "#5b2a6e", "#a93368", "#e25d46", "#fba04a", "#fff0a8"],
};

/** The colours of the theme that the page has now. */
export class Palette {
  readonly dark: boolean;
  readonly #ramp: [number, number, number][];
  readonly #variables = new Map<string, string>();

  constructor() {
    const chosen = document.documentElement.dataset["theme"];
    this.dark = chosen === undefined ? matchMedia("(prefers-color-scheme: dark)").matches : chosen === "dark";
    this.#ramp = RAMP[this.dark ? "dark" : "light"].map(numbers);
  }

  /** A colour of the style sheet, by the name of its variable. */
  variable(name: string): string {
    const known = this.#variables.get(name);
    if (known !== undefined) return known;
    // A variable can hold a pair of colours; only a property that uses it has the one of the theme.
    const probe = document.createElement("span");
    probe.style.color = `var(--${name})`;
    document.body.append(probe);
    const { color } = getComputedStyle(probe);
    probe.remove();
    this.#variables.set(name, color);
    return color;
  }

  category(name: string): string {
    return look(name)[this.dark ? "dark" : "light"];
  }

  /** The colour of a share of the largest force, as numbers from 0 to 255. The scale follows the square root. */
  force(share: number): [number, number, number] {
    const at = Math.sqrt(Math.min(Math.max(share, 0), 1)) * (this.#ramp.length - 1);
    const low = Math.min(Math.floor(at), this.#ramp.length - 2);
    const [a, b] = [this.#ramp[low]!, this.#ramp[low + 1]!];
    return [0, 1, 2].map((channel) => Math.round(a[channel]! + (b[channel]! - a[channel]!) * (at - low))) as [number, number, number];
  }

  forceText(share: number): string {
    return `rgb(${this.force(share).join(", ")})`;
  }
}

/** The channels of a colour such as #1b8a4b, from 0 to 255. */
export function numbers(colour: string): [number, number, number] {
  return [1, 3, 5].map((at) => Number.parseInt(colour.slice(at, at + 2), 16)) as [number, number, number];
}

/** Draws the mark of a category within a circle. */
export function drawMark(context: CanvasRenderingContext2D, mark: Mark, x: number, y: number, radius: number): void {
  const line = Math.max(1.2, radius * 0.36);
  context.lineWidth = line;
  context.beginPath();
  const polygon = (points: [number, number][]) => {
    points.forEach(([px, py], index) => {
      if (index === 0) context.moveTo(x + px * radius, y + py * radius);
      else context.lineTo(x + px * radius, y + py * radius);
    });
    context.closePath();
    context.fill();
  };
  if (mark === "triangle") polygon([[0, -1], [0.95, 0.8], [-0.95, 0.8]]);
  else if (mark === "square") polygon([[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8]]);
  else if (mark === "diamond") polygon([[0, -1], [0.9, 0], [0, 1], [-0.9, 0]]);
  else if (mark === "disc" || mark === "ring") {
    context.arc(x, y, radius * 0.8, 0, 2 * Math.PI);
    if (mark === "disc") context.fill();
    else context.stroke();
  } else {
    context.moveTo(x - 0.75 * radius, y + 0.75 * radius);
    context.lineTo(x + 0.75 * radius, y - 0.75 * radius);
    if (mark === "cross") {
      context.moveTo(x - 0.75 * radius, y - 0.75 * radius);
      context.lineTo(x + 0.75 * radius, y + 0.75 * radius);
    }
    context.stroke();
  }
}
