"""Key of a calibration: SHA-256 of record bytes, options and program version."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .. import _native
from .._errors import OptionError
from ..estimators import Estimator

PROGRAM = f"hysteron_models {_native.__version__}"
BLOCK = 1 << 20
# Options that change no number of the result.
WITHOUT_EFFECT = ("threads",)


def hash_of(paths: Sequence[str]) -> str:
    """SHA-256 of the bytes of a file; of several files, that of their hashes in order.

    Raises:
        OSError: a file that cannot be read.
    """
    hashes = [_of_file(path) for path in paths]
    return hashes[0] if len(hashes) == 1 else hashlib.sha256("".join(hashes).encode()).hexdigest()


def _of_file(path: str) -> str:
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(BLOCK):
            digest.update(block)
    return digest.hexdigest()


def options_of(estimator: Estimator, reading: Mapping[str, Any]) -> str:
    """Estimator and options of reading as canonical JSON."""
    options = {name: value for name, value in estimator.get_params().items() if name not in WITHOUT_EFFECT}
    kind = type(estimator)
    named = (
        kind.__name__
        if kind.__module__.startswith("hysteron_models.")
        else f"{kind.__module__}.{kind.__qualname__}"
    )
    try:
        return json.dumps(
            {"estimator": named, "options": options, "reading": dict(reading)}, sort_keys=True, default=_plain
        )
    except (TypeError, ValueError) as error:
        raise OptionError(f"an option has no form as text: {error}", code="option") from None


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} {value!r}")


def key_of(record: str, options: str) -> str:
    """Key of a record, by its hash, under these options and this version of the program."""
    return hashlib.sha256("\n".join([record, options, PROGRAM]).encode()).hexdigest()
