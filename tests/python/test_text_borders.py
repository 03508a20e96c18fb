"""Whatever a file or a command line holds, it is read or refused in one sentence: random and damaged texts."""

from __future__ import annotations

import copy
import gzip
import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from penumbra import cli, compare, scenes
from penumbra.batch import summary
from penumbra.batch.jobs import Item, Job, Shot, expand, frames_text, parse_frames
from penumbra.batch.store import Facts, Store, made_from
from penumbra.commands import registry
from penumbra.commands.batch import job_of
from penumbra.comparison import results
from penumbra.errors import UserError
from penumbra.read.notes import SHOWN_NAMES, Notes, kept
from penumbra.records import to_json
from scenes_at_random import many, values_of
from test_records import comparison

lines = st.text(st.characters(codec="utf-8"), max_size=40)
odd = ["", "1", "-1", "nan", "inf", "1e999", "9" * 5000, "\u0663", "\x00", "\ud800", "\n", '"', "on", "all"]
words = st.sampled_from(odd) | lines
numbers = st.integers() | st.floats() | st.sampled_from([10**400, math.nan, math.inf])
json_values = st.recursive(
    st.none() | st.booleans() | numbers | words,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(words, inner, max_size=3),
    max_leaves=6,
)


def assert_sentence(error: BaseException) -> None:
    text = str(error)
    assert text.strip() and len(text.splitlines()) == 1, repr(text)


# --- --set and other words of the command line -----------------------------------------------------------------------


@pytest.fixture(scope="session")
def infos(core: Any) -> list[dict[str, Any]]:
    return list(core.techniques())


@many
@given(text=words)
@example("pcf.kernel=" + "9" * 5000)
@example("pcf.bias_scale=1_0")
@example("pcf.bias\n=slope")
def test_any_text_after_set_is_a_setting_or_one_sentence(infos: list[dict[str, Any]], text: str) -> None:
    for given_text in (text, f"pcf.{text}", f"pcf.kernel={text}", f"pcf.bias_scale={text}", f"plateaus.plane={text}"):
        try:
            technique, key, value = compare.parse_setting(infos, given_text)
        except UserError as error:
            assert_sentence(error)
            continue
        (info,) = (info for info in infos if info["id"] == technique)
        (setting,) = (setting for setting in info["settings"] if setting["id"] == key)
        if setting["type"] in ("int", "float"):
            assert setting["minimum"] <= value <= setting["maximum"]


@many
@given(data=st.data())
def test_every_value_of_every_setting_survives_the_command_line(
    infos: list[dict[str, Any]], data: st.DataObject
) -> None:
    info = data.draw(st.sampled_from(infos))
    setting = data.draw(st.sampled_from(info["settings"]))
    value = data.draw(values_of(setting))
    word = ("on" if value else "off") if isinstance(value, bool) else str(value)
    assert compare.parse_setting(infos, f"{info['id']}.{setting['id']}={word}") == (info["id"], setting["id"], value)


@pytest.mark.parametrize(
    "command", ["compare", "render", "batch", "demo", "techniques", "doctor", "compare --size", "compare --frame",
                "batch --frames", "compare --warn-rmse", "compare --techniques", "batch --workers",
                "batch --item-timeout"]
)  # fmt: skip
@many
@given(given_words=st.lists(words | st.sampled_from(["--out", "--set", "--", "-", "--ou", " "]), max_size=3))
@example(["9" * 5000 + "x9"])
@example(["1-" + "9" * 5000])
@example([" "])
def test_any_words_are_a_command_or_one_sentence(command: str, given_words: list[str]) -> None:
    try:
        assert cli.registry is registry  # with all commands
        registry.parser().parse_args([*command.split(), *given_words])
    except UserError as error:
        assert_sentence(error)


@many
@given(st.lists(st.integers(-1048574, 1048574), min_size=1, max_size=30, unique=True))
def test_frames_survive_being_written_down(frames: list[int]) -> None:
    assert parse_frames(frames_text(frames)) == tuple(frames)


# --- job files -------------------------------------------------------------------------------------------------------

KEYS = ["frames", "cameras", "size", "techniques", "settings", "lights", "sweep", "reference_error", "target_rmse",
        "warn_rmse", "fail_rmse", "keep_everything", "out", "mode", "technique", "format", "device", "view_by",
        "workers", "no_cache", "scenes"]  # fmt: skip


