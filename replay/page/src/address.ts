// The state in the address, so that a finding can be sent: #reach=12&t=3.41&colour=truth&taxel=forearm.142

import type { Reach } from "./reach.ts";
import { CAMERAS, COLOURS, RATES, type State } from "./state.ts";

/** What an address asks for. */
export interface Asked {
  reach: number | null;
  beside: number | null;
  ghost: number | null;
  time: number | null;
  taxel: string | null;
  object: number | null;
  state: Partial<State>;
}

function whole(text: string | null): number | null {
  return text !== null && /^\d{1,9}$/.test(text) ? Number(text) : null;
}

/** Reads the address. What it leaves out, or what makes no sense, is as at the beginning. */
export function readAddress(hash: string): Asked {
  const values = new URLSearchParams(hash.replace(/^#/, ""));
  const time = Number(values.get("t") ?? "x");
  const state = {
    colour: COLOURS.find((name) => name === values.get("colour")) ?? "force",
    camera: CAMERAS.find((name) => name === values.get("view")) ?? "free",
    rate: RATES.find((value) => String(value) === values.get("rate")) ?? 1,
  };
  return {
    reach: whole(values.get("reach")),
    beside: whole(values.get("beside")),
    ghost: whole(values.get("ghost")),
    time: Number.isFinite(time) ? time : null,
    taxel: values.get("taxel"),
    object: whole(values.get("object")),
    state,
  };
}

/** The taxel of a name such as forearm.142. */
export function findTaxel(reach: Reach, name: string | null): number | null {
  const parts = /^(.*)\.(\d{1,6})$/.exec(name ?? "");
  const patch = reach.header.patches.find((patch) => patch.name === parts?.[1]);
  const index = Number(parts?.[2]);
  return patch !== undefined && index < patch.taxels ? patch.first_taxel + index : null;
}

/** The address of a state. Values that nobody changed are left out. */
export function writeAddress(state: State, reach: Reach): string {
  // Four decimals tell frames apart up to thousands a second. Zeros at the end say nothing.
  const time = Number(reach.time[state.frame]!.toFixed(4));
  const values = new URLSearchParams({ reach: String(state.reach), t: String(time) });
  if (state.beside !== null) values.set("beside", String(state.beside));
  if (state.ghost !== null) values.set("ghost", String(state.ghost));
  if (state.colour !== "force") values.set("colour", state.colour);
  if (state.camera !== "free") values.set("view", state.camera);
  if (state.rate !== 1) values.set("rate", String(state.rate));
  if (state.taxel !== null) values.set("taxel", reach.taxelAddress(state.taxel));
  if (state.object !== null) values.set("object", String(state.object));
  return `#${values}`;
}
