// The lists of the page: the reaches, and the mistakes and contact trials of the reach that is shown.

import { element, newtons, seconds } from "./dom.ts";
import type { Mistake } from "./mistakes.ts";
import type { Reach } from "./reach.ts";
import type { Source, Summary } from "./source.ts";
import { type Column, Table, tabs } from "./table.ts";
import type { Trial } from "./trial.ts";
import type { Trials } from "./trials.ts";
import type { WorstMistake } from "./worst.ts";
import { WorstList } from "./worstlist.ts";

/** The number of goals; 0 for a robot's log, of which nobody knows what the robot was to do. */
export function goalCount({ goal_outcomes: { reached, stuck, timed_out, aborted } }: Pick<Summary, "goal_outcomes">): number {
  return reached + stuck + timed_out + aborted;
}

function goals(reach: Summary): string {
  return `${reach.goal_outcomes.reached} of ${goalCount(reach)}`;
}

function audit(reach: Summary): string {
  return reach.audit_warnings.length === 0 ? "within bounds" : `${reach.audit_warnings.length} exceeded`;
}

/** A column with a dash, sorted before all values, in the rows of which `known` says no. */
function ifKnown(known: (reach: Summary) => boolean, { title, text, value, hint }: Column<Summary>): Column<Summary> {
  const column: Column<Summary> = { title, text: (reach) => (known(reach) ? text(reach) : "–") };
  if (value !== undefined) column.value = (reach) => (known(reach) ? value(reach) : -1);
  if (hint !== undefined) column.hint = (reach) => (known(reach) ? hint(reach) : "");
  return column;
}

/** How a reach went is not known while it runs. A table of trials never says it, and a log does not say what moved the robot. */
const hasEnded = (reach: Summary) => !reach.running;
const isSimulated = (reach: Summary) => !reach.log;
const hasResult = (reach: Summary) => hasEnded(reach) && !reach.table;
/** A log has forces and contacts, but no goals, and nothing was simulated that could be audited. */
const hasGoals = (reach: Summary) => hasResult(reach) && goalCount(reach) > 0;

export function reachTable(choose: (reach: Summary) => void): Table<Summary> {
  const controller = ifKnown(isSimulated, { title: "controller", text: (reach) => reach.controller });
  const outcome = ifKnown(hasGoals, { title: "outcome", text: (reach) => reach.outcome.replace("_", " ") });
  const audited = ifKnown(hasGoals, { title: "audit", text: audit, value: (reach) => reach.audit_warnings.length, hint: (reach) => reach.audit_warnings.join("\n") });
  return new Table<Summary>(
    "Reaches",
    ["reach", "reaches"],
    [
      { title: "#", text: (reach) => String(reach.number), value: (reach) => reach.number },
      { title: "scene", text: (reach) => reach.scene, hint: (reach) => reach.source },
      ifKnown(isSimulated, { title: "seed", text: (reach) => reach.seed, value: (reach) => Number(reach.seed) }),
      { title: "reach", text: (reach) => String(reach.reach_index), value: (reach) => reach.reach_index },
      controller,
      outcome,
      ifKnown(hasGoals, { title: "goals", text: goals, value: (reach) => reach.goal_outcomes.reached }),
      ifKnown(hasEnded, { title: "length / s", text: (reach) => reach.duration_s.toFixed(1), value: (reach) => reach.duration_s }),
      ifKnown(hasResult, { title: "peak / N", text: (reach) => reach.peak_force_n.toFixed(2), value: (reach) => reach.peak_force_n }),
      ifKnown(hasResult, { title: "contacts", text: (reach) => String(reach.contacts), value: (reach) => reach.contacts }),
      audited,
    ],
    [
      { label: "Scene", of: (reach) => reach.scene },
      { label: "Outcome", of: outcome.text },
      { label: "Controller", of: controller.text },
      { label: "Audit", of: audited.text },
    ],
    choose,
  );
}

function wrongFrames(trial: Trial): string {
  return trial.verdict === null ? "–" : `${trial.wrongFrames} of ${trial.last - trial.first + 1}`;
}

/** A trial with its reach, for the table. */
interface TrialRow {
  trial: Trial;
  reach: Reach;
}

function trialTable(choose: (trial: Trial) => void): Table<TrialRow> {
  return new Table<TrialRow>(
    "Contact trials",
    ["contact trial", "contact trials"],
    [
      { title: "start / s", text: ({ trial, reach }) => reach.time[trial.first]!.toFixed(2), value: ({ trial }) => trial.first },
      { title: "taxel", text: ({ trial, reach }) => reach.taxelName(trial.taxel) },
      { title: "truth", text: ({ trial }) => trial.truth },
      { title: "verdict", text: ({ trial }) => trial.verdict ?? "not judged" },
      { title: "judged", text: ({ trial }) => trial.judgement },
      { title: "wrong frames", text: ({ trial }) => wrongFrames(trial), value: ({ trial }) => trial.wrongFrames, hint: () => "Frames with a wrong verdict on what presses in that frame" },
      { title: "length / s", text: ({ trial, reach }) => ((trial.last - trial.first + 1) / reach.header.rate_hz).toFixed(2), value: ({ trial }) => trial.last - trial.first },
      { title: "peak / N", text: ({ trial }) => trial.peak.toFixed(2), value: ({ trial }) => trial.peak },
      { title: "object", text: ({ trial, reach }) => reach.objectName(trial.object) },
    ],
    [
      { label: "Truth", of: ({ trial }) => trial.truth },
      { label: "Verdict", of: ({ trial }) => trial.verdict ?? "not judged" },
      { label: "Judged", of: ({ trial }) => trial.judgement },
    ],
    ({ trial }) => choose(trial),
  );
}

