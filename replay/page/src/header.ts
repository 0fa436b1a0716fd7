// The head of the page: which reach it is, how it went, and the choice of reaches and theme.

import { find, say } from "./dom.ts";
import { goalCount } from "./lists.ts";
import type { Reach } from "./reach.ts";
import type { Summary } from "./source.ts";
import type { State } from "./state.ts";

/** What a reach is called. */
export function nameOf(reach: Summary): string {
  if (reach.log) return `${reach.number}: ${reach.scene}, reach ${reach.reach_index}`;
  return `${reach.number}: ${reach.scene}, seed ${reach.seed}, reach ${reach.reach_index}, ${reach.controller}`;
}

export interface HeaderActions {
  open(number: number): void;
  step(reaches: number): void;
  beside(number: number | null): void;
  themed(): void;
}

/** The number in a field if it is that of a reach. */
function numberOf(input: HTMLInputElement, count: number): number | null {
  const number = Number(input.value);
  return input.value !== "" && Number.isInteger(number) && number >= 0 && number < count ? number : null;
}

/** Under which name the browser keeps the theme. */
const THEME = "underbrush-theme";
const THEMES = ["system", "light", "dark"];

export class Header {
  readonly #reach = find<HTMLInputElement>("reach");
  readonly #beside = find<HTMLInputElement>("beside");

  #shown = "";
  #shownBeside = "";

  constructor(all: Summary[], actions: HeaderActions) {
    find("reach-controls").hidden = all.length < 2;
    // Numbers are those of the list, of the address and of --reaches.
    say(find("reach-count"), `of 0–${all.length - 1}`);
    // A number, and not a choice among names: a set can have thousands of reaches, and the list below has the names.
    for (const input of [this.#reach, this.#beside]) input.max = String(all.length - 1);
    this.#reach.addEventListener("change", () => {
      const number = numberOf(this.#reach, all.length);
      if (number !== null) actions.open(number);
      else this.#reach.value = this.#shown;
    });
    this.#beside.addEventListener("change", () => {
      const number = numberOf(this.#beside, all.length);
      if (number !== null || this.#beside.value === "") actions.beside(number);
      else this.#beside.value = this.#shownBeside;
    });
    find("previous-reach").addEventListener("click", () => actions.step(-1));
    find("next-reach").addEventListener("click", () => actions.step(1));
    find("theme").addEventListener("click", () => {
      nextTheme();
      actions.themed();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => actions.themed());
  }

  /** Shows the numbers of both reaches, but not where a reader types another. */
  show(state: State): void {
    this.#shown = String(state.reach);
    this.#shownBeside = state.beside === null ? "" : String(state.beside);
    for (const [input, value] of [[this.#reach, this.#shown], [this.#beside, this.#shownBeside]] as const) {
      if (document.activeElement !== input && input.value !== value) input.value = value;
    }
  }

  /** Says what a reach is and how it went. */
  describe(summary: Summary, reach: Reach): void {
    const { header } = reach;
    const { reached, stuck, timed_out: timedOut, aborted } = header.goal_outcomes;
    const goals = goalCount(header);
    const named: [number, string][] = [[stuck, "stuck"], [timedOut, "timed out"], [aborted, "aborted"]];
    const others = named.filter(([count]) => count > 0).map(([count, name]) => `, ${count} ${name}`);
    const seed = summary.log ? "" : `seed ${header.seed}, `;
    say(find("title"), `${header.scene}, ${seed}reach ${header.reach_index}`);
    document.title = `${find("title").textContent} – underbrush replay`;
    const stop = header.safety_stop;
    const model = header.verdicts === null ? "" : `model ${header.verdicts.model} (${header.verdicts.classifier})`;
    // A table of trials has neither an arm nor goals, and nothing was simulated that could be audited.
    const facts = reach.isTable ? ["a table of contact trials", `${summary.duration_s.toFixed(1)}\u00a0s`, model] : [
      summary.log ? "a robot's log" : header.controller,
      summary.running ? "running" : goals === 0 ? "no goals" : `${reached} of ${goals} goals reached${others.join("")}`,
      ...(summary.running ? [] : [`${summary.duration_s.toFixed(1)}\u00a0s`, `peak contact force ${summary.peak_force_n.toFixed(2)}\u00a0N`]),
      stop === null ? "" : `stopped by ${stop.force_n.toFixed(0)} N of ${stop.object_kind.replace(/_/g, " ")}${stop.object_index === null ? "" : ` ${stop.object_index}`} on ${stop.link}`,
      summary.running ? "" : header.audit_warnings.length > 0 ? `audit: ${header.audit_warnings.join("; ")}` : goals === 0 ? "" : "audit within bounds",
      model,
    ];
    say(find("facts"), facts.filter((fact) => fact !== "").join(" · "));
  }
}

function nextTheme(): void {
  const next = THEMES[(THEMES.indexOf(document.documentElement.dataset["theme"] ?? "system") + 1) % THEMES.length]!;
  setTheme(next);
  try {
    sessionStorage.setItem(THEME, next);
  } catch {
    // The browser keeps nothing for this page.
  }
}

function setTheme(theme: string): void {
  const { dataset } = document.documentElement;
  if (theme === "system") delete dataset["theme"];
  else dataset["theme"] = theme;
  say(find("theme"), `Theme: ${theme}`);
}

/** Takes the theme that was chosen before the page was loaded anew. */
export function restoreTheme(): void {
  try {
    const theme = sessionStorage.getItem(THEME);
    if (theme !== null && THEMES.includes(theme)) setTheme(theme);
  } catch {
    // The browser keeps nothing for this page.
  }
}
