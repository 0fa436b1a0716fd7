// The head of the page: which reach it is, how it went, and the choice of reaches and theme.

import { element, find, say } from "./dom.ts";
import type { Reach } from "./reach.ts";
import type { Summary } from "./source.ts";
import type { State } from "./state.ts";

/** What a reach is called. */
export function nameOf(reach: Summary): string {
  return `${reach.number}: ${reach.scene}, seed ${reach.seed}, reach ${reach.reach_index}, ${reach.controller}`;
}

export interface HeaderActions {
  open(number: number): void;
  step(reaches: number): void;
  beside(number: number | null): void;
  themed(): void;
}

const THEMES = ["system", "light", "dark"];

export class Header {
  readonly #reach = find<HTMLSelectElement>("reach");
  readonly #beside = find<HTMLSelectElement>("beside");

  constructor(all: Summary[], actions: HeaderActions) {
    find("reach-controls").hidden = all.length < 2;
    const options = () => all.map((reach) => element("option", { value: reach.number }, nameOf(reach)));
    this.#reach.append(...options());
    this.#reach.addEventListener("change", () => actions.open(Number(this.#reach.value)));
    this.#beside.append(element("option", { value: "" }, "none"), ...options());
    this.#beside.addEventListener("change", () => actions.beside(this.#beside.value === "" ? null : Number(this.#beside.value)));
    find("previous-reach").addEventListener("click", () => actions.step(-1));
    find("next-reach").addEventListener("click", () => actions.step(1));
    find("theme").addEventListener("click", () => {
      nextTheme();
      actions.themed();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => actions.themed());
  }

  show(state: State): void {
    this.#reach.value = String(state.reach);
    this.#beside.value = state.beside === null ? "" : String(state.beside);
  }

  /** Says what a reach is and how it went. */
  describe(summary: Summary, { header }: Reach): void {
    const { reached, stuck, timed_out: timedOut, aborted } = header.goal_outcomes;
    const named: [number, string][] = [[stuck, "stuck"], [timedOut, "timed out"], [aborted, "aborted"]];
    const others = named.filter(([count]) => count > 0).map(([count, name]) => `, ${count} ${name}`);
    say(find("title"), `${header.scene}, seed ${header.seed}, reach ${header.reach_index}`);
    document.title = `${find("title").textContent} – underbrush replay`;
    const stop = header.safety_stop;
    const facts = [
      header.controller,
      summary.running ? "running" : `${reached} of ${reached + stuck + timedOut + aborted} goals reached${others.join("")}`,
      ...(summary.running ? [] : [`${summary.duration_s.toFixed(1)} s`, `peak contact force ${summary.peak_force_n.toFixed(2)} N`]),
      stop === null ? "" : `stopped by ${stop.force_n.toFixed(0)} N of ${stop.object_kind.replace(/_/g, " ")} ${stop.object_index} on ${stop.link}`,
      summary.running ? "" : header.audit_warnings.length === 0 ? "audit within bounds" : `audit: ${header.audit_warnings.join("; ")}`,
      header.verdicts === null ? "" : `model ${header.verdicts.model} (${header.verdicts.classifier})`,
    ];
    say(find("facts"), facts.filter((fact) => fact !== "").join(" · "));
  }
}

function nextTheme(): void {
  const root = document.documentElement;
  const next = THEMES[(THEMES.indexOf(root.dataset["theme"] ?? "system") + 1) % THEMES.length]!;
  if (next === "system") delete root.dataset["theme"];
  else root.dataset["theme"] = next;
  say(find("theme"), `Theme: ${next}`);
}
