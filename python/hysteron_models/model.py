"""Models: predicted, simulated, scored, inverted, tracked, exported."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._errors import OptionError, with_arguments
from .record import Array, PathLike, Record, as_records, as_samples, natives
from .results import (
    Finding,
    FrequencyResponse,
    Inversion,
    Prediction,
    Realisation,
    Score,
    Tracking,
    per_output,
)

__all__ = ["Controller", "Model", "load"]

#: Form of an export.
ExportForm = Literal["c", "rust", "fmu", "matlab", "simulink"]


class Controller:
    """The inverse of a model, sample by sample: reference in, drive out.

    Made by :meth:`Model.controller`; it belongs to the thread that made it.
    """

    def __init__(self, native: _native.Controller) -> None:
        self._native = native

    def step(self, reference: float) -> float:
        """Drive for the newest sample of the reference."""
        return self._native.step(reference)

    def run(self, reference: ArrayLike) -> Array:
        """Drives for consecutive samples of the reference; the state is kept for the next call."""
        return self._native.run(as_samples(reference, "reference"))

    def rest_at(self, voltage: float) -> float:
        """Reset to rest at a voltage; return the displacement there."""
        return self._native.rest_at(voltage)

    @property
    def displacement(self) -> float:
        """Displacement predicted for the last drive."""
        return self._native.displacement

    @property
    def preview(self) -> int:
        """Preview of the reference [samples]."""
        return self._native.preview

    @property
    def fs(self) -> float:
        """Sample rate [Hz]."""
        return self._native.sample_rate_hz

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest drive."""
        return self._native.range


def _start(rest: float | None, settled: int | None) -> str | None:
    if rest is not None and settled is not None:
        raise OptionError("rest and settled exclude each other", code="start")
    if rest is not None:
        return json.dumps({"kind": "rest", "voltage_v": rest})
    if settled is not None:
        return json.dumps({"kind": "settled", "period_samples": settled})
    return None


def _inverting(
    limits: tuple[float, float] | None,
    slew: float | None,
    bandwidth: float | None,
    preview: int | None,
    predict_to: float | None,
    **more: Any,
) -> dict[str, Any]:
    options = {
        "range": None if limits is None else list(limits),
        "slew_per_s": slew,
        "bandwidth_hz": bandwidth,
        "preview": preview,
        "predict_to_hz": predict_to,
        **more,
    }
    return {key: value for key, value in options.items() if value is not None}


