"""Progress bars of long calls."""

from __future__ import annotations

import itertools
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

# Seconds before a bar appears, and between two updates.
_DELAY = 1.0
_EVERY = 0.1
_FORM = "{desc}: {percentage:3.0f}%|{bar}|{postfix} [{elapsed}<{remaining}]"


class Bar:
    """A progress bar of tqdm, in a terminal or a notebook. It appears when a task has taken a second, and vanishes at the end of the task."""

    _task: str | None = None
    _bar: Any = None
    _begun = _next = 0.0

    def __init__(self) -> None:
        with warnings.catch_warnings():
            # Notebooks without widgets show the bar as text.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm
        self._new = tqdm

    def __call__(self, task: str, done: int, of: int | None = None, numbers: str = "") -> None:
        """Shows the number of finished items of a task, and other numbers."""
        now = time.time()
        if task != self._task:
            self.close()
            self._task, self._begun, self._next = task, now, now + _DELAY
        if now < self._next:
            return
        self._next = now + _EVERY
        if self._bar is None:
            # The bar shows a fraction, because an adaptive grid changes the number of items.
            self._bar = self._new(desc=task, leave=False, total=1.0 if of else None, bar_format=_FORM if of else None)
            self._bar.start_t = self._begun
        self._bar.n = done / of if of else done
        self._bar.set_postfix_str(f"{done}/{of}{numbers}" if of else numbers)

    def close(self) -> None:
        """Ends a task."""
        if self._bar is not None:
            self._bar.close()
        self._bar = self._task = None


@contextmanager
def with_bar(callback: Callable[[Any, Any], Any] | None, progress: bool) -> Iterator[Callable[[Any, Any], Any] | None]:
    """A callback of an optimiser that shows a bar, if wanted, and calls the given one."""
    if not progress:
        yield callback
        return
    bar, numbers = Bar(), itertools.count()

    def called(iterate: Any, x: Any) -> Any:
        bar("iterates", next(numbers), None, f"J={iterate.value:.6g}, violation={iterate.violation:.1e}, stationarity={iterate.stationarity:.1e}")
        return callback(iterate, x) if callback else None

    try:
        yield called
    finally:
        bar.close()
