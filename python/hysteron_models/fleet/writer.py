"""The one writer of a registry: it waits for room on the disk and for the server, and loses nothing."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TypeVar

from sqlalchemy.exc import OperationalError

from .._errors import RegistryError
from .registry import Registry

# Between two attempts [s].
PAUSE_S = 2.0
T = TypeVar("T")


class Writer:
    """Writes to a registry, each call a transaction: whole, or not at all.

    A full disk, a locked file or a server that is away is waited for, ``patience`` seconds at most, while the
    workers finish what they have begun.
    """

    def __init__(self, registry: Registry, patience: float) -> None:
        self._registry = registry
        self._patience = patience

    def write(self, work: Callable[[Registry], T]) -> T:
        """Do ``work``.

        Raises:
            RegistryError: the registry could not be written for ``patience`` seconds.
        """
        begun, told = time.monotonic(), False
        while True:
            try:
                return work(self._registry)
            except OperationalError as error:
                reason = str(error.orig)
                if time.monotonic() - begun >= self._patience:
                    raise RegistryError(
                        f"{self._registry.shown} cannot be written: {reason}; what it holds is whole, and "
                        "the next run calibrates what is missing",
                        code="registry-not-written",
                    ) from error
            if not told:
                told = True
                print(
                    f"{self._registry.shown} cannot be written: {reason}; trying again for "
                    f"{self._patience:.0f} s",
                    file=sys.stderr,
                    flush=True,
                )
            # Connections to a server that was away are of no use.
            self._registry.engine.dispose()
            time.sleep(min(PAUSE_S, self._patience))
