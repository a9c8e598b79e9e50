"""Campaigns: recorded runs of one robot, and what can be asked of them."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike

from . import _beeline
from ._beeline import BeelineError, Model
from .results import Comparison, Explanation, Fit, Floats, Track

PathLike = str | os.PathLike[str]


@dataclass(frozen=True)
class Robot:
    """A robot as its data sheet describes it."""

    wheel_radius_m: float
    track_width_m: float
    name: str = "my-robot"
    #: Of an encoder revolution. Angles need none; it says how fine they are kept: the default is 2 microradians.
    counts_per_rev: float = 3_141_592.0
    #: Encoder revolutions per wheel revolution.
    gear_reduction: float = 1.0
    #: Standard errors of the measured poses, where they are known; else they are learnt from the runs.
    position_sigma_m: float | None = None
    heading_sigma_rad: float | None = None


@dataclass(frozen=True, eq=False)
class Run:
    """A run as it was recorded: angles of both wheels, and poses measured by something else, each at times of its own."""

    t_s: ArrayLike
    left_rad: ArrayLike
    right_rad: ArrayLike
    pose_t_s: ArrayLike
    x_m: ArrayLike
    y_m: ArrayLike
    #: Of the robot, counter-clockwise; ``None`` if it was not measured.
    heading_rad: ArrayLike | None = None
    gyro_t_s: ArrayLike | None = None
    gyro_rad_s: ArrayLike | None = None
    name: str = "run"
    #: On one clock for all runs.
    started_s: float | None = None
    payload_kg: float | None = None
    #: Nothing is fitted to it: it only shows what a model predicts.
    held_out: bool = False


@dataclass(frozen=True)
class Equation:
    """An effect of your own: what it adds to a motion, as ``dtheta/ds = k * v``."""

    equation: str
    name: str | None = None
    #: ``second``, ``metre`` or ``radian``, where the equation does not say it.
    per: str | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)


class Campaign:
    """Recorded runs of one robot, as they were when they were read."""

    def __init__(self, read: _beeline.Campaign, notes: Sequence[str] = ()) -> None:
        self._read = read
        facts = json.loads(read.facts())
        self.robot = Robot(**facts["robot"])
        #: Names of its runs.
        self.runs: tuple[str, ...] = tuple(run["name"] for run in facts["runs"])
        #: What is suspicious, and what an import did.
        self.warnings: tuple[str, ...] = (*notes, *facts["warnings"])

    @classmethod
    def from_folder(cls, folder: PathLike) -> Campaign:
        """Reads a campaign folder."""
        return cls(_beeline.Campaign.read(Path(folder)))

    @classmethod
    def from_arrays(cls, robot: Robot, runs: Iterable[Run], folder: PathLike | None = None) -> Campaign:
        """Makes a campaign of arrays; with ``folder`` it is kept there, for the command as well."""
        return _made(folder, lambda place: _beeline.write_arrays(place, robot, list(map(_bytes, runs))))

    @classmethod
    def from_bag(
        cls,
        *sources: PathLike,
        wheels: tuple[str, str] | None = None,
        pose: str | None = None,
        odometry: str | None = None,
        controller: PathLike | None = None,
        imu: str | None = None,
        mapping: str | None = None,
        name: str | None = None,
        wheel_radius_m: float | None = None,
        track_width_m: float | None = None,
        counts_per_rev: float | None = None,
        gear_reduction: float | None = None,
        rest_s: float = 2.0,
        folder: PathLike | None = None,
    ) -> Campaign:
        """Imports ROS 2 bags, tables and trajectories, as ``beeline import`` does; arguments are its options."""
        logs = SimpleNamespace(
            sources=list(map(Path, sources)),
            wheels=wheels and list(wheels),
            pose=pose,
            odometry=odometry,
            controller=controller,
            imu=imu,
            mapping=mapping,
            name=name,
            wheel_radius_m=wheel_radius_m,
            track_width_m=track_width_m,
            counts_per_rev=counts_per_rev,
            gear_reduction=gear_reduction,
            rest_s=rest_s,
        )
        return _made(folder, lambda place: _beeline.write_logs(place, logs))

    def explain(self, tolerance_m: float | None = None) -> Explanation:
        """Which effects are missing? As ``beeline explain``."""
        told, known, model = self._read.explain(tolerance_m)
        return Explanation.of(json.loads(told), json.loads(known), model)

    def compare(self, model: Model | Explanation | Fit | None = None) -> Comparison:
        """How far is a model off, and where? As ``beeline compare``; without a model, that of the folder's model.toml."""
        return Comparison.of(json.loads(self._read.compare(_model(model))))

    def fit(self, effects: Iterable[str] = (), custom: Iterable[str | Equation] = ()) -> Fit:
        """Fits effects of the catalogue, by their ids, and equations of your own."""
        equations = [one if isinstance(one, Equation) else Equation(one) for one in custom]
        told, model = self._read.fit(list(effects), equations)
        return Fit.of(json.loads(told), model)

    def predict(self, model: Model | Explanation | Fit | None = None) -> list[Track]:
        """What a model predicts for each run, beside what was measured; without one, the nominal robot. Held-out runs come last."""
        runs = self._read.predict(_model(model))
        return [Track(name, kind, held_out, *map(_array, arrays)) for name, kind, held_out, arrays in runs]

    def wheels(self, run: str) -> tuple[Floats, Floats, Floats]:
        """Times and angles of the left and the right wheel of a run."""
        if run not in self.runs:
            raise KeyError(run)
        t_s, left, right = map(_array, self._read.wheels(self.runs.index(run)))
        return t_s, left, right

    def __repr__(self) -> str:
        return f"Campaign({self.robot.name!r}, {len(self.runs)} runs)"


def _made(folder: PathLike | None, write) -> Campaign:
    """A campaign that is written first; without a folder it is only read, and nothing stays."""
    if folder is not None:
        notes = write(Path(folder))
        return Campaign(_beeline.Campaign.read(Path(folder)), notes or ())
    with tempfile.TemporaryDirectory(prefix="beeline-") as place:
        made = Path(place) / "campaign"
        notes = write(made)
        return Campaign(_beeline.Campaign.read(made), notes or ())


def _model(model: Model | Explanation | Fit | None) -> Model | None:
    return model.model if isinstance(model, Explanation | Fit) else model


def _array(data: bytes) -> Floats:
    return np.frombuffer(data, dtype=np.float64)


def _bytes(run: Run) -> SimpleNamespace:
    """A run as the compiled part takes it, after its shapes are checked."""
    columns = {
        "wheels": ("t_s", "left_rad", "right_rad"),
        "poses": ("pose_t_s", "x_m", "y_m", "heading_rad"),
        "gyro": ("gyro_t_s", "gyro_rad_s"),
    }
    arrays: dict[str, bytes] = {}
    for what, names in columns.items():
        values = [getattr(run, name) for name in names]
        length = np.size(values[0]) if values[0] is not None else 0
        for name, value in zip(names, values):
            array = np.full(length, np.nan) if value is None else np.asarray(value, dtype=np.float64)
            if array.shape != (length,):
                raise BeelineError(f"run {run.name}: {name} has the shape {array.shape}, and {names[0]} of {what} has {length} values")
            arrays[name] = array.tobytes()
    return SimpleNamespace(
        name=run.name, started_s=run.started_s, payload_kg=run.payload_kg, held_out=run.held_out, **arrays
    )
