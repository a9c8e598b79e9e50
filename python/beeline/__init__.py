"""Explains why a two-wheeled robot does not drive straight.

>>> import beeline
>>> campaign = beeline.Campaign.from_folder("examples/mystery-robot")
>>> explanation = campaign.explain()
>>> print(explanation.verdict)
"""

from ._beeline import BeelineError
from .campaign import Campaign, Equation, Model, Robot, Run
from .results import (
    Clock,
    Comparison,
    DataFault,
    Drift,
    Effect,
    Errors,
    ErrorPair,
    Explanation,
    Expression,
    Fit,
    FittedEffect,
    Group,
    HeldOut,
    NextRun,
    Parameter,
    Regime,
    Rejected,
    Rms,
    RunCompared,
    Track,
    Unexplained,
)

__all__ = [
    "BeelineError",
    "Campaign",
    "Clock",
    "Comparison",
    "DataFault",
    "Drift",
    "Effect",
    "Equation",
    "ErrorPair",
    "Errors",
    "Explanation",
    "Expression",
    "Fit",
    "FittedEffect",
    "Group",
    "HeldOut",
    "Model",
    "NextRun",
    "Parameter",
    "Regime",
    "Rejected",
    "Rms",
    "Robot",
    "Run",
    "RunCompared",
    "Track",
    "Unexplained",
]
