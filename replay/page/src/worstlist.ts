// The list of the worst mistakes of all reaches. The search begins when the list is looked at, and rests while it is not.

import { element, plural, say } from "./dom.ts";
import type { Mistake } from "./mistakes.ts";
import { Table } from "./table.ts";
import { type WorstMistake, WorstSearch } from "./worst.ts";
import type { Source, Summary } from "./source.ts";

export class WorstList {
  readonly box: HTMLElement;
  readonly #said = element("p", { class: "key" });
  readonly #progress = element("progress", { "aria-label": "Reaches read" });
  readonly #table: Table<WorstMistake>;
  readonly #search: WorstSearch;
  #shown: WorstMistake[] = [];

  constructor(source: Source, readonly all: Summary[], choose: (mistake: WorstMistake) => void) {
    this.#search = new WorstSearch(source, all);
    this.#table = new Table<WorstMistake>(
      "Worst mistakes of all reaches",
      ["mistake", "mistakes"],
      [
        { title: "reach", text: ({ reach }) => String(reach.number), value: ({ reach }) => reach.number, hint: ({ reach }) => reach.source },
        { title: "object", text: ({ objectName }) => objectName },
        { title: "truth", text: ({ truth }) => truth },
        { title: "verdict", text: ({ verdict }) => verdict, hint: () => "The verdict for most of the time in contact" },
        { title: "wrong / s", text: ({ wrongTime }) => wrongTime.toFixed(2), value: ({ wrongTime }) => wrongTime, hint: () => "Time in contact with a wrong verdict" },
        { title: "mean / N", text: ({ meanForce }) => meanForce.toFixed(2), value: ({ meanForce }) => meanForce, hint: () => "Mean sensed force while the verdict is wrong" },
        { title: "peak / N", text: ({ peakForce }) => peakForce.toFixed(2), value: ({ peakForce }) => peakForce, hint: () => "Largest sensed force while the verdict is wrong" },
        { title: "longest from / s", text: ({ time }) => time.toFixed(2), value: ({ time }) => time, hint: () => "Beginning of the longest wrong time, to which a click leads" },
        { title: "scene", text: ({ reach }) => reach.scene },
      ],
      [],
      choose,
    );
    this.#progress.max = all.length;
    this.box = element("div", {}, element("div", { class: "read" }, this.#said, this.#progress), this.#table.box);
  }

  /** Called when the list is looked at. */
  opened(): void {
    this.#tell();
    void this.#search.run(() => this.box.offsetParent !== null, () => this.#tell());
  }

  #tell(): void {
    const { read, judged, failed, worst } = this.#search;
    const done = read === this.all.length;
    this.#progress.value = read;
    this.#progress.hidden = done;
    const without = done && judged + failed < read ? ` ${plural(read - judged - failed, "reach has", "reaches have")} no verdicts.` : "";
    const lost = failed > 0 ? ` ${plural(failed, "reach", "reaches")} could not be read.` : "";
    say(this.#said, (done ? `The worst of all ${this.all.length} reaches, by wrong time times mean force.` : `${read} of ${this.all.length} reaches are read.`) + without + lost);
    this.#table.box.hidden = worst.length === 0;
    // Not without need: a row that has the focus of the keyboard would lose it.
    if (worst !== this.#shown) this.#table.fill(worst);
    this.#shown = worst;
  }

  /** Marks the mistake of the selection in the reach that is shown. */
  mark(number: number, chosen: Mistake | null): void {
    this.#table.mark(({ reach, taxel, object, frame }) => reach.number === number && taxel === chosen?.taxel && object === chosen.object && frame === chosen.run.first);
  }
}
