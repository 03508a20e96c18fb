"""Reports made from closed-form ramps: real arrays, no core and no Blender needed."""

from __future__ import annotations

import csv
import json
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ramps
from checks import check_files, exr, report_of
from penumbra import files, verdict
from penumbra.records import Comparison, Failure, LightResult, SceneResult
from penumbra.report import ReportWriter, html, plots


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A report of two scenes, and the arrays that went into the first one's first light."""
    folder = tmp_path_factory.mktemp("report") / "out"
    comparison = ramps.ramp_comparison()
    writer = ReportWriter(folder)
    kept: dict[str, Any] = {}
    for number, lights in enumerate((2, 1)):
        scene = ramps.ramp_scene(160, 90, lights, seed=number)
        if not kept:
            light = scene.lights[0]
            assert light.reference is not None
            kept = {"reference": light.reference, "shadow_map": light.records[0].visibility}
        comparison.scenes.append(scene)
        writer.add_scene(scene)
    comparison.failures.append(Failure("ramps, Key, <b>pcf</b>", "out of memory"))
    ramps.summarise(comparison)
    writer.finish(comparison)
    return folder, kept


def test_the_report_keeps_its_promises_about_files(made: tuple[Path, dict[str, Any]]) -> None:
    check_files(made[0])


def test_an_exr_holds_the_arrays_that_were_measured(made: tuple[Path, dict[str, Any]]) -> None:
    folder, kept = made
    light = report_of(folder)["scenes"][0]["lights"][0]
    assert np.array_equal(exr(folder / light["reference"]["images"]["area"])["visibility"], kept["reference"].area)
    irradiance = exr(folder / light["reference"]["images"]["irradiance"])
    assert np.array_equal(irradiance["visibility"], kept["reference"].irradiance)
    assert np.array_equal(irradiance["standard_error"], kept["reference"].irradiance_standard_error)
    first = light["records"][0]
    assert np.array_equal(exr(folder / first["images"]["visibility"])["visibility"], kept["shadow_map"])


def test_what_the_rules_saved_stands_beside_the_plan_if_it_was_measured(made: tuple[Path, dict[str, Any]]) -> None:
    records = report_of(made[0])["scenes"][0]["lights"][0]["records"]
    first = next(record for record in records if record["technique"] == "shadow_map")
    assert first["everything_ms"]["dynamic"]["median"] == 2.0 * first["time_ms"]["dynamic"]["median"]
    assert all(record["everything_ms"] == {} for record in records if record["technique"] == "ray_traced")
    page = (made[0] / "report.html").read_text(encoding="utf-8")
    cost = first["time_ms"]["dynamic"]["median"]
    saved = f"saves {verdict.milliseconds(cost)} of {verdict.milliseconds(2.0 * cost)}, 50 %"
    assert f"2 left out: {saved}" in page
    assert "2 left out: no saving to be told from noise" in page
    assert "2 left out</em>" in page  # not measured, nothing told


def test_what_a_technique_counted_stands_in_the_report(made: tuple[Path, dict[str, Any]]) -> None:
    record = report_of(made[0])["scenes"][0]["lights"][0]["records"][0]
    assert [statistic["id"] for statistic in record["statistics"]] == ["rays", "tagged"]
    page = (made[0] / "report.html").read_text(encoding="utf-8")
    assert "Rays cast: <b>1,234,567 rays</b>" in page
    assert "Tagged pixels: <b>5.12 % of the mask</b>" in page


def test_where_a_technique_leaves_its_field_of_use_stands_under_its_plan_and_nowhere_else(
    made: tuple[Path, dict[str, Any]],
) -> None:
    lights = [light for scene in report_of(made[0])["scenes"] for light in scene["lights"]]
    page = (made[0] / "report.html").read_text(encoding="utf-8")
    sentence = "Outside its field of use: the light is 1 m wide and &lt;one&gt; point stands for it."
    assert page.count("Outside its field of use") == page.count(sentence) == len(lights)
    plans = [plan.split("</details>")[0] for plan in page.split("<details>")[1:]]
    assert all((sentence in plan) == ("<b>Hard shadow map</b>" in plan) for plan in plans)
    for light in lights:
        warned = [record["technique"] for record in light["records"] if record.get("warnings")]
        assert warned == ["shadow_map"]


