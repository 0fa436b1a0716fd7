// Starts the page.

import { readAddress } from "./address.ts";
import { DataError } from "./container.ts";
import { find } from "./dom.ts";
import { restoreTheme } from "./header.ts";
import { Live } from "./live.ts";
import { explain, explainNoReach } from "./message.ts";
import { Page } from "./page.ts";
import { findSource } from "./source.ts";
import "./style.css";

async function start(): Promise<void> {
  try {
    restoreTheme();
    const asked = readAddress(location.hash);
    const source = findSource();
    const all = await source.list();
    if (all.length === 0) throw new DataError("The data set has no reaches.");
    const page = new Page(source, all, asked);
    Object.assign(window, { underbrushReplay: page.inspect });
    const reach = asked.reach ?? 0;
    const known = all[reach] !== undefined;
    await page.opening.open(known ? reach : 0, known ? asked : null);
    if (!known) explainNoReach(reach, all.length);
    if (all[0]!.running) new Live(find("live"), page.frames, (ended) => page.opening.grow(ended));
  } catch (error) {
    explain(error);
  }
}

void start();
