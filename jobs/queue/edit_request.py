"""The request for an edited copy of a published scene, checked before anything is written."""

from __future__ import annotations

from dataclasses import dataclass

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import require_storable
from jobs.queue.job_request import MAX_TITLE, one_line

__all__ = ["EditRequest"]


@dataclass(frozen=True)
class EditRequest:
    """A published scene and the list of splats to leave out. The title defaults to the scene's."""

    scene: str
    splats: bytes  # a file of strangers: read in the job's first stage alone
    title: str = ""

    def __post_init__(self) -> None:
        """Check the title.

        Raises:
            InputError: it is too long or holds control characters.
        """
        require_storable("title", self.title, MAX_TITLE)
        if one_line(self.title) != self.title:
            raise InputError.of_field("title", f"{self.title!a} holds control characters", "give one line of text")
