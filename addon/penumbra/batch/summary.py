"""What all items of a batch say together: summary.html, summary.json and summary.csv in the output folder."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import math
import os
import statistics
import urllib.parse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import environment, errors, native
from ..files import write_bytes
from ..records import headline
from ..report import html, palette
from .jobs import Item, Job
from .store import Document

SCHEMA = 1


# What reading a report raises that somebody has damaged.
_UNREADABLE = (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError)


@dataclass(frozen=True)
class Result:
    """What there is of an item, and where."""

    item: Item
    page: Path | None  # None: it failed
    document: Document  # item.json
    kept: bool  # from an earlier run
    reason: str = ""
    lines: tuple[str, ...] = ()
    attempts: int = 1


@dataclass(frozen=True)
class Figure:
    """One technique at one light of one item."""

    technique: str
    title: str
    light: str
    status: str
    reason: str
    error: float  # headline; NaN unless ok
    time_ms: float  # median of the dynamic frame; NaN unless measured


@dataclass(frozen=True)
class Shot:
    """A row of the summary: an item that is done."""

    id: str
    name: str
    scene: str
    camera: str
    frame: int
    page: str  # relative to the summary
    seconds: float
    kept: bool
    attempts: int
    workers: int  # that shared its machine
    machine: str
    device: str
    figures: tuple[Figure, ...]
    problems: tuple[str, ...]  # what failed within it
    notes: tuple[str, ...]
    warn_rmse: float | None
    fail_rmse: float | None

    @property
    def worst(self) -> Figure | None:
        return max((figure for figure in self.figures if figure.status == "ok"), key=lambda f: f.error, default=None)

    @property
    def best(self) -> Figure | None:
        return min((figure for figure in self.figures if figure.status == "ok"), key=lambda f: f.error, default=None)

    @property
    def verdict(self) -> str:
        """ "fail", "warn" or "ok": its worst error against the limits."""
        worst = self.worst.error if self.worst is not None else 0.0
        if self.fail_rmse is not None and worst > self.fail_rmse:
            return "fail"
        return "warn" if self.warn_rmse is not None and worst > self.warn_rmse else "ok"

    def error_of(self, technique: str) -> float:
        """The largest over the lights; NaN if it served none."""
        return max(
            (figure.error for figure in self.figures if figure.technique == technique and figure.status == "ok"),
            default=math.nan,
        )


@dataclass(frozen=True)
class Spread:
    """Of one figure over all lights of all shots; nearest rank."""

    count: int
    low: float
    p10: float
    median: float
    p90: float
    high: float


@dataclass(frozen=True)
class Technique:
    id: str
    title: str
    colour: str
    marker: str
    error: Spread | None
    time_ms: Spread | None
    unsupported: int
    failed: int
    worst: str  # the item with its largest error


@dataclass(frozen=True)
class Failure:
    item: str
    reason: str
    lines: tuple[str, ...] = ()


@dataclass(frozen=True)
class Book:
    mode: str
    technique: str  # of a render
    environment: dict[str, Any]
    seconds: float
    workers: int  # the most that shared a machine
    counts: dict[str, int]
    failures: tuple[Failure, ...]
    shots: tuple[Shot, ...]  # worst first
    techniques: tuple[Technique, ...]
    machines: tuple[str, ...] = ()


def collect(job: Job, results: Sequence[Result], given: list[str], seconds: float) -> Book:
    """Reads the items' reports. An item whose report cannot be read counts as failed."""
    shots, failures = [], []
    for result in results:
        if result.page is None:
            failures.append(Failure(result.item.id, result.reason, result.lines))
            continue
        try:
            shots.append(_shot(result, job))
        except _UNREADABLE as error:
            failures.append(Failure(result.item.id, f"its report cannot be read: {errors.sentence_of(error)}"))
    failures += [Failure(shot.id, problem) for shot in shots for problem in shot.problems]
    order = {"fail": 0, "warn": 1, "ok": 2}
    shots.sort(key=lambda shot: (order[shot.verdict], -(shot.worst.error if shot.worst else -1.0)))
    return Book(
        mode=job.mode,
        technique=job.technique,
        environment=environment.collect(native.load(), None, given),
        seconds=seconds,
        workers=max((shot.workers for shot in shots), default=1),
        counts={
            "items": len(results),
            "done": sum(not shot.kept for shot in shots),
            "kept": sum(shot.kept for shot in shots),
            "failed": sum(result.page is None for result in results),
            "retried": sum(result.attempts > 1 for result in results),
        },
        failures=tuple(failures),
        shots=tuple(shots),
        techniques=tuple(_techniques(shots)),
        machines=tuple(sorted({" · ".join(filter(None, (shot.machine, shot.device))) for shot in shots})),
    )


