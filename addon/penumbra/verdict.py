"""What the records of one light say: front, budgets, pick, and the sentences at the top of a report. Pure functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

from . import targets
from .records import Budget, LightResult, Pick, Record, Saving, Spread, word

INTERVAL = 0.05
"""Width of a median's 95 % interval, as a share of it, at which the core stops measuring (TimingOptions)."""

FEWEST_RUNS = 5
"""Below, the whole range of the runs is no 95 % interval of their median."""

BUDGETS = (0.1, 0.05, 0.02, 0.01, 1 / 255)
"""Headline errors that a report answers "who is cheapest?" for; the last is one step of an 8-bit picture."""


def judge(light: LightResult, target: float | None, pareto_front: Callable[..., Sequence[bool]]) -> None:
    """Fills in the light's fronts, budgets, targets, cheapest record within the target, and sentences.

    Times are dynamic frames: what a game pays when something moves. Errors are the headline figures.
    """
    indices = light.comparable()
    times = [light.records[i].time_ms["dynamic"].median for i in indices]
    errors = [light.records[i].headline for i in indices]
    for i, on_front in zip(indices, pareto_front(times, errors) if indices else [], strict=True):
        light.records[i].on_pareto_front = bool(on_front)
    for technique in {light.records[i].technique for i in indices}:
        for i in targets.curve(light, technique):
            light.records[i].on_own_front = True
    light.budgets = [budget(light, error) for error in BUDGETS]
    light.targets = [targets.target(light, error) for error in targets.errors_asked(target)]
    light.pick = pick(light, target) if target is not None else None
    light.cheapest_within_target = light.pick.technique if light.pick else None
    light.cheapest_settings = light.records[light.pick.record].settings if light.pick else None
    light.sentences = sentences(light, target)


def budget(light: LightResult, error: float) -> Budget:
    """The cheapest record within `error`. Those whose time intervals overlap the winner's are ties."""
    within = [i for i in light.comparable() if light.records[i].headline <= error]
    if not within:
        return Budget(error, None, None)
    winner = min(within, key=lambda i: light.records[i].time_ms["dynamic"].median)
    ties = [i for i in within if i != winner and _overlap(light.records[i], light.records[winner])]
    return Budget(error, light.records[winner].technique, winner, ties)


def pick(light: LightResult, target: float) -> Pick | None:
    """The cheapest record within the target, and what it saves against its technique as asked for and the next best."""
    found = budget(light, target)
    if found.record is None:
        return None
    winner = light.records[found.record]
    within = [i for i in light.comparable() if light.records[i].headline <= target]
    others = [i for i in within if light.records[i].technique != winner.technique]
    bases = [i for i in within if light.records[i].technique == winner.technique and not light.records[i].is_sweep_step]
    savings = [_saving(light, found.record, "default", i) for i in bases[:1] if i != found.record]
    if others:
        best = min(others, key=lambda i: light.records[i].time_ms["dynamic"].median)
        savings.append(_saving(light, found.record, "next_best", best))
    arguments = ["--techniques", winner.technique]
    for key, value in (winner.given or winner.changed).items():
        arguments += ["--set", f"{winner.technique}.{key}={word(value)}"]
    made = Pick(target, winner.technique, found.record, arguments, savings, "")
    made.sentence = _pick_sentence(light, made, [light.records[i].label() for i in found.ties])
    return made


def _saving(light: LightResult, winner: int, against: Literal["default", "next_best"], other: int) -> Saving:
    a, b = light.records[winner].time_ms["dynamic"], light.records[other].time_ms["dynamic"]

    def share(own: float, others: float) -> float:
        return 1.0 - own / others if others > 0.0 else 0.0

    technique = light.records[other].technique
    return Saving(against, technique, other, share(a.median, b.median), share(a.high, b.low), share(a.low, b.high))


def _pick_sentence(light: LightResult, made: Pick, ties: list[str]) -> str:
    winner = light.records[made.record]
    said = [f"Cheapest within the target of {made.error:g}: {winner.label()}, {_figures(winner)}{_tied(ties)}"]
    base = next((r for r in light.records if r.technique == winner.technique and not r.is_sweep_step), None)
    settings = "the settings asked for" if base is not None and base.given else "its default settings"
    worth: list[str] = []
    for saving in made.savings:
        other = light.records[saving.record]
        share = _percent(saving.share)
        if _overlap(winner, other) or share == _percent(0.0):
            continue  # a tie: it saves nothing that the timing could tell
        if min(r.time_ms["dynamic"].runs for r in (winner, other)) < FEWEST_RUNS:
            share = f"about {share}"
        elif _percent(saving.low) != _percent(saving.high):
            share += f" ({100 * saving.low:.0f} to {_percent(saving.high)})"
        slower = settings if saving.against == "default" else f"the next best technique, {other.label()}"
        worth.append(f"{share} of {'that' if worth else 'the time'} of {slower}")
    if worth:
        said.append(f"it saves {' and '.join(worth)}")
    if winner.is_sweep_step and base is not None and base.status == "ok" and base.headline > made.error:
        said.append(f"with {settings} it misses the target (error {base.headline:.3g})")
    if not any(saving.against == "next_best" for saving in made.savings):
        said.append("no other technique stays within it")
    return "; ".join(said) + "."


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def medians(light: LightResult) -> tuple[int, int]:
    """How many medians of frames were measured repeatedly, and how many of them are known as well as asked for."""
    told = [spread.tight for spread in _spreads(light).values() if spread.tight is not None]
    return len(told), sum(told)


