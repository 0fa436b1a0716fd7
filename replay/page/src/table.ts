// A table that can be sorted by its columns and filtered, with rows that can be chosen by mouse and keyboard.

import { button, element, find, plural, say } from "./dom.ts";

export interface Column<T> {
  title: string;
  /** What is shown. */
  text: (row: T) => string;
  /** What is sorted by, if not the text. */
  value?: (row: T) => number;
  /** A hint on hover. */
  hint?: (row: T) => string;
}

export interface Filter<T> {
  label: string;
  of: (row: T) => string;
}

/** Rows on one page of a table: a browser needs seconds for thousands, and nobody reads them. */
const PAGE_ROWS = 50;

export class Table<T> {
  readonly box: HTMLElement;
  readonly #count = element("p", { class: "key", role: "status" });
  readonly #body = element("tbody", {});
  readonly #heads: HTMLTableCellElement[];
  readonly #filters: { filter: Filter<T>; select: HTMLSelectElement }[];
  readonly #turn: HTMLElement;
  readonly #back: HTMLButtonElement;
  readonly #on: HTMLButtonElement;
  #rows: T[] = [];
  /** The rows that pass the filters, in order. */
  #shown: T[] = [];
  #page = 0;
  #stale = true;
  #order: { column: number; down: boolean } | null = null;
  #current: (row: T) => boolean = () => false;

