"""What a batch has to do, and what is done: expansion, job files, stamps. No Blender, no pictures."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from penumbra import cli
from penumbra.batch import jobs
from penumbra.batch.jobs import Item, Job, Shot, expand, frames_text, parse_frames
from penumbra.batch.store import Facts, Store, made_from
from penumbra.commands import registry
from penumbra.commands.batch import job_of
from penumbra.compare import Options

pytestmark = pytest.mark.usefixtures("core")


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("7", (7,)),
        ("1-4", (1, 2, 3, 4)),
        ("1..4", (1, 2, 3, 4)),
        ("1-10:4", (1, 5, 9)),
        ("-2-1", (-2, -1, 0, 1)),
        ("-5--3", (-5, -4, -3)),
        ("5, 1-3, 2", (5, 1, 2, 3)),
    ],
)
def test_frames_are_each_once_in_the_order_given(text: str, frames: tuple[int, ...]) -> None:
    assert parse_frames(text) == frames
    assert parse_frames(frames_text(frames)) == frames


@pytest.mark.parametrize("text", ["", "a", "1-", "4-1", "1-4:0", "1;2", "1-9999999", "1-1000000", "1.5"])
def test_what_is_no_range_of_frames_is_refused_with_its_text(text: str) -> None:
    with pytest.raises(ValueError, match="frame"):
        parse_frames(text)


def item(**changes: Any) -> Item:
    job = Job((Shot("wall", Path("/scenes/wall.blend"), (3,), ("Left",), (64, 36)),), Path("out"))
    (made,) = expand(job)
    return jobs.dataclasses.replace(made, **changes)


def test_items_go_scene_by_scene_camera_by_camera_in_the_order_of_frames() -> None:
    shots = (
        Shot("a", Path("a.blend"), (2, 1), ("Left", "left", "Right Eye")),
        Shot("b", Path("b.blend")),
    )
    assert [each.id for each in expand(Job(shots, Path("out")))] == [
        "a/0002-left", "a/0001-left", "a/0002-left-2", "a/0001-left-2", "a/0002-right-eye", "a/0001-right-eye",
        "b/current",
    ]  # fmt: skip


def test_scenes_of_one_file_name_get_folders_of_their_own() -> None:
    assert jobs.named([(None, Path("x/shot.blend")), (None, Path("y/shot.blend"))]) == ["shot", "shot-2"]


def test_an_item_survives_the_way_to_another_process() -> None:
    sent = item(options=Options(techniques=("pcf",), settings={"pcf": {"kernel": 5}}, lights=("Key",)), warn_rmse=0.1)
    assert Item.from_json(json.loads(json.dumps(sent.to_json()))) == sent


# --- job files -------------------------------------------------------------------------------------------------------

JOB = """
out = "results"
frames = "1-4"
techniques = ["shadow_map", "pcf"]
reference_error = 0.01
warn_rmse = 0.2
[settings.pcf]
kernel = 5
[[scenes]]
path = "a.blend"
[[scenes]]
path = "deep/b.blend"
name = "second"
frames = [1, "5-6"]
cameras = ["Left", "Right"]
techniques = ["shadow_map"]
size = [64, 36]
lights = ["Key"]
warn_rmse = 0.3
"""


def job(folder: Path, text: str, *words: str) -> Job:
    from penumbra import native

    (folder / "job.toml").write_text(text)
    parsed = registry.parser().parse_args(["batch", str(folder / "job.toml"), *words])
    return job_of(native.load(), parsed)


def test_a_scenes_own_words_win_over_those_for_all(tmp_path: Path) -> None:
    made = job(tmp_path, JOB)
    first, second = made.shots
    assert made.out == tmp_path / "results"
    assert (first.name, first.scene, first.frames, first.cameras) == ("a", tmp_path / "a.blend", (1, 2, 3, 4), ())
    assert first.options.techniques == ("shadow_map", "pcf")
    assert first.options.settings == {"pcf": {"kernel": 5}}
    assert (first.warn_rmse, second.warn_rmse) == (0.2, 0.3)
    assert (second.name, second.frames, second.cameras) == ("second", (1, 5, 6), ("Left", "Right"))
    assert (second.options.techniques, second.options.settings, second.size) == (("shadow_map",), {}, (64, 36))
    assert second.options.reference_error == 0.01


def test_the_command_line_wins_over_the_job_file(tmp_path: Path) -> None:
    words = ["--frames", "9", "--out", "elsewhere", "--techniques", "pcf", "--set", "pcf.kernel=7", "--workers", "3"]
    made = job(tmp_path, JOB, *words)
    assert made.out == Path("elsewhere")
    assert made.workers == 3
    assert [shot.frames for shot in made.shots] == [(9,), (9,)]
    assert made.shots[0].options.settings == {"pcf": {"kernel": 7}}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("scenes = 3", "has no scenes; write [[scenes]]"),
        ("[[scenes]]\nframes = 1", "scene 1 of the job file"),
        ("fames = 1\n[[scenes]]\npath = 'a.blend'", 'unknown key of the job file "fames"; did you mean frames?'),
        ("[[scenes]]\npath = 'a.blend'\ncamera = 'x'", 'unknown key of scene 1 "camera"; did you mean cameras?'),
        ("workers = 0\n[[scenes]]\npath = 'a.blend'", '"workers" of the job file: give a whole number from 1'),
        ("frames = '4-1'\n[[scenes]]\npath = 'a.blend'", '"frames" of the job file: "4-1" in "4-1" holds no frame'),
        ("sweep = 'fll'\n[[scenes]]\npath = 'a.blend'", "give one of off, quick, full"),
        ("warn_rmse = true\n[[scenes]]\npath = 'a.blend'", "is not a number from 0 to 1"),
        ("[settings]\npcf = 3\n[[scenes]]\npath = 'a.blend'", "[settings.pcf]"),
        ("[settings.pcf]\nkernl = 3\n[[scenes]]\npath = 'a.blend'", "did you mean kernel?"),
        ("mode = 'render'\n[[scenes]]\npath = 'a.blend'", "--technique"),
        ("= 3", "is not TOML"),
    ],
)
def test_a_wrong_job_file_is_one_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, says: str
) -> None:
    (tmp_path / "job.toml").write_text(text)
    (tmp_path / "a.blend").write_text("no scene")
    assert cli.main(["batch", str(tmp_path / "job.toml"), "--out", str(tmp_path / "out")]) == 2
    told = capsys.readouterr()
    (line,) = told.err.splitlines()
    assert says in line and told.out == ""
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["a.blend"], "say with --out"),
        (["a.blend", "job.toml", "--out", "out"], "give one job file, or scenes"),
        (["missing.blend", "--out", "out"], "does not exist"),
        (["a.blend", "--out", "out", "--render"], "--technique"),
        (["a.blend", "--out", "out", "--technique", "pcf"], "for --render"),
        (["a.blend", "--out", "out", "--render", "--technique", "pcf", "--warn-rmse", "0.1"], "measures no errors"),
        (["a.blend", "--out", "out", "--frames", "x"], "is not a range of frames"),
        (["a.blend", "--out", "out", "--workers", "0"], "whole number from 1"),
        (["a.blend", "--out", "out", "--overwrite", "--keep-existing"], "not allowed with"),
        (["a.blend", "--out", "out", "--openjd", "job.txt"], ".json or .yaml"),
        (["a.blend", "b.blend", "--out", "out", "--name", "x"], "single scene"),
    ],
)
def test_wrong_usage_is_one_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], says: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.blend", "b.blend", "job.toml"):
        Path(name).write_text("no scene")
    assert cli.main(["batch", *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert not Path("out").exists()


def test_the_workers_own_command_is_not_offered(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--help"]) == 0
    assert cli.main(["batsh"]) == 2
    told = capsys.readouterr()
    assert "batch" in told.out
    assert "batch-worker" not in told.out + told.err


# --- what is done already --------------------------------------------------------------------------------------------


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "out")


def finished(store: Store, made: Item, *others: Path, **more: Any) -> None:
    """A result of `made` as a worker leaves it."""
    facts = Facts()
    with store.workplace() as place:
        result = place / "result"
        result.mkdir()
        (result / "report.html").write_text("whole")
        files = [facts.of(path) for path in (Path(made.scene), *others)]
        store.commit(made, result, {"made_from": made_from(made, files), "failures": [], **more})


@pytest.fixture
def scene(tmp_path: Path) -> Item:
    path = tmp_path / "wall.blend"
    path.write_text("a scene")
    return item(scene=str(path))


def test_a_result_is_kept_while_nothing_has_changed(store: Store, scene: Item) -> None:
    assert store.state(scene).why_not == "new"
    finished(store, scene)
    assert store.state(scene).done
    assert Store(store.out).state(scene).done
    # Limits are looked at when all is done, and change no result.
    assert store.state(jobs.dataclasses.replace(scene, warn_rmse=0.1, fail_rmse=0.2)).done
    assert store.state(jobs.dataclasses.replace(scene, options=Options(use_cache=False))).done


def test_a_scene_that_was_only_touched_is_the_same_and_one_that_was_changed_is_not(store: Store, scene: Item) -> None:
    finished(store, scene)
    path = Path(scene.scene)
    os.utime(path, ns=(1, 1))
    assert Store(store.out).state(scene).done
    path.write_text("b scene")
    assert Store(store.out).state(scene).why_not == "the scene has changed"


def test_a_changed_library_makes_its_scenes_anew(store: Store, scene: Item, tmp_path: Path) -> None:
    library = tmp_path / "hero.blend"
    library.write_text("a hero")
    finished(store, scene, library)
    assert Store(store.out).state(scene).done
    library.write_text("another")
    assert Store(store.out).state(scene).why_not == "hero.blend has changed"
    library.unlink()
    assert not Store(store.out).state(scene).done


def test_other_options_another_core_and_a_failure_make_an_item_anew(store: Store, scene: Item) -> None:
    finished(store, scene)
    for changed in (
        jobs.dataclasses.replace(scene, size=(65, 36)),
        jobs.dataclasses.replace(scene, device="other"),
        jobs.dataclasses.replace(scene, view_by="rays"),
        jobs.dataclasses.replace(scene, options=Options(settings={"pcf": {"kernel": 5}})),
        jobs.dataclasses.replace(scene, options=Options(reference_error=0.1)),
    ):
        assert store.state(changed).why_not == "other options"
    path = store.result(scene) / "item.json"
    document = json.loads(path.read_text())
    document["made_from"]["core"] = "0.0.1 abc"
    path.write_text(json.dumps(document))
    assert store.state(scene).why_not == "another build of Penumbra"
    finished(store, scene, failures=[{"what": "pcf", "reason": "out of memory"}])
    assert store.state(scene).why_not == "something failed the last time"
    path.write_text("{")
    assert store.state(scene).why_not == "new"


def test_a_result_replaces_the_one_before_as_a_whole(store: Store, scene: Item) -> None:
    finished(store, scene)
    (store.result(scene) / "old.exr").write_text("of the old result")
    finished(store, scene)
    assert sorted(path.name for path in store.result(scene).iterdir()) == ["item.json", "report.html"]
    store.close()
    assert not (store.out / ".penumbra").exists()


def test_a_picture_never_stands_beside_the_stamp_of_another(store: Store, scene: Item, tmp_path: Path) -> None:
    picture = jobs.dataclasses.replace(scene, mode="render", technique="pcf", format="png")
    assert store.result(picture) == store.out / "wall" / "left" / "wall_0003.png"
    made = tmp_path / "made.png"
    made.write_text("one")
    store.commit(picture, made, {"made_from": made_from(picture, [Facts().of(Path(picture.scene))])})
    assert store.state(picture).done
    other = jobs.dataclasses.replace(picture, technique="shadow_map")
    assert store.state(other).why_not == "other options"
    # Killed between the picture and its stamp:
    made.write_text("two")
    os.replace(made, store.result(picture))
    store._document_path(picture).unlink()
    assert store.state(picture).why_not == "new"


def test_what_a_killed_process_left_is_removed_and_what_a_living_one_makes_is_not(store: Store) -> None:
    program = """if True:
        import sys
        from pathlib import Path
        from penumbra.batch.store import Store
        with Store(Path(sys.argv[1])).workplace() as place:
            (place / "half.exr").touch()
            print(place, flush=True)
            sys.stdin.read()
    """
    process = subprocess.Popen(
        [sys.executable, "-c", program, str(store.out)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    assert process.stdout is not None and process.stdin is not None
    place = Path(process.stdout.readline().strip())
    with store.workplace() as own:
        store.tidy()
        assert place.is_dir() and own.is_dir()
        process.send_signal(signal.SIGKILL)
        process.wait()
        store.tidy()
        assert not place.exists() and own.is_dir()
    process.stdout.close()
    process.stdin.close()
