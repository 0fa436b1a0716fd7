"""For MkDocs: the site has only this folder, so links from it to other files of the repository become plain text."""

import re
from typing import Any


def on_page_markdown(markdown: str, page: Any, **_: object) -> str:
    depth = page.file.src_uri.count("/") + 1
    return re.sub(rf"\[([^\]]+)\]\((?:\.\./){{{depth}}}[^)]*\)", r"\1", markdown)
