// How finely the 3-D view is drawn: as finely as the screen shows, or more coarsely while it moves on a slow machine.

/** Renderers that draw on the processor: SwiftShader in Chromium, llvmpipe and softpipe of Mesa, WARP on Windows. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
/** A moving view is drawn more coarsely when its frames are farther apart than this, ms: 30 a second, and a little room. */
const SLOW_MS = 36;
/** Frames between two decisions: a slow machine has found its pace after half a second. */
const EVERY = 7;
/** Longer pauses are not counted: something else happened, such as another tab, ms. */
const PAUSE_MS = 500;
/** Share of the pixels in each direction at least. */
const COARSEST = 0.5;

function drawsInSoftware(context: WebGL2RenderingContext): boolean {
  const names = context.getExtension("WEBGL_debug_renderer_info");
  const renderer: unknown = context.getParameter(names === null ? context.RENDERER : names.UNMASKED_RENDERER_WEBGL);
  return typeof renderer === "string" && SOFTWARE.test(renderer);
}

/** A canvas with a WebGL context, and whether the processor draws it. Then it has no smooth edges, which cost several times the
 * time. `make` gives a new canvas. Throws if the browser has no WebGL. */
export function prepareWebGL(make: () => HTMLCanvasElement): { canvas: HTMLCanvasElement; context: WebGL2RenderingContext; software: boolean } {
  const attempt = (antialias: boolean) => {
    const canvas = make();
    // Not transparent: the browser would mix every pixel with the page below.
    const context = canvas.getContext("webgl2", { alpha: false, antialias, powerPreference: "high-performance" });
    if (context === null) throw new Error("this browser has no WebGL");
    return { canvas, context };
  };
  // Where the processor draws, the first context is the one that is used: making one takes a tenth of a second there.
  const first = attempt(false);
  if (drawsInSoftware(first.context)) return { ...first, software: true };
  first.context.getExtension("WEBGL_lose_context")?.loseContext();
  return { ...attempt(true), software: false };
}

export class Quality {
  readonly #still: number;
  #moving: number;
  #last = 0;
  #gaps: number[] = [];

  constructor(readonly software: boolean) {
    this.#still = Math.min(window.devicePixelRatio || 1, software ? 1 : 2);
    this.#moving = this.#still;
  }

  /** Pixels of the drawing per CSS pixel, for a frame that begins at this time, ms. */
  ratio(moving: boolean, now: number): number {
    if (!moving) {
      this.#gaps = [];
      this.#last = 0;
      return this.#still;
    }
    if (this.#last > 0 && now - this.#last < PAUSE_MS) this.#gaps.push(now - this.#last);
    this.#last = now;
    if (this.#gaps.length >= EVERY) {
      const median = this.#gaps.sort((a, b) => a - b)[Math.floor(EVERY / 2)]!;
      this.#gaps = [];
      if (median > SLOW_MS) this.#moving = Math.max(COARSEST * this.#still, this.#moving * 0.75);
    }
    return this.#moving;
  }
}
