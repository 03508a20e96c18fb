from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import OpenEXR
import PIL.Image
import pytest
from penumbra import images


def test_the_bottom_row_of_an_array_is_the_last_row_of_an_exr(tmp_path: Path) -> None:
    values = np.arange(12, dtype=np.float32).reshape(3, 4) / 7
    mask = np.eye(3, 4, dtype=np.float32)
    images.write_exr(tmp_path / "v.exr", {"visibility": values, "mask": mask})
    channels = OpenEXR.File(str(tmp_path / "v.exr"), separate_channels=True).channels()
    assert sorted(channels) == ["mask", "visibility"]
    assert channels["visibility"].pixels.dtype == np.float32
    assert np.array_equal(channels["visibility"].pixels, values[::-1])
    assert np.array_equal(channels["mask"].pixels, mask[::-1])


def test_values_outside_zero_to_one_and_tiny_ones_survive_an_exr(tmp_path: Path) -> None:
    values = np.array([[-3.5, 1e-30, 65505.0, 1e10]], np.float32)
    images.write_exr(tmp_path / "v.exr", {"depth.Z": values})
    assert np.array_equal(OpenEXR.File(str(tmp_path / "v.exr")).channels()["depth.Z"].pixels, values)


def test_the_bottom_row_of_an_array_is_the_last_row_of_a_png() -> None:
    pixels = np.zeros((5, 7, 3), np.uint8)
    pixels[0, 2] = (255, 10, 20)
    shown = np.asarray(PIL.Image.open(io.BytesIO(images.png(pixels))))
    assert tuple(shown[4, 2]) == (255, 10, 20)
    assert shown.sum() == 285


@pytest.mark.parametrize(("linear", "code"), [(0.0, 0), (1.0, 255), (0.5, 188), (0.18, 118), (2.0, 255), (-1.0, 0)])
def test_srgb_has_its_known_values(linear: float, code: int) -> None:
    assert images.srgb_bytes(np.full((1, 1), linear, np.float32))[0, 0] == code


def test_the_srgb_table_agrees_with_the_curve_to_one_code() -> None:
    linear = np.linspace(0, 1, 50001, dtype=np.float32)[None]
    exact = np.rint(images.srgb_from_linear(linear) * 255).astype(int)
    assert np.abs(images.srgb_bytes(linear).astype(int) - exact).max() <= 1


def test_full_light_on_a_white_surface_is_white_and_full_shadow_is_the_ambient_share() -> None:
    irradiance = np.full((2, 2, 3), 7.0, np.float32)
    visibility = np.array([[1, 0], [0.5, 1]], np.float32)
    shown = images.shade(irradiance, visibility, np.ones((2, 2, 3), np.float32), 7.0)
    a = images.AMBIENT_SHARE
    assert shown[..., 0] == pytest.approx(np.array([[1 + a, a], [0.5 + a, 1 + a]]), abs=1e-6)


def test_a_view_without_light_has_a_white_level() -> None:
    assert images.white_level(np.zeros((2, 2, 3), np.float32)) == 1.0


def test_false_colours_grow_brighter_with_the_error_and_the_mask_is_grey() -> None:
    error = np.array([[0.0, 0.1, -0.3, 0.5, 9.0, 0.2]], np.float32)
    shown = images.false_colour(error, np.array([[1, 1, 1, 1, 1, 0]], np.uint8)).astype(int)
    brightness = shown.sum(axis=-1)[0]
    assert brightness[0] < brightness[1] < brightness[2] < brightness[3] == brightness[4]
    assert tuple(shown[0, 5]) == (64, 64, 64)


@pytest.mark.parametrize("width", [40, 320, 1280])
def test_the_legend_is_below_the_picture_and_leaves_it_as_it_was(width: int) -> None:
    picture = np.random.default_rng(1).integers(0, 255, (30, width, 3)).astype(np.uint8)
    sheet = images.with_legend(picture, "title")
    legend_rows = sheet.shape[0] - 30
    assert legend_rows > 20
    assert np.array_equal(sheet[legend_rows:, :width], picture)
    assert len(np.unique(sheet[:legend_rows].reshape(-1, 3), axis=0)) > 20


# --- FLIP: the calibration of a 256 px ramp ---------------------------------------------------------------------------

RAMP = (np.arange(256) + 0.5) / 256
ANSWERS = {
    "hard shadow": ((RAMP > 0.5) * 1.0, 0.457),
    "outer half only": (np.clip(2 * RAMP - 1, 0, 1), 0.489),
    "full width, shifted out by half": (np.clip(RAMP - 0.5, 0, 1), 0.597),
    "centred, half as wide": (np.clip(2 * RAMP - 0.5, 0, 1), 0.289),
    "smoothstep": (RAMP**2 * (3 - 2 * RAMP), 0.168),
    "width + 20 %": (np.clip((RAMP - 0.5) / 1.2 + 0.5, 0, 1), 0.120),
    "constant + 1/255": (RAMP + 1 / 255, 0.0215),
}


def picture(row: np.ndarray, height: int = 256) -> np.ndarray:
    return np.repeat(row[None], height, axis=0).astype(np.float32)


@pytest.mark.parametrize("name", list(ANSWERS))
def test_flip_of_known_wrong_penumbrae(name: str) -> None:
    row, expected = ANSWERS[name]
    found = images.flip_mean(picture(row), picture(RAMP), np.ones((256, 256), np.uint8))
    assert found == pytest.approx(expected, abs=1.5e-3)


def test_flip_of_equal_images_is_zero() -> None:
    assert images.flip_mean(picture(RAMP, 64), picture(RAMP, 64), np.ones((64, 256), np.uint8)) == 0.0


def test_flip_of_an_empty_mask_is_zero() -> None:
    assert images.flip_mean(picture(RAMP, 8), picture(1 - RAMP, 8), np.zeros((8, 256), np.uint8)) == 0.0


def test_flip_does_not_see_what_is_outside_the_mask() -> None:
    mask = np.zeros((120, 256), np.uint8)
    mask[40:80, 60:180] = 1
    a, b, c = picture(RAMP, 120), picture(RAMP**2, 120), picture(RAMP, 120)
    c[mask == 0] = 0.123
    assert images.flip_mean(b, a, mask) == images.flip_mean(b, c, mask)


def test_cutting_flip_to_the_masks_window_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    import flip_evaluator

    mask = np.zeros((140, 256), np.uint8)
    mask[50:90, 100:150] = 1
    shapes = []
    evaluate = flip_evaluator.evaluate

    def spy(reference: np.ndarray, *arguments: object, **more: object) -> object:
        shapes.append(reference.shape)
        return evaluate(reference, *arguments, **more)

    monkeypatch.setattr(flip_evaluator, "evaluate", spy)
    cut = images.flip_mean(picture(RAMP**2, 140), picture(RAMP, 140), mask)
    mask_shown = [np.where(mask, images.display_grey(picture(row, 140)), 0.5) for row in (RAMP, RAMP**2)]
    whole, _, _ = evaluate(
        *[np.repeat(image[..., None], 3, axis=2).astype(np.float32) for image in mask_shown],
        "LDR",
        applyMagma=False,
        computeMeanError=False,
    )
    assert shapes[0][0] < 140
    assert cut == pytest.approx(float(whole.reshape(140, 256)[mask != 0].mean()), abs=1e-6)
