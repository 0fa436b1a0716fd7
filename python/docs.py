"""Writes docs/python-api.md, the page of all calls, from docstrings and signatures; with --check, only compares them.

    python docs.py ../docs/python-api.md
"""

from __future__ import annotations

import inspect
import sys
import typing
from pathlib import Path
from types import ModuleType

import underbrush
import underbrush.distributed
import underbrush.gym
import underbrush.hdf5
import underbrush.live
import underbrush.mcap
import underbrush.results
import underbrush.ros2
import underbrush.rerun
import underbrush.sklearn
import underbrush.video

HEAD = """# Python: all calls

This page is made from the docstrings by `python/docs.py`; do not edit it. [python.md](python.md) is the guide. Quantities are in
SI units, which names end with; vectors are in the frame that their name ends with.
"""


def signature(found: object) -> str:
    try:
        text = str(inspect.signature(found))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return ""
    for old, new in (("'", ""), ("(self, /", "("), ("(self", "("), ("(, ", "("), ("_core.", "")):
        text = text.replace(old, new)
    return text


def described(name: str, found: object, level: str) -> str:
    call = "" if isinstance(found, property) or inspect.isgetsetdescriptor(found) else signature(found)
    text = inspect.getdoc(found) or ""
    return f"{level} `{name}{call}`\n\n{text}\n"


def of_class(name: str, found: type) -> str:
    if typing.is_typeddict(found):
        keys = [f"* `{key}`: `{inspect.formatannotation(own)}`" for key, own in found.__annotations__.items()]
        return f"### `{name}`\n\n{inspect.getdoc(found)}\n\n" + "\n".join(keys).replace("underbrush.results.", "") + "\n"
    parts = [described(name, found, "###")]
    for member, value in sorted(vars(found).items()):
        if member.startswith("_") and member != "__call__":
            continue
        own = value.__func__ if isinstance(value, (staticmethod, classmethod)) else value
        doc = inspect.getdoc(own)
        is_attribute = isinstance(value, property) or inspect.isgetsetdescriptor(value)
        if doc and (is_attribute or callable(own)):
            call = "" if is_attribute else signature(own)
            first = doc.split("\n\n")[0].replace("\n", " ")
            parts.append(f"* `{member}{call}`: {first}")
    return parts[0] + "\n" + "\n".join(parts[1:]) + ("\n" if len(parts) > 1 else "")


def page() -> str:
    parts = [HEAD]
    modules: list[tuple[str, ModuleType, list[str]]] = [
        ("underbrush", underbrush, list(underbrush.__all__)),
        ("underbrush.sklearn", underbrush.sklearn, ["_TrialClassifier", *underbrush.sklearn.__all__]),
        ("underbrush.distributed", underbrush.distributed, ["generate", "reproduce", "benchmark"]),
        ("underbrush.rerun", underbrush.rerun, ["log"]),
        ("underbrush.live", underbrush.live, ["Server", "classify"]),
        ("underbrush.hdf5", underbrush.hdf5, ["export", "csv_of"]),
        ("underbrush.mcap", underbrush.mcap, ["export", "csv_of"]),
        ("underbrush.ros2", underbrush.ros2, ["export"]),
        ("underbrush.video", underbrush.video, ["film", "lerobot"]),
        ("underbrush.gym", underbrush.gym, ["ReachEnv", "ReachVectorEnv"]),
    ]
    of_results = [name for name, found in vars(underbrush.results).items() if typing.is_typeddict(found)]
    modules.append(("underbrush.results", underbrush.results, of_results))
    for title, module, names in modules:
        parts.append(f"## `{title}`\n\n{inspect.getdoc(module)}\n")
        for name in names:
            found = getattr(module, name)
            if name == "__version__":
                continue
            parts.append(of_class(name, found) if isinstance(found, type) else described(name, found, "###"))
    return "\n".join(parts)


def main() -> None:
    *options, path = sys.argv[1:]
    text = page()
    if "--check" not in options:
        Path(path).write_text(text, encoding="utf-8")
    elif Path(path).read_text(encoding="utf-8") != text:
        sys.exit(f"{path} is not that of the docstrings; run: python docs.py {path}")


if __name__ == "__main__":
    main()
