"""For MkDocs: makes the site fit for phones and for search without a server."""

import re
from pathlib import Path
from typing import Any

# A page that was opened from disk may neither start a worker nor read the index, but it may load a script with both.
FROM_DISK = """
if (location.protocol === "file:") {
  window.Worker = undefined;
  window.$ = { getScript: () => {
    const script = document.createElement("script");
    script.src = joinUrl(base_url, "search/disk.js");
    document.body.append(script);
    return { done: () => ({ fail: () => {} }) };
  } };
}
"""


def on_page_markdown(markdown: str, page: Any, **_: object) -> str:
    """The site has only this folder, so links from it to other files of the repository become plain text."""
    depth = page.file.src_uri.count("/") + 1
    return re.sub(rf"\[([^\]]+)\]\((?:\.\./){{{depth}}}[^)]*\)", r"\1", markdown)


def on_page_content(html: str, **_: object) -> str:
    """Tables get a box in which they scroll."""
    return html.replace("<table>", '<div class="scroll"><table>').replace("</table>", "</table></div>")


def on_post_build(config: Any, **_: object) -> None:
    """Adds search from disk."""
    search = Path(config.site_dir) / "search"
    (search / "main.js").write_text(FROM_DISK + (search / "main.js").read_text())
    lunr, worker, index = ((search / name).read_text() for name in ("lunr.js", "worker.js", "search_index.json"))
    run = f"window.postMessage = message => onWorkerMessage({{ data: message }});\ndata = {index};\nonScriptsLoaded();\n"
    (search / "disk.js").write_text(f"{lunr}\n{worker}\n{run}")
