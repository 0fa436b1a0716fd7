// How a verdict compares with the truth.

import type { VerdictHeader } from "./reach.ts";

/** How a trial, or a reading in a frame, was judged. */
export type Judgement = "right" | "wrong" | "uncertain" | "spurious" | "unjudged";

/** The verdict that is right where this is the truth. A classifier of trials has none for a foam block, as in `evaluate`. */
function rightVerdict(truth: string, { categories, touch }: VerdictHeader): string {
  if (truth === "spurious") return "nothing";
  if (categories.includes(truth)) return truth;
  return touch !== null ? "unknown" : truth === "block" ? truth : "outlier";
}

/** Judges a verdict. Classifiers of trials have no verdict that is right for a spurious reading, so they are not blamed for any. */
export function judge(truth: string, verdict: string | null, header: VerdictHeader): Judgement {
  if (verdict === null) return "unjudged";
  if (truth === "spurious" && header.touch === null) return "spurious";
  if (verdict === rightVerdict(truth, header)) return "right";
  return verdict === "uncertain" && truth !== "spurious" ? "uncertain" : "wrong";
}
