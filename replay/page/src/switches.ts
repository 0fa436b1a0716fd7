// The two switches above the 3-D view: what colours mean, and where the view looks from.

import { choices, find } from "./dom.ts";
import type { CameraKind, ColourBy, State } from "./state.ts";

export class Switches {
  readonly #colour: Map<ColourBy, HTMLInputElement>;
  readonly #camera: Map<CameraKind, HTMLInputElement>;
  readonly #shadows = find<HTMLInputElement>("shadows");

  constructor(set: (values: Partial<State>) => void) {
    this.#colour = choices<ColourBy>(find("colour"), "colour", [
      { value: "force", text: "force", title: "Sensed force (1)" },
      { value: "truth", text: "truth", title: "What truly presses (2)" },
      { value: "verdict", text: "verdict", title: "What the model says (3)" },
    ], (colour) => set({ colour }));
    this.#camera = choices<CameraKind>(find("camera"), "camera", [
      { value: "free", text: "whole", title: "The whole arm, to be turned" },
      { value: "hand", text: "hand", title: "Follow the hand" },
      { value: "top", text: "top", title: "From above" },
      { value: "side", text: "side", title: "From the right side" },
    ], (camera) => set({ camera }));
    this.#shadows.addEventListener("change", () => set({ shadows: this.#shadows.checked }));
  }

  /** Verdicts can be shown only if there is a model. */
  allowVerdict(allowed: boolean): void {
    this.#colour.get("verdict")!.disabled = !allowed;
  }

  /** `software` says that the processor draws. */
  show(state: State, software: boolean): void {
    this.#shadows.checked = state.shadows ?? !software;
    for (const [value, input] of this.#colour) input.checked = state.colour === value;
    for (const [value, input] of this.#camera) input.checked = state.camera === value;
  }
}
