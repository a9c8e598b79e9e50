"""Many robots and dates: what `beeline fleet` does, in parts, so that another engine can run the parts on many machines.

Each campaign is explained, all of a kind are fitted with :func:`common_effects`, and :func:`judge` says who changes with time, who is
unlike the others, and what all have in common.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from . import _beeline
from .results import Explanation

#: Number of the robot, day (``None``: unknown), value, standard error.
Value = tuple[int, "float | None", float, float]


@dataclass(frozen=True)
class Trend:
    """How the values of a robot change with time."""

    per_day: float
    sigma: float
    p_value: float
    #: The false discovery rate is below 1 %, over all that was asked together.
    is_there: bool


@dataclass(frozen=True)
class Robot:
    """One robot among those of its kind."""

    robot: int
    campaigns: int
    mean: float
    sigma: float
    trend: Trend | None
    is_unlike: bool


@dataclass(frozen=True)
class Judgement:
    """One parameter over all robots of a kind."""

    mean: float
    mean_sigma: float
    #: By how much robots that are alike differ.
    spread: float
    alike: int
    is_common: bool
    robots: tuple[Robot, ...]


def common_effects(explanations: Iterable[Explanation]) -> list[str]:
    """The ids of the effects that all campaigns of a kind are fitted with: radii, track width, and what any of them shows.

    An equation of your own is among them if the model.toml of every campaign declares it, as only these can be fitted with it.
    """
    explained = list(explanations)
    effects = (effect for one in explained for effect in (*one.known, *one.effects))
    found = [(one.effect, list(one.indistinguishable), one.matters) for one in effects]
    return _beeline.common_effects(found, [one.model for one in explained])


def judge(parameters: Mapping[str, Sequence[Value]]) -> dict[str, Judgement]:
    """Judges all parameters of a fleet at once, each with its values in all campaigns of a kind."""
    told = json.loads(_beeline.judge([list(values) for values in parameters.values()]))
    return dict(zip(parameters, map(_judgement, told)))


def _judgement(told: dict) -> Judgement:
    robots = (Robot(**{**one, "trend": one["trend"] and Trend(**one["trend"])}) for one in told["robots"])
    return Judgement(**{**told, "robots": tuple(robots)})
