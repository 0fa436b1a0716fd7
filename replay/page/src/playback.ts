// Time in the reach: where it stands, and how it goes on while the reach plays.

import type { Reach } from "./reach.ts";
import type { State, Store } from "./state.ts";

/** A longer pause between two animation frames is another tab or another window; the reach does not jump over it, ms. */
const LONGEST_STEP_MS = 250;

export class Playback {
  /** Time in the reach, s; it lies between two frames while the reach plays slowly. */
  #time = 0;
  /** When it was last moved on, ms. */
  #at = 0;

  constructor(readonly store: Store, readonly reach: () => Reach | null) {}

  /** Goes to a frame, or to the nearest that there is. */
  seek(frame: number): Partial<State> {
    const reach = this.reach();
    const found = Math.min(Math.max(frame, 0), (reach?.frames ?? 1) - 1);
    this.#time = reach?.time[found] ?? 0;
    return { frame: found };
  }

  /** Plays or pauses. At the end it plays from the beginning. */
  toggle(): Partial<State> {
    const { playing, frame } = this.store.state;
    const atEnd = !playing && frame === (this.reach()?.frames ?? 0) - 1;
    this.#at = performance.now();
    return { ...(atEnd ? this.seek(0) : {}), playing: !playing };
  }

  /** Moves time on to an animation frame that begins at `now`, ms. */
  advance(now: number): void {
    const reach = this.reach();
    const { playing, rate } = this.store.state;
    if (!playing || reach === null) return;
    this.#time += (Math.min(now - this.#at, LONGEST_STEP_MS) / 1000) * rate;
    this.#at = now;
    this.store.set({ frame: reach.frameAt(this.#time), playing: this.#time < reach.duration });
  }
}
