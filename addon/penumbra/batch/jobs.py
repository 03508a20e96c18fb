"""What a batch has to do: items, each one scene at one frame through one camera, and the options they are made with."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from ..compare import Options
from ..errors import UserError
from ..files import slug, unique_slug
from ..records import word

MAX_FRAMES = 100_000  # of one scene: more is a slip of the finger
FRAME_LIMIT = 1048574  # Blender's own

Mode = Literal["compare", "render"]


@dataclass(frozen=True)
class Shot:
    """One scene with all that is wanted of it."""

    name: str
    scene: Path
    frames: tuple[int, ...] = ()  # empty: the file's current one
    cameras: tuple[str, ...] = ()  # empty: the scene's active one
    size: tuple[int, int] | None = None
    options: Options = field(default_factory=Options)
    warn_rmse: float | None = None
    fail_rmse: float | None = None


@dataclass(frozen=True)
class Job:
    """Everything that one `penumbra batch` is asked for."""

    shots: tuple[Shot, ...]
    out: Path
    mode: Mode = "compare"
    technique: str = ""  # of a render
    format: str = "exr"
    device: str = ""
    view_by: str = ""
    workers: int = 1


@dataclass(frozen=True)
class Item:
    """One scene at one frame through one camera. Plain data: it travels to other processes and machines as JSON."""

    id: str  # "courtyard/0001-left": where the result lies in the output folder
    name: str
    scene: str  # absolute path
    frame: int | None
    camera: str | None
    size: tuple[int, int] | None
    mode: Mode
    technique: str
    format: str
    device: str
    view_by: str
    options: Options
    warn_rmse: float | None = None
    fail_rmse: float | None = None

    def asked(self) -> dict[str, Any]:
        """All that changes the result, apart from the content of files and the build of the core."""
        options = dataclasses.asdict(self.options)
        options.pop("use_cache")
        if self.mode == "render":
            options = {name: options[name] for name in ("settings", "lights", "keep_everything")}
        asked = {
            "mode": self.mode,
            "frame": self.frame,
            "camera": self.camera,
            "size": self.size,
            "technique": self.technique,
            "device": self.device,
            "view_by": self.view_by,
            "options": options,
        }
        plain: dict[str, Any] = _lists(asked)
        return plain

    def arguments(self) -> list[str]:
        """The command line (after `penumbra`) that does the same alone, but for --out."""
        return [self.mode, self.scene, *self.view_arguments(), *self.option_arguments()]

    def view_arguments(self) -> list[str]:
        words = [] if self.frame is None else [f"--frame={self.frame}"]
        words += [] if self.camera is None else [f"--camera={self.camera}"]
        return words

    def option_arguments(self) -> list[str]:
        """The options without scene, frame and camera, as `compare`, `render` and `batch` take them."""
        options, words = self.options, []
        if self.size is not None:
            words.append(f"--size={self.size[0]}x{self.size[1]}")
        if self.device:
            words.append(f"--device={self.device}")
        if self.view_by:
            words.append(f"--view-by={self.view_by}")
        if options.lights:
            words.append(f"--lights={','.join(options.lights)}")
        if options.keep_everything:
            words.append("--keep-everything")
        if self.mode == "render":
            words.append(f"--technique={self.technique}")
        else:
            words.append(f"--techniques={','.join(options.techniques) or 'all'}")
            words.append(f"--sweep={options.sweep}")
            words.append(f"--reference-error={options.reference_error:g}")
            words += [] if options.target_rmse is None else [f"--target-rmse={options.target_rmse:g}"]
            if options.timing_seconds != Options.timing_seconds:
                words.append(f"--timing-seconds={options.timing_seconds:g}")
            words += ["--measure-savings"] if options.measure_savings else []
            words += [] if options.use_cache else ["--no-cache"]
        for technique, settings in options.settings.items():
            words += [f"--set={technique}.{key}={word(value)}" for key, value in settings.items()]
        return words

    def to_json(self) -> dict[str, Any]:
        return dataclasses.asdict(self)

    @classmethod
    def from_json(cls, document: dict[str, Any]) -> Item:
        options = dict(document["options"])
        for name in ("techniques", "lights"):
            options[name] = tuple(options[name])
        size = document["size"]
        return cls(**document | {"options": Options(**options), "size": tuple(size) if size else None})


def _lists(value: Any) -> Any:
    """As JSON gives it back: no tuples."""
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    return [_lists(item) for item in value] if isinstance(value, (list, tuple)) else value


def expand(job: Job) -> list[Item]:
    """All items of a job, scene by scene, camera by camera, in the order of frames."""
    items = []
    for shot in job.shots:
        taken: list[str] = []
        for camera in shot.cameras or (None,):
            ending = ""
            if camera is not None:
                taken.append(unique_slug(camera, taken))
                ending = f"-{taken[-1]}"
            for frame in shot.frames or (None,):
                number = "current" if frame is None else f"{frame:04d}"
                items.append(
                    Item(
                        id=f"{shot.name}/{number}{ending}",
                        name=shot.name,
                        scene=str(shot.scene.resolve()),
                        frame=frame,
                        camera=camera,
                        size=shot.size,
                        mode=job.mode,
                        technique=job.technique,
                        format=job.format,
                        device=job.device,
                        view_by=job.view_by,
                        options=shot.options,
                        warn_rmse=shot.warn_rmse,
                        fail_rmse=shot.fail_rmse,
                    )
                )
    return items


def named(wanted: Iterable[tuple[str | None, Path]]) -> list[str]:
    """Folder names of scenes: the name given, else the file's; numbered where two would share one."""
    names: list[str] = []
    for given, path in wanted:
        if given is not None and slug(given) in names:
            raise UserError(f'two scenes are called "{given}"; their results would lie in one folder')
        names.append(unique_slug(given if given is not None else path.stem, names))
    return names


_RANGE = re.compile(r"(-?\d{1,9})(?:(?:-|\.\.)(-?\d{1,9}))?(?::(\d{1,9}))?")


def parse_frames(text: str) -> tuple[int, ...]:
    """ "1-5,10,20-30:5" as numbers, each once, in the order given. @raises ValueError with a sentence"""
    frames: dict[int, None] = {}
    for part in text.replace(" ", "").split(","):
        match = _RANGE.fullmatch(part)
        if match is None:
            raise ValueError(f'"{text}" is not a range of frames such as 1-10, 1-100:5 or 1-5,20')
        first, last = int(match[1]), int(match[2] or match[1])
        step = int(match[3] or 1)
        if last < first or step < 1:
            raise ValueError(
                f'"{part}" in "{text}" holds no frame; write the smaller number first and a step of 1 or more'
            )
        if max(abs(first), abs(last)) > FRAME_LIMIT:
            raise ValueError(f'"{part}" in "{text}" is beyond the frames that Blender has')
        if len(frames) + (last - first) // step >= MAX_FRAMES:
            raise ValueError(f'"{text}" are more than {MAX_FRAMES} frames')
        frames.update(dict.fromkeys(range(first, last + 1, step)))
    return tuple(frames)


def frames_text(frames: Iterable[int]) -> str:
    """The shortest way to write frames that parse_frames understands: (1, 2, 3, 10) is "1-3,10"."""
    runs: list[list[int]] = []
    for frame in frames:
        if runs and frame == runs[-1][1] + 1:
            runs[-1][1] = frame
        else:
            runs.append([frame, frame])
    return ",".join(str(first) if first == last else f"{first}-{last}" for first, last in runs)
