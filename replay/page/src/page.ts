// All views of the page: loads a reach and keeps all views at the same moment.

import { type Asked, findTaxel, readAddress, writeAddress } from "./address.ts";
import { Palette } from "./colours.ts";
import { Container } from "./container.ts";
import { Details } from "./details.ts";
import { find, newtons, say, seconds } from "./dom.ts";
import { join } from "./grow.ts";
import { Header, nameOf } from "./header.ts";
import { drawLegend } from "./legend.ts";
import { describe, Lists } from "./lists.ts";
import { explain } from "./message.ts";
import { Loaded, Pane } from "./pane.ts";
import { Plots } from "./plots.ts";
import { plotsOf } from "./plotlist.ts";
import { followPrint } from "./print.ts";
import { Reach } from "./reach.ts";
import type { Source, Summary } from "./source.ts";
import { type State, Store } from "./state.ts";
import { Strips } from "./strips.ts";
import { Switches } from "./switches.ts";
import { Timeline } from "./timeline.ts";
import { type Actions, addTransport } from "./transport.ts";

/** The address changes at most this often, ms; browsers refuse more than 200 changes in 30 s. */
const ADDRESS_MS = 400;
/** While a reach plays, the selection is described this often, ms: nobody reads faster. */
const DETAILS_MS = 200;
/** While a reach plays, everything but the 3-D view and the maps follows this often where the processor draws, ms. */
const SOFTWARE_MS = 100;

export class Page {
  readonly #store: Store;
  readonly #panes: [Pane, Pane];
  readonly #timeline: Timeline;
  readonly #strips: Strips;
  readonly #plots: Plots;
  readonly #details: Details;
  readonly #lists: Lists;
  readonly #header: Header;
  readonly #switches: Switches;
  #palette = new Palette();
  #request = 0;
  #dirty = true;
  #scheduled = false;
  #clock = { time: 0, at: 0 };
  #addressTimer = 0;
  #described = 0;
  #followed = 0;
  /** Whether texts, lines at the current time and the scrubber follow in this frame. */
  #follows = true;

  constructor(readonly source: Source, readonly all: Summary[], asked: Asked) {
    const reach = asked.reach !== null && asked.reach < all.length ? asked.reach : 0;
    const state: State = { reach, beside: null, frame: 0, playing: false, rate: 1, colour: "force", camera: "free", taxel: null, object: null, ...asked.state };
    this.#store = new Store(state);
    const redraw = () => this.#wake(true);
    const picked = (hit: Pick<State, "taxel" | "object">) => this.#set(hit);
    this.#panes = [new Pane("Arm and objects", redraw, picked), new Pane("Second reach: arm and objects", redraw, () => undefined)];
    find("panes").append(this.#panes[0].stage);
    find("skins").append(this.#panes[0].skins);
    const seekTime = (time: number) => this.#loaded !== null && this.seek(this.#loaded.reach.frameAt(time));
    this.#timeline = new Timeline(find("timeline"), find("timeline-key"), (frame) => this.seek(frame));
    this.#strips = new Strips(find("strips"), seekTime);
    this.#plots = new Plots(find("plots"), seekTime);
    this.#details = new Details(find("details"), (frame) => this.seek(frame), (object) => this.#set({ object }));
    this.#lists = new Lists(find("lists"), all, (row) => this.open(row.number), (trial) => {
      this.#set({ taxel: trial.taxel, object: trial.object < 0 ? null : trial.object, playing: false });
      this.seek(trial.first);
    });
    this.#switches = new Switches((values) => this.#set(values));
    this.#header = new Header(all, {
      open: (number) => void this.open(number),
      step: (reaches) => void this.open(this.#store.state.reach + reaches),
      beside: (number) => this.#set({ beside: number }),
      themed: () => this.#everything(),
    });
    addTransport(this.#actions());
    this.#store.listen((changed) => this.#update(changed));
    addEventListener("hashchange", () => this.#follow(readAddress(location.hash)));
    let width = 0;
    new ResizeObserver(() => {
      if (find("main").clientWidth === width) return;
      width = find("main").clientWidth;
      this.#everything();
    }).observe(find("main"));
    const dock = find("transport");
    new ResizeObserver(() => document.documentElement.style.setProperty("--dock-height", `${dock.offsetHeight + 12}px`)).observe(dock);
    followPrint(() => this.#everything(), () => {
      this.#store.flush();
      if (this.#loaded !== null) this.#draw();
      this.#panes.forEach((pane) => pane.print(this.#palette));
    });
  }

  get #loaded(): Loaded | null {
    return this.#panes[0].loaded;
  }

