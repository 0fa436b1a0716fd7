// What is known about the chosen taxel or object at the moment.

import { element, newtons, plural, seconds, short } from "./dom.ts";
import type { Reach } from "./reach.ts";
import { pushesAt } from "./series.ts";
import type { State } from "./state.ts";
import type { Trial } from "./trial.ts";
import type { Trials } from "./trials.ts";
import { UsualFeatures } from "./usual.ts";

type Row = [string, string | Node];

/** A number with a unit taken from the end of its name, such as height_m. */
function parameter(name: string, value: number): Row {
  const units: [RegExp, string][] = [
    [/_n_m2$/, "N m²"], [/_kg_per_m2$/, "kg/m²"], [/_kg_per_m3$/, "kg/m³"], [/_nm_per_rad$/, "N m/rad"], [/_n_per_m$/, "N/m"], [/_nm$/, "N m"], [/_n$/, "N"], [/_pa$/, "Pa"],
    [/_deg$/, "°"], [/_kg$/, "kg"], [/_rad$/, "rad"], [/_m$/, "m"], [/_s$/, "s"],
  ];
  const [ending, unit] = units.find(([ending]) => ending.test(name)) ?? [/$^/, ""];
  return [name.replace(ending, "").replace(/_/g, " "), `${short(value)} ${unit}`.trim()];
}

/** Weaker forces would be shown as 0.00 N. */
const LEAST_N = 0.005;

export class Details {
  /** Whether the features of a region are unfolded. */
  #featuresOpen = false;
  #reach: Reach | null = null;
  #usual: UsualFeatures | null = null;

  constructor(readonly box: HTMLElement, readonly seek: (frame: number) => void, readonly selectObject: (object: number) => void) {}

  /** Unfolds the features of a region when a region is shown next. */
  unfold(): void {
    this.#featuresOpen = true;
  }

