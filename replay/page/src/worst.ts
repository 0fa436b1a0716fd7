// The worst mistakes of all reaches. Each reach is read and judged as if it were opened, one after the other, so that takes as
// long as opening them all.

import { Container } from "./container.ts";
import { harm } from "./mistakes.ts";
import { Reach } from "./reach.ts";
import type { Source, Summary } from "./source.ts";
import { Trials } from "./trials.ts";

/** How many are listed. */
const LISTED = 10;

/** A mistake with what is said about it, so that its reach need not be kept. */
export interface WorstMistake {
  reach: Summary;
  object: number;
  objectName: string;
  /** The taxel that feels the most where the longest wrong time begins: its number, and its name in addresses. */
  taxel: number;
  taxelAddress: string;
  truth: string;
  verdict: string;
  wrongTime: number;
  meanForce: number;
  peakForce: number;
  /** Beginning of the longest wrong time, s, and its frame. */
  time: number;
  frame: number;
  /** Wrong time times mean force, N s. */
  harm: number;
}

export class WorstSearch {
  /** The worst so far, the worst first. */
  worst: WorstMistake[] = [];
  /** Reaches that were read, and how many of them have verdicts or could not be shown. */
  read = 0;
  judged = 0;
  failed = 0;
  #busy = false;

  constructor(readonly source: Source, readonly all: Summary[]) {}

  /** Goes on while `wanted` says so. `told` is called after every reach. */
  async run(wanted: () => boolean, told: () => void): Promise<void> {
    if (this.#busy) return;
    this.#busy = true;
    while (this.read < this.all.length && wanted()) {
      try {
        this.#add(this.all[this.read]!, new Reach(new Container(await this.source.bytes(this.read))));
      } catch {
        this.failed++;
      }
      this.read++;
      told();
      // The page stays usable.
      await new Promise((done) => setTimeout(done));
    }
    this.#busy = false;
  }

  #add(summary: Summary, reach: Reach): void {
    if (reach.header.verdicts === null) return;
    this.judged++;
    const rate = reach.header.rate_hz;
    const found = new Trials(reach).mistakes.filter(({ wrongFrames }) => wrongFrames > 0).slice(0, LISTED).map((mistake) => ({
      reach: summary,
      object: mistake.object,
      objectName: reach.objectName(mistake.object),
      taxel: mistake.taxel,
      taxelAddress: reach.taxelAddress(mistake.taxel),
      truth: mistake.truth,
      verdict: mistake.verdict,
      wrongTime: mistake.wrongFrames / rate,
      meanForce: mistake.meanForce,
      peakForce: mistake.peakForce,
      time: reach.time[mistake.run.first]!,
      frame: mistake.run.first,
      harm: harm(mistake) / rate,
    }));
    if (found.length === 0) return;
    this.worst = [...this.worst, ...found].sort((a, b) => b.harm - a.harm || a.reach.number - b.reach.number).slice(0, LISTED);
  }
}
