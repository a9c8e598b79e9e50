"""What is found, as dataclasses. Each is made of the JSON that the command prints; ``json`` keeps that."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Json = dict[str, Any]


@dataclass(frozen=True)
class Errors:
    """How far predicted and measured tracks lie apart: root mean squares over whole runs."""

    position_rms_m: float
    heading_rms_rad: float
    chi: float


@dataclass(frozen=True)
class ErrorPair:
    """Errors on the runs fitted to, and cross-validated."""

    fitted: Errors
    cross_validated: Errors

    @classmethod
    def of(cls, json: Json) -> ErrorPair:
        return cls(Errors(**json["train"]), Errors(**json["heldout"]))


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect, with its standard error and its 95 % interval."""

    name: str
    unit: str
    value: float
    sigma: float
    low95: float
    high95: float


def _parameters(json: list[Json]) -> tuple[Parameter, ...]:
    return tuple(Parameter(**one) for one in json)


@dataclass(frozen=True)
class Effect:
    """An effect that is missing, with the errors of a model of it and all before it."""

    effect: str
    #: All effects that these runs cannot tell from it, itself included.
    indistinguishable: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    errors: ErrorPair
    p_value: float
    evidence: str
    matters: bool
    #: It explains more than is left unexplained; a saved model goes without it otherwise.
    used_to_predict: bool
    effect_size_m: float

    @classmethod
    def of(cls, json: Json) -> Effect:
        return cls(
            json["effect"],
            tuple(json["class"]),
            _parameters(json["parameters"]),
            ErrorPair.of(json),
            json["p_value"],
            json["why"],
            json["matters"],
            json["used_to_predict"],
            json["effect_size_m"],
        )

    def __getitem__(self, name: str) -> Parameter:
        return _named(self.parameters, name)


def _named(parameters: tuple[Parameter, ...], name: str) -> Parameter:
    for parameter in parameters:
        if parameter.name == name:
            return parameter
    raise KeyError(name)


@dataclass(frozen=True)
class Rejected:
    """An effect that was considered, and why it is not accepted."""

    effect: str
    reason: str
    cross_validated: Errors


@dataclass(frozen=True)
class Clock:
    """How late the poses of a run are by the clock of its wheels, and how much faster their clock runs."""

    run: str
    offset_s: float
    offset_sigma_s: float
    rate: float
    rate_sigma: float


@dataclass(frozen=True)
class DataFault:
    """What may be wrong with the data."""

    id: str
    run: str | None
    evidence: str
    mend: str
    error_m: float
    mended_m: float


@dataclass(frozen=True)
class Expression:
    """An equation for what no known effect explains."""

    equation: str
    #: Name, unit, value and standard error of each parameter.
    parameters: tuple[tuple[str, str, float, float], ...]
    position_rms_m: float


@dataclass(frozen=True)
class Unexplained:
    """What no effect explains."""

    structure: bool
    depends_on: tuple[str, ...]
    p_value: float
    size_m: float
    expression: Expression | None
    #: Position error that comes back when a run is driven again, which is no noise; 0 if like runs differ as noise does. None if too
    #: few runs were driven again.
    comes_back_m: float | None
    #: How far the robot turns at random in a metre, where that is much for wheels and no run was driven again.
    random_turn_rad: float | None

    @classmethod
    def of(cls, json: Json) -> Unexplained:
        found = json["expression"]
        if found is not None:
            names = ("name", "unit", "value", "sigma")
            parameters = tuple(tuple(one[name] for name in names) for one in found["parameters"])
            found = Expression(found["equation"], parameters, found["position_rms_m"])
        return cls(
            json["structure"],
            tuple(json["depends_on"]),
            json["p_value"],
            json["size_m"],
            found,
            json.get("comes_back_m"),
            json.get("random_turn_rad"),
        )


@dataclass(frozen=True)
class NextRun:
    """The run that would tell effects apart."""

    kind: str
    separates: tuple[str, ...]
    predicted: str


@dataclass(frozen=True)
class Explanation:
    """Which effects are missing, in order of evidence, and what remains."""

    verdict: str
    effects: tuple[Effect, ...]
    #: Effects that the folder's model.toml has already, and that the runs confirm.
    known: tuple[Effect, ...]
    rejected: tuple[Rejected, ...]
    #: Radii or track width that are no finding of their own, by effect.
    fitted_along: dict[str, tuple[Parameter, ...]]
    baseline: ErrorPair
    #: What any model could reach on these runs.
    floor: Errors
    unexplained: Unexplained
    #: Runs that everything else is not about: they are off by far more than the others, and hid what those show.
    set_aside: tuple[str, ...]
    next_run: NextRun | None
    clocks: tuple[Clock, ...]
    data: tuple[DataFault, ...]
    tolerance_m: float
    #: What other runs are predicted with: for ``Campaign.predict`` and ``Campaign.compare``.
    model: Any = field(repr=False)
    #: As ``beeline explain --format json`` prints it.
    json: Json = field(repr=False)

    @classmethod
    def of(cls, json: Json, known: Json, model: Any) -> Explanation:
        following = json["next_run"]
        return cls(
            verdict=json["verdict"],
            effects=tuple(map(Effect.of, json["steps"])),
            known=tuple(map(Effect.of, known)),
            rejected=tuple(Rejected(one["effect"], one["reason"], Errors(**one["heldout"])) for one in json["rejected"]),
            fitted_along={one["effect"]: _parameters(one["parameters"]) for one in json["fitted_along"]},
            baseline=ErrorPair.of(json["baseline"]),
            floor=Errors(**json["floor"]),
            unexplained=Unexplained.of(json["unexplained"]),
            set_aside=tuple(json.get("set_aside", {}).get("runs", ())),
            next_run=following and NextRun(following["kind"], tuple(following["separates"]), following["why"]),
            clocks=tuple(Clock(**one) for one in json["clocks"]),
            data=tuple(DataFault(**one) for one in json["data_hypotheses"]),
            tolerance_m=json["tolerance_m"],
            model=model,
            json=json,
        )


