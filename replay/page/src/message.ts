// Says on the page what went wrong.

import { DataError } from "./container.ts";
import { find, say } from "./dom.ts";

export function explain(error: unknown): void {
  const message = find("message");
  message.hidden = false;
  const cause = error instanceof Error ? error.message : String(error);
  say(message, error instanceof DataError ? cause : `The page failed: ${cause}. Please report it.`);
  document.body.dataset["failed"] = "true";
}
