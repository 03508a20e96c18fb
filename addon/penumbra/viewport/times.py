"""How long the parts of a viewport's drawing took: for measuring."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Times:
    """Seconds of the last time each was done."""

    read: float = 0.0  # what changed in Blender's scene
    core: float = 0.0  # a picture, on the viewport's own thread
    upload: float = 0.0  # its pixels to Blender's device
    draw: float = 0.0  # all that Blender waited for when it drew, upload included
