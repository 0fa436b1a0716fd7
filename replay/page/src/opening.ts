// Loads reaches: the one that is shown, one beside it, and more of one that runs.

import { type Asked, findTaxel } from "./address.ts";
import { Container } from "./container.ts";
import { find } from "./dom.ts";
import { GhostChoice } from "./ghost.ts";
import { join } from "./grow.ts";
import { type Header, nameOf } from "./header.ts";
import type { Lists } from "./lists.ts";
import { clear, explain, explainNoReach } from "./message.ts";
import { Loaded, type Pane } from "./pane.ts";
import { Reach } from "./reach.ts";
import type { Source, Summary } from "./source.ts";
import type { State, Store } from "./state.ts";
import type { Switches } from "./switches.ts";
import type { Timeline } from "./timeline.ts";

/** What a reach is loaded into. */
export interface Views {
  store: Store;
  panes: [Pane, Pane];
  timeline: Timeline;
  lists: Lists;
  header: Header;
  switches: Switches;
  seek(frame: number): void;
  /** Draws everything anew. */
  everything(): void;
  wake(): void;
}

/** A browser that shows nothing, such as one with a hidden tab, is waited for at most this long, ms. */
const PATIENCE_MS = 1000;

/** Waits until the browser has shown what is on the page so far. */
function shown(): Promise<void> {
  if (document.visibilityState === "hidden") return Promise.resolve();
  return new Promise((done) => {
    // A frame is shown when the task that follows its callbacks begins.
    requestAnimationFrame(() => setTimeout(done));
    setTimeout(done, PATIENCE_MS);
  });
}

export class Opening {
  #request = 0;
  /** The list is shown before anything is done for the first reach. */
  readonly #listed = shown().then(() => void performance.mark("listed"));

  readonly ghosts: GhostChoice;

  constructor(readonly source: Source, readonly all: Summary[], readonly views: Views) {
    this.ghosts = new GhostChoice(source, all, views.store, views.wake);
  }

