"""How a render is saved, for all versions of Blender."""

from __future__ import annotations

from typing import Any


def choose_multilayer_exr(settings: Any) -> None:
    """All passes, as float32. `settings`: a scene's render.image_settings"""
    if hasattr(settings, "media_type"):  # 5.0 and newer
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
