"""Films of reaches, and data sets with camera pictures that LeRobot loads.

    python -m underbrush.video film reach.parquet --out reach.mp4
    python -m underbrush.video lerobot my-set --out my-set-video --fps 25

Needs PyAV and pyarrow: ``pip install 'underbrush[video]'``.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core, _export
from ._errors import InputError

# Pictures that are drawn at once: enough for all cores, few enough to hold them.
_AT_ONCE = 64
# Every so many pictures, and pixels along each edge, enter the statistics of a camera.
_SAMPLED_PICTURES, _SAMPLED_PIXELS = 5, 4
# No farther depth fits into 16 bits of 1 mm, m.
_FARTHEST_M = 65.535
_QUANTILES = {"q01": 1, "q10": 10, "q50": 50, "q90": 90, "q99": 99}
# Where the camera of a data set is if its scenes have none, m: it sees the clutter of the shipped scenes.
_TARGET = (0.55, -0.05, -0.15)
_FRONT = _core.Camera((0.9, -1.5, 0.7), _TARGET)
_KINDS = {
    ".mp4": ("mp4", {}, "libx264", "yuv420p", {"crf": "20"}),
    # 0 repeats it without end.
    ".webp": ("webp", {"loop": "0"}, "libwebp_anim", "yuva420p", {"quality": "85"}),
}


def _av() -> Any:
    try:
        import av
    except ImportError as error:
        raise ImportError("underbrush.video needs PyAV: pip install 'underbrush[video]'") from error
    return av


def _fault(field: str, found: object, allowed: str, remedy: str) -> InputError:
    return InputError(f"{field}: found {found}; allowed: {allowed}; {remedy}", field=field)


def _pictures(
    reach: _core.Reach, numbers: Sequence[int], size: tuple[int, int], camera: _core.Camera | None, **options: Any
) -> Iterator[NDArray[Any]]:
    """The pictures of these frames, one by one."""
    for start in range(0, len(numbers), _AT_ONCE):
        yield from reach.render(numbers[start : start + _AT_ONCE], *size, camera=camera, **options)


def _encode(path: Path, kind: str, pictures: Iterable[NDArray[np.uint8]], fps: int, size: tuple[int, int], **options: str) -> None:
    """Writes pictures as a film."""
    av = _av()
    container, repeated, codec, pixels, standard = _KINDS[kind]
    with av.open(str(path), "w", format=container, options=repeated) as file:
        stream = file.add_stream(codec, rate=fps, options=standard | options)
        stream.width, stream.height = size
        stream.pix_fmt = pixels
        for picture in pictures:
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        file.mux(stream.encode(None))


def _check_size(size: tuple[int, int]) -> None:
    if size[0] % 2 or size[1] % 2:
        raise _fault("size", f"{size[0]} x {size[1]}", "even numbers of pixels", "films have colours for every second pixel")


def film(
    reach: _core.Reach,
    path: str | os.PathLike[str],
    *,
    fps: int = _core.FILM_FPS,
    speed: float = 1.0,
    size: tuple[int, int] = (640, 360),
    camera: _core.Camera | None = None,
    arrows: bool = True,
    force: bool = False,
) -> int:
    """Write a film of a reach. Its bytes depend on the version of the encoder.

    Parameters
    ----------
    reach : Reach
        The reach.
    path : path
        File to write: ``.mp4`` (H.264) or ``.webp``.
    fps : int
        Pictures per second.
    speed : float
        How many times as fast as in reality it plays.
    size : tuple of two int
        Width and height in pixels, even.
    camera : Camera or None
        Without one, all that moves in the reach is seen.
    arrows : bool
        Whether the forces of contacts have arrows, which are for readers: a robot's camera sees none.
    force : bool
        Whether a file that exists is overwritten.

    Returns
    -------
    int
        Number of pictures.

    Raises
    ------
    InputError
        For another ending, and for numbers out of range.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in _KINDS:
        raise _fault("path", repr(path.name), f"a name that ends in {' or '.join(_KINDS)}", "choose such a name")
    if not 1 <= fps <= 100 or not 0.1 <= speed <= 100:
        raise _fault("fps, speed", f"{fps}, {speed}", "1 to 100, and 0.1 to 100", "choose such numbers")
    _check_size(size)
    rate_hz = 1 / float(reach.time_s[1] - reach.time_s[0]) if len(reach) > 1 else 1.0
    step = speed * rate_hz / fps
    numbers = [round(index * step) for index in range(int((len(reach) - 1) / step) + 1)]
    # Python may lose a Ctrl-C that comes while it imports a module.
    _av()
    with _export.whole(path, force) as temporary:
        _encode(temporary, kind, _pictures(reach, numbers, size, camera, arrows=arrows), fps, size)
    return len(numbers)


