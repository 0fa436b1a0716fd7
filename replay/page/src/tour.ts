// A tour of a reach: the first contact, its forces, a verdict and a mistake, each with a sentence.

import { element, find, newtons, say, seconds } from "./dom.ts";
import type { Mistake } from "./mistakes.ts";
import type { Loaded } from "./pane.ts";
import { NO_OBJECT } from "./reach.ts";
import { pushesAt } from "./series.ts";
import type { State } from "./state.ts";
import { WEAKEST_N } from "./view/arrows.ts";

/** What the steps do; page.ts gives it. */
export interface TourActions {
  loaded(): Loaded | null;
  seek(frame: number): void;
  set(values: Partial<State>): void;
  follow(mistake: Mistake): void;
}

interface Step {
  text: string;
  frame: number;
  values: Partial<State>;
  mistake?: Mistake;
}

/** The first contact of the skin, and the moment in which it presses the most. */
function contactSteps({ reach, trials }: Loaded): Step[] {
  const values = { colour: "force", taxel: null, object: null } as const;
  const trial = trials.all[0];
  // A table of trials names no contacts of objects.
  if (reach.isTable && trial !== undefined) {
    const text = `The first contact is on ${reach.taxelName(trial.taxel)} at ${seconds(reach.time[trial.first]!)}.`;
    return [{ text, frame: trial.first, values: { ...values, taxel: trial.taxel } }];
  }
  const [first] = reach.header.contacts.filter(({ patch }) => patch !== null).sort((a, b) => a.first_frame - b.first_frame);
  if (first === undefined) return [];
  const { object, patch, first_frame: begin, last_frame: end } = first;
  const name = reach.objectName(object);
  const where = reach.header.patches[patch!]!.name;
  const steps: Step[] = [{ text: `The first contact: ${name} touches the ${where} at ${seconds(reach.time[begin]!)}.`, frame: begin, values: { ...values, object } }];
  let [strongest, most] = [begin, 0];
  for (let frame = begin; frame <= end; frame++) {
    const push = pushesAt(reach, frame).find((push) => push.object === object && push.patch === patch);
    const force = push === undefined ? 0 : Math.hypot(...push.force);
    if (force > most) [strongest, most] = [frame, force];
  }
  if (most >= WEAKEST_N) steps.push({ text: `The arrow shows the force of this contact, which is largest here: ${newtons(most)}.`, frame: strongest, values: { ...values, object } });
  return steps;
}

/** The first verdict on an object that names a category. */
function verdictStep({ reach, trials }: Loaded): Step[] {
  const header = reach.header.verdicts;
  for (let frame = 0; header !== null && frame < reach.frames; frame++) {
    for (let row = trials.verdictStart![frame]!; row < trials.verdictStart![frame + 1]!; row++) {
      const [taxel, verdict] = [trials.verdictTaxel[row]!, header.verdicts[trials.verdictCode[row]!]!];
      const object = reach.readingObject[reach.reading(taxel, frame)] ?? NO_OBJECT;
      if (object === NO_OBJECT || !header.categories.includes(verdict)) continue;
      const text = `The first verdict that names a category: ${verdict}. The truth is ${reach.category(object)}.`;
      return [{ text, frame, values: { colour: "verdict", taxel, object: null } }];
    }
  }
  return [];
}

function mistakeStep({ reach, trials }: Loaded): Step[] {
  const [worst] = trials.mistakes;
  if (worst === undefined) return [];
  const time = seconds(worst.wrongFrames / reach.header.rate_hz);
  const text = `The worst mistake: ${reach.objectName(worst.object)} is called ${worst.verdict}; the verdict is wrong for ${time}.`;
  return [{ text, frame: worst.run.first, values: { colour: "verdict" }, mistake: worst }];
}

export class Tour {
  readonly #text = element("p", { role: "status" });
  readonly #next = element("button", { type: "button", class: "primary" }, "Next");
  readonly #end = element("button", { type: "button" }, "End");
  readonly #begin = find("tour");
  readonly #box = find("tour-caption");
  #steps: Step[] = [];
  #at = 0;
  #reach = 0;

  constructor(readonly actions: TourActions) {
    this.#box.append(this.#text, this.#next, this.#end);
    this.#begin.addEventListener("click", () => this.#start());
    this.#next.addEventListener("click", () => this.#show(this.#at + 1));
    this.#end.addEventListener("click", () => this.end());
  }

  #start(): void {
    const loaded = this.actions.loaded();
    if (loaded === null) return;
    this.#steps = [...contactSteps(loaded), ...verdictStep(loaded), ...mistakeStep(loaded)];
    this.#reach = loaded.number;
    this.#box.hidden = false;
    if (this.#steps.length > 0) this.#show(0);
    else {
      say(this.#text, "Nothing touches the skin in this reach.");
      this.#next.hidden = true;
    }
    (this.#next.hidden ? this.#end : this.#next).focus();
  }

  #show(at: number): void {
    const { text, frame, values, mistake } = this.#steps[at]!;
    this.#at = at;
    say(this.#text, `${at + 1} of ${this.#steps.length}: ${text}`);
    this.#next.hidden = at === this.#steps.length - 1;
    if (this.#next.hidden) this.#end.focus();
    this.actions.set({ ...values, playing: false });
    if (mistake === undefined) this.actions.seek(frame);
    else this.actions.follow(mistake);
  }

  /** Ends the tour, and says whether there was one. */
  end(): boolean {
    if (this.#box.hidden) return false;
    this.#box.hidden = true;
    this.#begin.focus();
    return true;
  }

  /** Ends the tour when another reach is shown. */
  shown(reach: number): void {
    if (reach !== this.#reach) this.end();
  }
}
