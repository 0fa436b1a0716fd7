// Where reaches come from: the file itself, or the server that sent the page.

import { DataError } from "./container.ts";

/** One line of the list of reaches; replay/src/source.rs writes it. */
export interface Summary {
  number: number;
  source: string;
  scene: string;
  seed: string;
  reach_index: number;
  controller: string;
  outcome: string;
  goal_outcomes: { reached: number; stuck: number; timed_out: number; aborted: number };
  duration_s: number;
  contacts: number;
  peak_force_n: number;
  audit_warnings: string[];
  /** Whether the reach is still being simulated. */
  running: boolean;
  /** Whether it is from a robot's log or a table of its trials, so that nobody knows seed and controller. */
  log: boolean;
  /** Whether it is from a table of contact trials, which does not say how the reach went. */
  table: boolean;
}

export interface Source {
  list(): Promise<Summary[]>;
  /** The data of a reach; of one that runs, those that follow its first `from` frames. */
  bytes(number: number, from?: number): Promise<ArrayBuffer>;
}

async function decode(text: string): Promise<ArrayBuffer> {
  try {
    const binary = atob(text.trim());
    const bytes = new Uint8Array(binary.length);
    for (let index = 0; index < binary.length; index++) bytes[index] = binary.charCodeAt(index);
    return await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  } catch {
    throw new DataError("The data in this file are cut off or damaged. Copy or write the file again.");
  }
}

/** The data that “underbrush replay --out” put into this file. */
class Embedded implements Source {
  readonly #list: Element;

  constructor(list: Element) {
    this.#list = list;
  }

  async list(): Promise<Summary[]> {
    return JSON.parse(this.#list.textContent ?? "[]") as Summary[];
  }

  async bytes(number: number): Promise<ArrayBuffer> {
    const element = document.getElementById(`underbrush-reach-${number}`);
    if (element === null) throw new DataError(`This file does not have reach ${number}.`);
    return decode(element.textContent ?? "");
  }
}

/** The server that sent the page. */
class Served implements Source {
  async #get(path: string): Promise<Response> {
    let answer: Response;
    try {
      answer = await fetch(path);
    } catch {
      throw new DataError("The server does not answer. Start “underbrush replay” again and reload the page.");
    }
    if (!answer.ok) throw new DataError(await answer.text());
    return answer;
  }

  async list(): Promise<Summary[]> {
    return (await (await this.#get("api/reaches")).json()) as Summary[];
  }

  async bytes(number: number, from = 0): Promise<ArrayBuffer> {
    return (await this.#get(`api/reach/${number}${from > 0 ? `?from=${from}` : ""}`)).arrayBuffer();
  }
}

/** The source of this page. */
export function findSource(): Source {
  const list = document.getElementById("underbrush-reaches");
  if (list !== null) return new Embedded(list);
  const embedded = document.querySelector('script[id^="underbrush-reach-"]') !== null;
  if (embedded || location.protocol === "file:") {
    throw new DataError("This file is cut off: its list of reaches is missing. Copy or write the file again.");
  }
  return new Served();
}
