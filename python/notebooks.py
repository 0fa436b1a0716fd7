"""Writes the notebook beside each example from its script; with --check, only compares them. Notebooks hold no outputs.

    python notebooks.py examples/*.py

The script's docstring becomes a cell of text, and `# %%` begins a cell of code.
"""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path
from typing import Any

MARK = "# %%"


def cell(kind: str, number: int, text: str) -> dict[str, Any]:
    own: dict[str, Any] = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}}
    if kind == "code":
        own |= {"execution_count": None, "outputs": []}
    return own | {"source": text.strip("\n").splitlines(keepends=True)}


def notebook(script: str) -> str:
    head, *blocks = script.split(f"\n{MARK}\n")
    text = ast.get_docstring(ast.parse(head))
    if text is None or not blocks:
        raise SystemExit(f"an example begins with a docstring, and {MARK} begins each cell")
    cells = [cell("markdown", 0, text)]
    cells += [cell("code", number, block) for number, block in enumerate(blocks, 1)]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    content = {
        "cells": cells,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def main() -> None:
    scripts = [Path(own) for own in sys.argv[1:] if own != "--check"]
    if not scripts:
        raise SystemExit("no scripts; give examples/*.py")
    for script in scripts:
        path, text = script.with_suffix(".ipynb"), notebook(script.read_text(encoding="utf-8"))
        if "--check" not in sys.argv:
            path.write_text(text, encoding="utf-8")
        elif not path.exists() or path.read_text(encoding="utf-8") != text:
            raise SystemExit(f"{path} is not that of its script; run: python notebooks.py examples/*.py")


if __name__ == "__main__":
    main()
