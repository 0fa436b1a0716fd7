// Small helpers for elements and canvases.

type Attributes = Record<string, string | number | boolean>;

/** A new element. Attributes that are true are set without a value; those that are false are left out. */
export function element<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== false) made.setAttribute(key, value === true ? "" : String(value));
  }
  made.append(...children);
  return made;
}

/** An element of the page that must be there. */
export function find<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no #${id}`);
  return found as T;
}

export function button(text: string, label: string, action: () => void): HTMLButtonElement {
  const made = element("button", { type: "button", "aria-label": label, title: label }, text);
  made.addEventListener("click", action);
  return made;
}

/** Radio buttons that look like a switch. */
export function choices<T extends string>(
  fieldset: HTMLElement,
  name: string,
  options: readonly { value: T; text: string; title: string }[],
  chosen: (value: T) => void,
): Map<T, HTMLInputElement> {
  const inputs = new Map<T, HTMLInputElement>();
  for (const { value, text, title } of options) {
    const input = element("input", { type: "radio", name, value });
    input.addEventListener("change", () => input.checked && chosen(value));
    fieldset.append(element("label", { title }, input, element("span", {}, text)));
    inputs.set(value, input);
  }
  return inputs;
}

/** Gives a canvas the size of its place in CSS pixels, sharp on the screen, and its context with CSS pixels as units. */
export function prepare(canvas: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  const ratio = window.devicePixelRatio || 1;
  const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
  const context = canvas.getContext("2d");
  if (context === null) throw new Error("this browser cannot draw on a canvas");
  // A new size makes a new canvas, which takes long.
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
  } else context.reset();
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return context;
}

/** Replaces the text of an element only if it differs, so that screen readers hear changes alone. */
export function say(target: HTMLElement, text: string): void {
  if (target.textContent !== text) target.textContent = text;
}

/** A force for people, such as "0.42 N". */
export function newtons(force: number): string {
  return `${force.toFixed(2)} N`;
}

/** A number with at most four digits that count, so that 1.2 · 3 is 3.6. */
export function short(value: number): string {
  return String(Number(value.toPrecision(4)));
}

export function seconds(time: number): string {
  return `${time.toFixed(2)} s`;
}

export function plural(count: number, one: string, many = `${one}s`): string {
  return `${count} ${count === 1 ? one : many}`;
}