def toml(value: Any) -> str:
    """A value as TOML writes it; None is an empty list."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(str(key))} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, (int, float)):
        return str(value)
    return json.dumps(value if value is not None else [])


@many
@given(
    table=st.dictionaries(st.sampled_from(KEYS) | words, json_values, max_size=4),
    scene=st.dictionaries(st.sampled_from([*KEYS, "path", "name"]), json_values, max_size=3),
)
@example(table={"size": "9" * 5000 + "x1"}, scene={"path": "a"})
@example(table={"size": [10**400, 1]}, scene={"path": "a"})
@example(table={"out": "\x00"}, scene={"path": "a\nb"})
def test_any_table_is_a_job_or_one_sentence(
    core: Any, tmp_path: Path, table: dict[str, Any], scene: dict[str, Any]
) -> None:
    text = "".join(f"{toml(key)} = {toml(value)}\n" for key, value in table.items())
    text += "[[scenes]]\n" + "".join(f"{toml(key)} = {toml(value)}\n" for key, value in scene.items())
    assert_job_or_sentence(core, tmp_path, text.encode("utf-8", "surrogatepass"))


@many
@given(st.binary(max_size=60) | words.map(lambda text: text.encode("utf-8", "surrogatepass")))
@example(b"x = " + b"9" * 5000)
@example(b"x = " + b"[" * 100_000)
def test_any_bytes_are_a_job_or_one_sentence(core: Any, tmp_path: Path, content: bytes) -> None:
    assert_job_or_sentence(core, tmp_path, content)


def assert_job_or_sentence(core: Any, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "job.toml"
    path.write_bytes(content)
    parsed = registry.parser().parse_args(["batch", str(path), "--out", str(tmp_path / "out")])
    try:
        expand(job_of(core, parsed))
    except UserError as error:
        assert_sentence(error)


# --- what an earlier run left ----------------------------------------------------------------------------------------


@st.composite
def damaged(draw: st.DrawFn, document: Any) -> Any:
    """The document with one of its parts, however deep, replaced or gone."""
    document = copy.deepcopy(document)
    place: Any = document
    while True:
        key = draw(st.sampled_from(sorted(place) if isinstance(place, dict) else range(len(place))))
        inner = place[key]
        if not isinstance(inner, (dict, list)) or not inner or draw(st.booleans()):
            break
        place = inner
    if draw(st.booleans()):
        place[key] = draw(json_values)
    elif isinstance(place, dict):
        del place[key]
    else:
        place.clear()
    return document


REPORT = json.loads(json.dumps(to_json(comparison())))


@many
@given(document=damaged(REPORT) | json_values)
def test_records_in_a_blend_file_are_read_or_there_are_none(document: Any) -> None:
    text = json.dumps(document)
    found = results.unpacked(results.packed_text(text))
    if document == REPORT:
        assert found is not None and to_json(found) == REPORT
    elif found is not None:
        results.packed_text(json.dumps(to_json(found)))


@many
@given(words)
def test_any_text_in_a_blend_file_is_read_or_there_are_no_records(text: str) -> None:
    results.unpacked(text)


def item(tmp_path: Path) -> Item:
    (tmp_path / "wall.blend").write_text("a scene")
    (made,) = expand(Job((Shot("wall", tmp_path / "wall.blend", (3,)),), tmp_path / "out"))
    return made


@many
@given(document=damaged(REPORT) | json_values)
@example(document={**REPORT, "environment": ["a list"]})
@example(document={**REPORT, "scenes": [{**REPORT["scenes"][0], "frame": math.inf}]})
def test_a_damaged_report_fails_its_item_and_not_the_summary(tmp_path: Path, document: Any) -> None:
    folder = tmp_path / "out"
    folder.mkdir(exist_ok=True)
    (folder / "report.json").write_text(json.dumps(document))
    made = item(tmp_path)
    result = summary.Result(made, folder / "report.html", {}, True)
    book = summary.collect(Job((), folder), [result], [], 0.0)
    assert len(book.shots) + len([failure for failure in book.failures if failure.item == made.id]) == 1
    json.dumps(summary.to_json(book), allow_nan=False)
    summary.csv_text(book)


@many
@given(data=st.data())
def test_a_damaged_stamp_makes_its_item_anew(core: Any, tmp_path: Path, data: st.DataObject) -> None:
    made, store = item(tmp_path), Store(tmp_path / "out")
    library = tmp_path / "hero.blend"
    library.write_text("a hero")
    files = [Facts().of(Path(made.scene)), Facts().of(library)]
    whole = {"made_from": made_from(made, files), "failures": [], "notes": []}
    page = store.page(made)
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text("whole")
    stamp = page.parent / "item.json"
    stamp.write_text(json.dumps(whole))
    assert store.state(made).done
    document = data.draw(damaged(whole) | json_values)
    stamp.write_text(json.dumps(document))
    assert isinstance(store.state(made).done, bool)
    stamp.write_bytes(data.draw(st.binary(max_size=40)) + b"[" * 20_000)
    assert not store.state(made).done


# --- what comes with a .blend file -----------------------------------------------------------------------------------


@many
@given(
    st.binary(max_size=64),
    st.integers(0, 40),
    st.sampled_from([b"", b"BLENDER-v405", b"BLENDER17-01v0500", b"\x28\xb5\x2f\xfd"]),
)
def test_any_header_is_a_version_or_none(tmp_path: Path, content: bytes, cut: int, head: bytes) -> None:
    packed = gzip.compress(b"BLENDER-v405" + content)
    path = tmp_path / "a.blend"
    for written in (head + content, packed[:cut] + content + packed[cut:], packed[: len(packed) - cut]):
        path.write_bytes(written)
        version = scenes.blend_version(path)
        assert version is None or all(0 <= part <= 99 for part in version)


@many
@given(st.lists(st.tuples(st.sampled_from(["left out", "no faces"]), st.none() | lines), max_size=20))
def test_notes_name_the_first_of_each_kind_and_count_the_rest(said: list[tuple[str, str | None]]) -> None:
    notes = Notes()
    for text, name in said:
        notes.add(text, name)
    sentences = notes.sentences()
    assert len(sentences) == len({text for text, _ in said})
    for sentence, text in zip(sentences, dict.fromkeys(text for text, _ in said), strict=True):
        names = list(dict.fromkeys(name for other, name in said if other == text and name is not None))
        assert sentence.startswith(text)
        assert all(f'"{name}"' in sentence for name in names[:SHOWN_NAMES])
        assert sentence.endswith(f" and {len(names) - SHOWN_NAMES} more") == (len(names) > SHOWN_NAMES)


@many
@given(json_values)
def test_whatever_a_file_keeps_under_our_name_is_sentences(value: Any) -> None:
    for text in kept(value):
        assert text.strip() and len(text.splitlines()) == 1