@dataclass(frozen=True)
class FittedEffect:
    """An effect of a model that was chosen, fitted, and the evidence for it given all others."""

    effect: str
    parameters: tuple[Parameter, ...]
    p_value: float
    #: Its cross-validated gain is more than chance gives, and nothing speaks against it.
    better: bool
    verdict: str

    def __getitem__(self, name: str) -> Parameter:
        return _named(self.parameters, name)


@dataclass(frozen=True)
class HeldOut:
    """Errors on the runs that were held out."""

    runs: int
    kinds: tuple[str, ...]
    errors: Errors


@dataclass(frozen=True)
class Fit:
    """A model that was chosen, fitted."""

    effects: tuple[FittedEffect, ...]
    nominal: ErrorPair
    errors: ErrorPair
    held_out: HeldOut | None
    model: Any = field(repr=False)
    json: Json = field(repr=False)

    @classmethod
    def of(cls, json: Json, model: Any) -> Fit:
        effects = tuple(
            FittedEffect(one["effect"], _parameters(one["parameters"]), one["p_value"], one["better"], one["verdict"])
            for one in json["effects"]
        )
        aside = json["aside"]
        held_out = aside and HeldOut(aside["runs"], tuple(aside["kinds"]), Errors(**aside["errors"]))
        return cls(effects, ErrorPair.of(json["nominal"]), ErrorPair.of(json["errors"]), held_out, model, json)

    def __getitem__(self, effect: str) -> FittedEffect:
        for one in self.effects:
            if one.effect == effect:
                return one
        raise KeyError(effect)


@dataclass(frozen=True)
class Rms:
    """A root mean square error, what noise alone gives, and what noise exceeds in 1 % of cases."""

    rms: float
    noise: float
    noise_high: float

    @classmethod
    def of(cls, json: Json | None) -> Rms | None:
        return json and cls(**json)


@dataclass(frozen=True)
class RunCompared:
    """A run, predicted and measured."""

    name: str
    kind: str
    held_out: bool
    path_m: float
    turned_rad: float
    duration_s: float
    position_m: Rms | None
    heading_rad: Rms | None
    end_m: float | None

    @classmethod
    def of(cls, json: Json) -> RunCompared:
        both = {name: Rms.of(json[name]) for name in ("position_m", "heading_rad")}
        return cls(**{**json, **both})


@dataclass(frozen=True)
class Drift:
    """The error that all stretches of a group share, per metre of wheel travel."""

    component: str
    per_m: float
    sigma: float


@dataclass(frozen=True)
class Group:
    """Stretches of one regime."""

    name: str
    runs: int
    stretches: int
    rolled_m: float
    position_m: Rms
    heading_rad: Rms
    chi: float
    scattered: bool
    beyond_noise: bool
    drifts: tuple[Drift, ...]

    @classmethod
    def of(cls, json: Json) -> Group:
        both = {name: Rms.of(json[name]) for name in ("position_m", "heading_rad")}
        drifts = tuple(Drift(one["aspect"], one["per_m"], one["sigma"]) for one in json["drifts"])
        return cls(**{**json, **both, "drifts": drifts})


@dataclass(frozen=True)
class Regime:
    """What the error may depend on, with its groups."""

    name: str
    groups: tuple[Group, ...]


@dataclass(frozen=True)
class Comparison:
    """How far a model is off, where, and how much of that is noise."""

    finding: str
    #: Ids of the effects of the model; none is the nominal robot.
    model: tuple[str, ...]
    position_m: Rms
    heading_rad: Rms
    runs: tuple[RunCompared, ...]
    regimes: tuple[Regime, ...]
    json: Json = field(repr=False)

    @classmethod
    def of(cls, json: Json) -> Comparison:
        own = json["comparison"]
        return cls(
            own["finding"],
            tuple(json["model"]),
            Rms(**own["position_m"]),
            Rms(**own["heading_rad"]),
            tuple(map(RunCompared.of, own["runs"])),
            tuple(Regime(one["name"], tuple(map(Group.of, one["cells"]))) for one in own["regimes"]),
            json,
        )


@dataclass(frozen=True, eq=False)
class Track:
    """The measured poses of a run, and what a model predicts for the same times. NaN: not measured."""

    run: str
    kind: str
    held_out: bool
    t_s: Floats
    x_m: Floats
    y_m: Floats
    heading_rad: Floats
    predicted_x_m: Floats
    predicted_y_m: Floats
    predicted_heading_rad: Floats

    @property
    def error_m(self) -> Floats:
        """Distance between predicted and measured positions."""
        return np.hypot(self.x_m - self.predicted_x_m, self.y_m - self.predicted_y_m)

    @property
    def position_rms_m(self) -> float:
        """Its root mean square; NaN if no position was measured."""
        error_m = self.error_m[np.isfinite(self.error_m)]
        return float(np.sqrt(np.mean(error_m**2))) if error_m.size else float("nan")
