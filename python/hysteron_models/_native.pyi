from collections.abc import Callable, Sequence
from os import PathLike
from typing import final

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
_Path = str | PathLike[str]
_Progress = Callable[[str, float, float | None], object]
_Figures = tuple[str, float, float, float | None, int, list[float]]
_Widths = tuple[_Array, _Array, list[str]]
_Simulated = tuple[list[_Array], _Widths | None, str, list[tuple[str, str | None]]]
_Points = tuple[_Array, _Array, _Array, _Array | None, str]
_Scored = tuple[str, _Figures, str, Record]

__all__ = [
    "Controller",
    "Fit",
    "Model",
    "Record",
    "__version__",
    "chi_square_quantile",
    "chi_square_tail",
    "choices",
    "compare",
    "compare_axes",
    "contents",
    "design",
    "difference_of",
    "excite",
    "explain_response",
    "fleet_page",
    "identify",
    "inspect",
    "play",
    "prepare",
    "read",
    "residual_correlation",
    "split_header",
    "student_tail",
    "write",
]
__version__: str

@final
class Record:
    def __new__(
        cls,
        name: str,
        channels: list[tuple[str, str, _Array]],
        sample_rate_hz: float | None = None,
        start_s: float = 0.0,
        times_s: _Array | None = None,
        valid: NDArray[np.bool_] | None = None,
    ) -> Record: ...
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> str | None: ...
    @property
    def channels(self) -> list[tuple[str, str]]: ...
    @property
    def sample_rate_hz(self) -> float | None: ...
    @property
    def has_times(self) -> bool: ...
    def __len__(self) -> int: ...
    def samples(self, channel: int) -> _Array: ...
    def times(self) -> _Array | None: ...
    def valid(self) -> NDArray[np.bool_] | None: ...
    def with_rate(self, column: str) -> Record: ...
    def with_dead_band(
        self,
        dead_band: float | None,
        dead_zone: float | None,
        input: str | None = None,
        output: str | None = None,
    ) -> Record: ...
    def select(self, input: str | None = None, output: str | None = None) -> tuple[int, int]: ...

@final
class Fit:
    @property
    def model(self) -> Model: ...
    @property
    def treatment(self) -> list[str]: ...
    @property
    def interrupted(self) -> bool: ...
    @property
    def scores(self) -> list[tuple[str, _Figures]]: ...
    def to_json(self) -> str: ...
    def searches(self) -> str: ...
    def report(self, name: str) -> str: ...

@final
class Model:
    @staticmethod
    def load(path: _Path) -> Model: ...
    @staticmethod
    def from_json(json: str) -> Model: ...
    @property
    def kind(self) -> str: ...
    @property
    def name(self) -> str | None: ...
    @property
    def units(self) -> tuple[str, str]: ...
    @property
    def channels(self) -> tuple[list[str], list[str]] | None: ...
    @property
    def sample_rate_hz(self) -> float | None: ...
    @property
    def valid_range(self) -> str | None: ...
    @property
    def drive_range(self) -> tuple[float, float] | None: ...
    def save(self, path: _Path) -> None: ...
    def to_json(self) -> str: ...
    def simulate(
        self,
        record: Record,
        input: str | None = None,
        from_start: str | None = None,
        band: float | None = None,
        correct: bool = False,
    ) -> _Simulated: ...
    def predict(
        self,
        record: Record,
        input: str | None = None,
        output: str | None = None,
        from_start: str | None = None,
        band: float | None = None,
        correct: bool = False,
    ) -> tuple[_Simulated, list[float], _Array | None]: ...
    def score(
        self,
        record: Record,
        scoring: str,
        input: str | None = None,
        output: str | None = None,
        from_start: str | None = None,
        correct: bool = False,
    ) -> _Scored: ...
    def score_continued(
        self,
        records: list[Record],
        scoring: str,
        input: str | None = None,
        output: str | None = None,
        from_start: str | None = None,
    ) -> list[_Scored]: ...
    def invert(
        self,
        reference: _Array,
        sample_rate_hz: float,
        options: str,
        last: tuple[_Array, _Array] | None = None,
    ) -> tuple[_Array, _Array, str]: ...
    def decouple(
        self, references: Sequence[_Array], sample_rate_hz: float, options: str
    ) -> tuple[list[_Array], list[_Array], str]: ...
    def controller(self, sample_rate_hz: float, options: str) -> Controller: ...
    def track(
        self,
        reference: _Array,
        sample_rate_hz: float,
        options: str,
        plant: str = "rig",
        truth: str | None = None,
        seed: int = 0,
    ) -> tuple[str, str, list[tuple[str, _Array, _Array]]]: ...
    def frequency_response(self, frequency_hz: _Array) -> tuple[_Array, _Array]: ...
    def realise(
        self, sample_rate_hz: float, accuracy: float = 1e-5, lowest_frequency_hz: float | None = None
    ) -> tuple[str, list[_Array]]: ...
    def export(self, folder: _Path, options: str) -> list[str]: ...
    def adapt(
        self, record: Record, options: str, input: str | None = None, output: str | None = None
    ) -> tuple[str, Model | None]: ...
    def recalibrate(
        self,
        records: list[Record],
        input: str | None = None,
        output: str | None = None,
        continued: bool = False,
        least_fit_percent: float = 75.0,
    ) -> tuple[Model, str]: ...

