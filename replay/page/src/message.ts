// Says on the page what went wrong.

import { DataError } from "./container.ts";
import { find, say } from "./dom.ts";

/** Takes the message back. */
export function clear(): void {
  find("message").hidden = true;
  delete document.body.dataset["failed"];
}

/** Says that the list has no reach of this number. */
export function explainNoReach(number: number, count: number): void {
  explain(new DataError(`There is no reach ${number}; the list has ${count}, from 0.`));
}

export function explain(error: unknown): void {
  const message = find("message");
  message.hidden = false;
  const cause = error instanceof Error ? error.message : String(error);
  say(message, error instanceof DataError ? cause : `The page failed: ${cause}. Please report it.`);
  document.body.dataset["failed"] = "true";
}
