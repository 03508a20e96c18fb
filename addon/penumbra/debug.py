"""Pictures of a technique's inside: silhouettes, what it draws from them, its maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import images
from .errors import UserError
from .files import slug, write_bytes
from .progress import Progress
from .records import Settings

if TYPE_CHECKING:
    from .bridge import SceneExport


def write_views(
    renderer: Any,
    export: SceneExport,
    technique: str,
    settings: Settings,
    lights: Sequence[int],
    views: Sequence[str],
    folder: Path,
    progress: Progress,
) -> list[tuple[Path, str]]:
    """One PNG per light and view, `LIGHT-VIEW.png`. @returns files with their captions
    @raises UserError if no light has anything to show
    """
    progress.stage("view", 1.0)
    renderer.set_scene(export.scene)
    written: list[tuple[Path, str]] = []
    reasons: list[str] = []
    for index in lights:
        name = export.lights[index]
        progress.stage(f"{name}: {technique}", 2.0)
        reason = str(renderer.supports(index, technique))
        if reason:
            reasons.append(f'"{name}": {reason}')
            continue
        pictures = renderer.debug_images(index, technique, settings, views=list(views), progress=progress)
        if not pictures:
            reasons.append(f'"{name}": {technique} has no inside to show here')
        for picture in pictures:
            path = folder / f"{slug(name)}-{picture['id']}.png"
            folder.mkdir(parents=True, exist_ok=True)
            pixels = np.rint(np.clip(np.asarray(picture["rgb"]), 0.0, 1.0) * 255.0).astype(np.uint8)
            write_bytes(path, images.png(pixels))
            written.append((path, f"{picture['title']}: {picture['caption']}"))
    if not written:
        raise UserError(f"nothing to show: {'; '.join(reasons)}")
    return written
