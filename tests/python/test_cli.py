"""Bad usage and bad input: exit code 2, one sentence on standard error, nothing written."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from penumbra import __version__, cli

Run = Callable[..., "subprocess.CompletedProcess[str]"]


def refused(capsys: pytest.CaptureFixture[str], folder: Path, *arguments: object) -> str:
    """The sentence that a command line is refused with."""
    before = sorted(folder.rglob("*"))
    assert cli.main([str(argument) for argument in arguments]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    (line,) = told.err.splitlines()
    assert line.startswith("penumbra: ")
    assert "Traceback" not in line
    assert sorted(folder.rglob("*")) == before
    return line.removeprefix("penumbra: ")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """Exists, but is no .blend file."""
    path = tmp_path / "scene.blend"
    path.write_text("not a blend file")
    return path


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "COMMAND"),
        (["compar"], 'unknown command "compar"; did you mean compare?'),
        (["compare"], "SCENE"),
        (["compare", "{scene}"], "--out"),
        (["compare", "missing.blend", "--out", "{out}"], 'the scene "missing.blend" does not exist'),
        (["compare", "{scene}", "--out", "{out}", "--siez", "4x4"], 'unknown option "--siez", did you mean --size?'),
        (["compare", "{scene}", "--out", "{out}", "--size", "640"], '"640" is not a size such as 640x360'),
        (["compare", "{scene}", "--out", "{out}", "--size", "0x5"], "each side from 1 to 16384"),
        (
            ["compare", "{scene}", "--out", "{out}", "--sweep", "fll"],
            "did you mean full? choose from: off, quick, full",
        ),
        (["compare", "{scene}", "--out", "{out}", "--view-by", "ray"], "did you mean rays? choose from: raster, rays"),
        (["compare", "{scene}", "--out", "{out}", "--reference-error", "0"], "not a number from 1e-05 to 0.5"),
        (["compare", "{scene}", "--out", "{out}", "--target-rmse", "nan"], "not a number from 0 to 1"),
        (["compare", "{scene}", "--out", "{out}", "--frame", "one"], "not a frame number"),
        (["compare", "{scene}", "--out", "{out}", "--lights", ","], 'give "all" or names'),
        (["compare", "{scene}", "--out", "/proc/penumbra"], 'cannot write to the folder "/proc/penumbra"'),
        (["compare", "{scene}", "--out", "{scene}"], "is a file, not a folder"),
        (["render", "{scene}", "--technique", "pcf", "--out", "a.jpg"], ".exr or .png"),
        (["render", "{scene}", "--out", "a.png"], "--technique"),
    ],
)
def test_wrong_usage_is_one_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene: Path, arguments: list[str], says: str
) -> None:
    filled = [text.format(scene=scene, out=tmp_path / "out") for text in arguments]
    assert says in refused(capsys, tmp_path, *filled)


@pytest.mark.usefixtures("core")
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--techniques", "pfc"], 'unknown technique "pfc"; did you mean pcf? choose from: shadow_map'),
        (["--set", "pcf.kernl=3"], 'unknown setting of pcf "kernl"; did you mean kernel?'),
        (["--set", "pcf.kernel=1000"], "pcf.kernel is a whole number from"),
        (["--set", "kernel=3"], "technique.key=value"),
        (["--techniques", "shadow_map", "--set", "pcf.kernel=3"], "add pcf to --techniques"),
    ],
)
def test_wrong_techniques_and_settings_are_one_sentence_with_the_choices(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene: Path, arguments: list[str], says: str
) -> None:
    assert says in refused(capsys, tmp_path, "compare", scene, "--out", tmp_path / "out", *arguments)


@pytest.mark.usefixtures("core")
@pytest.mark.parametrize(
    "arguments",
    [
        ["compare", "{scene}", "--out", "{out}"],
        ["render", "{scene}", "--technique", "pcf", "--out", "{out}/a.png"],
        ["debug", "{scene}", "--technique", "pcf", "--out", "{out}"],
        ["bake", "{scene}", "--technique", "pcf", "--out", "{out}"],
        ["batch", "{scene}", "--out", "{out}"],
        ["stability", "--out", "{out}"],
    ],
)
def test_a_wrong_view_in_the_environment_is_one_sentence(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    scene: Path,
    arguments: list[str],
) -> None:
    monkeypatch.setenv("PENUMBRA_VIEW_BY", "ray")
    filled = [text.format(scene=scene, out=tmp_path / "out") for text in arguments]
    sentence = 'unknown PENUMBRA_VIEW_BY "ray"; did you mean rays? choose from: raster, rays'
    assert refused(capsys, tmp_path, *filled) == sentence


@pytest.mark.usefixtures("working_machine")
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--device", "no such card"], "no such card"),
        (["--lights", "Kye"], 'unknown light "Kye"; did you mean Key?'),
        (["--camera", "Nobody"], "Nobody"),
    ],
)
def test_wrong_devices_lights_and_cameras_are_one_sentence(
    penumbra: Run, tmp_path: Path, wall_blend: Path, arguments: list[str], says: str
) -> None:
    assert says in refused_process(penumbra, tmp_path, wall_blend, arguments)


@pytest.mark.usefixtures("working_machine")
@pytest.mark.parametrize("content", ["", "not a blend file", "BLENDER-v405"])
def test_a_file_that_blender_cannot_open_is_one_sentence(penumbra: Run, tmp_path: Path, content: str) -> None:
    path = tmp_path / "broken.blend"
    path.write_text(content)
    assert "broken.blend" in refused_process(penumbra, tmp_path, path, [])


def refused_process(penumbra: Run, folder: Path, scene: Path, arguments: list[str]) -> str:
    """Like refused(), in a process of its own: Blender prints past Python's streams."""
    result = penumbra("compare", scene, "--out", folder / "out", *arguments)
    assert result.returncode == 2
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert not (folder / "out").exists()
    return line