def test_scenes_of_one_name_do_not_overwrite_each_other(made: tuple[Path, dict[str, Any]]) -> None:
    scenes = report_of(made[0])["scenes"]
    paths = [scene["lights"][0]["reference"]["images"]["area"] for scene in scenes]
    assert len(set(paths)) == 2


def test_steps_of_a_sweep_are_records_without_images(made: tuple[Path, dict[str, Any]]) -> None:
    records = report_of(made[0])["scenes"][0]["lights"][0]["records"]
    steps = [record for record in records if record["sweep"]]
    assert len(steps) == 5
    assert all(record["images"] == {} for record in steps)
    assert {record["sweep"]["setting"] for record in steps} == {"kernel", "samples", "rays"}


def test_the_cheapest_within_the_target_is_the_cheapest_within_the_target(made: tuple[Path, dict[str, Any]]) -> None:
    for scene in report_of(made[0])["scenes"]:
        for light in scene["lights"]:
            within = [
                record
                for record in light["records"]
                if record["status"] == "ok" and record["error"]["area"]["penumbra_rmse"] <= 0.05
            ]
            cheapest = min(within, key=lambda record: record["time_ms"]["dynamic"]["median"])
            assert light["cheapest_within_target"] == cheapest["technique"]
            assert light["cheapest_settings"] == cheapest["settings"]


def rows(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / "results.csv").open(newline="")))


def test_the_table_says_when_each_technique_reaches_each_error(made: tuple[Path, dict[str, Any]]) -> None:
    folder, _ = made
    light = report_of(folder)["scenes"][0]["lights"][0]
    assert [target["error"] for target in light["targets"]] == [0.05, 0.02, 0.01, 0.005]
    told = {}
    for target in light["targets"]:
        there = [reach for reach in target["reaches"] if reach["time_ms"] is not None]
        assert target["winner"] == (min(there, key=lambda r: r["time_ms"])["technique"] if there else None)
        for reach in target["reaches"]:
            told[reach["technique"], target["error"]] = reach
            within = [r for r in light["records"] if r["technique"] == reach["technique"] and r["status"] == "ok"]
            within = [r for r in within if r["headline"] <= target["error"]]
            assert (reach["state"] == "not_reached") == (not within)
    for row in rows(folder)[:10]:
        if row["sweep"] or row["status"] != "ok":
            assert row["to_0.05"] == ""
            continue
        reach = told[row["technique"], 0.05]
        assert row["to_0.05"] == row["to_target"] == reach["state"]
        assert row["to_0.05_ms"] == ("" if reach["time_ms"] is None else str(reach["time_ms"]))
    page = (folder / "report.html").read_text()
    assert page.count("<h4>Time to an error</h4>") == 3 + 1 + 1  # lights, the first scene's together, all scenes


def test_what_holds_of_all_scenes_stands_in_front_of_each(made: tuple[Path, dict[str, Any]]) -> None:
    folder, _ = made
    document = report_of(folder)
    assert document["together"]["name"] == "All scenes"
    assert document["scenes"][0]["together"] is not None and document["scenes"][1]["together"] is None
    assert [target["scenes"] for target in document["targets"]] == [2, 2, 2, 2]
    techniques = {mean["technique"] for target in document["targets"] for mean in target["means"]}
    assert techniques == {"shadow_map", "pcf", "light_samples", "ray_traced"}
    page = (folder / "report.html").read_text()
    assert page.index("Each scene with its own setting") < page.index('aria-label="ramps &amp;')
    assert "geometric mean" in page
    assert "All scenes" not in document["scenes"][0]["path"]


