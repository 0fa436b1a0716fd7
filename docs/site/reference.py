"""For MkDocs: makes the pages of commands, files and crates, from the program and the workspace, each time the site is built.

The program is $UNDERBRUSH, or that of the installed package, or target/release/underbrush. Without any of them the pages say
so, and `mkdocs build --strict` fails.
"""

import functools
import html
import json
import logging
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

LOG = logging.getLogger("mkdocs.hooks.reference")
ROOT = Path(__file__).parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
NO_PROGRAM = (
    "There is no program to make this page from. Install the package (`pip install ./python`) or build the program (`cargo build "
    "--release`), and build the site again."
)
# The page of commands explains them once.
SHARED = ("--json", "--jobs <N>", "-h, --help", "-V, --version")

Schema = dict[str, Any]


@functools.cache
def program() -> Path | None:
    """The program whose commands and files are described."""
    places = [Path(sys.executable).with_name("underbrush"), TARGET / "release" / "underbrush"]
    if given := os.environ.get("UNDERBRUSH"):
        places.insert(0, Path(given))
    return next((place for place in places if place.is_file()), None)


@functools.cache
def answer(*arguments: str) -> str:
    """What the program prints, as wide as it prints to a terminal at most."""
    options: dict[str, Any] = {"check": True, "capture_output": True, "encoding": "utf-8", "env": os.environ | {"COLUMNS": "100"}}
    return str(subprocess.run([str(program()), *arguments], **options).stdout)


def escaped(text: str) -> str:
    return html.escape(text, quote=False)


def code(value: object) -> str:
    return f"<code>{escaped(value if isinstance(value, str) else json.dumps(value))}</code>"


