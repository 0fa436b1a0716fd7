#!/usr/bin/env python3
"""How many unknown objects a touch model finds if it was trained without the family that is nearest to them.

    python3 benches/left_out_family.py --folder DIR [--underbrush target/release/underbrush] [--model suites/touch.json]

Each family of unknown objects has trees of its own, so a model without a family's trees never saw that family. Of its limits,
only those over all families come from all of them, and fewer objects are called unknown at the same share. So the share is
chosen anew on development seed 6000: the one with which nearly as many known objects are called unknown as with all families.
The models and data sets go to DIR; sets that are there are used again. Prints a row for each family, and warnings that these
models have no seal. Needs no packages.
"""

import argparse
import json
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Each family, and the scene of unknown objects that are nearest to it.
FAMILIES = {
    "soft_roll": "soft-roll",
    "stiff_pole": "hard-roll",
    "free_cylinder": "full-bottle",
    "stalk": "springy-branch",
}
SHARES = [share / 100 for share in range(5, 13)]
COLUMNS = [
    "family left out", "scene", "all families: found %", "area under the ROC curve",
    "left out, same share: found %", "area under the ROC curve",
    "share for equal false alarms", "known objects called unknown, seed 6000", "found % (interval)", "known called unknown %",
]  # fmt: skip


def without(model: dict, family: str) -> dict:
    """The model without the trees and limits of a family."""
    model = json.loads(json.dumps(model))
    # The file's checksum would no longer fit.
    model.pop("blake3", None)
    unknown = model["unknown_objects"]
    place = [own["name"] for own in unknown["families"]].index(family)
    del unknown["families"][place]
    for stage in unknown["stages"]:
        for category in stage:
            del category["families"][place]
    return model


def false_alarms(evaluation: dict) -> int:
    """The number of known objects that are called unknown at their end."""
    return evaluation["unknown"]["false_alarm_objects"]


def found(evaluation: dict, interval: bool = False) -> str:
    """The share of unknown objects that are found, %."""
    unknown = evaluation["unknown"]
    share = f"{100 * unknown['found_objects'] / unknown['unknown_objects']:.0f}"
    low, high = (f"{100 * unknown['found_interval'][end]:.0f}" for end in ("low", "high"))
    return f"{share} ({low} to {high})" if interval else share


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--underbrush", default="target/release/underbrush")
    parser.add_argument("--model", type=Path, default=ROOT / "suites/touch.json")
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()
    jobs = [] if options.jobs is None else ["--jobs", str(options.jobs)]

    def run(*words: object) -> str:
        command = [options.underbrush, *map(str, words), *jobs]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout

    def data(name: str, reaches: int, seed: int, *scenes: object) -> Path:
        place = options.folder / name
        if not place.exists():
            run("generate", *scenes, "--reaches", reaches, "--seed", seed, "--out", place)
        return place

    def evaluated(data: Path, model: Path, share: float = 0.05) -> dict:
        return json.loads(run("evaluate", data, "--model", model, "--unknown-share", share, "--json"))

    options.folder.mkdir(parents=True, exist_ok=True)
    whole = json.loads(options.model.read_text())
    known = data("known-6000", 30, 6000, "leaf", "trunk", "mixed")
    allowed = false_alarms(evaluated(known, options.model))
    print(f"All families: {allowed} known objects of seed 6000 are called unknown.\n")
    print(f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|")
    for family, scene in FAMILIES.items():
        model = options.folder / f"without-{family}.json"
        model.write_text(json.dumps(without(whole, family)))
        test = data(f"{scene}-37000", 85, 37000, ROOT / f"scenes/unknown/{scene}.toml")
        alarms = {share: false_alarms(evaluated(known, model, share)) for share in SHARES}
        share = min(SHARES, key=lambda share: abs(alarms[share] - allowed))
        all_families, same, equal = evaluated(test, options.model), evaluated(test, model), evaluated(test, model, share)
        roc = [f"{own['unknown']['roc_area']:.2f}" for own in (all_families, same)]
        false_share = f"{100 * false_alarms(equal) / equal['unknown']['known_objects']:.1f}"
        cells = [
            family, scene, found(all_families, True), roc[0], found(same), roc[1],
            f"{share:.2f}", str(alarms[share]), found(equal, True), false_share,
        ]  # fmt: skip
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