  get #loaded(): Loaded | null {
    return this.views.panes[0].loaded;
  }

  async #fetch(number: number, pane: Pane): Promise<Loaded> {
    const bytes = this.source.bytes(number);
    // An error is told below, where the bytes are waited for.
    bytes.catch(() => undefined);
    await this.#listed;
    // While the server reads and judges the reach.
    pane.makeView();
    return new Loaded(number, new Reach(new Container(await bytes)));
  }

  /** Loads a reach by its number and shows it, at the time and with the selection of an address if there is one. */
  async open(number: number, asked: Asked | null = null): Promise<void> {
    const summary = this.all[number];
    if (summary === undefined) return;
    const request = ++this.#request;
    try {
      const loaded = await this.#fetch(number, this.views.panes[0]);
      // A later choice has overtaken this one.
      if (request !== this.#request) return;
      const { reach } = loaded;
      const { store, panes, timeline, lists, header } = this.views;
      clear();
      panes[0].load(loaded, nameOf(summary));
      timeline.load(reach);
      lists.load(number, reach, loaded.trials);
      // Only now, or a ghost would be compared with the reach that was shown before.
      if (asked !== null) store.set({ ...asked.state, beside: asked.beside, ghost: asked.ghost });
      const colour = this.#allowVerdict(reach) || store.state.colour !== "verdict" ? store.state.colour : "truth";
      const object = reach.header.objects[asked?.object ?? -1] === undefined ? null : asked!.object;
      store.set({ reach: number, playing: false, colour, taxel: findTaxel(reach, asked?.taxel ?? null), object });
      this.ghosts.offer(number);
      header.describe(summary, reach);
      this.views.seek(reach.frameNearest(asked?.time ?? 0));
      store.touch("reach", "frame");
      this.views.wake();
      document.body.dataset["ready"] = String(number);
    } catch (error) {
      if (request === this.#request) explain(error);
    }
  }

  /** Whether there are verdicts. Without them nothing leads to them, and nothing to contacts and goals that a log does not have. */
  #allowVerdict({ header }: Reach): boolean {
    const judged = header.verdicts !== null;
    this.views.switches.allowVerdict(judged);
    find("jump-mistake").hidden = !judged;
    find("jump-contact").hidden = header.contacts.length === 0;
    find("jump-goal").hidden = header.goals.length === 0;
    return judged;
  }

  /** Loads what is new of a reach that runs, and gives the number of its frames. A view at the last frame follows new frames. */
  async grow(ended: boolean): Promise<number> {
    const { store, panes, timeline, lists, header } = this.views;
    try {
      if (ended) {
        this.all.splice(0, 1, ...(await this.source.list()));
        lists.fill(this.all);
      }
      const before = this.#loaded?.reach ?? null;
      const known = before?.frames ?? 0;
      const piece = new Container(await this.source.bytes(0, known));
      const loaded = new Loaded(0, new Reach(before === null ? piece : join(before, piece)));
      const follows = store.state.frame >= known - 1;
      panes[0].grow(loaded);
      timeline.load(loaded.reach);
      lists.load(0, loaded.reach, loaded.trials);
      header.describe(this.all[0]!, loaded.reach);
      this.#allowVerdict(loaded.reach);
      store.touch("reach", "frame");
      if (follows) this.views.seek(loaded.reach.frames - 1);
      this.views.wake();
    } catch (error) {
      explain(error);
    }
    return this.#loaded?.reach.frames ?? 0;
  }

  /** Shows the second reach of the state beside the first, or none. */
  async showBeside(): Promise<void> {
    const { state } = this.views.store;
    const { beside } = state;
    const pane = this.views.panes[1];
    if (beside === null || this.all[beside] === undefined) {
      if (beside !== null) explainNoReach(beside, this.all.length);
      this.views.store.set({ beside: null });
      pane.stage.remove();
      pane.skins.remove();
      pane.loaded = null;
    } else if (pane.loaded?.number !== beside) {
      try {
        const loaded = await this.#fetch(beside, pane);
        // A later choice has overtaken this one.
        if (state.beside !== beside) return;
        pane.load(loaded, nameOf(this.all[beside]!));
        find("panes").append(pane.stage);
        find("skins").append(pane.skins);
      } catch (error) {
        if (state.beside === beside) explain(error);
      }
    }
    document.body.classList.toggle("compared", pane.loaded !== null);
    this.views.everything();
  }

  /** Shows the ghost of the state, or none. */
  async showGhost(): Promise<void> {
    const loaded = this.#loaded;
    if (loaded === null) return;
    const { state } = this.views.store;
    const number = state.ghost;
    const ghost = await this.ghosts.load(loaded.reach);
    if (loaded !== this.#loaded || state.ghost !== number) return;
    this.views.panes[0].haunt(ghost);
    this.views.wake();
  }

  /** Goes where an address points. */
  follow(asked: Asked): void {
    const { store } = this.views;
    const number = asked.reach ?? store.state.reach;
    if (this.#loaded !== null) clear();
    if (this.all[number] === undefined) {
      explainNoReach(number, this.all.length);
      // The address of what is shown takes its place.
      store.touch("frame");
    } else if (number !== store.state.reach) void this.open(number, asked);
    else if (this.#loaded !== null) {
      store.set({ ...asked.state, playing: false, beside: asked.beside, ghost: asked.ghost, taxel: findTaxel(this.#loaded.reach, asked.taxel), object: asked.object });
      this.ghosts.offer(number);
      if (asked.time !== null) this.views.seek(this.#loaded.reach.frameNearest(asked.time));
    }
    this.views.wake();
  }

  /** The state in which a page begins. */
  static first(all: Summary[], asked: Asked): State {
    const reach = asked.reach !== null && asked.reach < all.length ? asked.reach : 0;
    return { reach, beside: null, ghost: null, frame: 0, playing: false, rate: 1, colour: "force", camera: "free", shadows: null, taxel: null, object: null, ...asked.state };
  }
}
