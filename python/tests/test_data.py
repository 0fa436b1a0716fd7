"""Data sets: arrays without a copy, tables, pickling."""

import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import polars
import pyarrow
import pytest
from conftest import quick
from mcap.reader import make_reader

import underbrush as ub
import underbrush.mcap
from underbrush._core import Numbers

TACTILE = "observation.tactile.forearm"


def test_columns_are_those_of_the_files(data: ub.Dataset) -> None:
    """Tests that every column, of the whole set and of a reach, holds what another reader finds in the Parquet
    files."""
    files = polars.read_parquet(f"{data.path}/data/**/*.parquet")
    for name in data.column_names:
        expected = files[name].to_numpy()
        assert np.array_equal(data.column(name), expected), name
        first = files.filter(polars.col("episode_index") == 2)[name].to_numpy()
        assert np.array_equal(data[2].column(name), first), name
    assert data.column(TACTILE).dtype == np.float32
    double = data.column(TACTILE, "float64")
    assert double.dtype == np.float64 and np.array_equal(double, files[TACTILE].to_numpy())
    angles = "observation.state"
    assert data.column(angles).dtype == np.float64
    single = data.column(angles, "float32")
    assert single.dtype == np.float32 and np.array_equal(single, files[angles].to_numpy().astype(np.float32))


def test_data_types_are_those_of_numpy(data: ub.Dataset) -> None:
    """Tests that columns take data types in all forms that NumPy takes, and refuse others with those that are allowed."""
    reach = data[0]
    for double in (float, np.float64, np.dtype("f8"), "double"):
        assert data.column(TACTILE, double).dtype == np.float64
        assert reach.sensed_force_n("forearm", double) is reach.column(TACTILE, "float64")
    assert reach.sensed_force_n("forearm", dtype=np.float32) is reach.sensed_force_n("forearm")
    for other in (np.int8, "int8", "colour", 3, True, ">f4"):
        for call in (data.column, reach.column):
            with pytest.raises(ub.InputError, match="dtype: found .*; allowed: float32 or float64"):
                call(TACTILE, other)


def test_long_reaches_have_several_pages(tmp_path: Path) -> None:
    """Tests the columns of a reach so long that its numbers are in several pages of the Parquet file."""
    data = ub.generate("leaf", 1, tmp_path / "set", seed=1, progress=False)
    files = polars.read_parquet(f"{data.path}/data/**/*.parquet")
    assert len(files) > 2048
    for name in data.column_names:
        assert np.array_equal(data.column(name), files[name].to_numpy()), name
        assert np.array_equal(data[0].column(name), files[name].to_numpy()), name


def test_arrays_view_the_native_numbers(data: ub.Dataset) -> None:
    """Tests that an array is a view without a copy: it owns no data, its base holds the numbers, it is read-only, and
    it outlives the reach."""
    reach = data[0]
    force = reach.sensed_force_n("forearm")
    assert force.shape == (len(reach), data.skin.taxels("forearm")) and force.dtype == np.float32
    base = force.base
    while isinstance(base, np.ndarray):
        base = base.base
    assert isinstance(base, Numbers) and not force.flags.owndata and not force.flags.writeable
    assert force.__array_interface__["data"][0] == base.__array_interface__["data"][0]
    with pytest.raises(ValueError, match="read-only"):
        force[0, 0] = 1.0
    assert reach.sensed_force_n("forearm") is force
    total = force.sum()
    del reach
    assert force.sum() == total


def test_ground_truth_is_apart(data: ub.Dataset) -> None:
    """Tests that the frames hold no ground truth, and that the ground truth of reaches agrees with their table."""
    assert not [name for name in data.column_names if name.startswith("truth")]
    rows = 0
    for number, reach in enumerate(data):
        true = reach.true_normal_force_n("forearm", "float64")
        table = data.table("truth/taxels", reach=number).to_polars()
        expected = np.zeros_like(true)
        patch = table.filter(polars.col("patch") == "forearm")
        if patch.height > 0:
            expected[patch["frame_index"].to_numpy(), patch["taxel"].to_numpy()] = patch["normal_force_n"].to_numpy()
        assert np.array_equal(true, expected)
        rows += patch.height
    assert rows > 0


