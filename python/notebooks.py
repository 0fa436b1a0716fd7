"""Writes the notebook beside each example from its script, with what its cells print and draw.

    python -P notebooks.py examples/*.py            # runs the scripts as notebooks and writes them
    python -P notebooks.py --check examples/*.py    # runs them, and compares cells and pictures with those that are stored
    python -P notebooks.py --cells examples/*.py    # writes or, with --check, compares the cells alone, and runs nothing

The script's docstring becomes a cell of text, and `# %%` begins a cell of code. Printed text is stored but not compared, because
other versions of other packages print other numbers. The pictures of underbrush are the same on every machine. Of plots only the
number is compared, because other versions of Matplotlib draw other fonts.
"""

from __future__ import annotations

import argparse
import ast
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

MARK = "# %%"


def notebook(script: str) -> Any:
    """The cells of a script."""
    head, *blocks = script.split(f"\n{MARK}\n")
    text = ast.get_docstring(ast.parse(head))
    if text is None or not blocks:
        raise SystemExit(f"an example begins with a docstring, and {MARK} begins each cell")
    new = nbformat.v4
    cells = [new.new_markdown_cell(text), *(new.new_code_cell(block.strip("\n")) for block in blocks)]
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return new.new_notebook(cells=cells, metadata={"kernelspec": kernel, "language_info": {"name": "python"}})


def run(own: Any, folder: Path) -> None:
    """Runs the cells in their folder. What differs from run to run is left out."""
    options: dict[str, Any] = {"timeout": 3600, "record_timing": False, "coalesce_streams": True}
    NotebookClient(own, resources={"metadata": {"path": str(folder)}}, **options).execute()
    own["metadata"]["language_info"] = {"name": "python"}
    for cell in own["cells"]:
        if cell["cell_type"] == "code":
            # Progress is for those who wait.
            cell["outputs"] = [shown for shown in cell["outputs"] if shown.get("name") != "stderr"]


def compared(own: Any) -> tuple[list[str], list[str]]:
    """The texts of the cells, and their pictures."""
    outputs = [shown["data"] for cell in own["cells"] for shown in cell.get("outputs", []) if "data" in shown]
    pictures = [
        "plot" if data.get("text/plain", "").startswith("<Figure") else data["image/png"].strip()
        for data in outputs
        if "image/png" in data
    ]
    return [cell["source"] for cell in own["cells"]], pictures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare, and write nothing")
    parser.add_argument("--cells", action="store_true", help="run nothing")
    parser.add_argument("scripts", nargs="+", type=Path, help="examples/*.py")
    options = parser.parse_args()
    for script in options.scripts:
        path, own = script.with_suffix(".ipynb"), notebook(script.read_text(encoding="utf-8"))
        if not options.cells:
            run(own, script.parent)
        if not options.check:
            nbformat.write(own, path)
            continue
        stored = compared(nbformat.read(path, as_version=4)) if path.exists() else None
        found = compared(own)
        if stored is None or stored[0] != found[0] or not options.cells and stored[1] != found[1]:
            raise SystemExit(f"{path} is not that of its script; run: python -P notebooks.py {script}")


if __name__ == "__main__":
    main()
