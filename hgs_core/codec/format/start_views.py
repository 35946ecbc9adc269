"""The first views of a scene: a camera, and the part of its picture to keep in view (docs/format.md, "Start views")."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

from hgs_core.codec.format.json_fields import Field

__all__ = ["StartView", "StartViews"]


@dataclass(frozen=True)
class StartView:
    """A camera of the manifest, and a box in the plane of its picture."""

    camera: str  # name
    box: tuple[float, float, float, float]  # left, top, right, bottom, pixels; may reach beyond the picture

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        return {"camera": self.camera, "box": list(self.box)}

    @classmethod
    def read(cls, field: Field, cameras: Collection[str]) -> StartView:
        """Read the plain form.

        Raises:
            InputError: names the field, the value and the expectation.
        """
        name = field["camera"].text()
        if name not in cameras:
            raise field["camera"].error(f"is {name!r}, expected one of {', '.join(sorted(cameras))}")
        left, top, right, bottom = field["box"].numbers(4)
        if not (left < right and top < bottom):
            raise field["box"].error(f"is {field['box'].value!r}, expected left, top, right and bottom in this order")
        return cls(name, (left, top, right, bottom))


@dataclass(frozen=True)
class StartViews:
    """The start on a screen that is no higher than wide, and on an upright one."""

    wide: StartView
    tall: StartView

    def to_json(self) -> list[dict[str, Any]]:
        """Return the plain form: the two in this order."""
        return [self.wide.to_json(), self.tall.to_json()]

    @classmethod
    def read(cls, field: Field, cameras: Collection[str]) -> StartViews:
        """Read the plain form; raises the errors of `StartView.read`."""
        wide, tall = field.items(2)
        return cls(StartView.read(wide, cameras), StartView.read(tall, cameras))