  show(reach: Reach, trials: Trials, state: State): void {
    const parts: Node[] = [];
    if (state.taxel !== null) parts.push(...this.#taxel(reach, trials, state.taxel, state.frame));
    if (state.object !== null) parts.push(...this.#object(reach, state.object));
    if (parts.length === 0) {
      parts.push(element("p", { class: "key" }, "Click a taxel on the arm or on the map, or an object, to see its contact, trial, features and scores here."));
    }
    if (!reach.isLog) parts.push(...this.#touching(reach, state.frame));
    // What has not changed stays, so that the pointer and the keyboard do not lose it while the reach plays.
    const now = element("div", {}, ...parts);
    if (reach === this.#reach && now.innerHTML === this.box.innerHTML) return;
    this.#reach = reach;
    this.box.replaceChildren(...now.childNodes);
  }

  /** What presses on the skin at the moment: the arrows as text. */
  #touching(reach: Reach, frame: number): Node[] {
    const pushes = pushesAt(reach, frame).map((push) => ({ ...push, size: Math.hypot(...push.force) })).filter(({ size }) => size >= LEAST_N);
    const limit = reach.header.force_limit_n ?? Number.POSITIVE_INFINITY;
    const lines = pushes.sort((a, b) => b.size - a.size).map(({ object, patch, size, largest }) => {
      const link = element("button", { type: "button", class: "link" }, reach.objectName(object));
      link.addEventListener("click", () => this.selectObject(object));
      const over = largest > limit ? ` (above the limit of ${short(limit)} N)` : "";
      return element("li", {}, link, ` on ${reach.header.patches[patch]!.name}: ${newtons(size)}, largest taxel ${newtons(largest)}${over}`);
    });
    const none = element("p", { class: "key" }, "Nothing presses on the skin.");
    return [element("h3", {}, "Pressing now"), lines.length === 0 ? none : element("ul", { class: "contacts" }, ...lines)];
  }

  #rows(rows: Row[]): HTMLElement {
    return element("dl", {}, ...rows.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
  }

  #jump(frame: number, text: string): HTMLElement {
    const link = element("button", { type: "button", class: "link" }, text);
    link.addEventListener("click", () => this.seek(frame));
    return link;
  }

  #taxel(reach: Reach, trials: Trials, taxel: number, frame: number): Node[] {
    const row = reach.reading(taxel, frame);
    const object = row < 0 ? -1 : reach.readingObject[row]!;
    const shear = row < 0 ? 0 : Math.hypot(reach.shear[2 * row]!, reach.shear[2 * row + 1]!);
    const sensed: Row = ["sensed force", newtons(row < 0 ? 0 : reach.sensed[row]!)];
    const area: Row = ["area", `${(1e4 * reach.taxelArea[taxel]!).toFixed(2)} cm²`];
    const rows: Row[] = reach.isLog ? [sensed, ...(reach.isTable ? [] : [area])] : [
      sensed,
      ["true normal force", newtons(row < 0 ? 0 : reach.trueForce[row]!)],
      ["true shear force", newtons(shear)],
      ["pressed by", object < 0 ? "nothing" : `${reach.objectName(object)} (${reach.category(object)})`],
      area,
    ];
    const trial = trials.at(taxel, frame);
    const nodes: Node[] = [element("h3", {}, reach.taxelName(taxel)), this.#rows(rows)];
    if (trial !== null) nodes.push(element("h4", {}, `Trial ${trial.index}`), this.#rows(this.#trial(reach, trials, trial, frame)));
    nodes.push(...this.#region(reach, trials, taxel, frame));
    nodes.push(this.#others(reach, trials.of(taxel), trial));
    return nodes;
  }

  #trial(reach: Reach, trials: Trials, trial: Trial, frame: number): Row[] {
    const sample = trial.sample + frame - trial.first;
    const rows: Row[] = [
      ["from, to", element("span", {}, this.#jump(trial.first, seconds(reach.time[trial.first]!)), " – ", this.#jump(trial.last, seconds(reach.time[trial.last]!)))],
      ["truth of the trial", trial.truth],
      ["peak", this.#jump(trial.peakFrame, newtons(trial.peak))],
    ];
    if (!reach.isTable) rows.push(["contact motion so far", `${(1000 * trials.motion[sample]!).toFixed(1)} mm`]);
    if (trials.regionTaxels[sample]! > 0) {
      rows.push(["contact region", `${plural(trials.regionTaxels[sample]!, "taxel")}, ${newtons(trials.regionForce[sample]!)}`]);
    }
    const verdict = trials.verdict(trial.taxel, frame);
    const header = reach.header.verdicts;
    if (verdict === null || header === null) return rows;
    rows.push(["verdict now", `${verdict.name} after ${plural(verdict.samples, "sample")}`], ["verdict of the trial", `${trial.verdict} (${trial.judgement})`]);
    const scores = header.scores.map((name, index) => ({ name, score: trials.verdictScore[verdict.row * header.scores.length + index]! }));
    if (header.touch !== null) return [...rows, ...scores.map(({ name, score }): Row => [`probability of ${name}`, score.toFixed(3)])];
    for (const { name, score } of scores) rows.push([`score of ${name}`, `${score.toFixed(2)} nats`]);
    const [best, second] = scores.map(({ score }) => score).sort((a, b) => b - a);
    if (best !== undefined && second !== undefined) rows.push(["margin", `${(best - second).toFixed(2)} nats`]);
    return rows;
  }

  /** The contact region of a taxel as a touch model sees it. */
  #region(reach: Reach, trials: Trials, taxel: number, frame: number): Node[] {
    const header = reach.header.verdicts;
    const verdict = trials.verdict(taxel, frame);
    const region = verdict === null ? null : trials.region(verdict.row, frame);
    if (header === null || header.touch === null || region === null) return [];
    const { unknown_share: share } = header.touch;
    const rows: Row[] = [
      ["verdict on the region", `${region.verdict} after ${plural(region.samples, "sample")}`],
      ["taxels", `${region.taxels}, of which ${region.touchedTaxels} are not called nothing`],
      [
        "known objects as unusual",
        `${(100 * region.shareBeyond).toFixed(1)} % (unknown at ${short(100 * share)} % or less, in its first 0.6 s at a fifth of that)`,
      ],
    ];
    // The truth of the region is that of this taxel.
    const reading = reach.reading(taxel, frame);
    const truth = reading < 0 ? null : reach.category(reach.readingObject[reading]!);
    if (this.#usual?.reach !== reach) this.#usual = new UsualFeatures(reach, trials);
    const usual = truth === null ? null : this.#usual.of(truth);
    const features = header.features.map((name, index): Row => {
      const value = region.features[index]!;
      const [low, high] = usual?.[index] ?? [-Infinity, Infinity];
      if (value >= low && value <= high) return [name, value.toFixed(2)];
      return [name, element("strong", {}, `${value.toFixed(2)} ${value > high ? "▲" : "▼"} ${low.toFixed(2)} to ${high.toFixed(2)}`)];
    });
    const key = `▲ and ▼: above and below the middle 80 % of the regions of this reach that are truly ${truth}. These may have decided.`;
    const more = element(
      "details",
      { class: "features", open: this.#featuresOpen },
      element("summary", {}, "Features that the model sees (logarithmic scales)"),
      usual === null ? "" : element("p", { class: "key" }, key),
      this.#rows(features),
    );
    more.addEventListener("toggle", () => (this.#featuresOpen = more.open));
    return [element("h4", {}, `Contact region ${region.contact}`), this.#rows(rows), more];
  }

  #others(reach: Reach, trials: Trial[], current: Trial | null): Node {
    if (trials.length === 0) return element("p", { class: "key" }, "This taxel is never in contact in this reach.");
    const links = trials.slice(0, 24).flatMap((trial) => {
      const link = this.#jump(trial.first, seconds(reach.time[trial.first]!));
      if (trial === current) link.setAttribute("aria-current", "true");
      return [link, " "];
    });
    const more = trials.length > 24 ? `and ${trials.length - 24} more` : "";
    return element("p", { class: "key" }, `${plural(trials.length, "contact")} of this taxel: `, ...links, more);
  }

  #object(reach: Reach, object: number): Node[] {
    const found = reach.header.objects[object];
    if (found === undefined) return [];
    const contacts = reach.header.contacts.filter((contact) => contact.object === object);
    const peak = contacts.reduce((largest, contact) => Math.max(largest, contact.peak_force_n), 0);
    const rows: Row[] = reach.isLog ? [["category", reach.category(object)]] : [
      ["category", reach.category(object)],
      ["foot", `(${found.position_world.map((value) => value.toFixed(2)).join(", ")}) m`],
      ["contacts", contacts.length === 0 ? "none" : `${contacts.length}, peak ${newtons(peak)}`],
      ...Object.entries(found.parameters).map(([name, value]) => parameter(name, value)),
    ];
    const list = contacts.slice(0, 12).map((contact) => {
      const where = contact.patch === null ? `${contact.link}, no skin` : reach.header.patches[contact.patch]!.name;
      const link = this.#jump(contact.first_frame, seconds(reach.time[contact.first_frame]!));
      return element("li", {}, link, ` ${where}, peak ${newtons(contact.peak_force_n)}`);
    });
    const more = contacts.length > 12 ? [element("li", {}, `and ${contacts.length - 12} more`)] : [];
    return [element("h3", {}, reach.objectName(object)), this.#rows(rows), element("ul", { class: "contacts" }, ...list, ...more)];
  }
}
