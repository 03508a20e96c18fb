"""A result as an image of Blender, in an image editor; and as small pictures in the panel."""

from __future__ import annotations

import contextlib
from typing import Any

import bpy
import bpy.utils.previews
import numpy as np

from .. import cache, images
from ..errors import UserError
from ..records import Image, Mask
from ..report import palette
from . import pictures, plot, results

DESCRIPTIONS = {
    "VISIBILITY": "Show the share of the light that each point sees",
    "REFERENCE": "Show the ray-traced truth",
    "ERROR": "Show the error in the report's false colours",
    "SHADED": "Show the scene lit by this light alone",
}
ITEMS = [(key, key.capitalize(), f"{text}") for key, text in DESCRIPTIONS.items()]
_SHOWN_FILES = 24  # kept on disk; the pictures themselves stay in the cache
MARK = "penumbra"  # custom property of our images
MISSING = "the pictures of this comparison are not in this machine's cache; compare again"

_loaded: tuple[str, pictures.Pictures] | None = None  # the last comparison that was shown


def pictures_of(kept: Any) -> pictures.Pictures:
    """@raises UserError where this machine has them no more"""
    global _loaded
    if _loaded is None or _loaded[0] != kept.key or not kept.key:
        found = results.pictures_of(kept)
        if found is None:
            raise UserError(MISSING)
        _loaded = (kept.key, found)
    return _loaded[1]


def forget() -> None:
    global _loaded
    _loaded = None
    _Previews.clear()


def pixels_of(kept: Any, row: Any, what: str) -> Image:
    """(h, w, 4) scene linear, row 0 at the bottom; alpha is the mask for V, 1 elsewhere. @raises UserError"""
    found = pictures_of(kept)
    known = found.reference(row.light_index)
    if known is None:
        raise UserError(f"there is no reference for {row.light}")
    reference, mask = known
    seen = found.visibility(row.light_index, row.record)
    if what == "REFERENCE":
        return _grey(reference, mask)
    if seen is None:
        raise UserError(f"there is no picture of {row.name}; steps of a sweep have none")
    if what == "VISIBILITY":
        return _grey(seen, mask)
    if what == "ERROR":
        return _opaque(linear_from_srgb(images.false_colour(seen - reference, mask)))
    shaded = found.shaded(row.light_index, seen)
    if shaded is None:
        raise UserError(f"there is no shaded picture of {row.name}")
    return _opaque(shaded)


def linear_from_srgb(codes: images.Bytes) -> Image:
    """8-bit sRGB as linear light."""
    x = codes.astype(np.float32) / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4).astype(np.float32)


def _grey(values: Image, mask: Mask) -> Image:
    made = np.empty((*values.shape, 4), np.float32)
    made[..., :3] = values[..., None]
    made[..., 3] = mask != 0
    return made


def _opaque(colour: Image) -> Image:
    made = np.ones((*colour.shape[:2], 4), np.float32)
    made[..., :3] = colour
    return made


def image_of(kept: Any, row: Any, what: str) -> Any:
    """Blender's float image of a result, one for each kind of picture. It is a file in the cache, not in the .blend.

    @raises UserError without the pixels
    """
    pixels = pixels_of(kept, row, what)
    height, width = pixels.shape[:2]
    name = f"Penumbra {what.capitalize()}"
    image = next((image for image in bpy.data.images if image.get(MARK) == what), None)
    if image is not None and (tuple(image.size) != (width, height) or image.packed_file is not None):
        if image.packed_file is not None:
            del image[MARK]  # a kept one is the artist's
        else:
            bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
        image.colorspace_settings.name = "Non-Color"  # values, not to be converted
        image.alpha_mode = "CHANNEL_PACKED"
        image[MARK] = what
    image["technique"], image["light"] = row.name, row.light
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    _save(image, f"{kept.key[:16]}-{row.light_index}-{row.record}-{what.lower()}.exr")
    return image


def _save(image: Any, name: str) -> None:
    """Gives the image a file, so that Blender does not ask about unsaved pictures at the end."""
    folder = cache.folder() / "shown"
    with contextlib.suppress(OSError, RuntimeError):  # without a file it lives until the .blend is closed
        folder.mkdir(parents=True, exist_ok=True)
        image.filepath_raw = str(folder / name)
        image.file_format = "OPEN_EXR"
        image.save()
        files = sorted(folder.glob("*.exr"), key=lambda file: file.stat().st_mtime)
        for old in files[:-_SHOWN_FILES]:
            old.unlink(missing_ok=True)


def pack_all() -> list[str]:
    """Our images that are not packed yet; returns their names."""
    names = []
    for image in bpy.data.images:
        if image.get(MARK) and image.packed_file is None:
            image.pack()
            image.use_fake_user = True
            names.append(image.name)
    return names


