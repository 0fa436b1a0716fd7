"""The script that makes tables of trials from public data sets, on small files in the formats of these sets."""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).parents[2] / "examples" / "public-data" / "convert.py"
OBJECTS = (
    "blue_bear book empty_coke empty_vitamin_water full_vitamin_water lotion med_coke med_vitamin_water monkey_toy none"
).split()


def convert(name: str, data: Path, out: Path) -> list[dict[str, str]]:
    """The rows of the table."""
    subprocess.run([sys.executable, SCRIPT, name, data, out], check=True, capture_output=True)
    with out.open() as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("name", ["failures", "grasps", "slides"])
def test_missing_data_are_told_where_they_are(name: str, tmp_path: Path) -> None:
    """Tests that without the data the script says where they are and under which licence, and writes nothing."""
    words: list[str | Path] = [sys.executable, SCRIPT, name, tmp_path / "nowhere", tmp_path / "out.csv"]
    found = subprocess.run(words, check=False, capture_output=True, text=True)
    assert found.returncode == 1 and not (tmp_path / "out.csv").exists()
    assert "https://" in found.stderr and "Licence: " in found.stderr and "Cite: " in found.stderr


def test_wrenches_of_failures(tmp_path: Path) -> None:
    """Tests that each block of the file becomes a trial with its category, channels, and the length of its force."""
    text = "normal\n\t3\t-4\t0\t1\t2\t3\n\t0\t0\t7\t0\t0\t0\n\n\ncollision\n\t-1\t-2\t2\t0\t0\t9\n\n\n"
    (tmp_path / "lp.data").write_text(text)
    rows = convert("failures", tmp_path / "lp.data", tmp_path / "out.csv")
    assert [(row["trial"], row["category"], float(row["force_n"])) for row in rows] == [
        ("0", "normal", 5),
        ("0", "normal", 7),
        ("1", "collision", 3),
    ]
    assert [rows[0][name] for name in ("fx", "fy", "fz", "tx", "ty", "tz")] == ["3", "-4", "0", "1", "2", "3"]


def test_fingertips_of_grasps(tmp_path: Path) -> None:
    """Tests that a press of a taxel is a rise above the first sample of its grasp, whatever that reads."""
    rest = [" ".join(["240.0"] * 12)] * 5
    pressed = [rest[0], " ".join(["240.0"] * 11 + ["228.0"]), *rest[2:]]
    lines = ["-10000", *["joints", "largest", *rest], *["joints", "largest", *pressed]]
    for name in OBJECTS:
        for number in range(1, 21):
            (tmp_path / f"{name}_{number}.txt").write_text("\n".join(lines))
    rows = convert("grasps", tmp_path, tmp_path / "out.csv")
    assert len(rows) == 10 * 20 * 2
    first, second = rows[:2]
    assert float(first["force_n"]) == 0 and float(second["force_n"]) == 12
    assert (float(second["index_max"]), float(second["index_mean"]), float(second["thumb_max"])) == (12, 1, 0)


def test_taxels_of_slides(tmp_path: Path) -> None:
    """Tests that numbers in the order of the published files become the sums of their rows, columns and frames."""
    slide = np.arange(10 * 75 * 6, dtype=np.float32).reshape(10, 75, 6) / 100
    # As the files have it: the 75 x 6 numbers of a row cut into six parts, and the rows within each part.
    stored = slide.reshape(10, 6, 75).transpose(1, 0, 2)[None]
    for part in ("val_0", "val_1", "val_2", "val_3", "test"):
        np.save(tmp_path / f"icub_{part}.npy", np.ascontiguousarray(stored))
        np.save(tmp_path / f"labels_{part}.npy", np.array([16]))
    rows = convert("slides", tmp_path, tmp_path / "out.csv")
    assert len(rows) == 5 * 75 and {row["category"] for row in rows} == {"mat17"}
    for frame in (0, 40, 74):
        row = rows[frame]
        assert float(row["force_n"]) == pytest.approx(slide[:, frame].max(), rel=1e-3)
        assert float(row["row_3"]) == pytest.approx(slide[3, frame].sum(), rel=1e-3)
        assert float(row["column_5"]) == pytest.approx(slide[:, frame, 5].sum(), rel=1e-3)
        assert int(row["pressed"]) == (slide[:, frame] > 5).sum()
