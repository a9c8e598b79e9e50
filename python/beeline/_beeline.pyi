"""The compiled part. Results are the JSON that the command prints; arrays are the bytes of float64."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Protocol, final

class BeelineError(Exception):
    """What is wrong, where, and what to try."""

class _Equation(Protocol):
    @property
    def equation(self) -> str: ...
    @property
    def name(self) -> str | None: ...
    @property
    def per(self) -> str | None: ...
    @property
    def units(self) -> Mapping[str, str]: ...
    @property
    def ranges(self) -> Mapping[str, tuple[float, float]]: ...

@final
class Model:
    """Effects with values."""

    @staticmethod
    def read(file: str | PathLike[str]) -> Model:
        """Reads a model.toml."""

    def write(self, file: str | PathLike[str]) -> None:
        """Writes it as a model.toml."""

    @staticmethod
    def of_text(text: str, robot: str) -> Model:
        """Of the text of a model.toml: what `pickle` makes of it again."""

    def effects(self) -> list[str]:
        """The ids of its effects."""

@final
class Campaign:
    """A campaign folder as it was when it was read."""

    @staticmethod
    def read(folder: str | PathLike[str]) -> Campaign: ...
    def facts(self) -> str: ...
    def wheels(self, run: int) -> list[bytes]: ...
    def explain(self, tolerance_m: float | None = None) -> tuple[str, str, Model]: ...
    def compare(self, model: Model | None = None) -> str: ...
    def fit(self, effects: Sequence[str], custom: Sequence[_Equation]) -> tuple[str, Model]: ...
    def predict(self, model: Model | None = None) -> list[tuple[str, str, bool, list[bytes]]]: ...

def write_arrays(folder: str | PathLike[str], robot: object, runs: Sequence[object]) -> None: ...
def write_logs(folder: str | PathLike[str], logs: object) -> list[str]: ...
def common_effects(found: Sequence[tuple[str, Sequence[str], bool]], models: Sequence[Model]) -> list[str]: ...
def judge(parameters: Sequence[Sequence[tuple[int, float | None, float, float]]]) -> str: ...