def _shot(result: Result, job: Job) -> Shot:
    item, document = result.item, result.document
    assert result.page is not None
    figures: tuple[Figure, ...] = ()
    device = ""
    camera, frame = str(document.get("camera", item.camera or "")), int(document.get("frame", item.frame or 0))
    if item.mode == "compare":
        report = json.loads((result.page.parent / "report.json").read_text(encoding="utf-8"))
        (scene,) = report["scenes"]
        figures = tuple(
            _figure(light, record) for light in scene["lights"] for record in light["records"] if not record["sweep"]
        )
        device = str(report["environment"].get("gl_renderer", ""))
        camera, frame = str(scene["camera"]), int(scene["frame"])
    return Shot(
        id=item.id,
        name=item.name,
        scene=item.scene,
        camera=camera,
        frame=frame,
        page=urllib.parse.quote(os.path.relpath(result.page, job.out).replace(os.sep, "/")),
        seconds=float(document.get("seconds", 0.0)),
        kept=result.kept,
        attempts=result.attempts,
        workers=int(document.get("workers", 1)),
        machine=str(document.get("host", "")),
        device=device,
        figures=figures,
        problems=tuple(f"{each['what']}: {each['reason']}" for each in document.get("failures", [])),
        notes=tuple(map(str, document.get("notes", []))),
        warn_rmse=item.warn_rmse,
        fail_rmse=item.fail_rmse,
    )


def _figure(light: dict[str, Any], record: dict[str, Any]) -> Figure:
    ok = record["status"] == "ok"
    return Figure(
        technique=str(record["technique"]),
        title=str(record["title"]),
        light=str(light["name"]),
        status=str(record["status"]),
        reason=str(record["reason"]),
        error=headline(record["error"]["area"]) if ok else math.nan,
        time_ms=float(record["time_ms"]["dynamic"]["median"]) if ok and "dynamic" in record["time_ms"] else math.nan,
    )


def _techniques(shots: Sequence[Shot]) -> list[Technique]:
    """In the order of their first appearance, which is that of the registry."""
    by_id: dict[str, list[tuple[Shot, Figure]]] = {}
    for shot in sorted(shots, key=lambda shot: shot.id):
        for figure in shot.figures:
            by_id.setdefault(figure.technique, []).append((shot, figure))
    found = []
    for number, (technique, entries) in enumerate(by_id.items()):
        ok = [(shot, figure) for shot, figure in entries if figure.status == "ok"]
        worst = max(ok, key=lambda entry: entry[1].error, default=None)
        found.append(
            Technique(
                id=technique,
                title=entries[0][1].title,
                colour=palette.colour(number),
                marker=palette.marker(number),
                error=spread([figure.error for _, figure in ok]),
                time_ms=spread([figure.time_ms for _, figure in ok]),
                unsupported=sum(figure.status == "unsupported" for _, figure in entries),
                failed=sum(figure.status == "failed" for _, figure in entries),
                worst=worst[0].id if worst is not None else "",
            )
        )
    return found


def spread(values: Sequence[float]) -> Spread | None:
    """None where there is no finite value."""
    known = sorted(value for value in values if math.isfinite(value))
    if not known:
        return None

    def rank(share: float) -> float:
        return known[max(0, math.ceil(share * len(known)) - 1)]

    return Spread(len(known), known[0], rank(0.1), statistics.median(known), rank(0.9), known[-1])


# --- files -----------------------------------------------------------------------------------------------------------


