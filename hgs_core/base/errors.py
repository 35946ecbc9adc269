"""The one exception that is the user's to fix."""

from __future__ import annotations

__all__ = ["InputError"]


class InputError(ValueError):
    """Bad input: a file, field or argument that the caller can correct.

    The message is one line: where, what is wrong with which value, and the cure. The command line prints it and
    exits with status 2; the API answers with a 4xx problem document.
    """

    def __init__(self, where: object, problem: str, cure: str = "") -> None:
        """Join `where` (a file, field or argument), `problem` and, if known, `cure` into one line."""
        self.where = str(where)
        self.problem = problem
        self.cure = cure
        super().__init__(f"{self.where}: {problem}" + (f"; {cure}" if cure else ""))

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str]]:
        """Let the line go from one process to another; of a subclass nothing else."""
        return InputError, (self.where, self.problem, self.cure)
