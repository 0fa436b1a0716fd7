"""Counts the product lines of Rust of each crate: without tests, comments and blank lines.

    python3 benches/lines.py [--files N]

`--files N` also lists the N largest files.
"""

import argparse
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = [
    "src", "sim/src", "classifier/src", "recording/src", "experiments/src", "report/src", "replay/src",
    "render/src", "exchange/src", "validation/src", "tests/oracles/src", "python/src", "workspace-hack/src",
]  # fmt: skip


def product_lines(text: str) -> int:
    """Lines of a file, without comments, blank lines and what follows `#[cfg(test)]`."""
    count = 0
    lines = iter(text.splitlines())
    for line in lines:
        bare = line.strip()
        if bare.startswith("#[cfg(test)]"):
            # Leave out the next item: it ends with its line, or where its braces are closed.
            depth, opened = 0, False
            for item in lines:
                depth += item.count("{") - item.count("}")
                opened |= "{" in item
                if (opened and depth <= 0) or (not opened and item.rstrip().endswith(";")):
                    break
        elif bare and not bare.startswith("//"):
            count += 1
    return count


def test_modules(path: Path) -> set[Path]:
    """The files of modules that a file declares for tests only."""
    names = re.findall(r"#\[cfg\(test\)\]\n\s*(?:pub(?:\([^)]*\))? )?mod (\w+);", path.read_text())
    folder = path.parent if path.stem in ("lib", "main", "mod") else path.with_suffix("")
    return {folder / name for name in names}


def main() -> None:
    """Prints a line for each crate, and their sum."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=0, metavar="N")
    files = parser.parse_args().files
    counts = {}
    for folder in FOLDERS:
        paths = [
            path
            for path in (ROOT / folder).rglob("*.rs")
            if "tests" not in path.relative_to(ROOT / folder).parts[:-1] and not re.fullmatch(r"tests?\.rs", path.name)
        ]
        tests = {module for path in paths for module in test_modules(path)}
        own = {path: product_lines(path.read_text()) for path in paths if path.with_suffix("") not in tests}
        counts |= own
        print(f"{sum(own.values()):6} {folder}")
    print(f"{sum(counts.values()):6} in all")
    for path, count in sorted(counts.items(), key=lambda pair: -pair[1])[:files]:
        print(f"{count:6} {path.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
