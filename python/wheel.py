"""Checks a wheel as those who install it meet it: its tags, its size, and its work in a new environment, from an empty folder.

    python wheel.py underbrush-0.1.0-cp311-abi3-manylinux_2_28_x86_64.whl
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

LARGEST_BYTES = 15_000_000
# The scenes and the arm that ship, by name, and an arm of one's own, by its files.
SCENES = ("leaf", "mixed", "hedge", "panda/foliage.toml")
PANDA = Path(__file__).parents[1] / "docs" / "arms" / "panda"


def check_name(name: str) -> None:
    """Checks that one wheel is for all Pythons from 3.11 on, and says for which systems it is."""
    *_, python, abi, platform = name.removesuffix(".whl").split("-")
    if (python, abi) != ("cp311", "abi3"):
        sys.exit(f"{name} is not for all Pythons from 3.11 on: cp311-abi3 is missing")
    if platform.startswith("linux_"):
        print(f"{name} is for systems with the libraries of this one. Wheels that are published are built in a manylinux container.")
    elif sys.platform == "linux" and not platform.startswith("manylinux_"):
        sys.exit(f"{name} is for neither manylinux nor this system")


def check_work(wheel: Path, folder: Path) -> None:
    """Checks that it works with nothing but its dependencies, and finds what it ships."""
    venv.create(folder / "venv", with_pip=True)
    programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    empty = folder / "empty"
    shutil.copytree(PANDA, empty / "panda")
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "UNDERBRUSH")}

    def run(program: str, *arguments: str) -> str:
        options = {"cwd": empty, "env": environment, "check": True, "stdout": subprocess.PIPE, "text": True}
        return str(subprocess.run([programs / program, *arguments], **options).stdout)  # type: ignore[call-overload]

    run("python", "-m", "pip", "install", "--quiet", str(wheel))
    for scene in SCENES:
        if "sound" not in run("underbrush", "inspect", scene):
            sys.exit(f"the scene {scene} is not sound in the wheel")
    run("underbrush", "reach", "trunk", "--out", "reach.parquet")
    run("underbrush", "replay", "reach.parquet", "--out", "page.html")
    if "</html>" not in (empty / "page.html").read_text(encoding="utf-8"):
        sys.exit("the wheel has no replay page")
    urdf = "import underbrush as ub; print(ub.Arm.load('panda/panda.toml').name, ub.Arm.cody().files['cody.urdf'])"
    if "<robot" not in run("python", "-c", urdf):
        sys.exit("the wheel has no arm")


def main() -> None:
    wheel = Path(sys.argv[1]).resolve()
    check_name(wheel.name)
    if wheel.stat().st_size > LARGEST_BYTES:
        sys.exit(f"{wheel.name} has {wheel.stat().st_size / 1e6:.1f} MB, more than {LARGEST_BYTES / 1e6:.0f}")
    with tempfile.TemporaryDirectory() as folder:
        check_work(wheel, Path(folder))
    print(f"{wheel.name}, {wheel.stat().st_size / 1e6:.1f} MB, works")


if __name__ == "__main__":
    main()
