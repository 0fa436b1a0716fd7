// Keeps the address of the page at what it shows.

import { type Asked, readAddress, writeAddress } from "./address.ts";
import type { Reach } from "./reach.ts";
import type { State } from "./state.ts";

/** The address changes at most this often, ms; browsers refuse more than 200 changes in 30 s. */
const EVERY_MS = 400;

export class AddressBar {
  #timer = 0;

  /** `asked` is called when a reader changes the address. */
  constructor(readonly state: State, readonly reach: () => Reach | null, asked: (asked: Asked) => void) {
    // The page may have written its own address before it hears of the reader's, so `location` does not tell it.
    addEventListener("hashchange", ({ newURL }) => {
      const { hash } = new URL(newURL);
      // The link to the playback is no address of a finding.
      if (hash.includes("=")) asked(readAddress(hash));
      else this.write();
    });
  }

  /** Writes the state soon. */
  write(): void {
    if (this.#timer !== 0) return;
    this.#timer = window.setTimeout(() => {
      this.#timer = 0;
      const reach = this.reach();
      if (reach !== null) history.replaceState(null, "", writeAddress(this.state, reach));
    }, EVERY_MS);
  }
}