def test_unsigned_integers_are_numbers(trials: ub.Trials) -> None:
    """Tests that a column of unsigned integers is an array with the values of the table."""
    table = trials.to_table()
    assert np.array_equal(table.column("trial"), trials.to_polars()["trial"].to_numpy())


def test_a_reach_is_unpickled_from_the_same_data_only(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that a pickled reach of a data set is refused if the set was made again with another seed."""
    set_path = tmp_path / "set"
    ub.generate(quick("trunk"), reaches=1, out=set_path, seed=1)
    pickled = pickle.dumps(ub.Dataset(set_path)[0])
    assert pickle.loads(pickled).seed_and_index == (1, 0)
    ub.generate(quick("trunk"), reaches=1, out=set_path, seed=2, force=True)
    with pytest.raises(ub.RunError, match="another data set"):
        pickle.loads(pickled)


def test_tables_reach_other_libraries(data: ub.Dataset, trials: ub.Trials) -> None:
    """Tests that Polars, pyarrow and pandas read tables through Arrow's C stream interface with the same content."""
    table = data.table("truth/contacts")
    frame = polars.DataFrame(table)
    assert frame.height == len(table) == sum(episode["contacts"] for episode in data.episodes)
    assert frame.equals(polars.from_arrow(pyarrow.table(table)))
    assert list(table.to_pandas().columns) == table.column_names
    samples = trials.to_polars()
    assert samples.height == int(trials.lengths.sum())
    assert isinstance(trials.to_pandas(), pandas.DataFrame)
    assert np.array_equal(samples["force_n"].to_numpy(), np.concatenate([trial.force_n for trial in trials]))


def test_empty_tables_have_columns(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that tables of a set whose reach touches nothing have the columns of those with rows."""
    free = ub.Scene.parse('summary = "Free space"\ngoals = { count = 1, x_m = 0.6, y_m = 0.0, z_m = -0.2 }\n', "free.toml")
    untouched = ub.generate(free, 1, tmp_path / "free", progress=False)
    for name in ("truth/taxels", "truth/patches", "truth/contacts", "truth/contact_points", "truth/objects"):
        table, other = untouched.table(name), data.table(name)
        assert len(table) == 0 < len(other) and table.to_polars().schema == other.to_polars().schema
    assert "radius_m" in untouched.table("controller/map").to_polars().columns
    assert untouched.table("truth/taxels", reach=0).column("normal_force_n").shape == (0,)


def test_a_data_set_is_a_sequence(data: ub.Dataset) -> None:
    """Tests length, indices from both ends, slices, and the end of iteration."""
    assert len(data) == 8
    assert data[-1].seed_and_index == data[7].seed_and_index
    assert [reach.scene for reach in data[3:5]] == ["leaf-quick", "trunk-quick"]
    assert len(list(data)) == 8
    with pytest.raises(IndexError):
        data[8]
    assert "leaf-quick" in data._repr_html_()


def test_copies_of_a_set_know_its_folder(data: ub.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests that a set that was opened by a relative path, and copies of it and of its reaches, can be read in another
    folder."""
    monkeypatch.chdir(data.path.parent)
    near = ub.Dataset(data.path.name)
    pickles = [pickle.dumps(near), pickle.dumps(near[1])]
    monkeypatch.chdir("/")
    assert len(near[2].time_s) == len(near[2])
    again, reach = map(pickle.loads, pickles)
    assert again.path == data.path
    assert np.array_equal(reach.time_s, data[1].time_s)


def test_a_lost_folder_is_an_error_of_storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests that a relative path after the working folder was removed is an error of storage."""
    (tmp_path / "lost").mkdir()
    monkeypatch.chdir(tmp_path / "lost")
    (tmp_path / "lost").rmdir()
    with pytest.raises(ub.StorageError):
        ub.Dataset("set")


def test_pickled_sets_and_reaches_read_the_same_files(data: ub.Dataset) -> None:
    """Tests that a pickled data set, and a reach of it, read the same data."""
    again, reach = pickle.loads(pickle.dumps(data)), pickle.loads(pickle.dumps(data[1]))
    assert again.path == data.path and np.array_equal(reach.time_s, data[1].time_s)


def test_unknown_names_are_refused(data: ub.Dataset) -> None:
    """Tests that unknown columns, tables and patches are refused with the known ones."""
    for call, text in (
        (lambda: data.column("force"), TACTILE),
        (lambda: data[0].column("force"), TACTILE),
        (lambda: data.table("truth"), "truth/taxels"),
        (lambda: data[0].sensed_force_n("hand"), "forearm"),
        (lambda: data[0].column("truth.moved_pose"), "table"),
    ):
        with pytest.raises(ub.InputError, match=text):
            call()


def test_damage_is_found(data: ub.Dataset, tmp_path: Path) -> None:
    """Tests that a changed byte in a table is an error that names the file, and that a removed set is an error."""
    folder = tmp_path / "copy"
    shutil.copytree(data.path, folder)
    copy = ub.Dataset(folder)
    copy.verify()
    path = next(folder.glob("data/**/*.parquet"))
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))
    with pytest.raises(ub.InputError, match=path.name):
        copy.column(TACTILE)
    with pytest.raises(ub.InputError, match=path.name):
        copy.verify()
    shutil.rmtree(folder)
    with pytest.raises((ub.InputError, ub.RunError)):
        ub.Dataset(folder)
    with pytest.raises((ub.InputError, ub.RunError)):
        copy[0].time_s


def test_map_style_data_sets(data: ub.Dataset, trials: ub.Trials) -> None:
    """Tests what a PyTorch data loader needs: float32 arrays of one length with labels, and frames that may be
    changed."""
    pairs = ub.TrialDataset(trials, samples=30)
    assert pairs.categories == ["leaf", "trunk"] and len(pairs) == len(trials)
    array, label = pairs[0]
    assert array.shape == (30, 1) and array.dtype == np.float32
    assert pairs.categories[label] == trials[0].category
    assert np.array_equal(array[:20, 0], trials[0].force_n[:20].astype(np.float32))
    with pytest.raises(ub.InputError, match=r"categories: found \['x'\]"):
        ub.TrialDataset(trials, ["x"])
    for samples in (0, 2.5, True):
        with pytest.raises(ub.InputError, match=f"samples: found {samples}"):
            ub.TrialDataset(trials, samples=samples)
    with pytest.raises(ub.InputError, match="categories: found .* allowed: each name once"):
        ub.TrialDataset(trials, ["leaf", "trunk", "leaf"])
    with pytest.raises(ub.InputError, match="columns: found 'colour'"):
        ub.FrameDataset(data, ["action", "colour"])
    frames = ub.FrameDataset(data, [TACTILE, "action"])
    assert len(frames) == len(data.column("time_s"))
    last = frames[-1]
    last[TACTILE][0] = 1.0
    assert np.array_equal(last["action"], data.column("action", "float32")[-1])
    with pytest.raises(IndexError):
        frames[len(frames)]


def test_a_log_says_that_it_is_one(tmp_path: Path, command: Callable[..., Any]) -> None:
    """Tests that a reach imported from a robot's log shows no seed, no controller and no goal, and that a simulated one is no
    log."""
    (tmp_path / "log.csv").write_text("what,f0\n" + "leaf,0.5\n" * 10)
    (tmp_path / "taxels.csv").write_text("x_m,y_m,z_m,normal_x,normal_y,normal_z,area_m2\n0,0,0,0,0,1,1e-4\n")
    (tmp_path / "map.toml").write_text(
        '[time]\nrate_hz = 100\n[force]\nfrom = "f{taxel}"\ntaxels = 1\n'
        '[trial]\npatch = "pad"\ncategory_from = "what"\n[skin]\ntaxels = "taxels.csv"\n'
    )
    command("import", tmp_path / "log.csv", "--mapping", tmp_path / "map.toml", "--out", tmp_path / "felt")
    log = ub.Reach.load(tmp_path / "felt" / "reach-000000.parquet")
    assert log.is_log and repr(log) == 'Reach(log="log", index=0, 10 frames)'
    assert log.outcome == "unknown" and log._repr_png_() is None
    # One joint and one taxel have an axis, too.
    assert log.joint_angle_rad.shape == (10, 1) and log.sensed_force_n("pad").shape == (10, 1)
    ub.mcap.export(log, tmp_path / "log.mcap")
    with open(tmp_path / "log.mcap", "rb") as file:
        topics = {channel.topic for _, channel, _ in make_reader(file).iter_messages()}
    assert "/joint_states" in topics and "/goal" not in topics
    assert not ub.reach(quick("trunk"), 1).is_log
