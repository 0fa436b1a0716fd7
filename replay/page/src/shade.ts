// Shades the longest wrong run of the chosen mistake above a time axis.

import type { TimeAxis } from "./axis.ts";
import { element } from "./dom.ts";
import type { Run } from "./mistakes.ts";
import type { Reach } from "./reach.ts";

/** A shorter run could not be seen, px. */
const NARROWEST_PX = 3;

export class Shade {
  readonly box = element("div", { class: "shade", hidden: true });

  show(axis: TimeAxis, reach: Reach, run: Run | null): void {
    this.box.hidden = run === null;
    if (run === null) return;
    const from = axis.x(reach.time[run.first]!);
    const to = axis.x(reach.time[run.last + 1] ?? reach.duration);
    this.box.style.left = `${from}px`;
    this.box.style.width = `${Math.max(to - from, NARROWEST_PX)}px`;
  }
}
