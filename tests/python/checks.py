"""What must hold of every report folder, whoever made it."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import OpenEXR

SCHEMA = json.loads(Path(__file__).with_name("report_schema.json").read_text())


def report_of(folder: Path) -> dict[str, Any]:
    """report.json, after it has been held against the schema."""

    def refuse(word: str) -> None:
        raise AssertionError(f"report.json holds {word}")

    document: dict[str, Any] = json.loads((folder / "report.json").read_text(), parse_constant=refuse)
    jsonschema.Draft202012Validator(SCHEMA).validate(document)
    return document


def exr(path: Path) -> dict[str, np.ndarray]:
    """Channels of an EXR by name, bottom row first."""
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return {name: channel.pixels[::-1] for name, channel in channels.items()}


def check_files(folder: Path) -> None:
    """Every file that the report names is there, whole, and of the right kind; nothing temporary is left."""
    document = report_of(folder)
    for name in ("report.html", "results.csv", "pareto.svg", "pareto.png"):
        assert (folder / name).stat().st_size > 0
    assert not [path for path in folder.rglob("*") if path.name.startswith(".") or path.name.endswith(".tmp")]
    rows = list(csv.DictReader((folder / "results.csv").open(newline="")))
    records = [record for s in document["scenes"] for light in s["lights"] for record in light["records"]]
    assert len(rows) == len(records)
    for row, record in zip(rows, records, strict=True):
        assert row["technique"] == record["technique"]
        assert json.loads(row["settings"]) == record["settings"]
        if record["status"] == "ok":
            assert float(row["area_penumbra_rmse"]) == record["error"]["area"]["penumbra_rmse"]
            assert float(row["dynamic_median_ms"]) == record["time_ms"]["dynamic"]["median"]
    for scene in document["scenes"]:
        shape = tuple(reversed(scene["size"]))
        for light in scene["lights"]:
            _check_light(folder, light, shape)
    check_page(folder / "report.html")


def _check_light(folder: Path, light: dict[str, Any], shape: tuple[int, int]) -> None:
    images = light["reference"]["images"]
    reference = exr(folder / images["area"])
    for name in ("area", "irradiance"):
        channels = exr(folder / images[name])
        assert sorted(channels) == ["mask", "standard_error", "visibility"]
        assert all(channel.dtype == np.float32 and channel.shape == shape for channel in channels.values())
        assert set(np.unique(channels["mask"])) <= {0.0, 1.0}
    for record in light["records"]:
        if record["status"] != "ok" or record["sweep"]:
            continue
        channels = exr(folder / record["images"]["visibility"])
        assert sorted(channels) == ["mask", "visibility"]
        assert np.array_equal(channels["mask"], reference["mask"])
        inside = reference["mask"] > 0
        if inside.any() and record["seeds"] == 1:
            # The figures of the report are those of its images.
            error = (channels["visibility"] - reference["visibility"])[inside].astype(np.float64)
            np.testing.assert_allclose(
                np.sqrt((error**2).mean()), record["error"]["area"]["rmse"], rtol=1e-6, atol=1e-9
            )
            np.testing.assert_allclose(error.mean(), record["error"]["area"]["bias"], rtol=1e-6, atol=1e-9)
        for kind in ("error", "shaded"):
            assert (folder / record["images"][kind]).read_bytes().startswith(b"\x89PNG")
        parts = record["error"]["area"]["parts"]
        np.testing.assert_allclose(sum(parts.values()), record["error"]["area"]["rmse"] ** 2, rtol=1e-6, atol=1e-12)


def check_page(path: Path) -> None:
    """One file, no address of anything outside, no element that would load one."""
    page = path.read_text(encoding="utf-8")
    without_data = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]*", "", page)
    assert not re.search(r"(?:https?:)?//[a-z0-9-]+\.[a-z]", re.sub(r"[\w/.-]*\.blend", "", without_data))
    loading = r"<(?:script|img|iframe|object|embed|audio|video|source|link)\b[^>]*\s(?:src|href)=[\"']?(?!data:|\")"
    assert not re.search(loading, without_data)
    assert not re.search(r"<link\b[^>]*stylesheet", page)
    assert "@import" not in page
    assert "default-src 'none'" in page