class Model:
    """An identified model of any kind. Read by :func:`load`, made by an estimator; pickles and copies."""

    def __init__(self, native: _native.Model) -> None:
        self._native = native

    def save(self, path: PathLike) -> None:
        """Write the model file, readable by every command of ``hysteron``; an existing file is replaced in
        one step."""
        self._native.save(path)

    def __reduce__(self) -> tuple[Any, ...]:
        return _of_json, (self._native.to_json(),)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self._native.to_json() == other._native.to_json()

    def __hash__(self) -> int:
        return hash(self._native.to_json())

    def __repr__(self) -> str:
        name = f" {self.name}" if self.name else ""
        return f"<Model{name}: {self.kind}; {self.valid_range or 'range not known'}>"

    @property
    def data(self) -> dict[str, Any]:
        """The model file, with every number, unit and standard error."""
        found: dict[str, Any] = json.loads(self._native.to_json())
        return found

    @property
    def kind(self) -> str:
        """``hammerstein``, ``oscillator``, ``force``, ``modes`` or ``branches``."""
        return self._native.kind

    @property
    def name(self) -> str | None:
        """Name of the device or the experiment."""
        return self._native.name

    @property
    def units(self) -> tuple[str, str]:
        """Units of input and output."""
        return self._native.units

    @property
    def fs(self) -> float | None:
        """Sample rate of the identification [Hz]."""
        return self._native.sample_rate_hz

    @property
    def valid_range(self) -> str | None:
        """Range of the records of the identification; outside of it the model extrapolates."""
        return self._native.valid_range

    @property
    def drive_range(self) -> tuple[float, float] | None:
        """Least and largest drive of the identification."""
        return self._native.drive_range

    def predict(
        self,
        record: Record,
        *,
        band: float | None = None,
        band_of: Literal["measurement", "output"] = "measurement",
        rest: float | None = None,
        settled: int | None = None,
        correct: bool = False,
    ) -> Prediction:
        """Predict the measurement: free run from the start that fits the record best, with the offset of its
        sensor.

        A record without an output is simulated from the start that the model assumes, with the model's own
        offset.

        Args:
            record: drive, and the measured output if there is one.
            band: level of a band around the output, e.g. 0.95.
            band_of: band of a new measurement, or of the model's output. Where that of a measurement rests on
                other devices rather than on the records of the identification, the remarks say so.
            rest: the device rested at this drive before the record.
            settled: the record is in steady state from the first sample, with this period in samples.
            correct: add the predicted misfit of a device outside the model class; refused where that gains
                nothing on left-out parts of the records of the identification.
        """
        if not self._is_measured(record):
            return self.simulate(
                record, band=band, band_of=band_of, rest=rest, settled=settled, correct=correct
            )
        (outputs, widths, start, remarks), offsets, measured = self._native.predict(
            record._native, record._input, record._output, _start(rest, settled), band, correct
        )
        return self._prediction(record, outputs, widths, start, remarks, band, band_of, offsets, measured)

    def simulate(
        self,
        drive: Record,
        *,
        band: float | None = None,
        band_of: Literal["measurement", "output"] = "output",
        rest: float | None = None,
        settled: int | None = None,
        correct: bool = False,
    ) -> Prediction:
        """Simulate the output for a drive, from the start that the model assumes, as ``hysteron simulate``
        does; arguments as of :meth:`predict`."""
        outputs, widths, start, remarks = self._native.simulate(
            drive._native, drive._input, _start(rest, settled), band, correct
        )
        return self._prediction(
            drive, outputs, widths, start, remarks, band, band_of, [0.0] * len(outputs), None
        )

    def _is_measured(self, record: Record) -> bool:
        channels = self._native.channels
        if channels is None:
            return len(record.channels) > 1
        return all(output in record.channels for output in channels[1])

    def _prediction(
        self,
        record: Record,
        outputs: list[Array],
        widths: tuple[Array, Array, list[str]] | None,
        start: str,
        remarks: list[tuple[str, str | None]],
        level: float | None,
        band_of: str,
        offsets: Sequence[float],
        measured: Array | None,
    ) -> Prediction:
        if band_of not in ("measurement", "output"):
            raise OptionError('band_of: expected "measurement" or "output"', code="band")
        y = outputs[0] if len(outputs) == 1 else np.column_stack(outputs)
        of_measurement, of_output, rests_on = widths or (None, None, [])
        is_of_measurement = band_of == "measurement"
        half = of_measurement if is_of_measurement else of_output
        return Prediction(
            t=record.t,
            y=y,
            lower=None if half is None else y - half,
            upper=None if half is None else y + half,
            unit=self.units[1],
            start=start,
            offset=per_output(offsets),
            measured=measured,
            level=level,
            remarks=(
                *(with_arguments(*remark) for remark in remarks),
                *(rests_on if is_of_measurement else []),
            ),
            name=record.name,
        )

    def scores(
        self,
        record: Record | Sequence[Record],
        *,
        continued: bool = False,
        skip: float | None = None,
        fixed_offset: bool = False,
        rest: float | None = None,
        settled: int | None = None,
        correct: bool = False,
    ) -> Score | list[Score]:
        """Score the model on records as ``hysteron validate`` does: free run, from the start that fits each
        best.

        Args:
            record: one record, or several.
            continued: the records are consecutive parts of one run on one clock; one score a run.
            skip: seconds at the start that are not scored.
            fixed_offset: use the model's own offset instead of one estimated for each sensor.
            rest: the device rested at this drive before the record, or before the run.
            settled: the record is in steady state, with this period in samples.
            correct: score the model corrected by the predicted misfit of a device outside the model class;
                ``details`` of the score has that of the model alone as ``without_correction``. Refused where it
                gains nothing on left-out parts of the records of the identification, and of a run.
        """
        if continued and correct:
            raise OptionError("the score of a run in parts is not corrected", code="correct")
        scoring = {"skip_s": skip, "offset": "fixed" if fixed_offset else "estimated"}
        before = _start(rest, settled)
        if continued:
            given = as_records(record)
            runs = self._native.score_continued(
                natives(given), json.dumps(scoring), given[0]._input, given[0]._output, before
            )
            found = [
                Score._of(given[0].name, figures, start, Record._of(series, "u", "y"), json.loads(text), skip)
                for text, figures, start, series in runs
            ]
            return found[0] if len(found) == 1 else found
        scores = []
        for one in as_records(record):
            text, figures, start, series = self._native.score(
                one._native, json.dumps(scoring), one._input, one._output, before, correct
            )
            scores.append(
                Score._of(one.name, figures, start, Record._of(series, "u", "y"), json.loads(text), skip)
            )
        return scores[0] if isinstance(record, Record) else scores

    def invert(
        self,
        reference: ArrayLike | Record,
        *,
        fs: float | None = None,
        limits: tuple[float, float] | None = None,
        slew: float | None = None,
        bandwidth: float | None = None,
        preview: int | None = None,
        predict_to: float | None = None,
        periodic: bool = False,
        rest: float | None = None,
        virgin: float | None = None,
        last: tuple[ArrayLike, ArrayLike] | None = None,
        correct: bool = False,
    ) -> Inversion:
        """Find the drive that makes the output follow a reference, in the unit of the output.

        Args:
            reference: samples, or a record with one channel.
            fs: sample rate [Hz] of the reference, which is the controller's.
            limits: least and largest drive; the range of the identification if not given.
            slew: largest rate of the drive, per second.
            bandwidth: frequency up to which the inverse follows [Hz]; a twentieth of the sample rate if not
                given.
            preview: samples known ahead; the whole reference is known if neither this nor ``predict_to`` is
                given.
            predict_to: beyond the preview, predict the reference as a random motion up to this frequency
                [Hz].
            periodic: the reference repeats.
            rest: the device rests at this drive before.
            virgin: drive at which it was demagnetised.
            last: drive and measured output of the last run of the same reference, for iterative learning.
            correct: correct the drive by the predicted misfit of a device outside the model class.
        """
        samples, rate = self._reference(reference, fs)
        learnt = None if last is None else (as_samples(last[0], "last[0]"), as_samples(last[1], "last[1]"))
        options = _inverting(
            limits,
            slew,
            bandwidth,
            preview,
            predict_to,
            periodic=periodic,
            rest_voltage=rest,
            virgin_voltage=virgin,
            correct=correct,
        )
        drive, predicted, text = self._native.invert(samples, rate, json.dumps(options), learnt)
        summary = json.loads(text)
        return Inversion(
            t=np.arange(len(samples)) / rate,
            u=drive,
            predicted=predicted,
            reference=samples,
            summary=summary,
            findings=tuple(Finding._of(f) for f in summary.get("findings", [])),
        )

    def _reference(self, reference: ArrayLike | Record, fs: float | None) -> tuple[Array, float]:
        """Samples of a reference and their rate [Hz]; the model's if it has none."""
        if isinstance(reference, Record):
            fs = fs or reference.fs
            reference = reference._native.samples(0)
        rate = fs or self.fs
        if rate is None:
            raise OptionError("the reference has no sample rate: give it with fs=…", code="no-sample-rate")
        return as_samples(reference, "reference"), rate

    def decouple(
        self,
        references: Sequence[ArrayLike] | Record,
        *,
        fs: float | None = None,
        limits: Sequence[tuple[float, float]] | None = None,
        slew: float | None = None,
        bandwidth: float | None = None,
        preview: int | None = None,
        level: float | None = None,
        periodic: bool = False,
    ) -> Inversion:
        """Find the drives of all actuators with which the outputs of several axes follow references.

        Args:
            references: samples of every output, or a record of them, in the order of the model's.
            fs: sample rate [Hz] of the references, which is the controller's; the model's if not given.
            limits: least and largest drive of every actuator; the range of the identification if not given.
            slew: largest rate of every drive, per second.
            bandwidth: frequency up to which the inverse follows [Hz]; a twentieth of the sample rate if not
                given, at most of the rate of the model's steps.
            preview: samples known ahead; the whole references are known if not given.
            level: rms of the drives at which the modes are taken.
            periodic: the references repeat.

        Returns:
            drives, predicted outputs and references, one row each.
        """
        if isinstance(references, Record):
            fs = fs or references.fs
            references = [references[name] for name in references.channels]
        rate = fs or self.fs
        if rate is None:
            raise OptionError("the references have no sample rate: give it with fs=…", code="no-sample-rate")
        rows = [as_samples(one, f"references[{i}]") for i, one in enumerate(references)]
        options = {
            "ranges": [list(one) for one in limits or ()],
            "slews_per_s": [] if slew is None else [slew],
            "bandwidth_hz": bandwidth,
            "preview": preview,
            "level": level,
            "periodic": periodic,
        }
        drives, predicted, text = self._native.decouple(rows, rate, json.dumps(options))
        return Inversion(
            t=np.arange(len(rows[0]) if rows else 0) / rate,
            u=np.array(drives),
            predicted=np.array(predicted),
            reference=np.array(rows),
            summary=json.loads(text),
        )

    def controller(
        self,
        fs: float,
        *,
        limits: tuple[float, float] | None = None,
        slew: float | None = None,
        bandwidth: float | None = None,
        preview: int | None = None,
        predict_to: float | None = None,
    ) -> Controller:
        """Make a controller at its rate [Hz]: reference in, drive out; arguments as of :meth:`invert`."""
        options = _inverting(limits, slew, bandwidth, preview, predict_to)
        return Controller(self._native.controller(fs, json.dumps(options)))

    def track(
        self,
        reference: ArrayLike | Record,
        fs: float | None = None,
        *,
        plant: Literal["rig", "model"] = "rig",
        controllers: Sequence[str] = (),
        limits: tuple[float, float] | None = None,
        slew: float | None = None,
        bandwidth: float | None = None,
        preview: int | None = None,
        predict_to: float | None = None,
        truth: dict[str, Any] | None = None,
        seed: int = 0,
        skip: float | None = None,
    ) -> Tracking:
        """Follow a reference in closed loop, on the simulated bench or on the model itself.

        Args:
            reference: samples, or a record with one channel, in the unit of the output.
            fs: rate of the controller [Hz]; that of the record or the model if not given.
            plant: ``"rig"``, the simulated bench, or ``"model"``, the model without noise.
            controllers: names of controllers; all, if none is given.
            limits: least and largest drive.
            slew: largest rate of the drive, per second.
            bandwidth: frequency up to which the inverse follows [Hz].
            preview: samples known ahead.
            predict_to: highest frequency that is predicted [Hz].
            truth: true parameters of the simulated bench.
            seed: seed of its noise.
            skip: seconds at the beginning that are not scored.
        """
        options: dict[str, Any] = {
            "controllers": list(controllers),
            "preview": preview,
            "predict_to_hz": predict_to,
            "bandwidth_hz": bandwidth,
            "range": None if limits is None else list(limits),
            "slew_per_s": slew,
            "skip_s": skip,
        }
        options = {key: value for key, value in options.items() if value is not None}
        samples, rate = self._reference(reference, fs)
        text, page, runs = self._native.track(
            samples, rate, json.dumps(options), plant, None if truth is None else json.dumps(truth), seed
        )
        return Tracking(
            t=np.arange(len(samples)) / rate,
            reference=samples,
            drives={name: drive for name, drive, _ in runs},
            displacements={name: displacement for name, _, displacement in runs},
            summary=json.loads(text),
            _page=page,
        )

    def frequency_response(self, frequency_hz: ArrayLike | None = None) -> FrequencyResponse:
        """Response of the dynamic block with its delay at frequencies [Hz]; 200 of them if none are given."""
        if frequency_hz is None:
            highest = 0.5 * (self.fs or 2e3)
            frequency_hz = np.geomspace(1e-4 * highest, highest, 200)
        frequencies = as_samples(frequency_hz, "frequency_hz")
        real, imaginary = self._native.frequency_response(frequencies)
        return FrequencyResponse(frequencies, real + 1j * imaginary)

    def realise(
        self, fs: float, *, accuracy: float = 1e-5, lowest_frequency: float | None = None
    ) -> Realisation:
        """Realise the dynamic block at a rate [Hz], as a controller runs it and as a state space."""
        text, (a, b, c, d) = self._native.realise(fs, accuracy, lowest_frequency)
        return Realisation(a.reshape(b.shape[0], b.shape[0]), b, c, d, fs, json.loads(text))

    def export(
        self,
        folder: PathLike,
        to: ExportForm = "c",
        *,
        fs: float | None = None,
        float_type: Literal["f32", "f64"] = "f64",
        name: str = "model",
        accuracy: float | None = None,
        lowest_frequency: float | None = None,
        date: str | None = None,
        inverse: bool = False,
        limits: tuple[float, float] | Sequence[tuple[float, float]] | None = None,
        slew: float | Sequence[float] | None = None,
        bandwidth: float | None = None,
        preview: int | None = None,
        predict_to: float | None = None,
        controller: str | None = None,
        level: float | None = None,
    ) -> list[str]:
        """Write the model, and its inverse if requested, as source for a controller; return the names of the
        files.

        Args:
            folder: folder to write to; made where there is none.
            to: C99, a ``no_std`` crate of Rust, an FMU, functions of MATLAB and GNU Octave, or C99 with a
                Simulink S-function.
            fs: the controller's rate [Hz]; that of the identification if not given.
            float_type: number type of the source.
            name: beginning of every name in it.
            accuracy: largest error of the realised dynamics, as a share of the gain at rest; a tenth of the
                model's least error on a record if not given, from 1e-5 to 1e-3.
            lowest_frequency: frequency down to which unbounded creep is realised [Hz].
            date: day in the headers; none if not given, and the source is the same on every day.
            inverse: write the inverse, too; the other arguments are those of :meth:`invert`, and of
                :meth:`decouple` for a model of several axes.
            limits: least and largest drive; of several axes one pair for all actuators or one each.
            slew: largest rate of the drive, per second; of several axes one for all actuators or one each.
            bandwidth: frequency up to which the inverse follows [Hz].
            preview: samples of the reference known ahead.
            predict_to: highest frequency that is predicted [Hz].
            controller: a controller of :meth:`track` around the inverse, e.g. ``feedforward-pi`` or
                ``feedforward-observer``: as C99, Rust or FMUs.
            level: rms of the drives at which the modes of a model of several axes are taken; the highest
                identified if not given.
        """
        ranges = [] if limits is None else [list(one) for one in np.reshape(limits, (-1, 2)).tolist()]
        slews = [] if slew is None else np.atleast_1d(slew).tolist()
        options: dict[str, Any] = {
            "to": to,
            "sample_rate_hz": fs,
            "controller": controller,
            "float": float_type,
            "name": name,
            "date": date,
        }
        if self._native.channels is not None:
            for option, given in [
                ("accuracy", accuracy),
                ("lowest_frequency", lowest_frequency),
                ("predict_to", predict_to),
            ]:
                if given is not None:
                    raise OptionError(f"{option} does not go with a model of several axes")
            law = {"bandwidth_hz": bandwidth, "preview": preview, "level": level}
            options |= {"inverse": inverse, "decoupling": {"ranges": ranges, "slews_per_s": slews, **law}}
        else:
            if len(ranges) > 1 or len(slews) > 1 or level is not None:
                raise OptionError("several limits and level go with models of several axes")
            one = tuple(ranges[0]) if ranges else None
            rate = slews[0] if slews else None
            own = _inverting(one, rate, bandwidth, preview, predict_to)
            options |= {
                "accuracy": accuracy,
                "lowest_frequency_hz": lowest_frequency,
                "inverse": own if inverse else None,
            }
        return self._native.export(folder, json.dumps(options))

    def adapt(
        self,
        record: Record,
        *,
        terms: Sequence[str] = ("offset", "gain"),
        method: Literal["rls", "nlms"] = "rls",
        memory: float | None = None,
        step: float = 0.05,
        noise: float | None = None,
        every: int | None = None,
        run_length: float = 1e6,
        reopen: bool = False,
    ) -> tuple[Model | None, dict[str, Any]]:
        """Correct the model over a record, sample by sample, as a controller would.

        Args:
            record: drive and measured output, uniformly sampled.
            terms: adapted coefficients: ``offset``, ``gain``, ``power=N``, ``creep=SECONDS``.
            method: recursive least squares, or normalised least mean squares.
            memory: memory of ``"rls"`` [s]; a fifth of the record if not given.
            step: step size of ``"nlms"``.
            noise: standard deviation of a residual where the model fits.
            every: update by one of so many samples.
            run_length: mean number of samples to a false alarm.
            reopen: reset the covariance of the coefficients after an alarm.

        Returns:
            The corrected model (``None`` with a term of creep, which a model cannot hold), and the result, as
            ``hysteron adapt --json`` prints it.
        """
        options = {
            "method": {"least-squares": {"memory_s": memory}}
            if method == "rls"
            else {"gradient": {"step": step}},
            "terms": list(terms),
            "noise": noise,
            "every": every,
            "run_length": run_length,
            "reopen": reopen,
        }
        text, native = self._native.adapt(record._native, json.dumps(options), record._input, record._output)
        return None if native is None else Model(native), json.loads(text)

    def recalibrate(
        self, records: Record | Sequence[Record], *, continued: bool = False, least_fit: float = 75.0
    ) -> tuple[Model, dict[str, Any]]:
        """Re-identify gain, delay and offset from short records, the rest held.

        Returns:
            The new model, and the result, as ``hysteron recalibrate --json`` prints it.
        """
        given = as_records(records)
        native, text = self._native.recalibrate(
            natives(given), given[0]._input, given[0]._output, continued, least_fit
        )
        return Model(native), json.loads(text)


def _of_json(text: str) -> Model:
    return Model(_native.Model.from_json(text))


def load(path: PathLike) -> Model:
    """Read a model file of any kind and version."""
    return Model(_native.Model.load(path))