/** A mistake with its reach, for the table. */
interface MistakeRow {
  mistake: Mistake;
  reach: Reach;
}

/** Keeps the given order, the worst first, until a column is sorted by. */
function mistakeTable(choose: (mistake: Mistake) => void): Table<MistakeRow> {
  const time = (frames: number, reach: Reach) => (frames / reach.header.rate_hz).toFixed(2);
  return new Table<MistakeRow>(
    "Mistakes",
    ["mistake", "mistakes"],
    [
      { title: "object", text: ({ mistake, reach }) => reach.objectName(mistake.object) },
      { title: "taxel", text: ({ mistake, reach }) => reach.taxelName(mistake.taxel), hint: () => "The taxel that feels the most where the longest wrong time begins" },
      { title: "truth", text: ({ mistake }) => mistake.truth },
      { title: "verdict", text: ({ mistake }) => mistake.verdict, hint: () => "The verdict for most of the time in contact" },
      { title: "judged", text: ({ mistake }) => mistake.judgement },
      { title: "wrong / s", text: ({ mistake, reach }) => time(mistake.wrongFrames, reach), value: ({ mistake }) => mistake.wrongFrames, hint: () => "Time in contact with a wrong verdict" },
      { title: "contact / s", text: ({ mistake, reach }) => time(mistake.frames, reach), value: ({ mistake }) => mistake.frames, hint: () => "Time in contact with a verdict" },
      { title: "mean / N", text: ({ mistake }) => mistake.meanForce.toFixed(2), value: ({ mistake }) => mistake.meanForce, hint: () => "Mean sensed force while the verdict is wrong" },
      { title: "peak / N", text: ({ mistake }) => mistake.peakForce.toFixed(2), value: ({ mistake }) => mistake.peakForce, hint: () => "Largest sensed force while the verdict is wrong" },
      { title: "longest from / s", text: ({ mistake, reach }) => reach.time[mistake.run.first]!.toFixed(2), value: ({ mistake }) => mistake.run.first, hint: () => "Beginning of the longest wrong time, to which a click leads" },
    ],
    [
      { label: "Truth", of: ({ mistake }) => mistake.truth },
      { label: "Verdict", of: ({ mistake }) => mistake.verdict },
      { label: "Judged", of: ({ mistake }) => mistake.judgement },
    ],
    ({ mistake }) => choose(mistake),
  );
}

/** What a click on a row leads to. */
export interface ListActions {
  open(reach: Summary): void;
  trial(trial: Trial): void;
  mistake(mistake: Mistake): void;
  worst(mistake: WorstMistake): void;
}

export class Lists {
  readonly #reaches: Table<Summary>;
  readonly #mistakes: Table<MistakeRow>;
  readonly #trials: Table<TrialRow>;
  readonly #noMistakes = element("p", {});
  /** Of a single reach the list of mistakes says as much. */
  readonly #worst: WorstList | null;
  #number = 0;
  readonly open: (id: string) => void;

  constructor(box: HTMLElement, source: Source, all: Summary[], actions: ListActions) {
    this.#reaches = reachTable(actions.open);
    this.fill(all);
    this.#mistakes = mistakeTable(actions.mistake);
    this.#trials = trialTable(actions.trial);
    const worst = all.length < 2 ? null : new WorstList(source, all, actions.worst);
    this.#worst = worst;
    this.open = tabs(box, [
      { id: "reaches", title: "Reaches", content: this.#reaches.box, opened: () => this.#reaches.refresh() },
      { id: "mistakes", title: "Mistakes", content: element("div", {}, this.#noMistakes, this.#mistakes.box), opened: () => this.#mistakes.refresh() },
      ...(worst === null ? [] : [{ id: "worst", title: "Worst ten", content: worst.box, opened: () => worst.opened() }]),
      { id: "trials", title: "Contact trials", content: this.#trials.box, opened: () => this.#trials.refresh() },
    ]);
  }

  /** Lists these reaches. */
  fill(all: Summary[]): void {
    this.#reaches.fill(all);
  }

  load(number: number, reach: Reach, trials: Trials): void {
    this.#number = number;
    this.#reaches.reveal((row) => row.number === number);
    this.#trials.fill(trials.all.map((trial) => ({ trial, reach })));
    const none = trials.mistakes.length === 0;
    this.#mistakes.box.hidden = none;
    this.#noMistakes.hidden = !none;
    this.#noMistakes.textContent = reach.header.verdicts === null
      ? "There are no verdicts. Start “underbrush replay” with --model to see what a model says."
      : "Nothing is judged wrong or uncertain for most of its time in contact.";
    this.#mistakes.fill(trials.mistakes.map((mistake) => ({ mistake, reach })));
  }

  /** Marks the trial and the mistake of the selection. */
  mark(chosen: Trial | null, chosenMistake: Mistake | null): void {
    this.#trials.mark(({ trial }) => trial === chosen);
    this.#mistakes.mark(({ mistake }) => mistake === chosenMistake);
    this.#worst?.mark(this.#number, chosenMistake);
  }
}

export function describe(trial: Trial, reach: Reach): string {
  const verdict = trial.verdict === null ? "" : `, verdict ${trial.verdict}`;
  return `${reach.taxelName(trial.taxel)} from ${seconds(reach.time[trial.first]!)} to ${seconds(reach.time[trial.last]!)}: truth ${trial.truth}${verdict}, peak ${newtons(trial.peak)}`;
}