  #set(values: Partial<State>): void {
    this.#store.set(values);
    this.#wake();
  }

  seek(frame: number): void {
    const last = (this.#loaded?.reach.frames ?? 1) - 1;
    this.#clock.time = this.#loaded?.reach.time[Math.min(Math.max(frame, 0), last)] ?? 0;
    this.#set({ frame: Math.min(Math.max(frame, 0), last) });
  }

  #actions(): Actions {
    return {
      seek: (frame) => this.seek(frame),
      step: (frames) => {
        this.#set({ playing: false });
        this.seek(this.#store.state.frame + frames);
      },
      toggle: () => {
        const { playing, frame } = this.#store.state;
        if (!playing && this.#loaded !== null && frame === this.#loaded.reach.frames - 1) this.seek(0);
        this.#clock.at = performance.now();
        this.#set({ playing: !playing });
      },
      reach: (step) => this.open(this.#store.state.reach + step),
      loaded: () => this.#loaded,
      store: {
        state: this.#store.state,
        set: (values: Partial<State>) => this.#set(values),
      } as Store,
    };
  }

  async #fetch(number: number): Promise<Loaded> {
    return new Loaded(number, new Reach(new Container(await this.source.bytes(number))));
  }

  /** Loads a reach by its number and shows it, at the time and with the selection of an address if there is one. */
  async open(number: number, asked: Asked | null = null): Promise<void> {
    const summary = this.all[number];
    if (summary === undefined) return;
    const request = ++this.#request;
    try {
      const loaded = await this.#fetch(number);
      // A later choice has overtaken this one.
      if (request !== this.#request) return;
      const { reach } = loaded;
      find("message").hidden = true;
      this.#panes[0].load(loaded, nameOf(summary));
      this.#timeline.load(reach);
      this.#lists.load(number, reach, loaded.trials);
      const judged = this.#allowVerdict(reach);
      const colour = judged || this.#store.state.colour !== "verdict" ? this.#store.state.colour : "truth";
      const object = asked?.object ?? null;
      this.#store.set({ reach: number, playing: false, colour, taxel: findTaxel(reach, asked?.taxel ?? null), object: reach.header.objects[object ?? -1] === undefined ? null : object });
      this.#header.describe(summary, reach);
      this.seek(reach.frameAt(asked?.time ?? 0));
      this.#store.touch("reach", "frame");
      this.#wake(true);
      delete document.body.dataset["failed"];
      document.body.dataset["ready"] = String(number);
    } catch (error) {
      explain(error);
    }
  }

  /** Whether there are verdicts. Without them nothing leads to them. */
  #allowVerdict({ header }: Reach): boolean {
    const judged = header.verdicts !== null;
    this.#switches.allowVerdict(judged);
    find("jump-mistake").hidden = !judged;
    return judged;
  }

  /** The number of frames of the reach that is shown. */
  get frames(): number {
    return this.#loaded?.reach.frames ?? 0;
  }

  /** Loads what is new of a reach that runs, and gives the number of its frames. Who looks at its last frame goes on doing so. */
  async grow(ended: boolean): Promise<number> {
    try {
      if (ended) this.all.splice(0, 1, ...(await this.source.list()));
      const before = this.#loaded?.reach ?? null;
      const known = before?.frames ?? 0;
      const piece = new Container(await this.source.bytes(0, known));
      const loaded = new Loaded(0, new Reach(before === null ? piece : join(before, piece)));
      const follows = this.#store.state.frame >= known - 1;
      this.#panes[0].grow(loaded);
      this.#timeline.load(loaded.reach);
      this.#lists.load(0, loaded.reach, loaded.trials);
      this.#header.describe(this.all[0]!, loaded.reach);
      this.#allowVerdict(loaded.reach);
      this.#store.touch("reach", "frame");
      if (follows) this.seek(loaded.reach.frames - 1);
      this.#wake(true);
    } catch (error) {
      explain(error);
    }
    return this.frames;
  }

  /** Shows a second reach beside the first. */
  compare(number: number): void {
    this.#set({ beside: number });
  }

  async #showBeside(): Promise<void> {
    const { beside } = this.#store.state;
    const pane = this.#panes[1];
    if (beside === null || this.all[beside] === undefined) {
      pane.stage.remove();
      pane.skins.remove();
      pane.loaded = null;
    } else if (pane.loaded?.number !== beside) {
      try {
        pane.load(await this.#fetch(beside), nameOf(this.all[beside]!));
        find("panes").append(pane.stage);
        find("skins").append(pane.skins);
      } catch (error) {
        explain(error);
      }
    }
    document.body.classList.toggle("compared", pane.loaded !== null);
    this.#everything();
  }

  /** Goes where an address points. */
  #follow(asked: Asked): void {
    const { state } = this.#store;
    this.#set({ ...asked.state, beside: asked.beside });
    const number = asked.reach ?? state.reach;
    if (number !== state.reach) void this.open(number, asked);
    else if (this.#loaded !== null) {
      this.#set({ taxel: findTaxel(this.#loaded.reach, asked.taxel), object: asked.object });
      if (asked.time !== null) this.seek(this.#loaded.reach.frameAt(asked.time));
    }
  }

  #everything(): void {
    this.#palette = new Palette();
    this.#store.touch("reach", "frame", "taxel", "colour");
    this.#wake(true);
  }

  /** Draws at the next animation frame. */
  #wake(dirty = false): void {
    this.#dirty ||= dirty;
    if (this.#scheduled) return;
    this.#scheduled = true;
    requestAnimationFrame((now) => this.#tick(now));
  }

  #tick(now: number): void {
    this.#scheduled = false;
    const { state } = this.#store;
    if (state.playing && this.#loaded !== null) {
      const { reach } = this.#loaded;
      this.#clock.time += (Math.min(now - this.#clock.at, 250) / 1000) * state.rate;
      this.#clock.at = now;
      this.#store.set({ frame: reach.frameAt(this.#clock.time), playing: this.#clock.time < reach.duration });
    }
    this.#store.flush();
    if (this.#dirty && this.#loaded !== null) this.#draw();
    if (this.#store.state.playing) this.#wake();
  }

  /** Draws the parts that depend on the frame. */
  #draw(): void {
    this.#dirty = false;
    const { state } = this.#store;
    const { reach } = this.#loaded!;
    this.#panes[0].show(state.frame, state, this.#palette, true, this.#follows);
    const second = this.#panes[1].loaded;
    if (second !== null) this.#panes[1].show(second.reach.frameAt(reach.time[state.frame]!), state, this.#palette, false, this.#follows);
    for (const pane of this.#panes) if (pane.loaded !== null) pane.view?.render(state.playing);
    document.body.dataset["frame"] = String(state.frame);
  }

  #update(changed: ReadonlySet<keyof State>): void {
    const loaded = this.#loaded;
    if (loaded === null) return;
    const { state } = this.#store;
    const { reach, trials, series } = loaded;
    const [palette, anew] = [this.#palette, changed.has("reach")];
    if (changed.has("beside")) void this.#showBeside();
    this.#dirty = true;
    if (anew || changed.has("colour")) drawLegend(find("legend"), reach, palette, state.colour, loaded.largest);
    if (anew) this.#timeline.draw(reach, trials, palette);
    if (anew || changed.has("taxel")) {
      this.#strips.draw(reach, trials, palette, state.taxel);
      this.#plots.draw(plotsOf(reach, trials, series, state.taxel, this.#panes[1].loaded), palette);
    }
    const now = performance.now();
    const playsOn = state.playing && changed.size === 1 && changed.has("frame");
    const every = this.#panes[0].view?.software === true ? SOFTWARE_MS : 0;
    this.#follows = !playsOn || now - this.#followed >= every;
    if (!this.#follows) return;
    this.#followed = now;
    const time = reach.time[state.frame]!;
    this.#timeline.show(reach, state.frame);
    this.#strips.show(time);
    this.#plots.show(state.frame);
    if (!state.playing || anew || now - this.#described > DETAILS_MS) {
      this.#described = now;
      this.#details.show(reach, trials, state);
      const trial = state.taxel === null ? null : trials.at(state.taxel, state.frame);
      this.#lists.mark(trial);
      document.body.dataset["trial"] = trial === null ? "" : describe(trial, reach);
    }
    say(find("clock"), `${seconds(time)} of ${seconds(reach.duration)} · frame ${state.frame} · ${newtons(series.largest[state.frame]!)}`);
    say(find("play"), state.playing ? "Pause" : "Play");
    this.#switches.show(state);
    find<HTMLSelectElement>("rate").value = String(state.rate);
    this.#header.show(state);
    this.#writeAddress();
  }

  #writeAddress(): void {
    if (this.#addressTimer !== 0) return;
    this.#addressTimer = window.setTimeout(() => {
      this.#addressTimer = 0;
      if (this.#loaded !== null) history.replaceState(null, "", writeAddress(this.#store.state, this.#loaded.reach));
    }, ADDRESS_MS);
  }

  /** For tests, and for scripts of a reader. */
  get inspect() {
    return { state: this.#store.state, loaded: () => this.#loaded, drawn: () => this.#panes[0].view?.drawn ?? null, maps: () => this.#panes[0].maps };
  }
}