def put_up(context: Any, image: Any) -> bool:
    """Shows the image in an image editor: one that is open, else in a window of its own. False without windows."""
    if context.window is None or bpy.app.background:
        return False
    editor = _editor(context)
    if editor is None:
        bpy.ops.wm.window_new()
        editor = context.window_manager.windows[-1].screen.areas[0]
        editor.type = "IMAGE_EDITOR"
    space = editor.spaces.active
    space.image = image
    space.use_image_pin = True
    editor.tag_redraw()
    return True


def _editor(context: Any) -> Any | None:
    """In this window, else in another one; one that shows our picture before all others."""
    windows = [context.window, *(w for w in context.window_manager.windows if w != context.window)]
    found = [
        area
        for window in windows
        for area in window.screen.areas
        if area.type == "IMAGE_EDITOR" and area.ui_type == "IMAGE_EDITOR"
    ]
    ours = [area for area in found if area.spaces.active.image is not None and area.spaces.active.image.get(MARK)]
    return next(iter(ours + found), None)


def follow(context: Any) -> None:
    """Where an image editor shows one of our pictures, it shows the active row's. @raises UserError without it"""
    kept = context.scene.penumbra_comparison
    row = results.active(kept)
    if row is None or row.status != "ok":
        return
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            image = area.spaces.active.image if area.type == "IMAGE_EDITOR" else None
            if image is None or image.get(MARK, "REFERENCE") == "REFERENCE":
                continue
            what = image[MARK]
            if (image["technique"], image["light"]) != (row.name, row.light):
                area.spaces.active.image = image_of(kept, row, what)
                area.tag_redraw()


def hand_to_overlay(context: Any, row: Any) -> None:
    """The viewport's overlay, where there is one, shows the same technique on its left."""
    overlay = getattr(context.window_manager, "penumbra_overlay", None)
    if overlay is not None and hasattr(overlay, "first"):
        overlay.first = row.technique


# --- pictures in panels ----------------------------------------------------------------------------------------------


class _Previews:
    """Blender's own collection of small pictures, filled when a panel draws and emptied with the file."""

    collection: Any = None
    plot_key: Any = None

    @classmethod
    def get(cls) -> Any:
        if cls.collection is None:
            cls.collection = bpy.utils.previews.new()
        return cls.collection

    @classmethod
    def clear(cls) -> None:
        if cls.collection is not None:
            bpy.utils.previews.remove(cls.collection)
        cls.collection = cls.plot_key = None


def thumbnail_icon(text: str, *, error: bool, colour: int | None = None) -> int:
    """The icon of a thumbnail; 0 for none. @param colour number of the technique, shown as a bar on the left"""
    if not text:
        return 0
    collection = _Previews.get()
    name = f"{hash(text)} {error} {colour}"
    if name not in collection:
        thumbnail = pictures.read_thumbnail(text)
        if thumbnail is None:
            return 0
        _fill(collection.new(name), _with_bar(thumbnail.rgb(error=error), colour))
    return int(collection[name].icon_id)


def swatch_icon(colour: int) -> int:
    """A dot in the technique's colour, as in the plot."""
    collection = _Previews.get()
    name = f"swatch {colour}"
    if name not in collection:
        y, x = np.mgrid[:32, :32]
        inside = np.clip(11.5 - np.hypot(x - 15.5, y - 15.5), 0, 1)
        picture = np.zeros((32, 32, 4), np.uint8)
        picture[...] = np.rint(inside[..., None] * np.array([*_rgb(colour), 255]))  # premultiplied, as icons are
        _fill(collection.new(name), picture)
    return int(collection[name].icon_id)


def plot_icon(kept: Any) -> int:
    """The plot of error against time, drawn anew when what it shows changes."""
    key = (kept.document, kept.shown_light, kept.active_row, kept.target)
    collection = _Previews.get()
    if key != _Previews.plot_key or "plot" not in collection:
        if "plot" in collection:
            del collection["plot"]
        _fill(collection.new("plot"), plot.draw(results.plot_of(kept)))
        _Previews.plot_key = key
    return int(collection["plot"].icon_id)


def _rgb(colour: int) -> tuple[int, int, int]:
    code = palette.colour(colour).lstrip("#")
    return int(code[0:2], 16), int(code[2:4], 16), int(code[4:6], 16)


def _with_bar(rgb: images.Bytes, colour: int | None) -> images.Bytes:
    height, width = rgb.shape[:2]
    picture = np.full((height, width, 4), 255, np.uint8)
    picture[..., :3] = rgb
    if colour is not None:
        picture[:, : max(2, width // 28), :3] = _rgb(colour)
    return picture


def _fill(preview: Any, picture: images.Bytes) -> None:
    """(h, w, 4) 8-bit, row 0 at the bottom, as Blender has it."""
    height, width = picture.shape[:2]
    preview.image_size = preview.icon_size = (width, height)
    values = np.ascontiguousarray(picture, np.float32).ravel() / 255
    preview.image_pixels_float.foreach_set(values)
    preview.icon_pixels_float.foreach_set(values)
