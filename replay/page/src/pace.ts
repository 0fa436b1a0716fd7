// How often the parts of the page follow the current frame while a reach plays.

import type { State } from "./state.ts";

/** The selection is described this often, ms: nobody reads faster. */
const DETAILS_MS = 200;
/** Texts, lines at the current time and the scrubber follow this often where the processor draws, ms: every change on the screen
 * takes time from the 3-D view. */
const SOFTWARE_MS = 100;

export class Pace {
  #followed = 0;
  #described = 0;
  /** Whether texts, lines at the current time and the scrubber follow in this frame. */
  follows = true;
  /** Whether the selection is described anew in this frame. */
  describes = true;

  /** Decides for a frame in which these values have changed; `software` says that the processor draws. */
  decide(state: State, changed: ReadonlySet<keyof State>, software: boolean): void {
    const now = performance.now();
    const playsOn = state.playing && changed.size === 1 && changed.has("frame");
    this.follows = !playsOn || !software || now - this.#followed >= SOFTWARE_MS;
    if (this.follows) this.#followed = now;
    this.describes = this.follows && (!playsOn || now - this.#described > DETAILS_MS);
    if (this.describes) this.#described = now;
  }
}
