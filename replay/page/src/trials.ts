// Contact trials of a reach: what one taxel felt from the beginning of a contact to its end, and what the model said.

import { type Reach, search } from "./reach.ts";

/** How a trial was judged. */
export type Judgement = "right" | "wrong" | "uncertain" | "spurious" | "unjudged";

export interface Trial {
  index: number;
  taxel: number;
  first: number;
  last: number;
  /** The object that pressed in most samples; -1 for none. */
  object: number;
  /** Row of its first sample in the arrays of samples. */
  sample: number;
  peak: number;
  /** The frame of the peak. */
  peakFrame: number;
  truth: string;
  /** The last verdict, if the model judges this taxel. */
  verdict: string | null;
  judgement: Judgement;
}

/** The verdict on a taxel in a frame. */
export interface VerdictRow {
  row: number;
  name: string;
  samples: number;
}

/** The trials of a reach and the verdicts on them. */
export class Trials {
  readonly all: Trial[];
  readonly verdictStart: Uint32Array | null;
  readonly verdictTaxel: Uint32Array;
  readonly verdictCode: Uint8Array;
  readonly verdictScore: Float32Array;
  readonly #samples: Uint32Array;
  readonly #byTaxel = new Map<number, Trial[]>();
  readonly motion: Float32Array;
  readonly regionTaxels: Uint16Array;
  readonly regionForce: Float32Array;

  constructor(readonly reach: Reach) {
    const { data } = reach;
    const judged = reach.header.verdicts !== null;
    this.verdictStart = judged ? data.array("verdict_start", "u32") : null;
    this.verdictTaxel = judged ? data.array("verdict_taxel", "u32") : new Uint32Array();
    this.verdictCode = judged ? data.array("verdict_code", "u8") : new Uint8Array();
    this.#samples = judged ? data.array("verdict_samples", "u32") : new Uint32Array();
    this.verdictScore = judged ? data.array("verdict_score", "f32") : new Float32Array();
    this.motion = data.array("sample_motion_m", "f32");
    this.regionTaxels = data.array("sample_region_taxels", "u16");
    this.regionForce = data.array("sample_region_force_n", "f32");
    this.all = this.#read();
    for (const trial of this.all) {
      const others = this.#byTaxel.get(trial.taxel);
      if (others === undefined) this.#byTaxel.set(trial.taxel, [trial]);
      else others.push(trial);
    }
    this.all.sort((a, b) => a.first - b.first || a.taxel - b.taxel);
  }

  #read(): Trial[] {
    const { reach } = this;
    const taxels = reach.data.array("trial_taxel", "u32");
    const firsts = reach.data.array("trial_first_frame", "u32");
    const objects = reach.data.array("trial_object", "i16");
    const samples = reach.data.array("trial_sample_start", "u32");
    return Array.from(taxels, (taxel, index) => {
      const first = firsts[index]!;
      const last = first + samples[index + 1]! - samples[index]! - 1;
      let [peak, peakFrame] = [0, first];
      for (let frame = first; frame <= last; frame++) {
        const row = reach.reading(taxel, frame);
        if (row >= 0 && reach.sensed[row]! > peak) [peak, peakFrame] = [reach.sensed[row]!, frame];
      }
      const object = objects[index]!;
      const truth = reach.category(object);
      const verdict = this.verdict(taxel, last)?.name ?? null;
      const judgement = judge(truth, verdict);
      return { index, taxel, first, last, object, sample: samples[index]!, peak, peakFrame, truth, verdict, judgement };
    });
  }

  /** The verdict on a taxel in a frame, if it is in contact and judged. */
  verdict(taxel: number, frame: number): VerdictRow | null {
    if (this.verdictStart === null) return null;
    const row = search(this.verdictTaxel, taxel, this.verdictStart[frame]!, this.verdictStart[frame + 1]!);
    if (row < 0) return null;
    const name = this.reach.header.verdicts!.verdicts[this.verdictCode[row]!]!;
    return { row, name, samples: this.#samples[row]! };
  }

  /** The trials of a taxel, in order of time. */
  of(taxel: number): Trial[] {
    return this.#byTaxel.get(taxel) ?? [];
  }

  /** The trial of a taxel that is open in a frame. */
  at(taxel: number, frame: number): Trial | null {
    return this.of(taxel).find((trial) => trial.first <= frame && frame <= trial.last) ?? null;
  }

  /** The trials that end with a wrong verdict, or with none that decides. */
  get mistakes(): Trial[] {
    return this.all.filter((trial) => trial.judgement === "wrong" || trial.judgement === "uncertain");
  }
}

function judge(truth: string, verdict: string | null): Judgement {
  if (verdict === null) return "unjudged";
  if (truth === "spurious") return "spurious";
  if (verdict === "uncertain") return "uncertain";
  return verdict === truth ? "right" : "wrong";
}
