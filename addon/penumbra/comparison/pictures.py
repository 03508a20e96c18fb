"""The pictures of a comparison: whole ones in the user's cache, thumbnails small enough for the .blend file."""

from __future__ import annotations

import base64
import binascii
import contextlib
import hashlib
import io
import os
import zipfile
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import cache, colours, images
from ..records import Image, Mask, ReferenceResult, SceneResult

THUMBNAIL_PX = 112  # the longer edge
SUFFIX = ".comparison.npz"
_PLANES = ("area", "irradiance", "standard_error", "irradiance_standard_error", "mask")
_GREY = 64  # outside the mask, as in the report's pictures


def keep(scene: SceneResult) -> str:
    """Writes all pixels of a scene's results to the cache. @returns their key, "" if the cache does not take them"""
    arrays: dict[str, Any] = {}
    if scene.albedo is not None and scene.hit is not None:
        arrays |= {"albedo": scene.albedo, "hit": scene.hit}
    for i, light in enumerate(scene.lights):
        if light.irradiance is not None:
            arrays[f"{i}.light"] = light.irradiance
        if light.reference is not None:
            arrays |= {f"{i}.{name}": getattr(light.reference, name) for name in _PLANES}
        for j, record in enumerate(light.records):
            if record.visibility is not None:
                arrays[f"{i}.{j}"] = record.visibility
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    data = buffer.getvalue()
    key = hashlib.sha256(data).hexdigest()
    return key if cache.ReferenceCache.of_user().keep(f"{key}{SUFFIX}", data) else ""


def exist(key: str) -> bool:
    return bool(key) and (cache.folder() / f"{key}{SUFFIX}").is_file()


@dataclass(frozen=True)
class Pictures:
    """Of one comparison, read from the cache."""

    arrays: dict[str, Any]

    def visibility(self, light: int, record: int) -> Image | None:
        return self.arrays.get(f"{light}.{record}")

    def reference(self, light: int) -> tuple[Image, Mask] | None:
        """V and the mask."""
        area = self.arrays.get(f"{light}.area")
        return None if area is None else (area, self.arrays[f"{light}.mask"])

    def shaded(self, light: int, visibility: Image) -> Image | None:
        """Linear, 1 is white, as in the report."""
        arriving, albedo = self.arrays.get(f"{light}.light"), self.arrays.get("albedo")
        if arriving is None or albedo is None:
            return None
        return images.shade(arriving, visibility, albedo, images.white_level(arriving))

    def put_into(self, scene: SceneResult) -> None:
        """Gives the scene's records, read from the .blend, their pixels back: for the report."""
        scene.albedo, scene.hit = self.arrays.get("albedo"), self.arrays.get("hit")
        for i, light in enumerate(scene.lights):
            light.irradiance = self.arrays.get(f"{i}.light")
            if f"{i}.area" in self.arrays:
                info = light.reference_info
                light.reference = ReferenceResult(
                    **{name: self.arrays[f"{i}.{name}"] for name in _PLANES},
                    method=str(info.get("method", "")),
                    rays=int(info.get("rays", 0)),
                    mean_rays_per_pixel=float(info.get("samples", 0.0)),
                    standard_error_asked=float(info.get("standard_error_asked", 0.0)),
                    time_ms=float(info.get("time_ms", 0.0)),
                    reached=bool(info.get("reached", True)),
                    pixels_skipped=int(info.get("pixels_skipped", 0)),
                )
            for j, record in enumerate(light.records):
                record.visibility = self.arrays.get(f"{i}.{j}")


def load(key: str) -> Pictures | None:
    """None if they are not in the cache of this machine, or damaged."""
    if not exist(key):
        return None
    path = cache.folder() / f"{key}{SUFFIX}"
    try:
        data = path.read_bytes()
        if hashlib.sha256(data).hexdigest() != key:
            return None
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            found = Pictures({name: file[name] for name in file.files})
    except (OSError, ValueError, zipfile.BadZipFile):
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # used just now
    return found


# --- thumbnails ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Thumbnail:
    """8 bits per pixel: V, |error| up to the end of the error's legend, and the mask. Row 0 is the bottom row."""

    visibility: images.Bytes
    error: images.Bytes
    mask: images.Bytes

    def rgb(self, *, error: bool) -> images.Bytes:
        """(h, w, 3)"""
        if error:
            picture: images.Bytes = colours.table("inferno")[self.error]
        else:
            picture = np.repeat(self.visibility[..., None], 3, axis=2)
        picture[self.mask == 0] = _GREY
        return picture


def thumbnails(scene: SceneResult) -> list[list[bytes]]:
    """By light: of the reference, then of each record; empty where there is no picture."""
    made = []
    for light in scene.lights:
        reference = light.reference
        if reference is None:
            made.append([b""] * (1 + len(light.records)))
            continue
        row = [_small(reference.area, reference.area, reference.mask)]
        for record in light.records:
            seen = record.visibility
            row.append(b"" if seen is None else _small(seen, reference.area, reference.mask))
        made.append(row)
    return made


def _small(visibility: Image, reference: Image, mask: Mask) -> bytes:
    height, width = visibility.shape
    step = max(1, -(-max(height, width) // THUMBNAIL_PX))
    planes = (
        np.rint(np.clip(_shrunk(visibility, step), 0, 1) * 255),
        np.clip(_shrunk(np.abs(visibility - reference), step) * (255 / images.ERROR_SCALE), 0, 255),
        (_shrunk((mask != 0).astype(np.float32), step) >= 0.5) * 255,
    )
    rows, columns = planes[0].shape
    head = np.array([rows, columns], "<u2").tobytes()
    return base64.b64encode(zlib.compress(head + b"".join(plane.astype(np.uint8).tobytes() for plane in planes), 9))


def _shrunk(image: Image, step: int) -> Image:
    """Means over squares of `step` pixels; what does not fill one at the edges is cut."""
    rows, columns = (max(1, edge // step) for edge in image.shape)
    cut = image[: rows * step, : columns * step]
    if cut.shape != (rows * step, columns * step):
        return image  # thinner than a square
    small: Image = cut.reshape(rows, step, columns, step).mean(axis=(1, 3), dtype=np.float32)
    return small


def read_thumbnail(text: str) -> Thumbnail | None:
    """None for what is no thumbnail."""
    try:
        data = zlib.decompress(base64.b64decode(text))
        rows, columns = (int(edge) for edge in np.frombuffer(data[:4], "<u2"))
        planes = np.frombuffer(data, np.uint8, offset=4).reshape(3, rows, columns)
    except (ValueError, binascii.Error, zlib.error):
        return None
    return Thumbnail(planes[0], planes[1], planes[2])
