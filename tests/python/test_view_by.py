"""What finds the surface in each pixel, drawing or rays: how it is chosen, that the choice arrives, what it changes."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from checks import report_of
from must_run import skip
from penumbra import doctor, native
from penumbra.batch import jobs, openjd
from penumbra.batch.jobs import Item, expand
from penumbra.commands import registry
from penumbra.commands.batch import job_of
from penumbra.compare import Comparer, Options
from penumbra.errors import UserError
from penumbra.progress import Progress
from penumbra.records import SceneResult
from test_comparer import export

Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(autouse=True)
def _nothing_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PENUMBRA_VIEW_BY", raising=False)


@pytest.fixture(scope="module")
def renderers(core: Any) -> dict[str, Any]:
    try:
        return {view: native.renderer(core, "", view) for view in native.VIEWS}
    except core.DeviceError as error:
        skip(str(error))


def test_what_is_asked_for_goes_before_the_environment_and_that_before_drawing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert native.view_by() == "raster"
    monkeypatch.setenv("PENUMBRA_VIEW_BY", "rays")
    assert native.view_by() == "rays"
    assert native.view_by("raster") == "raster"
    monkeypatch.setenv("PENUMBRA_VIEW_BY", "")
    assert native.view_by() == "raster"


def test_an_unknown_word_is_refused_with_the_choices(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UserError, match=r'^unknown view "ray"; did you mean rays\? choose from: raster, rays$'):
        native.view_by("ray")
    monkeypatch.setenv("PENUMBRA_VIEW_BY", "Rays")
    with pytest.raises(UserError, match=r'^unknown PENUMBRA_VIEW_BY "Rays"; did you mean rays\? choose from: raster'):
        native.view_by()


def test_renderers_are_made_as_asked_for(renderers: dict[str, Any]) -> None:
    assert {view: renderer.environment["view_by"] for view, renderer in renderers.items()} == {
        "raster": "raster",
        "rays": "rays",
    }


def compared(core: Any, renderer: Any) -> SceneResult:
    options = Options(techniques=("pcf",), reference_error=0.05, timing_seconds=0.05)
    return Comparer(core, renderer, options, Progress(show=False)).compare(export(core), "scene.blend")


def test_rays_and_drawing_see_the_same_but_for_a_few_pixels_and_share_no_reference(
    core: Any, renderers: dict[str, Any]
) -> None:
    (drawn,) = compared(core, renderers["raster"]).lights
    (traced,) = compared(core, renderers["rays"]).lights
    (again,) = compared(core, renderers["rays"]).lights
    # A reference belongs to the pixels that it was traced for.
    assert [light.reference.from_cache for light in (drawn, traced, again)] == [False, False, True]
    assert np.count_nonzero(drawn.reference.mask) > 1000
    assert np.count_nonzero(drawn.reference.mask != traced.reference.mask) <= 8
    (a,), (b,) = (light.records for light in (drawn, traced))
    assert np.count_nonzero(np.abs(a.visibility - b.visibility) > 1e-3) <= 8


@pytest.mark.usefixtures("core")
def test_doctor_says_what_the_view_is_made_by(monkeypatch: pytest.MonkeyPatch) -> None:
    def view(asked: str = "") -> doctor.Check:
        (check,) = (check for check in doctor.examine("", asked) if check.name == "view")
        return check

    assert view().found == "drawn by OpenGL (raster)"
    assert view("rays").found == "traced by Embree (rays)"
    monkeypatch.setenv("PENUMBRA_VIEW_BY", "ray")
    wrong = view()
    assert not wrong.works
    assert wrong.found.startswith('unknown PENUMBRA_VIEW_BY "ray"')
    assert wrong.cure == "correct or unset PENUMBRA_VIEW_BY"


@pytest.mark.usefixtures("core")
def test_a_batch_hands_the_view_on_to_its_items_and_to_what_does_them_alone(core: Any, tmp_path: Path) -> None:
    job_file = tmp_path / "job.toml"
    job_file.write_text('out = "out"\nview_by = "rays"\n[[scenes]]\npath = "wall.blend"\n')

    def job(*more: str) -> jobs.Job:
        return job_of(core, registry.parser().parse_args(["batch", str(job_file), *more]))

    assert job("--view-by", "raster").view_by == "raster", "the command line wins"
    (item,) = expand(job())
    assert item.view_by == "rays"
    assert Item.from_json(json.loads(json.dumps(item.to_json()))) == item
    alone = registry.parser().parse_args([*item.arguments(), "--out", "x"])
    assert alone.view_by == "rays"
    assert "--view-by" not in " ".join(replace(item, view_by="").arguments())
    farm = tmp_path / "farm.json"
    openjd.write(job(), farm)
    assert "--view-by=rays" in farm.read_text()
    assert 'view_by = \\"rays\\"' in farm.read_text(), "the summary finds what the items made"


@pytest.mark.usefixtures("core")
def test_an_unknown_view_in_a_job_file_is_one_sentence(core: Any, tmp_path: Path) -> None:
    job_file = tmp_path / "job.toml"
    job_file.write_text('out = "out"\nview_by = "ray"\n[[scenes]]\npath = "wall.blend"\n')
    with pytest.raises(UserError, match='"view_by" of the job file: give one of raster, rays'):
        job_of(core, registry.parser().parse_args(["batch", str(job_file)]))


@pytest.mark.usefixtures("working_machine")
@pytest.mark.parametrize(("option", "said"), [(["--view-by", "rays"], "raster"), ([], "rays")])
def test_option_and_environment_reach_the_renderer_and_the_report_says_so(
    penumbra: Run, wall_blend: Path, tmp_path: Path, option: list[str], said: str
) -> None:
    result = penumbra(
        "compare", wall_blend, "--out", tmp_path / "out", "--techniques", "shadow_map", "--lights", "Key",
        "--reference-error", "0.05", "--timing-seconds", "0.05", *option, PENUMBRA_VIEW_BY=said,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert report_of(tmp_path / "out")["environment"]["view_by"] == "rays"
    assert "View traced by rays" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
