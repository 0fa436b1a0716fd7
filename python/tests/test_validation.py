"""Physics checks and the replay page."""

from pathlib import Path

import pytest

import underbrush as ub


def test_checks_pass_and_can_fail() -> None:
    """Tests that a check passes and that it fails with a tolerance of 0, and that bad names and scales are refused."""
    name = next(name for name in ub.checks() if "leaf" in name)
    (passed,) = ub.validate([name])
    assert passed["name"] == name and passed["verdict"] == "pass" and passed["comparisons"]
    (failed,) = ub.validate([name], tolerance_scale=0.0)
    assert failed["verdict"] == "fail"
    with pytest.raises(ub.InputError, match=name):
        ub.validate(["no-such"])
    with pytest.raises(ub.InputError, match="only: found none"):
        ub.validate([])
    with pytest.raises(ub.InputError, match=f"only: found {name}; allowed: a list"):
        ub.validate(name)
    with pytest.raises(ub.InputError, match="zero or more"):
        ub.validate([name], tolerance_scale=-1.0)


def test_the_replay_page_holds_the_reach(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that the page of a data set, and of a reach in memory, is one HTML file with the reaches inside, each once, and that
    no reaches and what are no numbers of reaches are refused."""
    page = ub.replay(data, [0, 1, 0])
    page.save(tmp_path / "new" / "page.html")
    text = (tmp_path / "new" / "page.html").read_text()
    assert text.count('id="underbrush-reach-') == 2 and "<iframe" in page._repr_html_()
    one = ub.replay(ub.Reach.load(_saved(data, tmp_path)))
    assert one.html.count('id="underbrush-reach-') == 1
    for reaches, found in (([], "none"), ([-1], "-1"), ([True], "True"), (0, "0")):
        with pytest.raises(ub.InputError, match=f"reaches: found {found}; allowed"):
            ub.replay(data, reaches)


def _saved(data: ub.Dataset, folder: Path) -> Path:
    data[0].save(folder / "reach.parquet")
    return folder / "reach.parquet"
