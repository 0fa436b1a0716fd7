// Contact trials of a reach: what one taxel felt from the beginning of a contact to its end, and what the model said.

import { judge } from "./judgement.ts";
import { type Mistake, mistakesOf } from "./mistakes.ts";
import { type Reach, search } from "./reach.ts";
import type { State } from "./state.ts";
import type { Trial, VerdictRow } from "./trial.ts";

/** A contact region as a touch model sees it in a frame. */
export interface TouchRegion {
  /** Number of the contact, which the region keeps while it slides. */
  contact: number;
  samples: number;
  taxels: number;
  /** Taxels that are not called nothing. */
  touchedTaxels: number;
  verdict: string;
  /** The share of contacts with known categories that are as unusual. */
  shareBeyond: number;
  features: Float32Array;
}

/** The regions of a touch model: those of frame f are the rows start[f] to start[f + 1]. */
interface TouchRegions {
  start: Uint32Array;
  /** For each verdict the place of its region among those of the frame. */
  ofVerdict: Uint16Array;
  contact: Uint32Array;
  samples: Uint32Array;
  taxels: Uint16Array;
  touchedTaxels: Uint16Array;
  code: Uint8Array;
  shareBeyond: Float32Array;
  features: Float32Array;
}

function touchRegions({ data, header }: Reach): TouchRegions | null {
  if (header.verdicts === null || header.verdicts.touch === null) return null;
  return {
    start: data.array("touch_start", "u32"),
    ofVerdict: data.array("verdict_region", "u16"),
    contact: data.array("touch_contact", "u32"),
    samples: data.array("touch_samples", "u32"),
    taxels: data.array("touch_taxels", "u16"),
    touchedTaxels: data.array("touch_touched_taxels", "u16"),
    code: data.array("touch_code", "u8"),
    shareBeyond: data.array("touch_share_beyond", "f32"),
    features: data.array("touch_feature", "f32"),
  };
}

/** The trials of a reach and the verdicts on them. */
export class Trials {
  readonly all: Trial[];
  /** The worst first. */
  readonly mistakes: Mistake[];
  readonly verdictStart: Uint32Array | null;
  readonly verdictTaxel: Uint32Array;
  readonly verdictCode: Uint8Array;
  readonly verdictScore: Float32Array;
  readonly touch: TouchRegions | null;
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
    this.touch = touchRegions(reach);
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
    this.mistakes = mistakesOf(this);
  }

  #read(): Trial[] {
    const { reach } = this;
    const header = reach.header.verdicts;
    const taxels = reach.data.array("trial_taxel", "u32");
    const firsts = reach.data.array("trial_first_frame", "u32");
    const objects = reach.data.array("trial_object", "i16");
    const samples = reach.data.array("trial_sample_start", "u32");
    return Array.from(taxels, (taxel, index) => {
      const first = firsts[index]!;
      const last = first + samples[index + 1]! - samples[index]! - 1;
      const object = objects[index]!;
      let [peak, peakFrame, verdict, wrongFrames] = [0, first, null as string | null, 0];
      for (let frame = first; frame <= last; frame++) {
        const row = reach.reading(taxel, frame);
        if (row < 0) continue;
        if (reach.sensed[row]! > peak) [peak, peakFrame] = [reach.sensed[row]!, frame];
        if (header === null || !header.patches.includes(reach.patchOf[taxel]!)) continue;
        const now = this.verdict(taxel, frame)?.name ?? null;
        const pressing = reach.readingObject[row]!;
        if (judge(reach.category(pressing), now, header) === "wrong") wrongFrames++;
        // A touch model says nothing when its object has left, although the sensor still reads a little.
        if (header.touch === null || pressing === object) verdict = now;
      }
      const truth = reach.category(object);
      const judgement = header === null ? "unjudged" : judge(truth, verdict, header);
      return { index, taxel, first, last, object, sample: samples[index]!, peak, peakFrame, truth, verdict, judgement, wrongFrames };
    });
  }

  /** What a touch model knows of the region of a taxel, by the row of its verdict; null for other models. */
  region(verdict: number, frame: number): TouchRegion | null {
    const { touch } = this;
    if (touch === null) return null;
    const row = touch.start[frame]! + touch.ofVerdict[verdict]!;
    const count = this.reach.header.verdicts!.features.length;
    return {
      contact: touch.contact[row]!,
      samples: touch.samples[row]!,
      taxels: touch.taxels[row]!,
      touchedTaxels: touch.touchedTaxels[row]!,
      verdict: this.reach.header.verdicts!.verdicts[touch.code[row]!]!,
      shareBeyond: touch.shareBeyond[row]!,
      features: touch.features.subarray(row * count, (row + 1) * count),
    };
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

  /** The mistake on the chosen object, or on the trial that is open on the chosen taxel. */
  mistakeAt({ taxel, object, frame }: Pick<State, "taxel" | "object" | "frame">): Mistake | null {
    const trial = taxel === null ? null : this.at(taxel, frame);
    return this.mistakes.find((mistake) => (mistake.trial === null ? mistake.object === object : mistake.trial === trial)) ?? null;
  }
}
