"""Writes OpenEXR files: float32 scanlines under ZIP compression, which is NumPy, zlib and a header.

No library does it, because Blender's program keeps a libOpenEXR of its own loaded for everybody: a compiled module with
another one inside then calls Blender's functions, and the process dies (docs/decisions/0012-batch.md). The layout is
that of "The OpenEXR File Layout", version 2, single part.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

_MAGIC = b"\x76\x2f\x31\x01"
_VERSION, _LONG_NAMES = 2, 0x400  # names of more than 31 bytes need the flag
_FLOAT, _ZIP, _INCREASING_Y = 2, 3, 0
_ROWS = 16  # that ZIP compresses together
_LEVEL = 4  # as OpenEXR's own: 6 takes twice as long for a percent of the size


def encode(channels: Mapping[str, npt.NDArray[np.float32]], attributes: Mapping[str, str] | None = None) -> bytes:
    """The whole file.

    @param channels each (height, width) float32, first row on top, by full name ("visibility", "normal.X")
    @param attributes texts for the header
    """
    names = sorted(channels, key=str.encode)
    height, width = channels[names[0]].shape
    # In the file, each row holds all channels one after another: (height, channels, width).
    rows = np.stack([np.ascontiguousarray(channels[name], dtype="<f4") for name in names], axis=1)
    blocks = [(y, _compress(rows[y : y + _ROWS].tobytes())) for y in range(0, height, _ROWS)]
    header = _header(names, width, height, attributes or {})
    offset = len(header) + 8 * len(blocks)
    offsets, parts = [], []
    for y, block in blocks:
        offsets.append(offset)
        parts.append(struct.pack("<ii", y, len(block)) + block)
        offset += len(parts[-1])
    return b"".join([header, struct.pack(f"<{len(offsets)}Q", *offsets), *parts])


def _compress(raw: bytes) -> bytes:
    """Bytes of equal significance side by side, differences of neighbours, zlib; raw where that does not help."""
    pixels = np.frombuffer(raw, np.uint8)
    sorted_bytes = np.concatenate([pixels[0::2], pixels[1::2]])
    differences = sorted_bytes.copy()
    differences[1:] = sorted_bytes[1:] - sorted_bytes[:-1] + np.uint8(128)  # modulo 256, as uint8 has it
    packed = zlib.compress(differences.tobytes(), _LEVEL)
    return packed if len(packed) < len(raw) else raw


def _header(names: list[str], width: int, height: int, attributes: Mapping[str, str]) -> bytes:
    encoded = [name.encode() for name in names]
    listed = b"".join(name + b"\0" + struct.pack("<iB3xii", _FLOAT, 0, 1, 1) for name in encoded) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    entries: list[tuple[str, str, Any]] = [
        ("channels", "chlist", listed),
        ("compression", "compression", struct.pack("<B", _ZIP)),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", struct.pack("<B", _INCREASING_Y)),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<ff", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
        *((name, "string", text.encode()) for name, text in attributes.items()),
    ]
    long = any(len(name) > 31 for name in (*encoded, *(name.encode() for name, _, _ in entries)))
    body = b"".join(
        name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data
        for name, kind, data in entries
    )
    return _MAGIC + struct.pack("<i", _VERSION | (_LONG_NAMES if long else 0)) + body + b"\0"