@final
class Controller:
    def step(self, reference: float) -> float: ...
    def run(self, reference: _Array) -> _Array: ...
    def rest_at(self, voltage: float) -> float: ...
    @property
    def displacement(self) -> float: ...
    @property
    def preview(self) -> int: ...
    @property
    def sample_rate_hz(self) -> float: ...
    @property
    def range(self) -> tuple[float, float]: ...

def read(paths: list[_Path], options: str) -> list[tuple[Record, str | None, str | None]]: ...
def split_header(header: str) -> tuple[str, str]: ...
def contents(path: _Path) -> str: ...
def write(path: _Path, record: Record) -> None: ...
def prepare(records: list[Record], options: str) -> tuple[Record, str]: ...
def design(
    options: str,
    model: Model | None = None,
    records: list[Record] = ...,
    input: str | None = None,
    output: str | None = None,
    progress: _Progress | None = None,
) -> tuple[_Array, _Array, str]: ...
def inspect(records: list[Record], input: str | None = None, output: str | None = None) -> str: ...
def identify(
    records: list[Record],
    kind: str,
    options: str,
    *,
    inputs: list[str] = ...,
    outputs: list[str] = ...,
    start: Model | None = None,
    resume: str | None = None,
    progress: _Progress | None = None,
) -> tuple[Fit, BaseException | None]: ...
def residual_correlation(series: Record, skip_s: float = 0.0) -> tuple[int, _Array, float] | None: ...
def choices() -> str: ...
def compare(
    records: list[Record],
    candidates: list[str] = ...,
    quick: bool = False,
    time_limit: float | None = None,
    continued: bool = False,
    input: str | None = None,
    output: str | None = None,
    threads: int | None = None,
    progress: _Progress | None = None,
) -> tuple[str, str, Model | None, BaseException | None]: ...
def compare_axes(
    records: list[Record],
    inputs: list[str],
    outputs: list[str],
    candidates: list[str] = ...,
    threads: int | None = None,
    progress: _Progress | None = None,
) -> tuple[str, str, Model | None, BaseException | None]: ...
def excite(options: str) -> tuple[Record, str]: ...
def play(
    drive: Record, truth: str | None = None, seed: int = 0, stream: int = 0, with_truth: bool = False
) -> tuple[Record, str]: ...
def explain_response(
    records: list[Record],
    path: _Path | None = None,
    options: str = "{}",
    structures: list[str] = ...,
    modes: int | None = None,
    band: tuple[float, float] | None = None,
    input: str | None = None,
    output: str | None = None,
    response: str | None = None,
    over: str | None = None,
) -> tuple[_Points, str, str, Model | None]: ...
def difference_of(first: Model, second: Model) -> tuple[str, bool]: ...
def chi_square_tail(x: float, degrees: float) -> float: ...
def chi_square_quantile(p: float, degrees: float) -> float: ...
def student_tail(t: float, degrees: float) -> float: ...
def fleet_page(fleet: str) -> str: ...