def test_the_pick_stands_in_the_report_with_the_words_to_ask_for_it(made: tuple[Path, dict[str, Any]]) -> None:
    folder, _ = made
    page = (folder / "report.html").read_text()
    for light in report_of(folder)["scenes"][0]["lights"]:
        pick = light["pick"]
        record = light["records"][pick["record"]]
        assert (record["technique"], record["settings"]) == (pick["technique"], light["cheapest_settings"])
        assert f"<code>{' '.join(pick['arguments'])}</code>" in page
        assert pick["sentence"] in light["sentences"]
    picked = [row for row in rows(folder) if row["picked"] == "True"]
    assert len(picked) == 3


def test_medians_that_are_not_tight_are_marked(made: tuple[Path, dict[str, Any]]) -> None:
    folder, _ = made
    page = (folder / "report.html").read_text()
    assert page.count("3 of 18 medians of frame times are not known to 5 %") == 3
    assert page.count('<abbr title="This median is not known to 5 %">') == 9
    assert {row["static_tight"] for row in rows(folder) if row["technique"] == "pcf"} == {"False"}


def test_names_from_a_scene_cannot_become_markup(made: tuple[Path, dict[str, Any]]) -> None:
    page = (made[0] / "report.html").read_text()
    assert "<walls>" not in page
    assert "ramps &amp; &lt;walls&gt;" in page
    assert "<b>pcf</b>" not in page


def test_failures_are_named_at_the_top(made: tuple[Path, dict[str, Any]]) -> None:
    folder, _ = made
    assert report_of(folder)["failures"] == [{"what": "ramps, Key, <b>pcf</b>", "reason": "out of memory"}]
    page = (folder / "report.html").read_text()
    assert page.index("out of memory") < page.index("<main")


def test_the_page_embeds_v_to_sixteen_bits(made: tuple[Path, dict[str, Any]]) -> None:
    import base64
    import io

    import PIL.Image

    folder, kept = made
    page = (folder / "report.html").read_text()
    start = page.index('id="data">') + len('id="data">')
    data = json.loads(page[start : page.index("</script>", start)])
    uri = data["lights"][0]["area"]
    pixels = np.asarray(PIL.Image.open(io.BytesIO(base64.b64decode(uri.partition(",")[2]))))[::-1].astype(int)
    shown = (pixels[..., 0] * 256 + pixels[..., 1]) / 65535
    assert np.abs(shown - kept["reference"].area).max() <= 0.5 / 65535 + 1e-7
    assert np.array_equal(pixels[..., 2] > 0, kept["reference"].mask > 0)


def test_a_script_end_in_a_name_does_not_end_the_script() -> None:
    text = html._script_safe({"name": "</script><script>alert(1)"})
    assert "<" not in text
    assert json.loads(text) == {"name": "</script><script>alert(1)"}


def test_an_empty_light_a_failed_light_and_no_time_make_a_report(tmp_path: Path) -> None:
    comparison = ramps.ramp_comparison()
    scene = ramps.ramp_scene(64, 36, 2)
    scene.lights[0].records = []
    for record in scene.lights[1].records:
        record.time_ms = {}
    for light in scene.lights:
        verdict.judge(light, None, ramps.staircase)
    scene.lights.append(LightResult("Broken", "sun", [], angle_rad=0.01, sentences=["No technique could be measured."]))
    comparison.scenes.append(scene)
    writer = ReportWriter(tmp_path)
    writer.add_scene(scene)
    page = writer.finish(comparison).read_text()
    assert "Broken" in page
    assert (tmp_path / "pareto.png").is_file()


def test_not_a_number_becomes_null_in_json(tmp_path: Path) -> None:
    comparison = Comparison(environment={"gl_renderer": "x", "bad": float("nan"), "worse": np.float32("inf")})
    comparison.scenes.append(SceneResult("a.blend", "Camera", 1, (4, 4), 2))
    from penumbra.records import to_json

    assert to_json(comparison)["environment"] == {"gl_renderer": "x", "bad": None, "worse": None}


