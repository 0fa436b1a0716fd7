// Print: paper is white, so everything is drawn in the light theme while the page is printed, in one column that paper has room for.

/** `themed` takes over the colours of another theme; `draw` then draws at once, before the browser makes the pages. */
export function followPrint(themed: () => void, draw: () => void): void {
  const { classList, dataset } = document.documentElement;
  let theme: string | undefined;
  addEventListener("beforeprint", () => {
    theme = dataset["theme"];
    dataset["theme"] = "light";
    classList.add("printed");
    themed();
    draw();
  });
  addEventListener("afterprint", () => {
    classList.remove("printed");
    if (theme === undefined) delete dataset["theme"];
    else dataset["theme"] = theme;
    themed();
  });
}
