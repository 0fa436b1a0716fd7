// All views of the page: makes them, and keeps them at the same moment.

import type { Asked } from "./address.ts";
import { AddressBar } from "./addressbar.ts";
import { Palette } from "./colours.ts";
import { Details } from "./details.ts";
import { find, newtons, say, seconds } from "./dom.ts";
import { Header } from "./header.ts";
import { drawLegend } from "./legend.ts";
import { describe, Lists } from "./lists.ts";
import type { Mistake } from "./mistakes.ts";
import { Opening } from "./opening.ts";
import { Pace } from "./pace.ts";
import { type Loaded, Pane } from "./pane.ts";
import { Playback } from "./playback.ts";
import { Plots } from "./plots.ts";
import { plotsOf } from "./plotlist.ts";
import { followPrint } from "./print.ts";
import type { Source, Summary } from "./source.ts";
import { type State, Store } from "./state.ts";
import { Strips } from "./strips.ts";
import { Switches } from "./switches.ts";
import { Timeline } from "./timeline.ts";
import { Tour } from "./tour.ts";
import { type Actions, addTransport } from "./transport.ts";
import type { WorstMistake } from "./worst.ts";

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
  readonly #address: AddressBar;
  readonly #playback: Playback;
  readonly #tour: Tour;
  readonly #pace = new Pace();
  /** Loads reaches into the views. */
  readonly opening: Opening;
  #palette = new Palette();
  #dirty = true;
  #scheduled = false;

  constructor(source: Source, all: Summary[], asked: Asked) {
    this.#store = new Store(Opening.first(all, asked));
    const reach = () => this.#loaded?.reach ?? null;
    this.#playback = new Playback(this.#store, reach);
    const redraw = () => this.#wake(true);
    const picked = (hit: Pick<State, "taxel" | "object">) => this.#set(hit);
    this.#panes = [new Pane("Arm and objects", redraw, picked), new Pane("Second reach: arm and objects", redraw, null)];
    find("panes").append(this.#panes[0].stage);
    find("skins").append(this.#panes[0].skins);
    const seek = (frame: number) => this.#set(this.#playback.seek(frame));
    const seekTime = (time: number) => this.#loaded !== null && seek(this.#loaded.reach.frameAt(time));
    const open = (number: number) => void this.opening.open(number);
    this.#timeline = new Timeline(find("timeline"), find("timeline-key"), seek);
    this.#strips = new Strips(find("strips"), seekTime);
    this.#plots = new Plots(find("plots"), seekTime);
    this.#details = new Details(find("details"), seek, (object) => this.#set({ object }));
    this.#lists = new Lists(find("lists"), source, all, {
      open: (row) => open(row.number),
      trial: (trial) => {
        this.#set({ taxel: trial.taxel, object: trial.object < 0 ? null : trial.object, playing: false });
        seek(trial.first);
      },
      mistake: (mistake) => this.#follow(mistake),
      worst: (mistake) => this.#open(mistake),
    });
    this.#switches = new Switches((values) => this.#set(values));
    this.#header = new Header(all, {
      open,
      step: (reaches) => open(this.#store.state.reach + reaches),
      beside: (number) => this.#set({ beside: number }),
      themed: () => this.#everything(),
    });
    this.opening = new Opening(source, all, {
      store: this.#store, panes: this.#panes, timeline: this.#timeline, lists: this.#lists, header: this.#header, switches: this.#switches,
      seek, everything: () => this.#everything(), wake: redraw,
    });
    this.#address = new AddressBar(this.#store.state, reach, (asked) => this.opening.follow(asked));
    const actions = this.#actions(seek, open);
    this.#tour = new Tour(actions);
    addTransport(actions);
    this.#store.listen((changed) => this.#update(changed));
    this.#followSizes();
    followPrint(() => this.#everything(), () => {
      this.#store.flush();
      if (this.#loaded !== null) this.#draw();
      this.#panes.forEach((pane) => pane.print(this.#palette));
    });
  }

  get #loaded(): Loaded | null {
    return this.#panes[0].loaded;
  }

  /** The force at the end of the colour scale, N: one scale for both reaches. */
  get #largest(): number {
    return Math.max(...this.#panes.map(({ loaded }) => loaded?.largest ?? 0));
  }

  #set(values: Partial<State>): void {
    this.#store.set(values);
    this.#wake();
  }

  /** Goes to the beginning of the longest wrong run of a mistake, selects it, and shows why the model said so. */
  #follow({ taxel, object, run }: Mistake): void {
    this.#details.unfold();
    this.#set({ taxel, object: object < 0 ? null : object, playing: false, ...this.#playback.seek(run.first) });
  }

  /** Goes to a mistake of any reach, as to one of the reach that is shown. */
  #open({ reach, time, taxelAddress, object }: WorstMistake): void {
    const { beside, ghost } = this.#store.state;
    this.#details.unfold();
    this.opening.follow({ reach: reach.number, beside, ghost, time, taxel: taxelAddress, object: object < 0 ? null : object, state: {} });
  }

  #actions(seek: (frame: number) => void, open: (number: number) => void): Actions {
    return {
      seek,
      step: (frames) => {
        this.#set({ playing: false });
        seek(this.#store.state.frame + frames);
      },
      toggle: () => this.#set(this.#playback.toggle()),
      reach: (step) => open(this.#store.state.reach + step),
      loaded: () => this.#loaded,
      state: this.#store.state,
      set: (values) => this.#set(values),
      follow: (mistake) => this.#follow(mistake),
      endTour: () => this.#tour.end(),
    };
  }

  /** Draws anew when the room for the views changes. */
  #followSizes(): void {
    const main = find("main");
    let width = main.clientWidth;
    new ResizeObserver(() => {
      if (main.clientWidth === width) return;
      width = main.clientWidth;
      this.#everything();
    }).observe(main);
    const dock = find("transport");
    new ResizeObserver(() => document.documentElement.style.setProperty("--dock-height", `${dock.offsetHeight + 12}px`)).observe(dock);
  }

  /** The number of frames of the reach that is shown. */
  get frames(): number {
    return this.#loaded?.reach.frames ?? 0;
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
    this.#playback.advance(now);
    this.#store.flush();
    if (this.#dirty && this.#loaded !== null) this.#draw();
    if (this.#store.state.playing) this.#wake();
  }

  /** Draws the parts that depend on the frame. */
  #draw(): void {
    this.#dirty = false;
    const { state } = this.#store;
    const { reach } = this.#loaded!;
    const texts = this.#pace.follows;
    this.#panes[0].show(state.frame, state, this.#palette, this.#largest, true, texts);
    const second = this.#panes[1].loaded;
    if (second !== null) this.#panes[1].show(second.reach.frameAt(reach.time[state.frame]!), state, this.#palette, this.#largest, false, texts);
    for (const pane of this.#panes) if (pane.loaded !== null) pane.view?.render(state.playing);
    if (document.body.dataset["frame"] === undefined) performance.mark("drawn");
    document.body.dataset["frame"] = String(state.frame);
  }

  #update(changed: ReadonlySet<keyof State>): void {
    const loaded = this.#loaded;
    if (loaded === null) return;
    const { state } = this.#store;
    const { reach, trials, series } = loaded;
    const [palette, anew] = [this.#palette, changed.has("reach")];
    if (anew) this.#tour.shown(state.reach);
    if (changed.has("beside")) void this.opening.showBeside();
    if (anew || changed.has("ghost")) void this.opening.showGhost();
    this.#dirty = true;
    if (anew || changed.has("colour") || changed.has("ghost")) {
      drawLegend(find("legend"), reach, palette, state.colour, this.#largest, state.ghost === null ? null : this.opening.ghosts.name(state.ghost));
    }
    if (anew) this.#timeline.draw(reach, trials, palette);
    if (anew || changed.has("taxel")) {
      this.#strips.draw(reach, trials, palette, state.taxel);
      this.#plots.draw(plotsOf(reach, trials, series, state.taxel, this.#panes[1].loaded), palette);
    }
    this.#pace.decide(state, changed, this.#panes[0].view?.software === true);
    if (!this.#pace.follows) return;
    const time = reach.time[state.frame]!;
    const mistake = trials.mistakeAt(state);
    this.#timeline.show(reach, state.frame, mistake?.run ?? null);
    this.#strips.show(reach, state.frame, mistake?.run ?? null);
    this.#plots.show(state.frame);
    if (this.#pace.describes) {
      this.#details.show(reach, trials, state);
      const trial = state.taxel === null ? null : trials.at(state.taxel, state.frame);
      this.#lists.mark(trial, mistake);
      document.body.dataset["trial"] = trial === null ? "" : describe(trial, reach);
    }
    say(find("clock"), `${seconds(time)} of ${seconds(reach.duration)} · frame ${state.frame} · largest taxel ${newtons(series.largest[state.frame]!)}`);
    say(find("play"), state.playing ? "Pause" : "Play");
    this.#switches.show(state, this.#panes[0].view?.software === true);
    find<HTMLSelectElement>("rate").value = String(state.rate);
    this.#header.show(state);
    this.#address.write();
  }

  /** For tests, and for scripts of a reader. */
  get inspect() {
    return { state: this.#store.state, loaded: () => this.#loaded, drawn: () => this.#panes[0].view?.drawn ?? null, maps: () => this.#panes[0].maps };
  }
}