  constructor(
    readonly name: string,
    readonly noun: [string, string],
    readonly columns: Column<T>[],
    filters: Filter<T>[],
    readonly choose: (row: T) => void,
  ) {
    this.#heads = columns.map((column, index) => {
      const sort = element("button", { type: "button" }, column.title);
      sort.addEventListener("click", () => this.#sort(index));
      return element("th", { scope: "col", "aria-sort": "none", class: kind(column) }, sort);
    });
    this.#filters = filters.map((filter) => {
      const select = element("select", {});
      select.addEventListener("change", () => this.#draw(0));
      return { filter, select };
    });
    const fields = this.#filters.map(({ filter, select }) => element("label", { class: "field" }, `${filter.label} `, select));
    this.#back = button("‹", `Previous page of ${name.toLowerCase()}`, () => this.#draw(this.#page - 1));
    this.#on = button("›", `Next page of ${name.toLowerCase()}`, () => this.#draw(this.#page + 1));
    this.#turn = element("span", { class: "group" }, this.#back, this.#on);
    const table = element("table", {}, element("caption", { class: "sr" }, name), element("thead", {}, element("tr", {}, ...this.#heads)), this.#body);
    this.box = element("div", { class: "table-box" }, element("div", { class: "filters" }, ...fields), element("div", { class: "pages" }, this.#count, this.#turn), element("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": name }, table));
  }

  /** Shows other rows. */
  fill(rows: T[]): void {
    this.#rows = rows;
    for (const { filter, select } of this.#filters) {
      const kept = select.value;
      const names = [...new Set(rows.map(filter.of))].sort();
      select.replaceChildren(element("option", { value: "" }, "all"), ...names.map((name) => element("option", { value: name }, name)));
      select.value = names.includes(kept) ? kept : "";
    }
    this.#stale = true;
    this.#page = 0;
    this.refresh();
  }

  /** Draws new rows if the table can be seen: most lists are never looked at. */
  refresh(): void {
    if (this.#stale && this.box.offsetParent !== null) this.#draw(this.#page);
  }

  /** Marks the current row. */
  mark(current: (row: T) => boolean): void {
    this.#current = current;
    if (this.#stale) return;
    const rows = this.#shown.slice(this.#page * PAGE_ROWS);
    [...this.#body.rows].forEach((line, index) => {
      if (current(rows[index]!)) line.setAttribute("aria-current", "true");
      else line.removeAttribute("aria-current");
    });
  }

  /** Marks the current row and turns to its page. */
  reveal(current: (row: T) => boolean): void {
    this.mark(current);
    if (this.#stale) return;
    const at = this.#shown.findIndex(current);
    const page = Math.floor(at / PAGE_ROWS);
    if (at >= 0 && page !== this.#page) this.#draw(page);
  }

  #sort(column: number): void {
    this.#order = { column, down: this.#order?.column === column && !this.#order.down };
    this.#heads.forEach((head, index) => {
      head.setAttribute("aria-sort", index !== column ? "none" : this.#order!.down ? "descending" : "ascending");
    });
    this.#draw(0);
  }

  /** The rows that pass the filters, in order. */
  #chosen(): T[] {
    const rows = this.#rows.filter((row) => this.#filters.every(({ filter, select }) => select.value === "" || filter.of(row) === select.value));
    if (this.#order === null) return rows;
    const { column, down } = this.#order;
    const { value, text } = this.columns[column]!;
    const compare = value !== undefined ? (a: T, b: T) => value(a) - value(b) : (a: T, b: T) => text(a).localeCompare(text(b), undefined, { numeric: true });
    rows.sort((a, b) => (down ? compare(b, a) : compare(a, b)));
    return rows;
  }

  #draw(page: number): void {
    if (this.#stale || page === 0) this.#shown = this.#chosen();
    this.#stale = false;
    const pages = Math.max(Math.ceil(this.#shown.length / PAGE_ROWS), 1);
    this.#page = Math.min(Math.max(page, 0), pages - 1);
    const first = this.#page * PAGE_ROWS;
    const rows = this.#shown.slice(first, first + PAGE_ROWS);
    this.#body.replaceChildren(...rows.map((row) => this.#line(row)));
    const [one, many] = this.noun;
    const [count, all] = [this.#shown.length, this.#rows.length];
    const part = pages === 1 ? "" : `, ${first + 1} to ${first + rows.length} shown`;
    say(this.#count, (count === all ? plural(count, one, many) : `${count} of ${plural(all, one, many)}`) + part);
    this.#turn.hidden = pages === 1;
    this.#back.disabled = this.#page === 0;
    this.#on.disabled = this.#page === pages - 1;
    this.mark(this.#current);
  }

  #line(row: T): HTMLTableRowElement {
    const cells = this.columns.map((column, index) => {
      const hint = column.hint?.(row) ?? "";
      if (index > 0) return element("td", { title: hint, class: kind(column) }, column.text(row));
      return element("th", { scope: "row" }, element("button", { type: "button", class: "link" }, column.text(row)));
    });
    const line = element("tr", {}, ...cells);
    line.addEventListener("click", () => this.choose(row));
    return line;
  }
}

/** Numbers stand on the right of their column. */
function kind<T>(column: Column<T>): string {
  return column.value === undefined ? "" : "number";
}

/** Tabs with one panel each. */
export function tabs(box: HTMLElement, panels: { id: string; title: string; content: HTMLElement; opened: () => void }[]): (id: string) => void {
  const buttons = panels.map(({ id, title }) => element("button", { type: "button", role: "tab", id: `tab-${id}`, "aria-controls": `panel-${id}` }, title));
  const sheets = panels.map(({ id, content }) => element("div", { role: "tabpanel", id: `panel-${id}`, "aria-labelledby": `tab-${id}` }, content));
  const open = (index: number) => {
    buttons.forEach((tab, at) => {
      tab.setAttribute("aria-selected", String(at === index));
      tab.tabIndex = at === index ? 0 : -1;
      sheets[at]!.hidden = at !== index;
    });
    panels[index]!.opened();
  };
  buttons.forEach((tab, index) => {
    tab.addEventListener("click", () => open(index));
    tab.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      const next = (index + step + buttons.length) % buttons.length;
      open(next);
      buttons[next]!.focus();
    });
  });
  box.replaceChildren(element("div", { role: "tablist", "aria-label": "Lists" }, ...buttons), ...sheets);
  open(0);
  return (id) => {
    open(panels.findIndex((panel) => panel.id === id));
    find(`tab-${id}`).scrollIntoView({ block: "nearest" });
  };
}
