// The unrolled skin: one patch of taxels as a flat map.

import { drawMark, look, type Palette } from "./colours.ts";
import { element, plural, prepare } from "./dom.ts";
import { type Cell, layOut } from "./unroll.ts";
import type { Reach } from "./reach.ts";

/** How a taxel looks at the moment. */
export interface TaxelLook {
  /** CSS colour; null for a taxel that feels nothing. */
  colour: string | null;
  /** The category whose mark is drawn, if any. */
  mark: string | null;
  /** A force that no object causes. */
  stray: boolean;
  /** Above the limit of the controller. */
  over: boolean;
  /** A verdict that does not agree with the truth. */
  wrong: boolean;
}

const MARGIN = { left: 22, right: 6, top: 18, bottom: 6 };
const LARGEST_WIDTH = 560;

export class SkinMap {
  readonly box: HTMLElement;
  readonly #canvas: HTMLCanvasElement;
  readonly #cells: Cell[];
  readonly #width: number;
  readonly #height: number;
  readonly #upwards: boolean;
  #scale = 1;
  #cursor: number | null = null;
  #room = 0;
  /** What is on the map, so that it is drawn only when it changes. */
  #shown = "";
  #drawn: { canvas: HTMLCanvasElement; palette: Palette } | null = null;

  constructor(
    readonly reach: Reach,
    readonly patch: number,
    readonly pointed: (taxel: number | null) => void,
    readonly chosen: ((taxel: number) => void) | null,
    resized: () => void,
  ) {
    const { name, grid, taxels } = reach.header.patches[patch]!;
    const plan = layOut(reach, patch);
    [this.#cells, this.#width, this.#height] = [plan.cells, plan.width, plan.height];
    // Of a log, nobody knows where the tip is.
    this.#upwards = plan.upwards && !reach.isLog;
    // Only a sleeve that is closed surely has a link within it.
    const [along, around] = grid?.wraps === true ? [" along", " around"] : ["", ""];
    const size = reach.isTable ? "taxels in the order of their numbers" : grid === null ? `${plural(taxels, "taxel")}${plan.twoSides ? ", seen on both sides" : ""}` : `${plural(grid.rows, "row")}${along} × ${plural(grid.columns, "column")}${around}`;
    this.#canvas = element("canvas", {
      tabindex: 0,
      role: "application",
      "aria-label": `${chosen === null ? "Second reach: map" : "Map"} of the skin of the ${name}, ${size}. Arrow keys move from taxel to taxel${chosen === null ? "" : ", Enter selects one"}.`,
      class: "skin-map",
      "data-patch": name,
    });
    this.box = element("figure", { class: "skin-figure" }, element("figcaption", {}, element("b", {}, name), ` ${size}`), this.#canvas);
    new ResizeObserver(([entry]) => {
      this.#room = entry!.contentRect.width;
      resized();
    }).observe(this.box);
    this.#listen();
  }

  #listen(): void {
    const canvas = this.#canvas;
    canvas.addEventListener("pointermove", (event) => {
      // Between two taxels the last one stays, or else its text would flicker.
      const taxel = this.#under(event);
      if (taxel !== null) this.pointed(taxel);
    });
    canvas.addEventListener("pointerleave", () => this.pointed(null));
    canvas.addEventListener("click", (event) => {
      const taxel = this.#under(event);
      if (taxel !== null) this.#choose(taxel);
    });
    canvas.addEventListener("blur", () => this.pointed(null));
    canvas.addEventListener("focus", () => this.#cursor !== null && this.pointed(this.#cursor));
    canvas.addEventListener("keydown", (event) => {
      const steps: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const step = steps[event.key];
      if (step === undefined && event.key !== "Enter") return;
      event.preventDefault();
      event.stopPropagation();
      const at = this.#cursor ?? this.#cells[0]!.taxel;
      if (step === undefined) this.#choose(at);
      else {
        this.#cursor = this.#neighbour(at, step);
        this.pointed(this.#cursor);
      }
    });
  }

  #choose(taxel: number): void {
    this.#cursor = taxel;
    this.chosen?.(taxel);
  }

