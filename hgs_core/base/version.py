"""The version of this software."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

__all__ = ["software_version"]


def software_version() -> str:
    """Return the installed version of HGS; "0+unknown" in a checkout that is not installed."""
    try:
        return version("hgs")
    except PackageNotFoundError:
        return "0+unknown"
