"""Runs calibrations on workers that may die, a bounded number in flight."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from queue import SimpleQueue

from .work import Outcome, Task, failed
from .workers import Workers, is_lost

Deliver = Callable[[Task, Outcome], object]


def run(tasks: Iterator[Task], workers: Workers, deliver: Deliver, retries: int) -> None:
    """Calibrate, and deliver every outcome in this thread, in the order in which they finish.

    Calibrations whose worker died are repeated one at a time, with nothing else in flight: one that ends its
    worker is then known, and takes no other with it. After more than ``retries`` losses alone it has failed.
    """
    schedule = _Schedule(workers, deliver, retries)
    try:
        schedule.run(tasks)
    except BaseException:
        for future in schedule.flying:
            future.cancel()
        raise


class _Schedule:
    def __init__(self, workers: Workers, deliver: Deliver, retries: int) -> None:
        self._workers, self._deliver, self._retries = workers, deliver, retries
        self._finished: SimpleQueue[Future[Outcome]] = SimpleQueue()
        self.flying: dict[Future[Outcome], Task] = {}
        self._suspects: deque[Task] = deque()
        self._alone: Task | None = None
        self._losses: Counter[str] = Counter()

    def run(self, tasks: Iterator[Task]) -> None:
        exhausted = False
        while True:
            while not exhausted and not self._suspects and not self._alone and self._has_room():
                task = next(tasks, None)
                if task is None:
                    exhausted = True
                else:
                    self._begin(task)
            if not self.flying and self._suspects:
                self._alone = self._suspects.popleft()
                self._begin(self._alone)
            if self.flying:
                self._end(self._finished.get())
            elif exhausted and not self._suspects:
                return

    def _has_room(self) -> bool:
        return len(self.flying) < self._workers.in_flight

    def _begin(self, task: Task) -> None:
        try:
            future = self._workers.submit(task)
        except (RuntimeError, CancelledError) as error:  # broken, or shut down
            self._lose(task, error)
            return
        self.flying[future] = task
        future.add_done_callback(self._finished.put)

    def _end(self, future: Future[Outcome]) -> None:
        task = self.flying.pop(future)
        error = CancelledError("dropped by its executor") if future.cancelled() else future.exception()
        if error is not None and is_lost(error):
            self._lose(task, error)
            return
        self._alone = None
        self._deliver(task, future.result() if error is None else _raised(error))

    def _lose(self, task: Task, error: BaseException) -> None:
        self._workers.renew()
        if self._alone is task:
            self._alone = None
            self._losses[task.key] += 1
        losses = self._losses[task.key]
        if losses > self._retries:
            reason = f"its worker ended {losses} times: {str(error) or type(error).__name__}"
            self._deliver(task, failed(reason, "machine"))
        else:
            self._suspects.append(task)


def _raised(error: BaseException) -> Outcome:
    return failed(f"{type(error).__name__}: {error}", "machine")