  /** The taxel next to another in a direction, or the same at the edge. */
  #neighbour(taxel: number, [dx, dy]: [number, number]): number {
    const from = this.#cells.find((cell) => cell.taxel === taxel)!;
    let [best, cost] = [taxel, Number.POSITIVE_INFINITY];
    for (const cell of this.#cells) {
      const [x, y] = [cell.x - from.x, cell.y - from.y];
      const [along, across] = [x * dx + y * dy, Math.abs(x * dy) + Math.abs(y * dx)];
      if (along > 1e-9 && along + 3 * across < cost) [best, cost] = [cell.taxel, along + 3 * across];
    }
    return best;
  }

  /** Middle of a taxel on the canvas, CSS pixels. */
  centre(cell: Cell): [number, number] {
    return [MARGIN.left + cell.x * this.#scale, MARGIN.top + cell.y * this.#scale];
  }

  #under(event: MouseEvent): number | null {
    const [x, y] = [event.offsetX, event.offsetY];
    const hit = this.#cells.find((cell) => {
      const [cx, cy] = this.centre(cell);
      const half = (cell.size * this.#scale) / 2;
      return Math.abs(x - cx) <= half && Math.abs(y - cy) <= half;
    });
    return hit?.taxel ?? null;
  }

  /** Draws all taxels; `chosen` and `hovered` have a frame. */
  draw(palette: Palette, lookOf: (taxel: number) => TaxelLook, chosen: number | null, hovered: number | null): void {
    const width = Math.min(this.#room, LARGEST_WIDTH);
    if (width === 0) return;
    const looks = this.#cells.map((cell) => ({ cell, look: lookOf(cell.taxel) })).filter(({ look }) => look.colour !== null);
    const shown = JSON.stringify([width, window.devicePixelRatio, chosen, hovered, looks.map(({ cell, look }) => [cell.taxel, look])]);
    if (this.#drawn?.palette === palette && this.#shown === shown) return;
    this.#shown = shown;
    this.#scale = (width - MARGIN.left - MARGIN.right) / this.#width;
    const height = this.#height * this.#scale + MARGIN.top + MARGIN.bottom;
    const context = prepare(this.#canvas, width, height);
    context.drawImage(this.#ground(palette, width, height), 0, 0, width, height);
    const ink = palette.variable("ink");
    for (const { cell, look: own } of looks) {
      const [x, y] = this.centre(cell);
      const side = cell.size * this.#scale - 1;
      context.fillStyle = own.colour!;
      context.fillRect(x - side / 2, y - side / 2, side, side);
      const mark = own.mark ?? (own.stray ? "spurious" : null);
      if (mark !== null) {
        context.fillStyle = context.strokeStyle = own.mark === null ? ink : palette.variable("panel");
        drawMark(context, look(mark).mark, x, y, side * 0.32);
      }
      if (own.over || own.wrong) {
        const frame = (name: string) => {
          context.strokeStyle = palette.variable(name);
          context.strokeRect(x - side / 2 + 1, y - side / 2 + 1, side - 2, side - 2);
        };
        context.lineWidth = 2;
        if (own.wrong) {
          // Some verdicts are as red as the dashes.
          frame("panel");
          context.setLineDash([2, 2]);
        }
        frame("over");
        context.setLineDash([]);
      }
    }
    for (const [taxel, colour, wide] of [[hovered, palette.variable("quiet"), 1.5], [chosen, ink, 2.5]] as const) {
      const cell = this.#cells.find((cell) => cell.taxel === taxel);
      if (cell === undefined) continue;
      const [x, y] = this.centre(cell);
      const side = cell.size * this.#scale + 1;
      context.strokeStyle = colour;
      context.lineWidth = wide;
      context.strokeRect(x - side / 2, y - side / 2, side, side);
    }
  }

  /** The map without forces: drawn anew only for another size or theme, because it has hundreds of cells. */
  #ground(palette: Palette, width: number, height: number): HTMLCanvasElement {
    const known = this.#drawn;
    if (known !== null && known.palette === palette && known.canvas.width === this.#canvas.width) return known.canvas;
    const canvas = element("canvas", {});
    const context = prepare(canvas, width, height);
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = palette.variable("quiet");
    if (this.#upwards) {
      context.fillText("▲ towards the tip", MARGIN.left, 12);
      context.save();
      context.translate(12, height - MARGIN.bottom);
      context.rotate(-Math.PI / 2);
      context.fillText("towards the base", 0, 0);
      context.restore();
    }
    context.fillStyle = palette.variable("cell");
    context.strokeStyle = palette.variable("line");
    context.lineWidth = 0.6;
    for (const cell of this.#cells) {
      const [x, y] = this.centre(cell);
      const side = cell.size * this.#scale - 1;
      context.fillRect(x - side / 2, y - side / 2, side, side);
      context.strokeRect(x - side / 2, y - side / 2, side, side);
    }
    this.#drawn = { canvas, palette };
    return canvas;
  }

  /** Side of a taxel on the canvas, CSS pixels. */
  side(taxel: number): number {
    return (this.#cells.find((cell) => cell.taxel === taxel)?.size ?? 0) * this.#scale;
  }

  /** Middle of a taxel on the canvas, for tests. */
  placeOf(taxel: number): [number, number] | null {
    const cell = this.#cells.find((cell) => cell.taxel === taxel);
    return cell === undefined ? null : this.centre(cell);
  }
}
