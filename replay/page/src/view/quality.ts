// How finely the 3-D view is drawn: as finely as the screen shows, or more coarsely while it moves on a slow machine.

/** Renderers that draw on the processor: SwiftShader in Chromium, llvmpipe and softpipe of Mesa, WARP on Windows. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
/** A moving view is drawn more coarsely when it takes longer than this, ms: 30 frames a second with room for the rest. */
const SLOW_MS = 22;
/** Frames between two measurements. */
const EVERY = 6;
/** Share of the pixels in each direction at least. */
const COARSEST = 0.5;

/** Whether the processor draws WebGL. Smooth edges then cost several times the time. */
export function drawsInSoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  if (context === null) return false;
  const names = context.getExtension("WEBGL_debug_renderer_info");
  const renderer: unknown = context.getParameter(names === null ? context.RENDERER : names.UNMASKED_RENDERER_WEBGL);
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return typeof renderer === "string" && SOFTWARE.test(renderer);
}

export class Quality {
  readonly #still: number;
  #moving: number;
  #frames = 0;
  #times: number[] = [];

  constructor(readonly software: boolean) {
    this.#still = Math.min(window.devicePixelRatio || 1, software ? 1 : 2);
    this.#moving = this.#still;
  }

  /** Pixels of the drawing per CSS pixel. */
  ratio(moving: boolean): number {
    return moving ? this.#moving : this.#still;
  }

  /** Draws with `draw`. While the view moves, measures now and then how long that takes, and draws more coarsely if it takes long. */
  measured(moving: boolean, context: WebGL2RenderingContext, draw: () => void): void {
    if (!moving || this.#frames++ % EVERY !== 0) return draw();
    const start = performance.now();
    draw();
    // Drawing goes on after the call returns. Reading a pixel waits for its end.
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));
    this.#times.push(performance.now() - start);
    if (this.#times.length < 3) return;
    const [, median] = this.#times.sort((a, b) => a - b);
    this.#times = [];
    if (median! > SLOW_MS) this.#moving = Math.max(COARSEST * this.#still, this.#moving * 0.75);
  }
}
