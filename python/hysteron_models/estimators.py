"""Estimators: options in the constructor, ``fit`` on a list of records, results with a trailing
underscore."""

from __future__ import annotations

import inspect as signatures
import json
import multiprocessing
import sys
import threading
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, cast

from numpy.typing import ArrayLike

from . import _native
from ._errors import ModelError, OptionError, missing
from .model import Controller, ExportForm, Model
from .progress import Progress, shown
from .record import PathLike, Record, as_records, natives
from .results import Finding, FrequencyResponse, Inversion, Prediction, Score, Tracking, write_text

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Branches", "Estimator", "Force", "Hammerstein", "Modes", "Oscillator"]

E = TypeVar("E", bound="Estimator")


def _in_worker() -> bool:
    """Whether this runs in a worker of a pool, whose siblings have the other cores."""
    return (
        multiprocessing.parent_process() is not None
        or threading.current_thread() is not threading.main_thread()
    )


class Estimator:
    """Base class of the estimators.

    After :meth:`fit`:

    Attributes:
        model_: the identified :class:`Model`.
        findings_: verdicts, advice and warnings.
        scores_: score of every record of the fit.
        treatment_: steps of data preparation, in words.
        result_: everything, as ``hysteron identify --json`` prints it.
        interrupted_: the fit was stopped; the model is the best so far.
        searches_: checkpoint for ``fit(…, resume=…)``.
    """

    _kind: ClassVar[str]
    model_: Model
    findings_: list[Finding]
    scores_: list[Score]
    treatment_: list[str]
    result_: dict[str, Any]
    interrupted_: bool
    searches_: str

    # --- conventions of scikit-learn, without needing it

    @classmethod
    def _names(cls) -> list[str]:
        parameters = signatures.signature(cls.__init__).parameters.values()
        return [p.name for p in parameters if p.name != "self"]

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Options of the constructor by name."""
        return {name: getattr(self, name) for name in self._names()}

    def set_params(self: E, **params: Any) -> E:
        """Change options of the constructor."""
        known = self._names()
        for name, value in params.items():
            if name not in known:
                raise OptionError(f"{type(self).__name__} has no option {name}: it has {', '.join(known)}")
            setattr(self, name, value)
        return self

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=False),
            regressor_tags=RegressorTags(),
            input_tags=InputTags(two_d_array=False),
        )

    def __repr__(self) -> str:
        defaults = signatures.signature(type(self).__init__).parameters
        given = [f"{n}={v!r}" for n, v in self.get_params().items() if v != defaults[n].default]
        return f"{type(self).__name__}({', '.join(given)})"

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "model_")

    # --- identification

    def _options(self) -> dict[str, Any]:
        raise NotImplementedError

    def _columns(self) -> tuple[list[str], list[str]]:
        return [], []

    def fit(
        self: E,
        records: Record | Sequence[Record],
        y: None = None,
        *,
        progress: bool | Progress = False,
        start: Model | None = None,
        resume: str | None = None,
    ) -> E:
        """Identify the model from records of one device.

        Ctrl-C stops the fit, keeps the best so far in ``model_`` and raises ``KeyboardInterrupt``.

        Args:
            records: one record, or several.
            y: not used; here for scikit-learn.
            progress: show a bar, or call ``progress(stage, fraction, cost)``; an exception in it stops the
                fit.
            start: model whose parameters every search tries first.
            resume: ``searches_`` of an interrupted fit of the same records with the same options.

        Raises:
            ModelError: records that cannot be used.
            IdentifyError: no model of this class fits them.
        """
        given = as_records(records)
        options = self._options()
        if options.get("threads", 0) is None and _in_worker():
            options["threads"] = 1
        inputs, outputs = self._columns()
        with shown(progress) as told:
            fit, interrupt = _native.identify(
                natives(given),
                self._kind,
                json.dumps({key: value for key, value in options.items() if value is not None}),
                inputs=inputs,
                outputs=outputs,
                start=None if start is None else start._native,
                resume=resume,
                progress=told,
            )
        self._fit = fit
        self.model_ = Model(fit.model)
        self.result_ = json.loads(fit.to_json())
        self.findings_ = [Finding._of(f) for f in self.result_["findings"]]
        self.scores_ = [Score._of(name, figures) for name, figures in fit.scores]
        self.treatment_ = fit.treatment
        self.interrupted_ = fit.interrupted
        self.searches_ = fit.searches() if fit.interrupted else ""
        if interrupt is not None:
            raise interrupt
        return self

    def __getstate__(self) -> dict[str, Any]:
        state = self.__dict__.copy()
        state.pop("_fit", None)
        return state

    def _fitted(self) -> Model:
        if not hasattr(self, "model_"):
            raise _not_fitted()(
                f"this {type(self).__name__} is not fitted yet: call fit first", code="not-fitted"
            )
        return self.model_

    @property
    def parameters_(self) -> pd.DataFrame:
        """One row a parameter, by its name: ``value``, ``std_error``, ``lower``, ``upper``, ``unit``.

        ``lower`` to ``upper`` is the 95 % interval of a joint fit. Both are NaN for parameters that were held
        or are not determined, and in fits of two steps, of oscillators and of branches.
        """
        try:
            import pandas as pd
        except ImportError:
            raise missing(
                "pandas", "pandas", "a DataFrame of parameters (parameters() gives a list)"
            ) from None
        rows = self.parameters()
        columns = ["value", "std_error", "lower", "upper", "unit", "held", "of"]
        index = pd.Index([row.pop("name") for row in rows], name="parameter")
        return pd.DataFrame(rows, columns=columns, index=index)

    def parameters(self) -> list[dict[str, Any]]:
        """The parameters as a list of dictionaries, for which no extra package is needed."""
        self._fitted()
        rows = []
        for p in self.result_.get("parameters") or []:
            interval = p.get("interval_95") or {}
            rows.append(
                {
                    "name": p["name"],
                    "value": p["value"],
                    "std_error": _number(p.get("std_error")),
                    "lower": _number(interval.get("low")),
                    "upper": _number(interval.get("high")),
                    "unit": "" if p["unit"] == "1" else p["unit"],
                    "held": p["held"],
                    "of": p.get("block") or p.get("of") or "",
                }
            )
        return rows

    def summary(self) -> str:
        """Summary as text: range, scores, parameters with standard errors, findings."""
        model = self._fitted()
        lines = [f"[[Model]]\n    {model.kind}; {model.valid_range or 'range not known'}", "[[Scores]]"]
        for score in self.scores_:
            fit = "" if score.fit_percent is None else f", fit {score.fit_percent:.2f} %"
            lines.append(
                f"    {score.record}: RMSE {score.rmse:.4g} {score.unit}, max {score.max_abs_error:.4g}"
                f"{fit}, {score.samples} samples"
            )
        rows = self.parameters()
        if rows:
            lines.append("[[Parameters]]")
            width = max(len(row["name"]) for row in rows)
            for row in rows:
                error = row["std_error"]
                if row["held"]:
                    known = "(held)"
                elif error != error:
                    known = "(not determined)"
                else:
                    share = f" ({100 * abs(error / row['value']):.2f} %)" if row["value"] else ""
                    known = f"+/- {error:.3g}{share}"
                lines.append(f"    {row['name'] + ':':<{width + 1}} {row['value']:.7g} {row['unit']} {known}")
        if self.findings_:
            lines.append("[[Findings]]")
            lines += [f"    {finding}" for finding in self.findings_]
        return "\n".join(lines)

    def report(self, path: PathLike, name: str = "Identified model") -> None:
        """Write the report of the fit: a page that works offline and prints. Not after pickling."""
        self._fitted()
        if not hasattr(self, "_fit"):
            raise ModelError(
                "the records of a fit are not kept in a pickle: fit again for a report", code="no-records"
            )
        write_text(path, self._fit.report(name))

    # --- the model's own

    def predict(self, record: Record | Sequence[Record], **how: Any) -> Prediction | list[Prediction]:
        """See :meth:`Model.predict`; a list of records gives a list."""
        model = self._fitted()
        if isinstance(record, Record):
            return model.predict(record, **how)
        return [model.predict(one, **how) for one in record]

    def scores(self, record: Record | Sequence[Record], **how: Any) -> Score | list[Score]:
        """See :meth:`Model.scores`."""
        return self._fitted().scores(record, **how)

    def score(self, records: Record | Sequence[Record], y: None = None) -> float:
        """Mean of 1 − ‖e‖₂/‖y − ȳ‖₂ over records, simulated in free run: 1 is perfect."""
        found = self._fitted().scores(as_records(records))
        shares = [s.fit_percent or 0.0 for s in cast("list[Score]", found)]
        return sum(shares) / (100.0 * len(shares))

    def invert(self, reference: ArrayLike | Record, **how: Any) -> Inversion:
        """See :meth:`Model.invert`."""
        return self._fitted().invert(reference, **how)

    def controller(self, fs: float, **how: Any) -> Controller:
        """See :meth:`Model.controller`."""
        return self._fitted().controller(fs, **how)

    def track(self, reference: ArrayLike, fs: float, **how: Any) -> Tracking:
        """See :meth:`Model.track`."""
        return self._fitted().track(reference, fs, **how)

    def frequency_response(self, frequency_hz: ArrayLike | None = None) -> FrequencyResponse:
        """See :meth:`Model.frequency_response`."""
        return self._fitted().frequency_response(frequency_hz)

    def export(self, folder: PathLike, to: ExportForm = "c", **how: Any) -> list[str]:
        """See :meth:`Model.export`."""
        return self._fitted().export(folder, to, **how)

    def save(self, path: PathLike) -> None:
        """See :meth:`Model.save`."""
        self._fitted().save(path)


def _not_fitted() -> type[ModelError]:
    """The exception of an estimator that is not fitted; that of scikit-learn, too, where it is in use."""
    if "sklearn" not in sys.modules:
        return ModelError
    from sklearn.exceptions import NotFittedError

    return type("NotFittedError", (ModelError, NotFittedError), {})


def _number(value: Any) -> float:
    return float("nan") if value is None else float(value)


class Hammerstein(Estimator):
    """Hysteresis followed by linear dynamics with delay: y = offset + G(s) e^(−τs) · H[u].

    After L. Yang, Z. Zhao, Y. Zhang, D. Li, *Micromachines* 13 (2022) 42, doi:10.3390/mi13010042, which is
    ``hysteresis="bouc-wen"`` with ``dynamics="fractional"``. What is not given is chosen from the records;
    :func:`choices` lists the names.

    Args:
        hysteresis: family of the hysteresis block; ``"auto"`` takes the one with the smallest held-out error,
            of those that describe most stacks.
        dynamics: dynamic block.
        elements: elements of the family: plays, states, degree, …
        order: poles of ``dynamics="integer"`` or ``"modes"``.
        creep: creep factor of the dynamics.
        creep_elements: elements of ``creep="kelvin-voigt"``.
        degree: degree of the polynomial.
        n: Bouc–Wen exponent, or ``"free"``.
        delay: delay [s].
        scheme: simulation scheme of the dynamic block.
        inter_sample: inter-sample behaviour of the drive.
        method: ``"joint"``, or ``"two-step"`` as in the article.
        initial: initial state of each record.
        drift: allow for a linear drift of each record's output.
        continued: the records are consecutive parts of one run on one clock.
        fixed: parameters held at values.
        bounds: ranges of parameters.
        optimizer: optimiser instead of least squares from data-driven starts.
        population: its population, or number of starts.
        generations: generations of a population method.
        least_fit: least fit [%] for which a model is returned.
        input: input column of the records.
        output: output column.
        seed: seed of every random number.
        threads: threads; all cores if not given, 1 within workers of a pool. The result does not depend on
            it.
    """

    _kind = "hammerstein"

    def __init__(
        self,
        hysteresis: str | None = None,
        dynamics: str = "auto",
        *,
        elements: int | None = None,
        order: int | None = None,
        creep: str | None = None,
        creep_elements: int | None = None,
        degree: int | None = None,
        n: float | str | None = None,
        delay: float | None = None,
        scheme: str = "auto",
        inter_sample: str = "auto",
        method: str = "joint",
        initial: str = "auto",
        drift: bool = False,
        continued: bool = False,
        fixed: Mapping[str, float] | None = None,
        bounds: Mapping[str, tuple[float, float]] | None = None,
        optimizer: str = "auto",
        population: int | None = None,
        generations: int | None = None,
        least_fit: float = 75.0,
        input: str | None = None,
        output: str | None = None,
        seed: int = 1,
        threads: int | None = None,
    ) -> None:
        self.hysteresis = hysteresis
        self.dynamics = dynamics
        self.elements = elements
        self.order = order
        self.creep = creep
        self.creep_elements = creep_elements
        self.degree = degree
        self.n = n
        self.delay = delay
        self.scheme = scheme
        self.inter_sample = inter_sample
        self.method = method
        self.initial = initial
        self.drift = drift
        self.continued = continued
        self.fixed = fixed
        self.bounds = bounds
        self.optimizer = optimizer
        self.population = population
        self.generations = generations
        self.least_fit = least_fit
        self.input = input
        self.output = output
        self.seed = seed
        self.threads = threads

    def _options(self) -> dict[str, Any]:
        options = self.get_params()
        for column in ("input", "output"):
            options.pop(column)
        options["delay_s"] = options.pop("delay")
        options["least_fit_percent"] = options.pop("least_fit")
        options["fixed"] = None if self.fixed is None else dict(self.fixed)
        options["bounds"] = None if self.bounds is None else {k: list(v) for k, v in self.bounds.items()}
        return options

    def _columns(self) -> tuple[list[str], list[str]]:
        return [self.input] if self.input else [], [self.output] if self.output else []


class Oscillator(Estimator):
    """A mass on a hysteretic spring: m y″ + c y′ + k y + z = u, from records of force and displacement.

    Args:
        initial: initial state of each record.
        inter_sample: inter-sample behaviour of the force.
        fixed: parameters held at values: ``mass``, ``damping``, ``n``.
        least_fit: least fit [%] for which a model is returned.
        input: column of the force.
        output: column of the displacement.
    """

    _kind = "oscillator"

    def __init__(
        self,
        *,
        initial: str = "auto",
        inter_sample: str = "band-limited",
        fixed: Mapping[str, float] | None = None,
        least_fit: float = 75.0,
        input: str | None = None,
        output: str | None = None,
    ) -> None:
        self.initial = initial
        self.inter_sample = inter_sample
        self.fixed = fixed
        self.least_fit = least_fit
        self.input = input
        self.output = output

    def _options(self) -> dict[str, Any]:
        return {
            "initial": self.initial,
            "inter_sample": self.inter_sample,
            "fixed": [[name, value] for name, value in (self.fixed or {}).items()],
            "least_fit_percent": self.least_fit,
        }

    def _columns(self) -> tuple[list[str], list[str]]:
        return [self.input] if self.input else [], [self.output] if self.output else []


class Force(Estimator):
    """Force of a damper against its displacement: hysteresis of the displacement beside terms of its rate.

    Args:
        hysteresis: family of the hysteresis; one state that relaxes exponentially (``dahl`` with exponent 1)
            if not given.
        elements: size of the hysteresis block, for a family that has one.
        degree: degree of the polynomial of the displacement; 1: the stiffness alone.
        fixed: numbers held at values: those of the family's shape, ``viscous``, ``saturating_force``,
            ``saturating_rate``, ``saturating_reach``.
        rate_window_s: time over which the rate of the displacement is averaged [s]; a fiftieth of the
            period of the fastest swings if not given.
        least_fit: least fit [%] for which a model is returned.
        input: column of the displacement.
        output: column of the force.
    """

    _kind = "force"

    def __init__(
        self,
        *,
        hysteresis: str | None = None,
        elements: int | None = None,
        degree: int = 1,
        fixed: Mapping[str, float] | None = None,
        rate_window_s: float | None = None,
        least_fit: float = 75.0,
        input: str | None = None,
        output: str | None = None,
    ) -> None:
        self.hysteresis = hysteresis
        self.elements = elements
        self.degree = degree
        self.fixed = fixed
        self.rate_window_s = rate_window_s
        self.least_fit = least_fit
        self.input = input
        self.output = output

    def _options(self) -> dict[str, Any]:
        family: dict[str, Any] | None = None
        if self.hysteresis is not None:
            family = {"name": self.hysteresis}
            if self.elements is not None:
                family["elements"] = self.elements
        return {
            "hysteresis": family,
            "degree": self.degree,
            "fixed": [[name, value] for name, value in (self.fixed or {}).items()],
            "rate_window_s": self.rate_window_s,
            "least_fit_percent": self.least_fit,
        }

    def _columns(self) -> tuple[list[str], list[str]]:
        return [self.input] if self.input else [], [self.output] if self.output else []


class Modes(Estimator):
    """Structural modes with the hysteresis of each actuator in feedback, of several inputs and outputs.

    Args:
        inputs: names of the input columns.
        outputs: names of the output columns.
        modes: initial number of pole pairs; chosen by their fit to the response if not given.
        steps: simulation steps per sample.
        plays: plays of each actuator; 0: polynomials alone.
        hysteresis: include hysteresis; without it the modes are linear at each level.
        lag: initial corner frequency of the inputs' lags [Hz]; 0.8 of the highest excited frequency if not
            given.
        exponent: exponent of the level in the schedule of the modes; from the responses of three levels or
            more where they determine it, else 0.3, if not given.
        ridge: weight of the ridge that shrinks the change of the modes with the level towards one common
            relative shift.
        time_constant: time constant of the running level of a drive that is not periodic [s].
        iterations: iterations of the last search.
        whole_records: treat a record without a detectable period as one period of a steady state.
        least_fit: least fit [%] for which a model is returned.
    """

    _kind = "modes"

    def __init__(
        self,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        *,
        modes: int | None = None,
        steps: int = 2,
        plays: int = 6,
        hysteresis: bool = True,
        lag: float | None = None,
        exponent: float | None = None,
        ridge: float = 0.0,
        time_constant: float = 2.0,
        iterations: int = 12,
        whole_records: bool = False,
        least_fit: float = 75.0,
    ) -> None:
        self.inputs = inputs
        self.outputs = outputs
        self.modes = modes
        self.steps = steps
        self.plays = plays
        self.hysteresis = hysteresis
        self.lag = lag
        self.exponent = exponent
        self.ridge = ridge
        self.time_constant = time_constant
        self.iterations = iterations
        self.whole_records = whole_records
        self.least_fit = least_fit

    def _options(self) -> dict[str, Any]:
        options = self.get_params()
        for column in ("inputs", "outputs"):
            options.pop(column)
        options["lag_hz"] = options.pop("lag")
        options["time_constant_s"] = options.pop("time_constant")
        options["least_fit_percent"] = options.pop("least_fit")
        return options

    def _columns(self) -> tuple[list[str], list[str]]:
        return list(self.inputs), list(self.outputs)


class Branches(Estimator):
    """A sum of Hammerstein branches, of several inputs and outputs.

    Args:
        inputs: names of the input columns.
        outputs: names of the output columns.
        least_fit: least fit [%] for which a model is returned.
    """

    _kind = "branches"

    def __init__(
        self, inputs: Sequence[str] = (), outputs: Sequence[str] = (), *, least_fit: float = 75.0
    ) -> None:
        self.inputs = inputs
        self.outputs = outputs
        self.least_fit = least_fit

    def _options(self) -> dict[str, Any]:
        return {"least_fit_percent": self.least_fit}

    def _columns(self) -> tuple[list[str], list[str]]:
        return list(self.inputs), list(self.outputs)
