// How a verdict compares with the truth.

import type { VerdictHeader } from "./reach.ts";

/** How a trial, or a reading in a frame, was judged. */
export type Judgement = "right" | "wrong" | "uncertain" | "spurious" | "unjudged";

/** The verdict that is right where this is the truth. */
function rightVerdict(truth: string, { categories, touch }: VerdictHeader): string {
  if (touch === null) return truth;
  if (truth === "spurious") return "nothing";
  return categories.includes(truth) ? truth : "unknown";
}

/** Judges a verdict. Classifiers of trials have no verdict that is right for a spurious reading, so they are not blamed for any. */
export function judge(truth: string, verdict: string | null, header: VerdictHeader): Judgement {
  if (verdict === null) return "unjudged";
  if (truth === "spurious" && header.touch === null) return "spurious";
  if (verdict === rightVerdict(truth, header)) return "right";
  return verdict === "uncertain" && truth !== "spurious" ? "uncertain" : "wrong";
}