def test_a_techniques_curve_is_its_own_front_and_what_lies_beside_it_stays_alone() -> None:
    light = ramps.ramp_scene(64, 36, 1).lights[0]
    (line,) = plots.curves(light)["pcf"]
    assert [record.settings["kernel"] for record in line] == [3, 9, 17]
    (alone,) = plots.curves(light)["shadow_map"]
    assert len(alone) == 1
    dear = next(record for record in light.records if record.settings.get("kernel") == 9)
    dear.time_ms["dynamic"] = ramps.spread(1000.0)
    line, beside = plots.curves(light)["pcf"]
    assert [record.settings["kernel"] for record in line] == [3, 17]
    assert beside == [dear]


@pytest.mark.parametrize(
    ("name", "slug"),
    [
        ("Key Light.001", "key-light-001"),
        ("Lumière", "lumiere"),
        ("灯", "unnamed"),
        ("../../etc", "etc"),
        ("", "unnamed"),
    ],
)
def test_any_name_becomes_a_file_name(name: str, slug: str) -> None:
    assert files.slug(name) == slug


def test_equal_names_are_numbered() -> None:
    assert files.unique_slug("灯", ["unnamed", "unnamed-2"]) == "unnamed-3"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (0.28867, "0.289"),
        (0.0123456, "0.0123"),
        (1.0, "1.00"),
        (2.34e-7, "2.3e-07"),
        (None, "–"),
        (0.1, "0.100"),
    ],
)
def test_errors_are_shown_with_three_digits(value: float | None, text: str) -> None:
    assert html.format_error(value) == text


def test_a_report_killed_halfway_leaves_only_whole_files(tmp_path: Path, environment: dict[str, str]) -> None:
    import signal
    import sys

    program = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
import ramps
from penumbra.report import ReportWriter
scenes = [ramps.ramp_scene(320, 180, 2, seed) for seed in range(3)]
print("start", flush=True)
while True:
    writer = ReportWriter(Path(sys.argv[1]))
    comparison = ramps.ramp_comparison()
    for scene in scenes:
        import copy
        scene = copy.deepcopy(scene)
        comparison.scenes.append(scene)
        writer.add_scene(scene)
    writer.finish(comparison)
"""
    for delay in (0.15, 0.4, 0.9, 1.7):
        folder = tmp_path / str(delay)
        process = subprocess.Popen(
            [sys.executable, "-c", program, str(folder)], stdout=subprocess.PIPE, env=environment
        )
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        for path in folder.rglob("*"):
            if path.suffix == ".exr":
                assert exr(path)["visibility"].shape == (180, 320)
            elif path.suffix == ".png":
                assert path.read_bytes().endswith(b"IEND\xaeB`\x82")
            elif path.name == "report.json":
                report_of(folder)
            elif path.name == "report.html":
                assert path.read_text().endswith("</html>\n")
            elif path.is_file() and path.suffix not in (".csv", ".svg"):
                # Complete, between its two names; see files.whole_file.
                assert path.name.startswith(".penumbra-")


def test_the_page_opens_offline_in_a_browser_and_shows_its_pictures(
    made: tuple[Path, dict[str, Any]], chromium: str, tmp_path: Path
) -> None:
    shot = tmp_path / "shot.png"
    common = [
        chromium, "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
        "--virtual-time-budget=60000", "--window-size=1280,1600",
    ]  # fmt: skip
    page = (made[0] / "report.html").as_uri()
    dom = subprocess.run([*common, "--dump-dom", page], capture_output=True, text=True, timeout=120).stdout
    viewers = dom.count('<div class="viewer">')
    assert viewers >= 1, "no viewer started"
    assert "could not show the pictures (" not in dom.partition("<script")[0]
    assert dom.count('<svg viewBox="0 0 640 400"') == 3 + 2  # lights, and several together
    subprocess.run([*common, f"--screenshot={shot}", page], capture_output=True, timeout=120)
    assert shot.stat().st_size > 50_000
