"""Where calibrations run: a pool of own processes, made anew where it breaks, or a given executor."""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor

from .._errors import HysteronError
from .work import Outcome, Task, calibrate_record

# Calibrations in flight where nothing says how many workers there are.
UNKNOWN = 64


def is_lost(error: BaseException) -> bool:
    """Whether a calibration ended because its worker did. Dask's exception is known by its name: it is not
    imported where Dask is not used."""
    return isinstance(error, BrokenExecutor | CancelledError) or type(error).__name__ == "KilledWorker"


def is_alive() -> bool:
    """Called in a new worker."""
    return True


class Workers:
    """Submits calibrations.

    Args:
        executor: a given one, which stays open; ``None`` for a pool of own processes.
        workers: processes of the own pool; a process a core if not given.
        in_flight: calibrations submitted and not finished, at most.
    """

    def __init__(self, executor: Executor | None, workers: int | None, in_flight: int | None) -> None:
        self._given = executor
        self._count = workers or _cores()
        self._pool: Executor | None = executor
        self.in_flight = in_flight or (2 * self._count + 2 if executor is None else _room(executor))

    def submit(self, task: Task) -> Future[Outcome]:
        """Submit a calibration; raises what :func:`is_lost` recognises where the executor is broken."""
        if self._pool is None:
            self._pool = self._made()
        return self._pool.submit(calibrate_record, task)

    def renew(self) -> None:
        """After a loss: end the broken pool of own processes; the next calibration makes another."""
        if self._given is None and self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def close(self) -> None:
        """End the own processes; calibrations that were not begun are dropped."""
        if self._given is None and self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def _made(self) -> Executor:
        # Not forked: threads of the library and open registries do not survive a fork.
        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(self._count, mp_context=context)
        try:
            # As many as there are workers, so that all start at once: the pool makes one a call.
            for started in [pool.submit(is_alive) for _ in range(self._count)]:
                started.result()
        except BrokenExecutor:
            pool.shutdown()
            raise HysteronError(
                "the worker processes end as they start: a script calls calibrate "
                'under  if __name__ == "__main__":',
                code="workers",
            ) from None
        return pool


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _room(executor: Executor) -> int:
    workers = getattr(executor, "_max_workers", None)
    if isinstance(workers, int):
        return 2 * workers + 2
    client = getattr(executor, "_client", None)
    if client is not None and hasattr(client, "ncores"):
        cores = sum(int(count) for count in client.ncores().values())
        return max(UNKNOWN, 4 * cores)
    return UNKNOWN