def inline(text: str) -> str:
    """Text as HTML, with what is in backticks as code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escaped(" ".join(text.split())))


# Commands


def sections(text: str) -> Iterator[tuple[str, list[str]]]:
    """The parts of a help text, each with its heading and its lines: what it does, `Usage`, `Options`, …"""
    for part in re.split(r"\n\n(?=\S)", text.strip()):
        first, *lines = part.split("\n")
        is_list = bool(lines) and first.endswith(":") and all(line == "" or line.startswith(" ") for line in lines)
        yield (first[:-1], lines) if is_list else ("", [first, *lines])


def items(lines: list[str]) -> list[tuple[str, list[str]]]:
    """Options, arguments or commands, each with the lines of its description, beside it or below it."""
    found: list[tuple[str, list[str]]] = []
    for line in lines:
        if re.match(r" {2,6}\S", line):
            name, *beside = re.split(r" {2,}", line.strip(), maxsplit=1)
            found.append((name, beside))
        else:
            found[-1][1].append(line.strip())
    return found


def description(lines: list[str]) -> str:
    """The description of an option, with the values that it may have as a list."""
    parts = []
    for text in re.split(r"\n\n", "\n".join(lines)):
        heading, *values = re.split(r"\n- ", text)
        values = [re.sub(r"(\S+): +(.*)", r"`\1`: \2", " ".join(value.split())) for value in values]
        listed = "".join(f"<li>{inline(value)}</li>" for value in values)
        parts.append(inline(heading) + (f"<ul>{listed}</ul>" if listed else ""))
    return "<br>".join(part for part in parts if part)


def command(words: tuple[str, ...]) -> str:
    """A command, and those within it."""
    name = " ".join(("underbrush", *words))
    text, below = f"## {name}\n\n", ""
    for heading, lines in sections(answer(*words, "--help")):
        if heading == "Commands":
            names = [(own, about) for own, about in items(lines) if own != "help"]
            shown = [(f'<a href="#{slug(name, own)}">{own}</a>', about) for own, about in names]
            below = "".join(command((*words, own)) for own, _ in names)
        elif heading and re.match(r"\s*[-<\[]", "\n".join(lines)):
            shown = [(code(own), about) for own, about in items(lines) if not words or own not in SHARED]
        else:
            # Examples keep their columns.
            is_prose = not heading and not re.search(r"\S {2,}\S", "\n".join(lines)) and not lines[0].startswith("Usage:")
            whole = escaped("\n".join(line.removeprefix("  ") for line in lines))
            text += f"<p>{heading}</p>\n" * bool(heading)
            text += f"<p>{inline(' '.join(lines))}</p>\n\n" if is_prose else f"<pre><code>{whole}</code></pre>\n\n"
            continue
        if shown:
            text += f"<p>{heading}</p>\n<dl>"
            text += "".join(f"<dt>{own}</dt><dd>{description(about)}</dd>\n" for own, about in shown) + "</dl>\n\n"
    return text + below


def slug(*words: str) -> str:
    return "-".join(words).lower().replace(" ", "-")


def commands() -> str:
    head = "This page is made from `underbrush COMMAND --help`. `--json`, `--jobs` and `--help` are options of every command."
    return f"# Command line\n\n{head}\n\n{command(())}"


# Files


def kinds() -> dict[str, str]:
    """The kinds of file that have a schema, and what each is."""
    listed = next(lines for heading, lines in sections(answer("schema", "--help")) if heading == "Arguments")
    values = " ".join(" ".join(listed).split()).partition("Possible values:")[2].partition("[default")[0]
    return dict(re.findall(r"- (\w+): +\w+: (.+?)(?= - \w+: |$)", values.strip()))


def number(value: float) -> str:
    return f"{value:g}" if abs(value) >= 1e7 or value != round(value) else f"{value:.0f}"


def limits(schema: Schema) -> str:
    low, high, unit = schema.get("minimum"), schema.get("maximum"), schema.get("unit", "")
    if low is not None and high is not None:
        text = f" from {number(low)} to {number(high)}"
    else:
        text = "" if low is None else f" of at least {number(low)}"
    return f"{text} {escaped(unit)}".rstrip() if text else f", {escaped(unit)}" * bool(unit)


def value(schema: Schema, is_limited: bool = True) -> str:
    """What a key may hold, with limits or without."""
    alternatives = schema.get("anyOf") or schema.get("oneOf") or schema.get("allOf")
    kind = schema.get("type", "")
    if isinstance(kind, list):
        kind = next(own for own in kind if own != "null")
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f'<a href="#{name.lower()}">{name}</a>'
    if "const" in schema:
        return code(schema["const"])
    if "enum" in schema:
        return " or ".join(code(own) for own in schema["enum"])
    if alternatives:
        return " or ".join(value(own, is_limited) for own in alternatives if own.get("type") != "null")
    if kind == "array":
        first, sizes = schema.get("prefixItems"), (schema.get("minItems"), schema.get("maxItems"))
        if first:
            return f"[{', '.join(value(own, is_limited) for own in first)}]"
        count = f" {sizes[0]}" if sizes[0] == sizes[1] is not None else ""
        return f"list of{count}: {value(schema.get('items', {}), is_limited)}"
    if "properties" in schema:
        # The limits of the numbers within are those of the number itself, or nearly.
        own = [f"{key} = {value(kept, False)}" for key, kept in schema["properties"].items()]
        return "{ " + ", ".join(own) + " }"
    if kind == "object":
        inner = schema.get("additionalProperties")
        return f"table of names, each: {value(inner, is_limited)}" if isinstance(inner, dict) else "table"
    names = {"boolean": "true or false", "integer": "whole number", "string": "text", "": "anything"}
    return names.get(kind, kind) + (limits(schema) if is_limited else "")


def keys(schema: Schema) -> str:
    """A table of the keys of a table."""
    rows = []
    for key, own in schema.get("properties", {}).items():
        held = value(own)
        if key in schema.get("required", []):
            held += ". Required"
        elif own.get("default") not in (None, {}, []) and not isinstance(own["default"], dict):
            held += f". Default {code(own['default'])}"
        rows.append(f"<tr><td>{code(key)}</td><td>{held}</td><td>{inline(own.get('description', ''))}</td></tr>\n")
    head = "<thead><tr><th>key</th><th>value</th><th>meaning</th></tr></thead>"
    return f"<table>{head}<tbody>\n{''.join(rows)}</tbody></table>\n\n" if rows else ""


def definition(schema: Schema) -> str:
    """What a table of a file holds, or which values a name stands for."""
    text = f"{inline(schema.get('description', ''))}\n\n{keys(schema)}"
    if "oneOf" in schema or "anyOf" in schema:
        alternatives = schema.get("oneOf") or schema["anyOf"]
        if all(set(own) == {"required"} for own in alternatives):
            either = " or ".join(", ".join(code(key) for key in own["required"]) for own in alternatives)
            return f"{text}<p>Either {either}.</p>\n\n"
        listed = "".join(f"<li>{value(own)}. {inline(own.get('description', ''))}</li>\n" for own in alternatives)
        return f"{text}<ul>\n{listed}</ul>\n\n"
    for part in schema.get("allOf", []):
        for key, condition in part["if"]["properties"].items():
            text += f"### {key} = {', '.join(condition['enum'])}\n\n{definition(part['then'])}"
    if not keys(schema) and schema.get("type") != "object" and "allOf" not in schema:
        text += f"<p>{value(schema)}</p>\n\n"
    return text


def named(schema: object) -> Iterator[str]:
    """The definitions that are referred to, in order."""
    if isinstance(schema, dict):
        if isinstance(target := schema.get("$ref"), str):
            yield target.rpartition("/")[2]
        schema = [own for key, own in schema.items() if key != "$defs"]
    if isinstance(schema, list):
        for own in schema:
            yield from named(own)


def file_page(kind: str, about: str) -> str:
    """The page of a kind of file. Its definitions are in the order in which they are met."""
    schema: Schema = json.loads(answer("schema", kind))
    order = list(dict.fromkeys(named(schema)))
    for name in order:
        order += [own for own in dict.fromkeys(named(schema["$defs"][name])) if own not in order]
    text = (
        f"# File: {kind}\n\n{inline(about[0].upper() + about[1:])}. This page is made from the JSON Schema that `underbrush schema "
        f'{kind}` prints: <a href="{kind}.schema.json">{kind}.schema.json</a>, for editors and programs.\n\n'
    )
    return text + definition(schema) + "".join(f"## {name}\n\n{definition(schema['$defs'][name])}" for name in order)


# Crates


def crates() -> dict[str, str]:
    """The crates of the workspace that are published, and what each is."""
    members = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["members"]
    manifests = [tomllib.loads((ROOT / place / "Cargo.toml").read_text(encoding="utf-8"))["package"] for place in (".", *members)]
    return {own["name"]: own["description"] for own in manifests if own.get("publish", True) and "hack" not in own["name"]}


def rust_page(is_there: bool) -> str:
    text = "# Rust\n\nThe crates, from `Cargo.toml`. `cargo doc --workspace --no-deps --open` makes the pages of all their items. "
    text += "" if is_there else "They were not there when this site was built. "
    text += "Once the crates are published, docs.rs has these pages, too.\n\n"
    text += "<table><thead><tr><th>crate</th><th>what it is</th></tr></thead><tbody>\n"
    for name, about in crates().items():
        shown = f'<a href="../rust/{name.replace("-", "_")}/index.html">{name}</a>' if is_there else code(name)
        text += f"<tr><td>{shown}</td><td>{inline(about)}</td></tr>\n"
    return f"{text}</tbody></table>\n"


def rust_is_there() -> bool:
    return all((TARGET / "doc" / name.replace("-", "_") / "index.html").exists() for name in crates())


# The site


def in_nav(nav: Iterable[Any]) -> Iterator[str]:
    """The pages of the navigation that this hook makes."""
    for entry in nav:
        if isinstance(entry, dict):
            entry = [page for pages in entry.values() for page in (pages if isinstance(pages, list) else [pages])]
            yield from in_nav(entry)
        elif entry.startswith("reference/"):
            yield entry


def on_files(files: Files, config: Any, **_: object) -> Files:
    """Adds the pages."""
    listed = list(in_nav(config.nav))
    made = {"reference/rust.md": rust_page(rust_is_there())}
    if program() is None:
        LOG.warning(NO_PROGRAM)
        made |= {name: f"# {Path(name).stem.capitalize()}\n\n{NO_PROGRAM}\n" for name in listed if name not in made}
    else:
        made["reference/commands.md"] = commands()
        for kind, about in kinds().items():
            made[f"reference/{kind}.md"] = file_page(kind, about)
            files.append(File.generated(config, f"reference/{kind}.schema.json", content=answer("schema", kind)))
    for name in made:
        files.append(File.generated(config, name, content=made[name]))
    if set(listed) != set(made):
        LOG.warning("mkdocs.yml must list these pages: %s", ", ".join(made))
    return files


def on_post_build(config: Any, **_: object) -> None:
    """Copies the pages that `cargo doc` has made."""
    if rust_is_there():
        shutil.copytree(TARGET / "doc", Path(config.site_dir) / "rust", dirs_exist_ok=True)
