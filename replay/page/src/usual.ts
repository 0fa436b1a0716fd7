// What is usual for contact regions of a category: in which range each feature lies that a touch model sees.

import type { Reach } from "./reach.ts";
import type { Trials } from "./trials.ts";

/** The range of a feature: from a tenth to nine tenths of the values. */
export type Range = [low: number, high: number];
const SHARES = [0.1, 0.9] as const;
/** Fewer regions say little about what is usual. Choice: a fifth of a second. */
const FEWEST = 20;

export class UsualFeatures {
  /** The rows of the regions of each category. */
  #rows: Map<string, number[]> | null = null;
  readonly #ranges = new Map<string, Range[] | null>();

  constructor(readonly reach: Reach, readonly trials: Trials) {}

  /** The range of each feature of the regions that a category truly presses on in this reach, frame by frame; null if they are few. */
  of(category: string): Range[] | null {
    const known = this.#ranges.get(category);
    if (known !== undefined) return known;
    this.#rows ??= this.#collect();
    const rows = this.#rows.get(category) ?? [];
    const ranges = rows.length < FEWEST ? null : this.#rangesOf(rows);
    this.#ranges.set(category, ranges);
    return ranges;
  }

  #rangesOf(rows: number[]): Range[] {
    const count = this.reach.header.verdicts!.features.length;
    const { features } = this.trials.touch!;
    return Array.from({ length: count }, (_, feature) => {
      const values = Float32Array.from(rows, (row) => features[row * count + feature]!).sort();
      const at = (share: number): number => values[Math.round(share * (values.length - 1))]!;
      return [at(SHARES[0]), at(SHARES[1])];
    });
  }

  /** The category of a region is that of what presses on its strongest taxel. */
  #collect(): Map<string, number[]> {
    const { reach, trials } = this;
    const { touch, verdictStart, verdictTaxel } = trials;
    const found = new Map<string, number[]>();
    if (touch === null || verdictStart === null) return found;
    for (let frame = 0; frame + 1 < verdictStart.length; frame++) {
      const strongest = new Map<number, { force: number; category: string }>();
      for (let row = verdictStart[frame]!; row < verdictStart[frame + 1]!; row++) {
        const reading = reach.reading(verdictTaxel[row]!, frame);
        const region = touch.start[frame]! + touch.ofVerdict[row]!;
        const force = reading < 0 ? 0 : reach.sensed[reading]!;
        if (force > (strongest.get(region)?.force ?? 0)) strongest.set(region, { force, category: reach.category(reach.readingObject[reading]!) });
      }
      for (const [region, { category }] of strongest) {
        const rows = found.get(category);
        if (rows === undefined) found.set(category, [region]);
        else rows.push(region);
      }
    }
    return found;
  }
}
