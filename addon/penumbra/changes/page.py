"""changes.html: one file that opens offline, in the look of the reports it compares."""

from __future__ import annotations

import functools
import math
from importlib import resources
from typing import Any

from ..report import html
from . import text
from .match import Changes, Ratio

_LEAST_SPAN = 1.25  # the bars' scale goes at least from 1/1.25 to 1.25
_MOST_SPAN = 20.0


def page(changes: Changes) -> str:
    """The whole page as text."""
    ratios = [t.time for t in changes.techniques if t.time is not None]
    ratios += [time.ratio for _, _, pair in changes.pairs() for time in pair.times if time.frame == "dynamic"]
    span = _span(ratios)
    made: str = _template().render(
        changes=changes,
        a=changes.a,
        b=changes.b,
        count=sum(1 for _ in changes.pairs()),
        changed=sum(pair.changes for _, _, pair in changes.pairs()),
        bar=lambda ratio: _bar(ratio, span),
        span=span,
        time_words=text.TIME_WORDS,
        error_words=text.ERROR_WORDS,
        ratio=text.ratio_text,
        facts=text.facts,
        settings_of=text.settings_of,
        style=html.style(),
        own_style=_text("changes.css"),
    )
    return made


def _span(ratios: list[Ratio]) -> float:
    """The largest ratio either way that a bar shows; what is beyond is cut off."""
    furthest = max((max(ratio.value, 1.0 / ratio.value) for ratio in ratios), default=1.0)
    return min(max(furthest * 1.1, _LEAST_SPAN), _MOST_SPAN)


def _bar(ratio: Ratio, span: float) -> dict[str, float]:
    """Ends and middle of the interval in percent of the width; 50 is a ratio of 1, the scale is logarithmic."""

    def place(value: float) -> float:
        share = math.log(max(value, 1e-12)) / math.log(span)
        return 50.0 + 50.0 * min(1.0, max(-1.0, share))

    low, high = place(ratio.low), place(ratio.high)
    return {"left": low, "width": max(high - low, 0.6), "middle": place(ratio.value)}


def _text(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


@functools.cache
def _template() -> Any:
    return html.template(_text("changes.html.j2"))
