// The choice of a ghost: the arm of another reach of the same draw, seen through at the same time of its run.

import { Container, DataError } from "./container.ts";
import { element, find } from "./dom.ts";
import { explain } from "./message.ts";
import { Reach } from "./reach.ts";
import type { Source, Summary } from "./source.ts";
import type { Store } from "./state.ts";

/** Whether two reaches are of the same scene, seed and number, so that the same objects were drawn. Of logs nobody knows. */
function isSameDraw(a: Summary, b: Summary): boolean {
  return !a.log && !b.log && !a.running && !b.running && a.scene === b.scene && a.seed === b.seed && a.reach_index === b.reach_index;
}

export class GhostChoice {
  readonly #select = find<HTMLSelectElement>("ghost");
  readonly #field = find("ghost-field");
  #loaded: { number: number; of: Reach; reach: Reach } | null = null;

  constructor(readonly source: Source, readonly all: Summary[], readonly store: Store, readonly wake: () => void) {
    this.#select.addEventListener("change", () => {
      store.set({ ghost: this.#select.value === "" ? null : Number(this.#select.value) });
      wake();
    });
  }

  /** Offers the reaches of the same draw as this one, and keeps the chosen one if it is among them. */
  offer(number: number): void {
    const own = this.all[number]!;
    const others = this.all.filter((other) => other !== own && isSameDraw(own, other));
    this.#field.hidden = others.length === 0;
    this.#select.replaceChildren(element("option", { value: "" }, "off"), ...others.map((other) => element("option", { value: other.number }, this.name(other.number))));
    if (!others.some((other) => other.number === this.store.state.ghost)) this.store.set({ ghost: null });
  }

  name(number: number): string {
    return `${number}: ${this.all[number]!.controller}`;
  }

  /** Loads the ghost of the state for this reach and gives it; null if there is none, or another choice has overtaken this one. */
  async load(own: Reach): Promise<Reach | null> {
    const number = this.store.state.ghost;
    this.#select.value = String(number ?? "");
    if (number === null) return null;
    if (this.#loaded?.number === number && this.#loaded.of === own) return this.#loaded.reach;
    try {
      const reach = new Reach(new Container(await this.source.bytes(number)));
      if (this.store.state.ghost !== number) return null;
      // The scene file may have changed between the two, or the program.
      if (JSON.stringify(reach.header.objects) !== JSON.stringify(own.header.objects)) {
        throw new DataError(`Reach ${number} cannot be a ghost here: its objects differ, although scene and seed have the same names.`);
      }
      this.#loaded = { number, of: own, reach };
      return reach;
    } catch (error) {
      if (this.store.state.ghost !== number) return null;
      this.store.set({ ghost: null });
      this.wake();
      explain(error);
      return null;
    }
  }
}
