// Play, steps, rates, jumps and their keys.

import { button, element, find } from "./dom.ts";
import type { Mistake } from "./mistakes.ts";
import type { Loaded } from "./pane.ts";
import { NO_OBJECT } from "./reach.ts";
import { CAMERAS, COLOURS, RATES, type State } from "./state.ts";

/** What the keys and buttons do; page.ts gives it. */
export interface Actions {
  seek(frame: number): void;
  step(frames: number): void;
  toggle(): void;
  reach(step: number): void;
  loaded(): Loaded | null;
  state: Readonly<State>;
  set(values: Partial<State>): void;
  follow(mistake: Mistake): void;
  /** Ends the tour, and says whether there was one. */
  endTour(): boolean;
}

type Jump = "contact" | "mistake" | "peak" | "goal";

interface Target {
  frame: number;
  taxel: number | null;
  mistake?: Mistake;
}

/** The frames that a jump can go to, in order. */
function targets(loaded: Loaded, jump: Jump): Target[] {
  const { reach, trials } = loaded;
  const plain = (frame: number) => ({ frame, taxel: null });
  if (jump === "contact") return [...new Set(reach.header.contacts.map((contact) => contact.first_frame))].sort((a, b) => a - b).map(plain);
  if (jump === "goal") return reach.header.goals.map((goal) => plain(reach.frameAt(goal.start_time_s)));
  if (jump === "mistake") return trials.mistakes.map((mistake) => ({ frame: mistake.run.first, taxel: mistake.taxel, mistake })).sort((a, b) => a.frame - b.frame);
  const peaks = trials.all.filter((trial) => trial.peak > 0.5 * loaded.largest).map((trial) => ({ frame: trial.peakFrame, taxel: trial.taxel }));
  const best = loaded.series.largest.reduce((most, force, frame, all) => (force > all[most]! ? frame : most), 0);
  const all: Target[] = peaks.some(({ frame }) => frame === best) ? peaks : [...peaks, plain(best)];
  return all.sort((a, b) => a.frame - b.frame);
}

/** Whether the page stands at a target: at its frame, with its selection. */
function isAt({ frame, taxel, object }: State, target: Target): boolean {
  if (target.frame !== frame || (target.taxel !== null && target.taxel !== taxel)) return false;
  return target.mistake === undefined || target.mistake.object === (object ?? NO_OBJECT);
}

function go(actions: Actions, jump: Jump, forward: boolean): void {
  const loaded = actions.loaded();
  if (loaded === null) return;
  const { frame } = actions.state;
  const all = targets(loaded, jump);
  // Several can be in one frame.
  const here = all.findIndex((target) => isAt(actions.state, target));
  const near = forward ? all.find((target) => target.frame >= frame) : all.findLast((target) => target.frame < frame);
  const next = here < 0 ? near : all[here + (forward ? 1 : -1)];
  if (next === undefined) return;
  if (next.mistake !== undefined) return actions.follow(next.mistake);
  actions.set({ playing: false });
  if (next.taxel !== null) actions.set({ taxel: next.taxel });
  actions.seek(next.frame);
}

interface Key {
  keys: string[];
  shown: string;
  text: string;
  act: (actions: Actions, shift: boolean) => void;
}