def timing_sentence(light: LightResult) -> str:
    """Whether every median reached its interval; empty if nothing is known of it."""
    count, tight = medians(light)
    if count == 0:
        return ""
    if tight == count:
        return f"All {count} medians of frame times are known to {_percent(INTERVAL)}."
    loose = {name: s for name, s in _spreads(light).items() if s.tight is False and s.median > 0.0}
    said = f"{count - tight} of {count} medians of frame times are not known to {_percent(INTERVAL)}"
    if loose:
        worst, spread = max(loose.items(), key=lambda item: (item[1].high - item[1].low) / item[1].median)
        width = (spread.high - spread.low) / spread.median
        said += f"; the widest 95 % interval is {_percent(width)} of its median ({worst}, {spread.runs} runs)"
    return f"{said}. --timing-seconds gives each more time."


def _spreads(light: LightResult) -> dict[str, Spread]:
    return {
        f"{light.records[i].label()}, {name} frame": light.records[i].time_ms[name]
        for i in light.comparable()
        for name in ("dynamic", "static")
        if name in light.records[i].time_ms
    }


def _overlap(a: Record, b: Record) -> bool:
    ta, tb = a.time_ms["dynamic"], b.time_ms["dynamic"]
    return ta.low <= tb.high and tb.low <= ta.high


def milliseconds(value: float) -> str:
    """Three significant digits: "0.0431 ms", "4.31 ms", "431 ms", "4.31 s"."""
    if value >= 1000:
        return f"{value / 1000:.3g} s"
    return f"{value:.0f} ms" if value >= 100 else f"{value:.3g} ms"


def error_name(error: float) -> str:
    return "1/255" if abs(error - 1 / 255) < 1e-12 else f"{error:g}"


def sentences(light: LightResult, target: float | None) -> list[str]:
    """What a reader should take away, each sentence true by the numbers beside it."""
    indices = light.comparable()
    if not indices:
        return ["No technique could be measured at this light."]
    records = light.records
    said: list[str] = []
    reference = records[indices[0]].area or {}
    if not reference.get("pixels", 1):
        return ["This light reaches no visible pixel: there is nothing to compare."]
    if not reference.get("penumbra_pixels", 1):
        said.append("No visible pixel is partly lit: errors are over the whole mask instead of the penumbra.")

    best = min(indices, key=lambda i: records[i].headline)
    fast = min(indices, key=lambda i: records[i].time_ms["dynamic"].median)
    if best == fast:
        said.append(f"{records[best].label()} is the most accurate and the fastest: {_figures(records[best])}.")
    else:
        said.append(f"Most accurate: {records[best].label()}, {_figures(records[best])}.")
        tied = [records[i].label() for i in indices if i != fast and _overlap(records[i], records[fast])]
        said.append(f"Fastest: {records[fast].label()}, {_figures(records[fast])}{_tied(tied)}.")
    if target is not None:
        picked = pick(light, target)
        said.append(picked.sentence if picked else f"No technique stays within the target of {target:g}.")
    noise = [i for i in indices if (records[i].area or {}).get("within_reference_noise")]
    if noise:
        names = ", ".join(_grouped([records[i] for i in noise]))
        one = "differs" if len(noise) == 1 else "differ"
        said.append(f"{names} {one} from the reference by no more than the reference's own noise.")
    info = light.reference_info
    if info and not info.get("reached", True):
        said.append(
            "At some pixels the reference hit its limit of rays before the standard error asked for "
            f"({info['standard_error_asked']:g})."
        )
    return said


def _grouped(records: Sequence[Record]) -> list[str]:
    """Their labels, or where a technique has many of them, its title and how many."""
    by_title: dict[str, list[str]] = {}
    for record in records:
        by_title.setdefault(record.title, []).append(record.label())
    return [
        name
        for title, labels in by_title.items()
        for name in (labels if len(labels) <= 2 else [f"{title} ({len(labels)} settings)"])
    ]


def _tied(labels: list[str]) -> str:
    if not labels:
        return ""
    shown = labels if len(labels) <= 3 else [*labels[:2], f"{len(labels) - 2} others"]
    return f"; {' and '.join(shown)} cannot be told from it by time"


def _figures(record: Record) -> str:
    return f"error {record.headline:.3g}, {milliseconds(record.time_ms['dynamic'].median)} a frame"
