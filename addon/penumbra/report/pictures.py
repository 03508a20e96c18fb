"""The images of a report: files beside it, and the few that are embedded in the page."""

from __future__ import annotations

import base64
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .. import images
from ..environment import usable_cores
from ..files import unique_slug, write_bytes
from ..records import Image, LightResult, Mask, Record, SceneResult


def write(folder: Path, scene_slug: str, scene: SceneResult) -> None:
    """All image files of a scene under folder/images/<scene>/<light>/; notes their relative paths in the records."""
    tasks: list[Callable[[], None]] = []
    taken: list[str] = []
    for light in scene.lights:
        if light.reference is None:
            continue
        taken.append(unique_slug(light.name, taken))
        relative = Path("images") / scene_slug / taken[-1]
        (folder / relative).mkdir(parents=True, exist_ok=True)
        tasks += _light_tasks(folder, relative, scene, light)
    # Compression lets other threads run, so that two cores take half the time.
    with ThreadPoolExecutor(max(1, min(4, usable_cores()))) as pool:
        for done in [pool.submit(task) for task in tasks]:
            done.result()


def _light_tasks(folder: Path, relative: Path, scene: SceneResult, light: LightResult) -> list[Callable[[], None]]:
    reference = light.reference
    assert reference is not None
    mask = reference.mask.astype(np.float32)
    white = images.white_level(light.irradiance) if light.irradiance is not None else 1.0

    def reference_exr(name: str, values: Image, error: Image) -> None:
        channels = {"visibility": values, "mask": mask, "standard_error": error}
        images.write_exr(folder / relative / f"reference_{name}.exr", channels, {"penumbraLight": light.name})

    def visibility_exr(record: Record, values: Image) -> None:
        attributes = {"penumbraLight": light.name, "penumbraTechnique": record.technique}
        path = folder / relative / f"{record.technique}_visibility.exr"
        images.write_exr(path, {"visibility": values, "mask": mask}, attributes)

    def error_png(record: Record, values: Image) -> None:
        picture = images.false_colour(values - reference.area, reference.mask)
        picture = images.with_legend(picture, f"{record.title}: |V - reference|")
        write_bytes(folder / relative / f"{record.technique}_error.png", images.png(picture))

    def shaded_png(name: str, values: Image) -> None:
        assert light.irradiance is not None and scene.albedo is not None
        picture = images.shade(light.irradiance, values, scene.albedo, white)
        write_bytes(folder / relative / f"{name}_shaded.png", images.png(images.srgb_bytes(picture)))

    tasks: list[Callable[[], None]] = [
        lambda: reference_exr("area", reference.area, reference.standard_error),
        lambda: reference_exr("irradiance", reference.irradiance, reference.irradiance_standard_error),
    ]
    light.reference_info["images"] = {
        "area": (relative / "reference_area.exr").as_posix(),
        "irradiance": (relative / "reference_irradiance.exr").as_posix(),
    }
    shaded = light.irradiance is not None and scene.albedo is not None
    if shaded:
        tasks.append(lambda: shaded_png("reference", reference.irradiance))
        light.reference_info["images"]["shaded"] = (relative / "reference_shaded.png").as_posix()
    for record in light.records:
        if record.visibility is None:
            continue
        values = record.visibility
        tasks.append(lambda record=record, values=values: visibility_exr(record, values))  # type: ignore[misc]
        tasks.append(lambda record=record, values=values: error_png(record, values))  # type: ignore[misc]
        record.images = {
            "visibility": (relative / f"{record.technique}_visibility.exr").as_posix(),
            "error": (relative / f"{record.technique}_error.png").as_posix(),
        }
        if shaded:
            tasks.append(lambda record=record, values=values: shaded_png(record.technique, values))  # type: ignore[misc]
            record.images["shaded"] = (relative / f"{record.technique}_shaded.png").as_posix()
    return tasks


@dataclass(slots=True)
class EmbeddedLight:
    """The pixels of one light in the page. Everything else it shows is computed from these by its script."""

    base: str = ""  # unshadowed picture, sRGB of linear / base_scale
    base_scale: float = 1.0
    ambient: float = images.AMBIENT_SHARE
    area: str = ""  # 16-bit V in red (high byte) and green (low byte), mask in blue
    irradiance: str = ""
    records: dict[int, str] = field(default_factory=dict)  # index of the record: 16-bit V


@dataclass(slots=True)
class EmbeddedScene:
    albedo: str = ""
    lights: list[EmbeddedLight] = field(default_factory=list)


def embed(scene: SceneResult) -> EmbeddedScene:
    """What the page needs to show this scene."""
    result = EmbeddedScene(lights=[EmbeddedLight() for _ in scene.lights])
    tasks: list[tuple[Callable[[str], None], Callable[[], str]]] = []
    if scene.albedo is not None:
        albedo = scene.albedo
        tasks.append((lambda uri: setattr(result, "albedo", uri), lambda: _uri(images.srgb_bytes(albedo))))
    for light, shown in zip(scene.lights, result.lights, strict=True):
        tasks += _embed_tasks(scene, light, shown)
    with ThreadPoolExecutor(max(1, min(4, usable_cores()))) as pool:
        for keep, uri in [(keep, pool.submit(make)) for keep, make in tasks]:
            keep(uri.result())
    return result


def _embed_tasks(
    scene: SceneResult, light: LightResult, shown: EmbeddedLight
) -> list[tuple[Callable[[str], None], Callable[[], str]]]:
    reference = light.reference
    if reference is None or light.irradiance is None or scene.albedo is None:
        return []
    base = light.irradiance * scene.albedo / images.white_level(light.irradiance)
    # Bright spots lie above white; without this scale a half lit one would come out grey instead of white.
    shown.base_scale = float(min(max(base.max(initial=1.0), 1.0), 8.0))
    tasks: list[tuple[Callable[[str], None], Callable[[], str]]] = [
        (lambda uri: setattr(shown, "base", uri), lambda: _uri(images.srgb_bytes(base / shown.base_scale))),
        (lambda uri: setattr(shown, "area", uri), lambda: _uri(sixteen_bits(reference.area, reference.mask))),
        (
            lambda uri: setattr(shown, "irradiance", uri),
            lambda: _uri(sixteen_bits(reference.irradiance, reference.mask)),
        ),
    ]
    for i, record in enumerate(light.records):
        if record.visibility is not None:
            values = record.visibility
            tasks.append(
                (
                    lambda uri, i=i: shown.records.__setitem__(i, uri),  # type: ignore[misc]
                    lambda values=values: _uri(sixteen_bits(values, reference.mask)),  # type: ignore[misc]
                )
            )
    return tasks


def sixteen_bits(visibility: Image, mask: Mask) -> images.Bytes:
    """V as 16 bits in the red (high) and green (low) byte of an RGB picture, the mask in blue."""
    code = np.rint(np.clip(visibility, 0.0, 1.0) * 65535).astype(np.uint16)
    picture = np.empty((*code.shape, 3), np.uint8)
    picture[..., 0] = code >> 8
    picture[..., 1] = code & 255
    picture[..., 2] = np.where(mask != 0, 255, 0)
    return picture


def _uri(pixels: images.Bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(images.png(pixels)).decode()


def drop_pixels(scene: SceneResult) -> None:
    """Lets go of every array of a scene; its numbers stay."""
    scene.albedo = scene.hit = None
    for light in scene.lights:
        light.reference = light.irradiance = None
        for record in light.records:
            record.visibility = None
