"""What the bridge left out, placed or approximated: counted, named, nothing said twice."""

from __future__ import annotations

from typing import Any

SHOWN_NAMES = 4


class Notes:
    """Collects remarks; equal remarks about several objects become one sentence."""

    def __init__(self) -> None:
        self._names: dict[str, dict[str, int]] = {}

    def add(self, text: str, name: str | None = None) -> None:
        """Remember `text`, said about the object called `name`, or about the scene as a whole."""
        names = self._names.setdefault(text, {})
        if name is not None:
            names[name] = names.get(name, 0) + 1

    def sentences(self) -> list[str]:
        """One sentence per remark in the order of first mention: `left out, it has no faces: "A", "B" (3 times)`."""
        return [text + _listed(names) for text, names in self._names.items()]


def kept(value: Any) -> list[str]:
    """What `scenes.open_scene` put into a scene. Anybody may write anything there, and files keep it."""
    texts = [value] if isinstance(value, str) else value if hasattr(value, "__iter__") else []
    return [" ".join(str(text).split()) for text in texts if str(text).strip()]


def _listed(names: dict[str, int]) -> str:
    if not names:
        return ""
    shown = [f'"{name}"' + (f" ({count} times)" if count > 1 else "") for name, count in names.items()][:SHOWN_NAMES]
    rest = len(names) - len(shown)
    tail = f" and {rest} more" if rest else ""
    return ": " + ", ".join(shown) + tail