const KEYS: Key[] = [
  { keys: [" ", "k"], shown: "Space", text: "play or pause", act: (actions) => actions.toggle() },
  { keys: ["ArrowLeft"], shown: "← →", text: "one frame back or forward; with Shift ten frames", act: (actions, shift) => actions.step(shift ? -10 : -1) },
  { keys: ["ArrowRight"], shown: "", text: "", act: (actions, shift) => actions.step(shift ? 10 : 1) },
  { keys: ["Home"], shown: "Home, End", text: "first or last frame", act: (actions) => actions.seek(0) },
  { keys: ["End"], shown: "", text: "", act: (actions) => actions.seek(Number.MAX_SAFE_INTEGER) },
  { keys: ["c", "C"], shown: "C", text: "next contact; with Shift the previous one", act: (actions, shift) => go(actions, "contact", !shift) },
  { keys: ["m", "M"], shown: "M", text: "next mistake; with Shift the previous one", act: (actions, shift) => go(actions, "mistake", !shift) },
  { keys: ["p", "P"], shown: "P", text: "next force peak; with Shift the previous one", act: (actions, shift) => go(actions, "peak", !shift) },
  { keys: ["g", "G"], shown: "G", text: "next goal; with Shift the previous one", act: (actions, shift) => go(actions, "goal", !shift) },
  { keys: [",", "<"], shown: ", .", text: "slower or faster", act: (actions) => rate(actions, -1) },
  { keys: [".", ">"], shown: "", text: "", act: (actions) => rate(actions, 1) },
  { keys: ["1"], shown: "1 2 3", text: "colour by force, truth or verdict", act: (actions) => actions.set({ colour: COLOURS[0]! }) },
  { keys: ["2"], shown: "", text: "", act: (actions) => actions.set({ colour: COLOURS[1]! }) },
  { keys: ["3"], shown: "", text: "", act: (actions) => actions.loaded()?.reach.header.verdicts && actions.set({ colour: COLOURS[2]! }) },
  { keys: ["v", "V"], shown: "V", text: "next view: whole, hand, top, side", act: (actions) => view(actions) },
  { keys: ["["], shown: "[ ]", text: "previous or next reach", act: (actions) => actions.reach(-1) },
  { keys: ["]"], shown: "", text: "", act: (actions) => actions.reach(1) },
  { keys: ["Escape"], shown: "Esc", text: "end the tour, or select nothing", act: (actions) => actions.endTour() || actions.set({ taxel: null, object: null }) },
  { keys: ["?"], shown: "?", text: "this list", act: () => find<HTMLDialogElement>("help").showModal() },
];

function rate(actions: Actions, step: number): void {
  const at = RATES.indexOf(actions.state.rate as (typeof RATES)[number]) + step;
  if (RATES[at] !== undefined) actions.set({ rate: RATES[at] });
}

function view(actions: Actions): void {
  const at = CAMERAS.indexOf(actions.state.camera);
  actions.set({ camera: CAMERAS[(at + 1) % CAMERAS.length]! });
}

/** Makes the buttons and listens to the keys. */
export function addTransport(actions: Actions): void {
  find("play").addEventListener("click", () => actions.toggle());
  find("steps").append(
    button("|‹", "First frame", () => actions.seek(0)),
    button("‹", "One frame back", () => actions.step(-1)),
    button("›", "One frame on", () => actions.step(1)),
    button("›|", "Last frame", () => actions.seek(Number.MAX_SAFE_INTEGER)),
  );
  for (const jump of ["contact", "mistake", "peak", "goal"] as const) {
    const back = button("‹", `Previous ${jump}`, () => go(actions, jump, false));
    const on = button("›", `Next ${jump}`, () => go(actions, jump, true));
    const group = element("span", { class: "jump", role: "group", "aria-label": `Jump to a ${jump}`, id: `jump-${jump}` }, back, element("span", {}, jump), on);
    find("jumps").append(group);
  }
  const rates = find<HTMLSelectElement>("rate");
  rates.append(...RATES.map((value) => element("option", { value }, `${value}×`)));
  rates.addEventListener("change", () => actions.set({ rate: Number(rates.value) }));
  const help = find<HTMLDialogElement>("help");
  const rows = KEYS.filter(({ shown }) => shown !== "").flatMap(({ shown, text }) => [element("dt", {}, element("kbd", {}, shown)), element("dd", {}, text)]);
  const close = element("button", { type: "button" }, "Close");
  close.addEventListener("click", () => help.close());
  help.append(element("h2", { id: "help-title" }, "Keys"), element("dl", { class: "keys" }, ...rows), element("p", { class: "key" }, "On the 3-D view, arrow keys turn it and plus and minus zoom. On a skin map, arrow keys move from taxel to taxel and Enter selects one."), close);
  find("help-button").addEventListener("click", () => help.showModal());
  document.addEventListener("keydown", (event) => onKey(event, actions));
}

function onKey(event: KeyboardEvent, actions: Actions): void {
  if (event.ctrlKey || event.metaKey || event.altKey || find<HTMLDialogElement>("help").open) return;
  const target = event.target as HTMLElement;
  const range = target instanceof HTMLInputElement && target.type === "range";
  if (target instanceof HTMLInputElement && target.type === "number") return;
  if (target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && !range && /^Arrow| /.test(event.key))) return;
  // Space presses a button that has the focus, and unfolds what is folded.
  if (event.key === " " && target.closest("button, summary") !== null) return;
  // Arrows scroll a table that has the focus, and so do the keys of its ends.
  if (/^Arrow|^Home$|^End$/.test(event.key) && target.matches(".scroll")) return;
  const key = KEYS.find(({ keys }) => keys.includes(event.key));
  if (key === undefined) return;
  event.preventDefault();
  key.act(actions, event.shiftKey);
}