def _rows(column: Any) -> NDArray[Any]:
    """A column of numbers or of lists of one length, as (rows, numbers)."""
    flat = np.asarray(column.combine_chunks().flatten()) if str(column.type).startswith("fixed_size_list") else column.to_numpy()
    return np.asarray(flat).reshape(len(column), -1)


def _statistics(values: NDArray[Any]) -> dict[str, list[Any]]:
    """Statistics along the first axis, with LeRobot's names."""
    own = values.astype(np.float64)
    found = {"min": own.min(0), "max": own.max(0), "mean": own.mean(0), "std": own.std(0)}
    found |= {name: np.percentile(own, percent, axis=0) for name, percent in _QUANTILES.items()}
    return {name: value.tolist() for name, value in found.items()} | {"count": [len(own)]}


class _Camera:
    """One camera: the same name and size in all scenes. Its pictures are a feature of a data set."""

    kind, channels, unit = "rgb", 3, 255.0

    def __init__(self, name: str, of_scene: Mapping[str, _core.Camera]) -> None:
        self.key, self.of_scene = f"observation.images.{name}", of_scene
        self.size = next(iter(of_scene.values())).size_px
        self.sampled: list[list[NDArray[Any]]] = []

    def seen(self, reach: _core.Reach, numbers: Sequence[int]) -> Iterator[NDArray[Any]]:
        """The pictures of these frames, one by one. Some of their pixels enter the statistics."""
        sampled: list[NDArray[Any]] = []
        self.sampled.append(sampled)
        for index, picture in enumerate(_pictures(reach, numbers, self.size, self.of_scene[reach.scene], kind=self.kind)):
            own = self.stored(picture)
            if index % _SAMPLED_PICTURES == 0:
                sampled.append(own[::_SAMPLED_PIXELS, ::_SAMPLED_PIXELS])
            yield own

    def stored(self, picture: NDArray[Any]) -> NDArray[Any]:
        return picture

    def statistics(self, sampled: list[list[NDArray[Any]]]) -> dict[str, list[Any]]:
        """Statistics of each channel, of shape (channels, 1, 1); `count` is the number of pictures."""
        pictures = [picture.reshape(-1, self.channels) for own in sampled for picture in own]
        found = _statistics(np.concatenate(pictures) / self.unit)
        shaped = {name: np.reshape(value, (-1, 1, 1)).tolist() for name, value in found.items() if name != "count"}
        return shaped | {"count": [len(pictures)]}


class _Films(_Camera):
    """The films of a camera."""

    def __init__(self, folder: Path, name: str, fps: int, of_scene: Mapping[str, _core.Camera]) -> None:
        super().__init__(name, of_scene)
        self.folder, self.fps = folder, fps
        self.path = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"

    def write(self, episode: int, reach: _core.Reach, numbers: Sequence[int], per_chunk: int) -> dict[str, Any]:
        """Writes the film of an episode and returns where it is."""
        chunk, file = divmod(episode, per_chunk)
        path = self.folder / self.path.format(video_key=self.key, chunk_index=chunk, file_index=file)
        path.parent.mkdir(parents=True, exist_ok=True)
        # Every second picture can be decoded without the others, as in LeRobot's own films.
        _encode(path, ".mp4", self.seen(reach, numbers), self.fps, self.size, g="2")
        where = {"chunk_index": chunk, "file_index": file, "from_timestamp": 0.0, "to_timestamp": len(numbers) / self.fps}
        return {f"videos/{self.key}/{name}": value for name, value in where.items()}

    def feature(self) -> dict[str, Any]:
        width, height = self.size
        film = {"height": height, "width": width, "codec": "h264", "pix_fmt": "yuv420p", "fps": self.fps, "channels": 3}
        about = {f"video.{name}": value for name, value in film.items()} | {"video.is_depth_map": False, "has_audio": False}
        return {"dtype": "video", "shape": [height, width, 3], "names": ["height", "width", "channels"], "info": about}