def test_without_the_compiled_core_the_sentence_says_how_to_get_it(penumbra: Run, tmp_path: Path, scene: Path) -> None:
    # A module of that name that cannot be loaded stands in the way of the real one.
    (tmp_path / "block" / "penumbra_core").mkdir(parents=True)
    (tmp_path / "block" / "penumbra_core" / "__init__.py").write_text("raise ImportError('libsomething.so is missing')")
    path = os.pathsep.join([str(tmp_path / "block"), *sys.path])
    result = penumbra("compare", scene, "--out", tmp_path / "out", PYTHONPATH=path)
    assert result.returncode == 2
    (line,) = result.stderr.splitlines()
    assert "libsomething.so is missing" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("core")
def test_without_blender_the_sentence_says_how_to_get_it(penumbra: Run, tmp_path: Path, scene: Path) -> None:
    (tmp_path / "block" / "bpy").mkdir(parents=True)
    (tmp_path / "block" / "bpy" / "__init__.py").write_text("raise ModuleNotFoundError('no bpy here', name='bpy')")
    path = os.pathsep.join([str(tmp_path / "block"), *sys.path])
    result = penumbra("compare", scene, "--out", tmp_path / "out", PYTHONPATH=path)
    assert result.returncode == 2
    (line,) = result.stderr.splitlines()
    assert "pip install" in line
    assert not (tmp_path / "out").exists()
    doctor = penumbra("doctor", PYTHONPATH=path)
    assert doctor.returncode == 1
    assert "Not ready" in doctor.stdout


def test_an_unexpected_error_is_one_line_without_a_traceback(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from penumbra import native

    def fail() -> None:
        raise ZeroDivisionError("something of ours\nwith more lines")

    monkeypatch.setattr(native, "load", fail)
    assert cli.main(["techniques"]) == 1
    told = capsys.readouterr()
    (line,) = told.err.splitlines()
    assert "something of ours" in line
    assert "PENUMBRA_TRACEBACK=1" in line
    monkeypatch.setenv("PENUMBRA_TRACEBACK", "1")
    assert cli.main(["techniques"]) == 1
    assert "Traceback" in capsys.readouterr().err


def test_the_version_is_the_packages(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"penumbra {__version__}\n"


@pytest.mark.parametrize("command", ["compare", "compare-reports", "demo", "render", "techniques", "doctor"])
def test_every_command_explains_itself(capsys: pytest.CaptureFixture[str], command: str) -> None:
    assert cli.main([command, "--help"]) == 0
    assert command in capsys.readouterr().out


@pytest.mark.usefixtures("core")
def test_techniques_lists_every_technique_with_its_settings(capsys: pytest.CaptureFixture[str], core: object) -> None:
    assert cli.main(["techniques", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [info["id"] for info in listed] == [info["id"] for info in core.techniques()]  # type: ignore[attr-defined]
    assert cli.main(["techniques"]) == 0
    text = capsys.readouterr().out
    assert all(f"{info['id']}.{setting['id']}=" in text for info in listed for setting in info["settings"])
    assert cli.main(["techniques", "--rules"]) == 0
    text = capsys.readouterr().out
    assert cli.main(["techniques", "--rules", "--json"]) == 0
    rules = json.loads(capsys.readouterr().out)
    assert rules == core.rules()  # type: ignore[attr-defined]
    assert len(text.split("\n\n")) == len(rules)
    for rule in rules:
        assert f"{rule['id']}: " in text and rule["stage"] in text
        assert rule["techniques"] or rule["stage"] == "reference"


def test_a_closed_pipe_is_no_error(environment: dict[str, str]) -> None:
    pytest.importorskip("penumbra_core")
    process = subprocess.Popen(
        [sys.executable, "-m", "penumbra", "techniques", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait() == 0