def write(book: Book, out: Path) -> Path:
    """@return the path of summary.html, or of the folder if there is nothing to show"""
    from . import page

    out.mkdir(parents=True, exist_ok=True)
    document = json.dumps(to_json(book), indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    write_bytes(out / "summary.csv", csv_text(book).encode())
    write_bytes(out / "summary.json", document.encode())
    target = out / "summary.html"
    write_bytes(target, page.page(book).encode())
    return target


def to_json(book: Book) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "environment": book.environment,
        "mode": book.mode,
        "technique": book.technique or None,
        "seconds": round(book.seconds, 3),
        "workers": book.workers,
        "machines": list(book.machines),
        "counts": book.counts,
        "failures": [{**dataclasses.asdict(failure), "lines": list(failure.lines)} for failure in book.failures],
        "shots": [_plain(_shot_json(shot)) for shot in book.shots],
        "techniques": [_plain(dataclasses.asdict(technique)) for technique in book.techniques],
    }


def _shot_json(shot: Shot) -> dict[str, Any]:
    document = dataclasses.asdict(shot)
    worst = shot.worst
    return document | {
        "verdict": shot.verdict,
        "worst": dataclasses.asdict(worst) if worst is not None else None,
    }


def _plain(value: Any) -> Any:
    """No NaN, no tuples."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


COLUMNS = [
    "item", "scene", "camera", "frame", "light", "technique", "status", "reason", "penumbra_rmse", "dynamic_median_ms",
    "verdict", "seconds", "kept", "report",
]  # fmt: skip


def csv_text(book: Book) -> str:
    """One line per technique, light and item, worst item first; a failed item is one line. All other figures of a
    comparison stand in its own results.csv."""
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for failure in (failure for failure in book.failures if failure.item not in {shot.id for shot in book.shots}):
        writer.writerow({"item": failure.item, "status": "failed", "reason": failure.reason})
    for shot in book.shots:
        row = {
            "item": shot.id,
            "scene": shot.scene,
            "camera": shot.camera,
            "frame": shot.frame,
            "verdict": shot.verdict,
            "seconds": shot.seconds,
            "kept": shot.kept,
            "report": urllib.parse.unquote(shot.page),
        }
        for figure in shot.figures:
            writer.writerow(
                row
                | {
                    "light": figure.light,
                    "technique": figure.technique,
                    "status": figure.status,
                    "reason": figure.reason,
                    "penumbra_rmse": figure.error if math.isfinite(figure.error) else "",
                    "dynamic_median_ms": figure.time_ms if math.isfinite(figure.time_ms) else "",
                }
            )
        if not shot.figures:
            writer.writerow(row | {"technique": book.technique, "status": "ok"})
    return buffer.getvalue()


# --- what is told ----------------------------------------------------------------------------------------------------

_SHOWN = 10


def conclude(book: Book, page: Path, say: Callable[[str], None]) -> int:
    """Prints the worst shots and the techniques. @return the exit code"""
    if book.mode == "compare" and book.shots:
        print(f"worst of {len(book.shots)}:" if len(book.shots) > _SHOWN else "worst first:")
        for shot in book.shots[:_SHOWN]:
            worst = shot.worst
            told = f"{html.format_error(worst.error):>8}  {worst.title} at {worst.light}" if worst else "       –"
            print(f"  {shot.id:<28} {told}")
        print("techniques, median over all shots and lights:")
        for technique in book.techniques:
            if technique.error is not None and technique.time_ms is not None:
                time = f"{technique.time_ms.median:>9.2f} ms"
                print(f"  {technique.id:<20} {technique.error.median:>9.4f}  {time}".rstrip())
    print(f"summary: {page}")
    for failure in book.failures:
        say(f"{failure.item}: {failure.reason}")
    if book.failures:
        return errors.FAILED
    for verdict, code, option in (("fail", errors.FAIL, "fail"), ("warn", errors.WARN, "warn")):
        above = [shot for shot in book.shots if shot.verdict == verdict]
        if above and (worst := above[0].worst) is not None:
            limit = above[0].fail_rmse if option == "fail" else above[0].warn_rmse
            more = f" ({len(above)} items are)" if len(above) > 1 else ""
            say(
                f"{worst.technique} at {worst.light} in {above[0].id} has a penumbra RMSE of {worst.error:.4g}, "
                f"above --{option}-rmse {limit:g}{more}"
            )
            return code
    return errors.OK
