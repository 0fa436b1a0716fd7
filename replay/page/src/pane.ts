// One reach on the screen: its 3-D view and its skin maps. Two panes stand side by side when reaches are compared.

import { type Palette } from "./colours.ts";
import { element, newtons, say } from "./dom.ts";
import { judge } from "./judgement.ts";
import type { Reach } from "./reach.ts";
import { SkinMap, type TaxelLook } from "./skinmap.ts";
import type { ColourBy, State } from "./state.ts";
import { Trials } from "./trials.ts";
import { type Hit, View3D } from "./view/view3d.ts";
import { type Series, seriesOf } from "./series.ts";

const QUIET: TaxelLook = { colour: null, mark: null, stray: false, over: false, wrong: false };

/** A loaded reach with what is computed from it. */
export class Loaded {
  readonly trials: Trials;
  readonly series: Series;
  /** The force at the end of the colour scale, N. */
  readonly largest: number;

  constructor(readonly number: number, readonly reach: Reach) {
    this.trials = new Trials(reach);
    this.series = seriesOf(reach);
    this.largest = this.series.largest.reduce((most, force) => Math.max(most, force), reach.header.force_limit_n ?? 1);
  }
}

export class Pane {
  readonly stage = element("div", { class: "pane" });
  readonly skins = element("div", { class: "skins" });
  readonly #title = element("p", { class: "pane-title" });
  readonly #under = element("output", { class: "under" });
  view: View3D | null = null;
  loaded: Loaded | null = null;
  maps: SkinMap[] = [];
  #ghost: Reach | null = null;
  #hovered: number | null = null;
  #looks: ((taxel: number) => TaxelLook) | null = null;

  /** `picked` hears what a reader chooses; it is null if nothing can be chosen here. */
  constructor(readonly name: string, readonly redraw: () => void, readonly picked: ((hit: Hit) => void) | null) {
    this.stage.append(this.#title);
  }

  /** Makes the 3-D view if it is not there yet, or says why there is none. */
  makeView(): void {
    if (this.stage.childElementCount > 1) return;
    try {
      this.view = new View3D(this.name, this.redraw, this.picked ?? (() => undefined));
      this.stage.append(this.view.box);
    } catch {
      const text = "This browser cannot draw in 3-D (WebGL is missing or switched off). The maps of the skin, the strips and the plots work without it.";
      this.stage.append(element("p", { class: "no-webgl", role: "status" }, text));
    }
  }

  load(loaded: Loaded, title: string): void {
    this.loaded = loaded;
    say(this.#title, title);
    this.makeView();
    this.#ghost = null;
    this.view?.load(loaded.reach);
    this.#hovered = null;
    this.maps = loaded.reach.header.patches.map((_, patch) => {
      const point = (taxel: number | null) => {
        if (taxel === this.#hovered) return;
        this.#hovered = taxel;
        this.redraw();
      };
      const { picked } = this;
      return new SkinMap(loaded.reach, patch, point, picked === null ? null : (taxel) => picked({ taxel, object: null }), this.redraw);
    });
    this.skins.replaceChildren(...this.maps.map((map) => map.box), this.#under);
    if (this.maps.length === 0) this.skins.replaceChildren(element("p", { class: "key" }, "This arm has no skin."));
  }

  /** Shows the same reach with more frames. */
  grow(loaded: Loaded): void {
    this.loaded = loaded;
    this.view?.load(loaded.reach, true);
  }

  /** Shows the arm of another reach, too, or of none. */
  haunt(reach: Reach | null): void {
    if (this.#ghost === reach) return;
    this.#ghost = reach;
    this.view?.haunt(reach);
  }

  /** How each taxel looks in a frame, with `largest`, N, at the end of the colour scale; worked out once a frame. */
  looks(frame: number, colour: ColourBy, palette: Palette, largest: number): (taxel: number) => TaxelLook {
    const { reach, trials } = this.loaded!;
    const found = new Map<number, TaxelLook>();
    const limit = reach.header.force_limit_n ?? Number.POSITIVE_INFINITY;
    const threshold = reach.header.threshold_n;
    for (let row = reach.readingStart[frame]!; row < reach.readingStart[frame + 1]!; row++) {
      const taxel = reach.readingTaxel[row]!;
      const [sensed, truth] = [reach.sensed[row]!, reach.category(reach.readingObject[row]!)];
      const over = sensed > limit;
      const stray = truth === "spurious";
      if (colour === "force") {
        if (sensed > 0) found.set(taxel, { colour: palette.forceText(sensed / largest), mark: null, stray, over, wrong: false });
      } else if (colour === "truth") {
        if (sensed > threshold || !stray) found.set(taxel, { colour: palette.category(truth), mark: truth, stray, over, wrong: false });
      } else {
        const verdict = trials.verdict(taxel, frame);
        if (verdict === null) continue;
        const judgement = judge(truth, verdict.name, reach.header.verdicts!);
        const wrong = judgement === "wrong" || judgement === "uncertain";
        found.set(taxel, { colour: palette.category(verdict.name), mark: verdict.name, stray, over, wrong });
      }
    }
    return (taxel) => found.get(taxel) ?? QUIET;
  }

  /** Draws everything for a frame of this pane's reach; `texts` brings the texts up to date, too. */
  show(frame: number, state: State, palette: Palette, largest: number, own: boolean, texts: boolean): void {
    if (this.loaded === null) return;
    this.#looks = this.looks(frame, state.colour, palette, largest);
    const [taxel, object] = own ? [state.taxel, state.object] : [null, null];
    const quiet = palette.variable("plate");
    const looks = this.#looks;
    this.view?.show(frame, { palette, camera: state.camera, shadows: state.shadows, taxel, object, texts, colourOf: (at) => looks(at).colour ?? quiet });
    for (const map of this.maps) map.draw(palette, looks, taxel, this.#hovered);
    if (texts) this.#say(frame, taxel);
  }

  /** Puts the 3-D picture into the page as an image, because printers get no WebGL. */
  print(palette: Palette): void {
    if (this.view === null || this.loaded === null) return;
    this.view.box.querySelector("img")?.remove();
    this.view.box.append(element("img", { src: this.view.picture(palette), alt: "The arm and the objects at this moment", class: "print" }));
  }

  /** Says what the taxel under the pointer, or the chosen one, feels. */
  #say(frame: number, chosen: number | null): void {
    const { reach, trials } = this.loaded!;
    const taxel = this.#hovered ?? chosen;
    if (taxel === null) {
      say(this.#under, "Point at a taxel to read it.");
      return;
    }
    const row = reach.reading(taxel, frame);
    const verdict = trials.verdict(taxel, frame);
    const said = verdict === null ? "" : `, verdict ${verdict.name}`;
    const force = row < 0 ? "no force" : `${newtons(reach.sensed[row]!)} sensed, ${this.#cause(row)}${said}`;
    say(this.#under, `${reach.taxelName(taxel)}: ${force}`);
  }

  /** The true force and its object; of a log the category, if it is known. */
  #cause(row: number): string {
    const { reach } = this.loaded!;
    const object = reach.readingObject[row]!;
    if (reach.isLog) return object < 0 ? "labelled nothing, or not at all" : reach.category(object);
    const truth = `${newtons(reach.trueForce[row]!)} true, `;
    return truth + (object < 0 ? "spurious: no object presses" : reach.objectName(object));
  }
}
