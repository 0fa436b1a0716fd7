// Print: paper is white, so everything is drawn in the light theme while the page is printed.

/** `themed` takes over the colours of another theme; `draw` then draws at once, before the browser makes the pages. */
export function followPrint(themed: () => void, draw: () => void): void {
  const { dataset } = document.documentElement;
  let theme: string | undefined;
  addEventListener("beforeprint", () => {
    theme = dataset["theme"];
    dataset["theme"] = "light";
    themed();
    draw();
  });
  addEventListener("afterprint", () => {
    if (theme === undefined) delete dataset["theme"];
    else dataset["theme"] = theme;
    themed();
  });
}