class _Depth(_Camera):
    """The depth that a camera sees, mm, as pictures within the table of frames. 0 is where nothing is."""

    kind, channels, unit = "depth", 1, 1.0

    def stored(self, picture: NDArray[Any]) -> NDArray[Any]:
        return np.where(picture < _FARTHEST_M, np.rint(1000 * picture), 0).astype(np.uint16)

    def pictures(self, reach: _core.Reach, numbers: Sequence[int]) -> Iterator[dict[str, bytes]]:
        """The pictures as PNG, in the form of `datasets.Image`."""
        encoder = _av().CodecContext.create("png", "w")
        encoder.width, encoder.height, encoder.pix_fmt, encoder.time_base = *self.size, "gray16be", Fraction(1)
        for picture in self.seen(reach, numbers):
            (packet,) = encoder.encode(_av().VideoFrame.from_ndarray(picture, format="gray16be"))
            yield {"bytes": bytes(packet)}

    def feature(self) -> dict[str, Any]:
        width, height = self.size
        about = {"is_depth_map": True, "depth_unit": "mm"}
        return {"dtype": "image", "shape": [height, width, 1], "names": ["height", "width", "channels"], "info": about}


def _cameras(dataset: _core.Dataset, given: Mapping[str, _core.Camera] | None) -> dict[str, dict[str, _core.Camera]]:
    """The cameras by their names, each by the names of scenes: those given, else those of the scenes, else one."""
    texts = {own["name"]: own["file"]["text"] for own in dataset.provenance["scenes"]}
    scenes = {name: dict(given or _core.Scene.parse(text, f"{name}.toml").cameras) for name, text in texts.items()}
    if not any(scenes.values()):
        scenes = {name: {"front": _FRONT} for name in scenes}
    first, *others = scenes.items()
    sizes = {name: camera.size_px for name, camera in first[1].items()}
    for name, cameras in others:
        found = {name: camera.size_px for name, camera in cameras.items()}
        if found != sizes:
            remedy = "give the cameras with `cameras`, or a data set of one scene"
            raise _fault("cameras", f"{found} in {name}", f"the same names and sizes as in {first[0]}, {sizes}", remedy)
    for name, size in sizes.items():
        _check_size(size)
        # A feature of LeRobot has no slash in its name, and the name is that of a folder. Scene files have the same rule.
        if not re.fullmatch(r"[A-Za-z0-9_-]+", name):
            raise _fault("cameras", repr(name), "a name of letters, digits, - and _", "give the camera such a name")
    return {name: {scene: cameras[name] for scene, cameras in scenes.items()} for name in sizes}


