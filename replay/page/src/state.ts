// What the page shows at the moment. Views listen; changes of one animation frame are reported together.

export type ColourBy = "force" | "truth" | "verdict";
export type CameraKind = "free" | "hand" | "top" | "side";

export interface State {
  /** Number of the reach in the list. */
  reach: number;
  /** Number of a second reach that is shown beside it. */
  beside: number | null;
  /** Number of a reach of the same draw whose arm is shown see-through. */
  ghost: number | null;
  frame: number;
  playing: boolean;
  /** Seconds of the reach per second. */
  rate: number;
  colour: ColourBy;
  camera: CameraKind;
  /** Whether there are shadows; null for where the processor does not draw. */
  shadows: boolean | null;
  taxel: number | null;
  object: number | null;
}

export const RATES = [0.1, 0.25, 0.5, 1, 2, 5, 10] as const;
export const COLOURS: readonly ColourBy[] = ["force", "truth", "verdict"];
export const CAMERAS: readonly CameraKind[] = ["free", "hand", "top", "side"];

type Listener = (changed: ReadonlySet<keyof State>) => void;

export class Store {
  readonly #listeners: Listener[] = [];
  #changed = new Set<keyof State>();

  constructor(readonly state: Readonly<State>) {}

  /** Changes some values. Listeners hear of it at the next `flush`. */
  set(values: Partial<State>): void {
    for (const key of Object.keys(values) as (keyof State)[]) {
      if (this.state[key] !== values[key]) this.#changed.add(key);
    }
    Object.assign(this.state, values);
  }

  listen(listener: Listener): void {
    this.#listeners.push(listener);
  }

  /** Marks a value as changed although it is the same, because what it refers to has changed. */
  touch(...keys: (keyof State)[]): void {
    for (const key of keys) this.#changed.add(key);
  }

  /** Tells the listeners what has changed since the last call. */
  flush(): void {
    if (this.#changed.size === 0) return;
    const changed = this.#changed;
    this.#changed = new Set();
    for (const listener of this.#listeners) listener(changed);
  }
}
