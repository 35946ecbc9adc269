"""Progress bars on the terminal: one per stage, with its figures."""

from __future__ import annotations

from types import TracebackType
from typing import Any, Self

from tqdm import tqdm

from hgs_core.base.progress import Progress, StageStopped
from server.cli.interrupts import Interrupts
from server.cli.job_words import duration

__all__ = ["ProgressBars"]


class ProgressBars:
    """A `ProgressCallback` that draws on standard error; with `interrupts`, Ctrl-C stops the stage in order."""

    def __init__(self, interrupts: Interrupts | None = None) -> None:
        self._interrupts = interrupts
        self._stage = ""
        self._bar: Any = None

    def __call__(self, progress: Progress, left: float | None = None) -> None:
        """Draw a report, with the seconds that are left of everything, where these are known.

        Raises:
            StageStopped: the user pressed Ctrl-C.
        """
        if self._interrupts is not None and self._interrupts.pending:
            raise StageStopped
        if self._bar is None or progress.stage != self._stage:
            self.close()
            self._stage = progress.stage
            self._bar = tqdm(
                desc=f"{progress.stage:<10}", total=progress.total, dynamic_ncols=True, initial=progress.done
            )
        self._bar.total = progress.total
        figures = {name: _figure(value) for name, value in progress.figures.items()}
        if left is not None:
            figures = {"left": duration(left), **figures}
        if figures:
            self._bar.set_postfix(figures, refresh=False)
        self._bar.update(progress.done - self._bar.n)

    def close(self) -> None:
        """End the bar as it stands."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()


def _figure(value: float) -> str:
    return f"{value:.0f}" if float(value).is_integer() else f"{value:.4g}"