def lerobot(
    data: str | os.PathLike[str],
    out: str | os.PathLike[str],
    cameras: Mapping[str, _core.Camera] | None = None,
    *,
    fps: int = _core.FILM_FPS,
    depth: bool = False,
) -> int:
    """Write a data set with the pictures of cameras, in the LeRobotDataset v3.0 layout.

    It holds what a robot senses, without ground truth, at the rate of the cameras: every n-th frame of the reaches.

    Parameters
    ----------
    data : path
        A data set.
    out : path
        Folder to write. It must not exist.
    cameras : dict of str to Camera, optional
        The cameras by their names; their features are ``observation.images.NAME``. Without them those of the scene files, or
        else one, ``front``, which sees the clutter of the shipped scenes. Width and height of a camera are even.
    fps : int
        Frames per second; a divisor of the data set's rate.
    depth : bool
        Whether the set also has the depth that each camera sees, mm, as ``observation.images.NAME_depth``: pictures of 16 bits,
        with 0 where nothing is.

    Returns
    -------
    int
        Number of frames.

    Raises
    ------
    InputError
        If the rate is no divisor, a size is odd, a name has more than letters, digits, - and _, the depth of a camera has the name of another one, a link that carries a camera is not known, or the scenes of the data set have
        different cameras.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError as error:
        raise ImportError("underbrush.video needs pyarrow: pip install 'underbrush[video]'") from error
    data, out = Path(data), Path(out)
    dataset = _core.Dataset(data)
    info = json.loads((data / "meta" / "info.json").read_text())
    chosen = _cameras(dataset, cameras)
    if taken := [name for name in chosen if depth and f"{name}_depth" in chosen]:
        raise _fault("cameras", f"{taken[0]}_depth", f"another name, which the depth of {taken[0]} needs", "rename that camera")
    if fps < 1 or info["fps"] % fps:
        allowed = ", ".join(str(rate) for rate in range(1, int(info["fps"]) + 1) if info["fps"] % rate == 0)
        raise _fault("fps", fps, allowed, "choose a divisor of the data set's rate")
    if out.exists():
        raise _fault("out", f"{out}, which exists already", "a new folder", "choose another name")
    every = int(info["fps"]) // fps
    folder = out.with_name(f".{out.name}.{os.getpid()}")
    try:
        (folder / "meta" / "episodes" / "chunk-000").mkdir(parents=True)
        films = [_Films(folder, name, fps, of_scene) for name, of_scene in chosen.items()]
        depths = [_Depth(f"{name}_depth", of_scene) for name, of_scene in chosen.items() if depth]
        drawn: list[_Films | _Depth] = [*films, *depths]
        files = sorted((data / "data").rglob("*.parquet"))
        frames = pa.concat_tables([pq.read_table(file) for file in files])
        frames = frames.filter(pa.array(frames["frame_index"].to_numpy() % every == 0))
        columns = {column: frames[column] for column in frames.column_names}
        numbers = frames["frame_index"].to_numpy() // every
        columns["frame_index"] = pa.array(numbers)
        columns["timestamp"] = pa.array((numbers / fps).astype(np.float32))
        columns["index"] = pa.array(np.arange(len(numbers)))
        table = pa.table(columns)
        path = folder / info["data_path"].format(chunk_index=0, file_index=0)
        path.parent.mkdir(parents=True)
        # The columns of `datasets.Image`.
        image = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
        schema = pa.schema([*table.schema, *(pa.field(own.key, image) for own in depths)])
        writer = pq.ParquetWriter(path, schema, compression="zstd")
        episode_of = table["episode_index"].to_numpy()
        episodes = pa.concat_tables([pq.read_table(file) for file in sorted((data / "meta" / "episodes").rglob("*.parquet"))])
        rows = episodes.select([own for own in episodes.column_names if not own.startswith("stats/")]).to_pylist()
        features = {own: feature for own, feature in info["features"].items() if own in columns}
        values = {own: _rows(table[own]) for own in features}
        for row in rows:
            episode = row["episode_index"]
            own = np.flatnonzero(episode_of == episode)
            reach, seen = dataset[episode], (numbers[own] * every).tolist()
            depth_columns = [pa.array(list(camera.pictures(reach, seen)), image) for camera in depths]
            writer.write_table(pa.table([*table.take(own).columns, *depth_columns], schema=schema))
            for film in films:
                row.update(film.write(episode, reach, seen, info["chunks_size"]))
            row.update(length=len(own), dataset_from_index=int(own[0]), dataset_to_index=int(own[-1]) + 1)
            row.update({f"{kind}/{number}": 0 for kind in ("data", "meta/episodes") for number in ("chunk_index", "file_index")})
            found = {feature: _statistics(values[feature][own]) for feature in features}
            found |= {camera.key: camera.statistics(camera.sampled[-1:]) for camera in drawn}
            row.update({f"stats/{feature}/{kind}": value for feature, kinds in found.items() for kind, value in kinds.items()})
        writer.close()
        pq.write_table(pa.Table.from_pylist(rows), folder / "meta" / "episodes" / "chunk-000" / "file-000.parquet")
        statistics = {feature: _statistics(values[feature]) for feature in features}
        statistics |= {camera.key: camera.statistics(camera.sampled) for camera in drawn}
        (folder / "meta" / "stats.json").write_text(json.dumps(statistics))
        features |= {camera.key: camera.feature() for camera in drawn}
        info.update(total_frames=len(numbers), fps=fps, video_path=films[0].path, features=features)
        (folder / "meta" / "info.json").write_text(json.dumps(info, indent=2))
        for kept in ("tasks.parquet", "provenance.json"):
            shutil.copy(data / "meta" / kept, folder / "meta" / kept)
        folder.rename(out)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return len(numbers)


def _reaches(text: str) -> list[int]:
    if not re.fullmatch(r"\d+(,\d+)*", text):
        raise argparse.ArgumentTypeError(f"found {text!r}; give the number of a reach, from 0")
    return [int(number) for number in text.split(",")]


def _size(text: str) -> tuple[int, int]:
    size = re.fullmatch(r"(\d+)x(\d+)", text)
    if not size:
        raise argparse.ArgumentTypeError(f"found {text!r}; give width and height in pixels, such as 640x360")
    return int(size[1]), int(size[2])


def main(arguments: list[str] | None = None) -> int:
    """The command line: ``python -m underbrush.video --help``."""
    formatter = argparse.ArgumentDefaultsHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m underbrush.video", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    films = commands.add_parser("film", help="write a film of a reach", formatter_class=formatter)
    films.add_argument("data", type=Path, help="recording (.parquet), data set or folder of recordings")
    films.add_argument("--reaches", type=_reaches, default=argparse.SUPPRESS, metavar="N", help="reach of the folder, from 0")
    _export.output_options(films, ".mp4 or .webp")
    films.add_argument("--fps", type=int, default=_core.FILM_FPS, help="pictures per second")
    films.add_argument("--speed", type=float, default=1.0, help="how many times as fast as in reality it plays")
    films.add_argument("--size", type=_size, default="640x360", metavar="WxH", help="pixels")
    films.add_argument("--camera", default=argparse.SUPPRESS, metavar="NAME", help="camera of the scene file; for a data set")
    sets = commands.add_parser("lerobot", help="write a data set with camera pictures", formatter_class=formatter)
    sets.add_argument("data", type=Path, help="data set (folder)")
    sets.add_argument("--out", required=True, type=Path, help="folder to write")
    sets.add_argument("--json", action="store_true", help="print the result as one JSON object")
    sets.add_argument("--fps", type=int, default=_core.FILM_FPS, help="frames per second, a divisor of the data set's rate")
    place: dict[str, Any] = {"type": float, "nargs": 3, "metavar": ("X", "Y", "Z")}
    sets.add_argument("--depth", action="store_true", help="also write the depth that each camera sees")
    sets.add_argument("--eye", **place, default=argparse.SUPPRESS, help="place of a camera instead of those of the scene files, m, world frame")
    sets.add_argument("--target", **place, default=_TARGET, help="with --eye: the middle of its pictures, m, world frame")
    sets.add_argument("--fov", type=float, default=_FRONT.vertical_fov_deg, metavar="DEG", help="with --eye: angle between upper and lower edge")
    sets.add_argument("--size", type=_size, default="320x240", metavar="WxH", help="with --eye: pixels")
    sets.add_argument("--name", default="front", help="with --eye: name of the camera")
    options = parser.parse_args(arguments)

    def run() -> dict[str, int]:
        size: tuple[int, int] = options.size
        if options.command == "film":
            places = _core._with_recordings([options.data])
            dataset = _core.Dataset(options.data) if places[0].is_dir() else None
            count = len(places) if dataset is None else len(dataset)
            numbers = options.reaches if "reaches" in options else range(count)
            if len(numbers) != 1:
                raise InputError(f"a picture shows one reach; choose one of {count} with --reaches N, from 0")
            if numbers[0] >= count:
                raise InputError(f"there is no reach {numbers[0]}; give a number below {count}")
            reach = _core.Reach.load(places[numbers[0]]) if dataset is None else dataset[numbers[0]]
            camera = None
            if "camera" in options:
                cameras = _cameras(dataset, None) if dataset else {}
                if options.camera not in cameras:
                    allowed = ", ".join(cameras) or "none of a recording, which does not know its scene"
                    raise _fault("--camera", options.camera, allowed, "choose one of these, or leave it out")
                camera = cameras[options.camera][reach.scene]
            # A camera of the scene shows what a camera sees.
            given: dict[str, Any] = {name: getattr(options, name) for name in ("fps", "speed", "force")}
            return {"pictures": film(reach, options.out, size=size, camera=camera, arrows=camera is None, **given)}
        own = None
        if "eye" in options:
            place = _core.Camera(options.eye, options.target, vertical_fov_deg=options.fov, size_px=size)
            own = {str(options.name): place}
        else:
            plain = parser.parse_args(["lerobot", ".", "--out", "."])
            for name in ("target", "fov", "size", "name"):
                if getattr(options, name) != getattr(plain, name):
                    raise InputError(f"--{name} is for the camera of --eye; give --eye, too, or leave it out")
        return {"frames": lerobot(options.data, options.out, own, fps=options.fps, depth=options.depth)}

    return _export.status(run, options)


if __name__ == "__main__":
    sys.exit(main())
