"""What `penumbra compare-reports` finds between two reports. Every time and error here is made up."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import ramps
from checks import check_page
from penumbra import cli
from penumbra.changes import match, page, read, text
from penumbra.errors import UserError
from penumbra.records import Comparison, LightResult, Record, SceneResult, Spread, Step, to_json

Document = dict[str, Any]


def spread(ms: float, width: float, runs: int = 9) -> Spread:
    return Spread(ms, ms, ms, ms * (1 - width), ms * (1 + width), runs, True)


def record(
    technique: str, error: float, ms: float, width: float = 0.02, rays: int | None = None, **more: Any
) -> Record:
    made = Record(technique, technique.upper(), {"size": 4} | ({"rays": rays} if rays else {}))
    if rays:
        made.sweep = {"setting": "rays", "value": rays, "changed": {"rays": rays}}
        made.given = {"rays": rays}
    made.area = {"penumbra_rmse": error, "rmse": error, "penumbra_pixels": 5, "pixels": 9}
    made.area |= {"parts": {}, "dominant": "bias", "sentence": "So it is."}
    made.irradiance = dict(made.area)
    made.headline_error = more.get("se", 0.0)
    made.time_ms = {"dynamic": spread(ms, width, more.get("runs", 9)), "static": spread(ms / 2, width)}
    made.plan = [Step("map", "run", time_ms=1.0), Step("filter", "left_out", "no penumbra", "narrow", 0.0)]
    made.memory_bytes = 1024
    return made


def document(
    *records: Record, path: str = "/a/shot.blend", size: tuple[int, int] = (8, 6), light: str = "Key"
) -> Document:
    lights = [LightResult(light, "rectangle", [1.0, 2.0], {}, None, {"method": "rays"}, list(records))]
    scene = SceneResult(path, "Camera", 1, size, 12, lights=lights)
    comparison = Comparison(dict(ramps.ENVIRONMENT), {"sweep": "quick"}, [scene])
    made: Document = json.loads(json.dumps(to_json(comparison), allow_nan=False))
    return made


def report(folder: Path, name: str, content: Document) -> Path:
    (folder / name).mkdir()
    (folder / name / "report.json").write_text(json.dumps(content))
    return folder / name


@pytest.fixture
def compared(tmp_path: Path) -> Callable[..., match.Changes]:
    def run(a: Document, b: Document) -> match.Changes:
        return match.changes(read.read(report(tmp_path, "a", a)), read.read(report(tmp_path, "b", b)))

    return run


Compared = Callable[[Document, Document], match.Changes]


def pairs_of(changes: match.Changes) -> list[match.Pair]:
    return [pair for _, _, pair in changes.pairs()]


# ------------------------------------------------------------------------------------------------------------ judging


def test_a_report_compared_with_itself_has_no_change(compared: Compared) -> None:
    made = document(record("pcf", 0.1, 5.0), record("pcf", 0.05, 9.0, rays=4))
    found = compared(made, made)
    assert not any(pair.changes for pair in pairs_of(found))
    assert (found.environment, found.options, found.missing) == ([], [], [])
    assert found.overall is not None and found.overall.value == pytest.approx(1.0)
    assert text.gate(found, text.Limits(1.0, 1.0, 1.0, 1.0, True)) == (0, [])


@pytest.mark.parametrize(
    ("b_ms", "width", "call"),
    [(10.0, 0.02, "same"), (10.3, 0.02, "same"), (11.0, 0.02, "more"), (9.0, 0.02, "less"), (11.0, 0.1, "same")],
)
def test_a_time_changed_only_if_the_intervals_do_not_overlap(b_ms: float, width: float, call: str) -> None:
    found = match.time_change("dynamic", spread(10.0, width), spread(b_ms, width))
    assert found.call == call
    assert found.ratio.value == pytest.approx(b_ms / 10.0)
    assert found.ratio.low == pytest.approx(b_ms * (1 - width) / (10.0 * (1 + width)))
    assert found.ratio.high == pytest.approx(b_ms * (1 + width) / (10.0 * (1 - width)))
    assert (found.ratio.low > 1.0 or found.ratio.high < 1.0) == (call != "same")


def test_of_fewer_than_five_runs_no_change_is_told() -> None:
    found = match.time_change("dynamic", spread(10.0, 0.0, runs=1), spread(20.0, 0.0, runs=9))
    assert found.call == "unknown"


def test_a_time_of_nothing_has_a_ratio() -> None:
    found = match.time_change("dynamic", spread(0.0, 0.0), spread(0.0, 0.0))
    assert (found.ratio.value, found.call) == (1.0, "same")


@pytest.mark.parametrize(
    ("a", "b", "se", "call"),
    [
        (0.1, 0.1, 0.0, "same"),
        (0.1, 0.1 + 1e-8, 0.0, "same"),  # rounding
        (0.1, 0.1001, 0.0, "more"),
        (0.1, 0.1001, 0.0001, "same"),
        (0.1, 0.0999, 0.0, "less"),
    ],
)
def test_an_error_changed_only_if_the_intervals_do_not_overlap(a: float, b: float, se: float, call: str) -> None:
    assert match.error_change(record("x", a, 1.0, se=se), record("x", b, 1.0, se=se)).call == call


def test_of_an_older_report_the_references_noise_tells_how_sure_an_error_is() -> None:
    a, b = record("x", 0.01, 1.0), record("x", 0.0101, 1.0)
    for item in (a, b):
        assert item.area is not None
        item.area["reference_standard_error"] = 0.002  # its square over twice the error is 0.0002
    assert match.error_change(a, b).call == "same"
    assert match.error_change(a, b).a_width == pytest.approx(1.96 * 0.0002)


def test_geometric_means_stand_for_each_technique(compared: Compared) -> None:
    a = document(record("pcf", 0.1, 5.0), record("pcf", 0.1, 5.0, rays=4), record("map", 0.1, 3.0))
    b = document(record("pcf", 0.1, 10.0), record("pcf", 0.05, 40.0, rays=4), record("map", 0.1, 3.0))
    pcf, still = compared(a, b).techniques
    assert pcf.time is not None and still.time is not None
    assert pcf.time.value == pytest.approx(4.0)
    half = math.hypot(math.log(1.02 / 0.98), math.log(1.02 / 0.98)) / 2
    assert math.log(pcf.time.high / pcf.time.value) == pytest.approx(half)
    assert pcf.error == pytest.approx(math.sqrt(0.5))
    assert (pcf.slower, pcf.faster, pcf.better, pcf.worse, pcf.pairs) == (2, 0, 1, 0, 2)
    assert still.time.value == pytest.approx(1.0)


# ----------------------------------------------------------------------------------------------------------- matching


def test_records_are_matched_by_settings_and_the_rest_is_named(compared: Compared) -> None:
    a = document(record("pcf", 0.1, 5.0), record("pcf", 0.1, 5.0, rays=4))
    b = document(record("pcf", 0.1, 5.0, rays=8), record("pcf", 0.1, 5.0), record("new", 0.1, 1.0))
    found = compared(a, b)
    assert [pair.label for pair in pairs_of(found)] == ["PCF"]
    assert found.missing == [
        "shot, Key: PCF (rays 4) only in A",
        "shot, Key: PCF (rays 8) only in B",
        "shot, Key: NEW only in B",
    ]


def test_a_setting_that_one_version_lacks_is_named_and_does_not_part_a_pair(compared: Compared) -> None:
    a, b = document(record("pcf", 0.1, 5.0)), document(record("pcf", 0.1, 5.0))
    b["scenes"][0]["lights"][0]["records"][0]["settings"]["fresh"] = 3
    (pair,) = pairs_of(compared(a, b))
    assert pair.new_settings == ("fresh",)


def test_a_default_that_changed_parts_a_pair(compared: Compared) -> None:
    a, b = document(record("pcf", 0.1, 5.0)), document(record("pcf", 0.1, 5.0))
    b["scenes"][0]["lights"][0]["records"][0]["settings"]["size"] = 8
    assert pairs_of(compared(a, b)) == []


def test_one_is_not_on(compared: Compared) -> None:
    a, b = document(record("pcf", 0.1, 5.0)), document(record("pcf", 0.1, 5.0))
    a["scenes"][0]["lights"][0]["records"][0]["settings"]["size"] = 1
    b["scenes"][0]["lights"][0]["records"][0]["settings"]["size"] = True
    assert pairs_of(compared(a, b)) == []


@pytest.mark.parametrize("path", ["/else/where/shot.blend", "C:\\scenes\\shot.blend", "shot.blend"])
def test_scenes_are_matched_by_their_files_name_wherever_they_lie(compared: Compared, path: str) -> None:
    found = compared(document(record("pcf", 0.1, 5.0)), document(record("pcf", 0.1, 5.0), path=path))
    assert len(pairs_of(found)) == 1 and found.missing == []


def test_pictures_of_two_sizes_are_not_compared_and_it_says_so(compared: Compared) -> None:
    found = compared(document(record("pcf", 0.1, 5.0)), document(record("pcf", 0.1, 9.0), size=(16, 12)))
    assert pairs_of(found) == []
    assert "8 x 6 in A and 16 x 12 in B: nothing is compared" in found.scenes[0].notes[0]


def test_a_technique_that_fails_now_is_a_change_and_worse(compared: Compared) -> None:
    broken = Record("pcf", "PCF", {}, "failed", "out of memory")
    found = compared(document(record("pcf", 0.1, 5.0)), document(broken))
    (pair,) = pairs_of(found)
    assert (pair.a_status, pair.b_status, pair.changes) == ("ok", "failed", True)
    code, (said,) = text.gate(found, text.Limits(fail_worse=2.0))
    assert code == 4 and "failed (out of memory)" in said


def test_steps_that_the_plan_now_runs_or_leaves_out_are_told(compared: Compared) -> None:
    now = record("pcf", 0.1, 5.0)
    now.plan = [Step("map", "run"), Step("filter", "run"), Step("pack", "left_out", "one light")]
    (pair,) = pairs_of(compared(document(record("pcf", 0.1, 5.0)), document(now)))
    assert pair.plan == (
        match.StepChange("filter", "left out", "run", "no penumbra"),
        match.StepChange("pack", "", "left out", "one light"),
    )
    assert pair.changes


def test_what_differs_in_machine_version_and_options_is_told_but_not_the_date(compared: Compared) -> None:
    a, b = document(record("pcf", 0.1, 5.0)), document(record("pcf", 0.1, 5.0))
    b["environment"] |= {"cpu": "Other CPU", "date": "2030-01-01", "command": "x", "build": {"compiler": "GCC 13"}}
    b["options"]["keep_everything"] = True
    found = compared(a, b)
    assert found.environment == [("cpu", "Some CPU", "Other CPU"), ("build compiler", "GCC 12.2", "GCC 13")]
    assert found.options == [("keep_everything", "–", "yes")]


# -------------------------------------------------------------------------------------------------------------- gates


@pytest.mark.parametrize(
    ("limits", "code"),
    [
        (text.Limits(), 0),
        (text.Limits(warn_slower=1.2), 3),
        (text.Limits(fail_slower=1.2), 4),
        (text.Limits(warn_slower=1.2, fail_slower=3.0), 3),
        (text.Limits(fail_slower=3.0), 0),
        (text.Limits(warn_worse=1.05), 3),
        (text.Limits(fail_worse=1.05), 4),
        (text.Limits(fail_worse=1.5), 0),
    ],
)
def test_gates_close_on_changes_beyond_their_limit(compared: Compared, limits: text.Limits, code: int) -> None:
    found = compared(document(record("pcf", 0.1, 5.0)), document(record("pcf", 0.12, 10.0)))
    assert text.gate(found, limits)[0] == code


def test_a_time_that_only_may_have_grown_closes_no_gate(compared: Compared) -> None:
    found = compared(document(record("pcf", 0.1, 5.0, 0.3)), document(record("pcf", 0.1, 8.0, 0.3)))
    assert text.gate(found, text.Limits(fail_slower=1.2)) == (0, [])


def test_a_gate_names_the_worst_and_counts_the_rest(compared: Compared) -> None:
    a = document(record("pcf", 0.1, 5.0), record("map", 0.1, 5.0))
    found = compared(a, document(record("pcf", 0.1, 10.0), record("map", 0.1, 20.0)))
    (said,) = text.gate(found, text.Limits(fail_slower=1.2))[1]
    assert said == "MAP at Key in shot: its dynamic frame takes 4.00 times as long, above --fail-slower 1.2, and 3 more"


# ------------------------------------------------------------------------------------------------------- the command


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = cli.main(["compare-reports", *map(str, arguments)])
    told = capsys.readouterr()
    return code, told.out, told.err


@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    a = document(record("pcf", 0.1, 5.0), record("map", 0.3, 2.0), record("old", 0.3, 2.0))
    b = document(record("pcf", 0.08, 10.0), record("map", 0.3, 2.0))
    b["environment"]["cpu"] = "<Other> CPU"
    return report(tmp_path, "a", a), report(tmp_path, "b", b)


def test_the_command_tells_what_changed_and_writes_page_and_json(
    two: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = run(capsys, *two, "--out", tmp_path / "out")
    assert (code, err) == (0, "")
    assert "  cpu: Some CPU -> <Other> CPU" in out
    assert "  PCF: error 0.1 -> 0.08, more accurate; dynamic frame 5 ms -> 10 ms, x 2.00 (1.92 to 2.08), slower" in out
    assert "shot, Key: OLD only in A" in out
    assert "2 records in both reports, 1 changed." in out
    found = json.loads((tmp_path / "out" / "changes.json").read_text())
    assert found["schema"] == 1
    pair = next(p for p in found["scenes"][0]["lights"][0]["pairs"] if p["technique"] == "pcf")
    assert pair["error"]["call"] == "less"
    assert pair["times"][0]["ratio"]["value"] == pytest.approx(2.0)
    check_page(tmp_path / "out" / "changes.html")
    shown = (tmp_path / "out" / "changes.html").read_text()
    assert "&lt;Other&gt; CPU" in shown and "<Other>" not in shown
    assert not list((tmp_path / "out").glob(".*"))


def test_a_report_itself_is_named_as_well_as_its_folder(
    two: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    a, b = two
    assert run(capsys, a / "report.json", b)[1] == run(capsys, a, b / "report.json")[1]


def test_for_programs_only_json_is_printed(two: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run(capsys, *two, "--json")
    assert json.loads(out)["missing"] == ["shot, Key: OLD only in A"]


def test_gates_set_the_exit_code_and_say_why(two: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, *two, "--fail-slower", 1.5)
    assert code == 4 and "PCF at Key in shot" in err
    assert run(capsys, *two, "--warn-slower", 1.5)[0] == 3
    assert run(capsys, *two, "--fail-worse", 1.01)[0] == 0
    code, _, err = run(capsys, *two, "--fail-missing")
    assert code == 4 and "OLD only in A" in err


BAD = {
    "missing": (None, "does not exist"),
    "not JSON": ("{", "is not JSON"),
    "a list": ("[]", "is not a report.json"),
    "another file": ('{"schema": 1, "rows": []}', "is not a report.json"),
    "another schema": ('{"schema": 2, "scenes": []}', "has schema 2; this version of Penumbra reads schema 1"),
    "NaN": ('{"schema": 1, "scenes": [NaN]}', "holds NaN"),
    "infinity": ('{"schema": 1, "scenes": [-Infinity]}', "holds -Infinity"),
    "no environment": ('{"schema": 1, "scenes": []}', "is damaged: 'environment' is missing"),
    "bytes": ("\udcff", "is not JSON"),
    "deep": ("[" * 100_000, "is not JSON"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_sentence_and_nothing_is_written(
    name: str, two: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content, says = BAD[name]
    bad = tmp_path / "bad.json"
    if content is not None:
        bad.write_bytes(content.encode("utf-8", "surrogateescape"))
    for arguments in ((bad, two[1]), (two[0], bad)):
        code, out, err = run(capsys, *arguments, "--out", tmp_path / "out")
        assert (code, out) == (2, "")
        assert says in err and str(bad) in err and err.count("\n") == 1
        assert not (tmp_path / "out").exists()


def test_reports_without_a_scene_in_common_are_refused(
    two: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = report(tmp_path, "c", document(record("pcf", 0.1, 5.0), path="other.blend"))
    code, _, err = run(capsys, two[0], other)
    assert code == 2 and "no scene in common" in err


def places(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The way to every value in a document."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in inner:
        yield (*at, key)
        yield from places(item, (*at, key))


def damaged(made: Document) -> Iterator[tuple[str, Document]]:
    """Every value of the document taken away, or replaced by one of another kind."""
    for at in places(made):
        for what in ("gone", None, True, -1, 1e999, "text", [], {}, [1], {"x": 1}):
            copied = copy.deepcopy(made)
            inner: Any = copied
            for key in at[:-1]:
                inner = inner[key]
            if what == "gone":
                del inner[at[-1]]
            else:
                inner[at[-1]] = what
            yield f"{at}: {what!r}", copied


def test_whatever_is_damaged_a_report_is_read_or_refused_in_one_sentence(tmp_path: Path) -> None:
    made = document(record("pcf", 0.1, 5.0, rays=4))
    made["environment"] = {"cpu": "x", "build": {"compiler": "y"}}
    good = read.read(report(tmp_path, "good", made))
    file = tmp_path / "report.json"
    answered = tried = 0
    for where, content in damaged(made):
        tried += 1
        file.write_text(json.dumps(content).replace("Infinity", "1e999"))
        try:
            found = match.changes(good, read.read(file))
            json.dumps(text.to_json(found), allow_nan=False)
            "\n".join(text.lines(found))
            if tried % 8 == 0:  # a page takes longer than all else
                page.page(found)
            answered += 1
        except UserError as error:
            answered += len(str(error).splitlines()) == 1
        except Exception as error:
            raise AssertionError(f"{where} gave {type(error).__name__}: {error}") from error
    assert answered == tried > 1000
