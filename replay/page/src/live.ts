// A reach that still runs: news from the server, and buttons that pause and step the simulation.

import { button, element, plural, say } from "./dom.ts";

/** What the server tells; replay/src/live.rs writes it. */
interface News {
  frames: number;
  paused: boolean;
  ended: boolean;
}

/** The page is filled anew at most this often while the reach runs, ms. */
const EVERY_MS = 400;

export class Live {
  readonly #state = element("span", { role: "status" });
  readonly #pause: HTMLButtonElement;
  readonly #steps: HTMLButtonElement[];
  readonly #events = new EventSource("api/live");
  #news: News = { frames: 0, paused: false, ended: false };
  #busy = false;
  /** Number of frames that the page has. */
  #shown: number;

  /** The page has `shown` frames, and `grown` loads those that follow and gives their number. */
  constructor(box: HTMLElement, shown: number, readonly grown: (ended: boolean) => Promise<number>) {
    this.#shown = shown;
    this.#pause = button("Pause", "Pause the simulation or let it go on", () => void this.#send(this.#news.paused ? "run" : "pause"));
    this.#pause.removeAttribute("aria-label");
    this.#steps = [1, 10].map((count) => button(`+${plural(count, "frame")}`, `Simulate ${plural(count, "frame")}, then pause`, () => void this.#send(`step/${count}`)));
    box.replaceChildren(element("b", {}, "Live"), this.#state, this.#pause, ...this.#steps);
    box.hidden = false;
    this.#events.addEventListener("message", (event) => {
      this.#news = JSON.parse(String(event.data)) as News;
      void this.#follow();
    });
    this.#events.addEventListener("error", () => {
      if (!this.#news.ended) this.#close("The simulation has stopped. What it has sent so far is shown.");
    });
    this.#say();
  }

  async #send(command: string): Promise<void> {
    try {
      await fetch(`api/live/${command}`, { method: "POST" });
    } catch {
      this.#close("The simulation does not answer.");
    }
  }

  /** Shows what is new, once at a time. */
  async #follow(): Promise<void> {
    this.#say();
    if (this.#busy) return;
    this.#busy = true;
    while (this.#shown < this.#news.frames || this.#news.ended) {
      const { paused, ended } = this.#news;
      if (ended) this.#close("The reach has ended.");
      const before = this.#shown;
      this.#shown = await this.grown(ended);
      // Without new frames something failed; the next news tries again.
      if (ended || this.#shown === before) break;
      if (!paused) await new Promise((done) => setTimeout(done, EVERY_MS));
    }
    this.#busy = false;
  }

  #say(): void {
    const { frames, paused } = this.#news;
    say(this.#state, `${paused ? "paused" : "running"} after ${plural(frames, "frame")}`);
    say(this.#pause, paused ? "Go on" : "Pause");
  }

  #close(text: string): void {
    this.#events.close();
    say(this.#state, text);
    for (const control of [this.#pause, ...this.#steps]) control.hidden = true;
  }
}
