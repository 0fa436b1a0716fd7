// What the model got wrong. A touch model judges regions of skin anew in every frame, so its mistakes are those of whole
// objects. A classifier of trials judges the contacts of single taxels, so its mistakes are those of trials.

import { judge, type Judgement } from "./judgement.ts";
import type { Reach, VerdictHeader } from "./reach.ts";
import type { Trial, VerdictRow } from "./trial.ts";

/** The trials of a reach, and the verdict on a taxel in a frame. */
interface Trials {
  readonly reach: Reach;
  readonly all: Trial[];
  verdict(taxel: number, frame: number): VerdictRow | null;
}

/** Frames that follow one another, both ends included. */
export interface Run {
  first: number;
  last: number;
}

/** An object or a trial whose verdict was wrong or uncertain for most of its time in contact. */
export interface Mistake {
  /** The object; -1 for none. */
  object: number;
  /** The trial; null for an object. */
  trial: Trial | null;
  truth: string;
  /** The wrong or uncertain verdict that it had for longest. */
  verdict: string;
  judgement: Judgement;
  /** Frames with a verdict. */
  frames: number;
  wrongFrames: number;
  /** Mean and largest force in the wrong frames, N; 0 if there are none. */
  meanForce: number;
  peakForce: number;
  /** The longest run of wrong frames, or of uncertain ones if none is wrong. */
  run: Run;
  /** The taxel that feels the most when the run begins. */
  taxel: number;
}

/** The verdict on an object or on a trial in one frame. */
interface Moment {
  frame: number;
  taxel: number;
  /** Sensed force, N; of an object on all its taxels that are judged. */
  force: number;
  verdict: string;
  judgement: Judgement;
}

/** The name with the largest amount. */
function largest(amounts: Map<string, number>): string {
  return [...amounts].reduce((most, other) => (other[1] > most[1] ? other : most))[0];
}

function longestRun(moments: Moment[]): Run {
  let longest: Run = { first: 0, last: -1 };
  let run = longest;
  for (const { frame } of moments) {
    run = run.last === frame - 1 ? { first: run.first, last: frame } : { first: frame, last: frame };
    if (run.last - run.first > longest.last - longest.first) longest = run;
  }
  return longest;
}

/** The mistake that these moments make; null unless the verdict is wrong or uncertain for most of the time. */
function mistakeOf(object: number, trial: Trial | null, truth: string, moments: Moment[], header: VerdictHeader): Mistake | null {
  const times = new Map<string, number>();
  let against = 0;
  for (const { verdict } of moments) {
    if (!["wrong", "uncertain"].includes(judge(truth, verdict, header))) continue;
    times.set(verdict, (times.get(verdict) ?? 0) + 1);
    against++;
  }
  if (2 * against <= moments.length) return null;
  const verdict = largest(times);
  const judgement = judge(truth, verdict, header);
  const wrong = moments.filter((moment) => moment.judgement === "wrong");
  const uncertain = moments.filter((moment) => moment.judgement === "uncertain");
  // A trial can have neither: another object may press in some of its frames.
  const run = longestRun([wrong, uncertain, moments].find((some) => some.length > 0)!);
  return {
    object, trial, truth, verdict, judgement, run,
    frames: moments.length,
    wrongFrames: wrong.length,
    meanForce: wrong.reduce((sum, { force }) => sum + force, 0) / Math.max(wrong.length, 1),
    peakForce: wrong.reduce((peak, { force }) => Math.max(peak, force), 0),
    taxel: moments.find(({ frame }) => frame === run.first)!.taxel,
  };
}

/** The verdicts of a touch model on each object, frame by frame: in a frame, the verdict with most of the object's force. */
function momentsOfObjects(trials: Trials, header: VerdictHeader): Map<number, Moment[]> {
  const { reach } = trials;
  const found = new Map<number, Moment[]>();
  for (let frame = 0; frame < reach.frames; frame++) {
    const felt = new Map<number, { taxel: number; most: number; force: number; shares: Map<string, number> }>();
    for (let row = reach.readingStart[frame]!; row < reach.readingStart[frame + 1]!; row++) {
      const [taxel, object, force] = [reach.readingTaxel[row]!, reach.readingObject[row]!, reach.sensed[row]!];
      const verdict = object < 0 || force <= 0 ? null : trials.verdict(taxel, frame);
      if (verdict === null) continue;
      const own = felt.get(object) ?? { taxel, most: 0, force: 0, shares: new Map() };
      felt.set(object, own);
      if (force > own.most) [own.taxel, own.most] = [taxel, force];
      own.force += force;
      own.shares.set(verdict.name, (own.shares.get(verdict.name) ?? 0) + force);
    }
    for (const [object, { taxel, force, shares }] of felt) {
      const verdict = largest(shares);
      const moment = { frame, taxel, force, verdict, judgement: judge(reach.category(object), verdict, header) };
      const others = found.get(object);
      if (others === undefined) found.set(object, [moment]);
      else others.push(moment);
    }
  }
  return found;
}

/** The verdicts on a trial, each judged by what presses in its frame. */
function momentsOfTrial(trials: Trials, { taxel, first, last }: Trial, header: VerdictHeader): Moment[] {
  const { reach } = trials;
  const moments: Moment[] = [];
  for (let frame = first; frame <= last; frame++) {
    const row = reach.reading(taxel, frame);
    const verdict = row < 0 ? null : trials.verdict(taxel, frame);
    if (verdict === null) continue;
    const judgement = judge(reach.category(reach.readingObject[row]!), verdict.name, header);
    moments.push({ frame, taxel, force: reach.sensed[row]!, verdict: verdict.name, judgement });
  }
  return moments;
}

/** What mistakes are sorted by: wrong frames times mean force. */
export function harm({ wrongFrames, meanForce }: Mistake): number {
  return wrongFrames * meanForce;
}

/** The mistakes of a reach. First are those that were wrong for long while they pressed hard: by wrong time times force. */
export function mistakesOf(trials: Trials): Mistake[] {
  const { reach } = trials;
  const header = reach.header.verdicts;
  if (header === null) return [];
  const all = header.touch === null
    ? trials.all.map((trial) => mistakeOf(trial.object, trial, trial.truth, momentsOfTrial(trials, trial, header), header))
    : [...momentsOfObjects(trials, header)].map(([object, moments]) => mistakeOf(object, null, reach.category(object), moments, header));
  return all.filter((mistake) => mistake !== null).sort((a, b) => harm(b) - harm(a) || a.run.first - b.run.first);
}
