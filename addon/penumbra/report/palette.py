"""One colour and one marker per technique, the same in every plot of a report."""

from __future__ import annotations

from ..records import Comparison

# Told apart on white and on black, and by people who see few colours together with the markers.
COLOURS = (
    "#3f8fe0", "#e8743b", "#19a979", "#c261c9", "#d6a400", "#ed4a7b",
    "#13a4b4", "#8d6bdd", "#8c8c5a", "#6c8893", "#bf6f39", "#6b9e3f",
)  # fmt: skip
MARKERS = ("o", "s", "D", "^", "v", "P", "X", "p", "h", "*", "<", ">")


def order(comparison: Comparison) -> dict[str, int]:
    """The number of each technique, by its first appearance."""
    numbers: dict[str, int] = {}
    for scene in comparison.scenes:
        for light in scene.lights:
            for record in light.records:
                numbers.setdefault(record.technique, len(numbers))
    return numbers


def colour(number: int) -> str:
    return COLOURS[number % len(COLOURS)]


def marker(number: int) -> str:
    return MARKERS[number % len(MARKERS)]
