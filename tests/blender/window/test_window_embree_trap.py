"""Blender has an Embree of its own in the global scope; ours must answer all the same, and trace true shadows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

STANDARD_ERROR = 0.004  # asked for in embree_trap.py


@pytest.mark.parametrize(
    ("wheelhouse", "generation"),
    [
        pytest.param("wheelhouse", 3, id="embree 3 beside blender's embree 4"),
        pytest.param("wheelhouse/trixie", 4, id="embree 4 beside blender's embree 4"),
    ],
)
def test_our_own_embree_traces_inside_a_window_whose_blender_has_another(
    window: Callable[..., dict[str, Any]], extension: Callable[[str], Path], wheelhouse: str, generation: int
) -> None:
    answer = window("embree_trap.py", f"embree{generation}", extension(wheelhouse))

    # The trap is there: Blender's Embree is what everybody gets, our own plugin too if it is opened carelessly.
    assert answer["global_version"] // 10000 == 4
    assert answer["careless_version"] == answer["global_version"]
    # And is not walked into: the wheel's Embree, from the wheel's folder.
    assert answer["core"].startswith("/root/")
    assert answer["embree_version"].startswith(f"{generation}.")
    ours = [path for path in answer["libraries"] if path.startswith("/root/")]
    assert any(f"libembree{generation}" in path for path in ours), answer["libraries"]

    # The half plane's penumbra is a ramp with a closed form.
    assert answer["exact_max"] < 1e-6
    assert answer["traced_rmse"] <= STANDARD_ERROR
    assert abs(answer["traced_bias"]) <= 5 * STANDARD_ERROR / answer["pixels"] ** 0.5
    assert answer["mapped_wrong"] == 0

    # Blender still draws, with our OpenGL context beside its own: the pictures are there, lit right of the edge.
    screen = Image.open(answer["folder"] / "picture.png").convert("L")
    assert [screen.getpixel(tuple(at)) for at in answer["lit_px"]] == [255, 255]
    assert [screen.getpixel(tuple(at)) for at in answer["dark_px"]] == [0, 0]
