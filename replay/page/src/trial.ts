// What one contact trial and one verdict are.

import type { Judgement } from "./judgement.ts";

/** What one taxel felt from the beginning of a contact to its end. */
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
  /** The last verdict, if the model judges this taxel; of a touch model the last one while its object presses. */
  verdict: string | null;
  judgement: Judgement;
  /** Frames with a wrong verdict on what presses in that frame. */
  wrongFrames: number;
}

/** The verdict on a taxel in a frame. */
export interface VerdictRow {
  row: number;
  name: string;
  samples: number;
}
