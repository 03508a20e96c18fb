"""The command line on a real scene, in processes of its own: Blender, core, report."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from checks import check_files, exr, report_of

pytestmark = pytest.mark.usefixtures("working_machine")

Run = Callable[..., subprocess.CompletedProcess[str]]
FAST = ("--reference-error", "0.03", "--timing-seconds", "0.3")


@pytest.fixture(scope="module")
def reported(
    tmp_path_factory: pytest.TempPathFactory, wall_blend: Path, environment: dict[str, str]
) -> tuple[Path, subprocess.CompletedProcess[str], Path]:
    """Folder, process and cache folder of one comparison of all techniques at both lights."""
    base = tmp_path_factory.mktemp("compare")
    result = subprocess.run(
        [sys.executable, "-m", "penumbra", "compare", str(wall_blend), "--out", str(base / "out"), *FAST,
         "--target-rmse", "0.2"],
        capture_output=True, text=True, env=environment | {"PENUMBRA_CACHE": str(base / "cache")}, timeout=600,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    return base / "out", result, base / "cache"


def test_a_comparison_writes_what_it_promises(reported: tuple[Path, object, Path]) -> None:
    check_files(reported[0])


def test_every_technique_has_a_record_at_every_light(reported: tuple[Path, object, Path], core: object) -> None:
    (scene,) = report_of(reported[0])["scenes"]
    assert [light["name"] for light in scene["lights"]] == ["Key", "Sun"]
    for light in scene["lights"]:
        found = [record["technique"] for record in light["records"]]
        assert found == [info["id"] for info in core.techniques()]  # type: ignore[attr-defined]
        assert all(record["status"] in ("ok", "unsupported") for record in light["records"])


def test_the_random_techniques_error_is_noise_and_the_hard_shadows_is_not(reported: tuple[Path, object, Path]) -> None:
    key = report_of(reported[0])["scenes"][0]["lights"][0]
    records = {record["technique"]: record for record in key["records"]}
    assert records["ray_traced"]["dominant_error"] == "noise"
    assert records["ray_traced"]["seeds"] == 4
    assert records["shadow_map"]["dominant_error"] != "noise"
    assert (
        records["shadow_map"]["error"]["area"]["penumbra_rmse"]
        > records["ray_traced"]["error"]["area"]["penumbra_rmse"]
    )


def test_the_reference_is_dark_behind_the_wall_and_its_top_row_is_far_away(reported: tuple[Path, object, Path]) -> None:
    folder = reported[0]
    key = report_of(folder)["scenes"][0]["lights"][0]
    channels = exr(folder / key["reference"]["images"]["area"])
    assert channels["visibility"][8:30, 60:100].mean() < channels["visibility"][70:90, 60:100].mean()


def test_the_summary_and_nothing_else_is_printed(reported: tuple[Path, subprocess.CompletedProcess[str], Path]) -> None:
    folder, result, _ = reported
    assert f"report: {folder / 'report.html'}" in result.stdout
    assert "Key (rectangle)" in result.stdout
    assert not [line for line in result.stdout.splitlines() if "Blender" in line or "Read blend" in line]


def test_a_second_comparison_takes_the_references_from_the_cache(
    reported: tuple[Path, object, Path], penumbra: Run, wall_blend: Path, tmp_path: Path
) -> None:
    folder, _, cache = reported
    arguments = ["compare", wall_blend, "--out", tmp_path / "again", *FAST, "--techniques", "shadow_map"]
    assert penumbra(*arguments, PENUMBRA_CACHE=str(cache)).returncode == 0
    first, second = report_of(folder)["scenes"][0]["lights"], report_of(tmp_path / "again")["scenes"][0]["lights"]
    assert [light["reference"]["from_cache"] for light in first] == [False, False]
    assert [light["reference"]["from_cache"] for light in second] == [True, True]
    for a, b in zip(first, second, strict=True):
        one = exr(folder / a["reference"]["images"]["area"])
        other = exr(tmp_path / "again" / b["reference"]["images"]["area"])
        assert all(np.array_equal(one[name], other[name]) for name in one)
    fresh = [*arguments, "--no-cache"]
    fresh[3] = tmp_path / "fresh"
    assert penumbra(*fresh, PENUMBRA_CACHE=str(cache)).returncode == 0
    third = report_of(tmp_path / "fresh")["scenes"][0]["lights"]
    assert [light["reference"]["from_cache"] for light in third] == [False, False]


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--warn-rmse", "0.01"], 3),
        (["--fail-rmse", "0.01"], 4),
        (["--warn-rmse", "0.01", "--fail-rmse", "0.9"], 3),
        (["--warn-rmse", "0.9", "--fail-rmse", "0.9"], 0),
    ],
)
def test_errors_above_a_limit_set_the_exit_code_and_deliver_all_the_same(
    penumbra: Run, wall_blend: Path, tmp_path: Path, options: list[str], code: int
) -> None:
    arguments = ["--techniques", "shadow_map", "--lights", "Key", "--size", "80x48", *FAST]
    result = penumbra("compare", wall_blend, "--out", tmp_path / "out", *arguments, *options)
    assert result.returncode == code, result.stderr
    check_files(tmp_path / "out")
    told = [line for line in result.stderr.splitlines() if line.startswith("penumbra: ")]
    assert len(told) == (1 if code else 0)


def test_one_bad_scene_of_two_is_named_and_the_other_delivered(penumbra: Run, wall_blend: Path, tmp_path: Path) -> None:
    bad = tmp_path / "bad.blend"
    bad.write_text("not a blend file")
    arguments = ["--techniques", "shadow_map", "--lights", "Key", "--size", "80x48", *FAST]
    result = penumbra("compare", bad, wall_blend, "--out", tmp_path / "out", *arguments)
    assert result.returncode == 1, result.stderr
    document = report_of(tmp_path / "out")
    assert len(document["scenes"]) == 1
    assert [failure["what"] for failure in document["failures"]] == [str(bad)]
    assert "bad.blend" in (tmp_path / "out" / "report.html").read_text()


def test_a_sweep_gives_further_records(penumbra: Run, wall_blend: Path, tmp_path: Path) -> None:
    arguments = ["--techniques", "ray_traced", "--lights", "Key", "--size", "80x48", "--sweep", "quick", *FAST]
    arguments += ["--target-rmse", "0.5"]
    told = penumbra("compare", wall_blend, "--out", tmp_path / "out", *arguments)
    assert told.returncode == 0
    check_files(tmp_path / "out")
    light = report_of(tmp_path / "out")["scenes"][0]["lights"][0]
    # Whichever was the cheapest: one ray is within 0.5.
    assert f"  {light['pick']['sentence']}\n" in told.stdout
    assert f"  use: {' '.join(light['pick']['arguments'])}\n" in told.stdout
    assert light["pick"]["arguments"][:2] == ["--techniques", "ray_traced"]
    assert [target["error"] for target in light["targets"]] == [0.5, 0.05, 0.02, 0.01, 0.005]
    assert light["targets"][0]["reaches"][0]["state"] == "at_most"
    records = light["records"]
    assert all(isinstance(record["time_ms"]["dynamic"]["tight"], bool) for record in records)
    assert all(record["headline_error"] > 0 for record in records)
    again = penumbra("compare-reports", tmp_path / "out", tmp_path / "out", "--fail-slower", "1", "--fail-missing")
    assert again.returncode == 0
    assert f"{len(records)} records in both reports, 0 changed." in again.stdout
    by_rays = sorted((record["settings"]["rays"], record["error"]["area"]["penumbra_rmse"]) for record in records)
    assert len(by_rays) >= 3
    assert [error for _, error in by_rays] == sorted((error for _, error in by_rays), reverse=True)


def start(environment: dict[str, str], wall_blend: Path, out: Path) -> subprocess.Popen[str]:
    """A comparison that takes long: a fine reference of a large picture."""
    return subprocess.Popen(
        [sys.executable, "-m", "penumbra", "compare", str(wall_blend), "--out", str(out), "--size", "1600x960",
         "--reference-error", "0.0005", "--no-cache"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip


@pytest.mark.parametrize("delay", [3.0, 6.0])
def test_an_interrupt_ends_the_run_within_a_second_with_one_line(
    environment: dict[str, str], wall_blend: Path, tmp_path: Path, delay: float
) -> None:
    process = start(environment, wall_blend, tmp_path / "out")
    time.sleep(delay)
    assert process.poll() is None
    asked = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=30)
    waited = time.monotonic() - asked
    assert process.returncode == 130
    assert [line for line in told.splitlines() if line.startswith("penumbra:")] == ["penumbra: interrupted"]
    assert "Traceback" not in told
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").rglob("*.*"))
    # Shown, not asserted: a loaded machine may take longer than the second that an idle one keeps to.
    print(f"ended {waited:.2f} s after SIGINT")


def test_a_killed_run_leaves_no_partial_file(environment: dict[str, str], wall_blend: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start(environment, wall_blend, out)
    time.sleep(5.0)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert not out.exists() or not list(out.rglob("*.*"))


def test_render_writes_a_png_and_a_multilayer_exr(penumbra: Run, wall_blend: Path, tmp_path: Path) -> None:
    for name in ("picture.png", "picture.exr"):
        result = penumbra("render", wall_blend, "--technique", "shadow_map", "--out", tmp_path / name)
        assert result.returncode == 0, result.stderr
        # Where the technique leaves its field of use stands on the terminal.
        (warned,) = [line for line in result.stderr.splitlines() if '"Key" is outside' in line]
        assert warned.startswith('penumbra: "Key" is outside the field of use of shadow_map: the light is ')
    import PIL.Image

    with PIL.Image.open(tmp_path / "picture.png") as shown:
        assert shown.size == (160, 96)
    channels = exr(tmp_path / "picture.exr")
    wanted = {"R", "G", "B", "visibility.Key", "visibility.Sun", "mask.Key", "mask.Sun", "depth.Z"}
    wanted |= {f"{name}.{axis}" for name in ("position", "normal") for axis in "XYZ"}
    assert set(channels) == wanted
    floor = channels["position.Z"][10, 5]
    assert abs(floor) < 1e-4
    # The camera stands 4.5 m up and looks 48 degrees down from the horizontal's complement.
    eye, forward = np.array([0, -5, 4.5]), np.array([0, np.sin(np.radians(48)), -np.cos(np.radians(48))])
    seen = np.array([channels[f"position.{axis}"][10, 5] for axis in "XYZ"])
    assert channels["depth.Z"][10, 5] == pytest.approx(float((seen - eye) @ forward), rel=1e-5)


def test_doctor_is_healthy_here(penumbra: Run) -> None:
    result = penumbra("doctor", "--json")
    assert result.returncode == 0
    told = json.loads(result.stdout)
    assert told["healthy"]
    assert {"core", "EGL devices", "OpenGL", "view", "Embree", "Blender", "report", "cache"} == {
        check["name"] for check in told["checks"]
    }
