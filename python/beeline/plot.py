"""Drawings with matplotlib, each on axes that you give or on new ones. What they draw comes from the results."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .results import Explanation, Track

MEASURED, BEFORE, AFTER = "#222222", "#c0392b", "#1f77b4"


def _axes(ax: Any) -> Any:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots()[1]


def path(nominal: Track, model: Track | None = None, ax: Any = None) -> Any:
    """The measured path of a run, and what the nominal robot and a model predict."""
    ax = _axes(ax)
    ax.plot(nominal.x_m, nominal.y_m, color=MEASURED, label="measured")
    ax.plot(nominal.predicted_x_m, nominal.predicted_y_m, color=BEFORE, ls="--", label="nominal robot")
    if model is not None:
        ax.plot(model.predicted_x_m, model.predicted_y_m, color=AFTER, ls="--", label="model")
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x [m]", ylabel="y [m]", title=nominal.run)
    ax.legend()
    return ax


def waterfall(explanation: Explanation, ax: Any = None) -> Any:
    """The cross-validated error as effects are added, and what any model could reach."""
    ax = _axes(ax)
    names = ["nominal robot", *(f"+ {' or '.join(one.indistinguishable)}" for one in explanation.effects), "error floor"]
    errors = [explanation.baseline.cross_validated, *(one.errors.cross_validated for one in explanation.effects), explanation.floor]
    values = [1e3 * one.position_rms_m for one in errors]
    colours = [BEFORE, *[AFTER] * len(explanation.effects), "#999999"]
    bars = ax.barh(range(len(names)), values, color=colours)
    ax.bar_label(bars, fmt="%.1f mm", padding=3)
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.set(xlabel="cross-validated position error [mm]")
    ax.margins(x=0.15)
    return ax


def errors(tracks: Sequence[Track], ax: Any = None, **style: Any) -> Any:
    """How far measured and predicted positions lie apart over the time of each run."""
    ax = _axes(ax)
    for number, track in enumerate(tracks):
        label = style.get("label") if number == 0 else None
        ax.plot(track.t_s - track.t_s[0], 1e3 * track.error_m, **{"lw": 1, **style, "label": label})
    ax.set(xlabel="time in the run [s]", ylabel="position error [mm]")
    return ax


def intervals(explanation: Explanation, ax: Any = None) -> Any:
    """The parameters found, in units of their standard errors from zero, with 95 % intervals."""
    ax = _axes(ax)
    found = [(one.effect, parameter) for one in explanation.effects for parameter in one.parameters]
    scale = np.array([parameter.sigma or 1.0 for _, parameter in found])
    values = np.array([parameter.value for _, parameter in found])
    low = values - np.array([parameter.low95 for _, parameter in found])
    high = np.array([parameter.high95 for _, parameter in found]) - values
    ax.errorbar(values / scale, range(len(found)), xerr=[low / scale, high / scale], fmt="o", color=AFTER, capsize=4)
    ax.axvline(0.0, color="#999999", lw=1)
    ax.set_yticks(range(len(found)), [f"{effect}: {parameter.name}" for effect, parameter in found])
    ax.set(xlabel="standard errors from zero")
    return ax
