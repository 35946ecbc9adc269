"""pycolmap, without the side effects of its import.

Importing it replaces the handlers of SIGTERM and of faults by glog's, which print a C++ stack trace and abort: a stage
that is asked to stop would die instead of saving. So the handlers are put back here, and pycolmap is imported nowhere
else. Of the other libraries in use none touches a handler when it is imported (torch, av, cv2, dbos, uvicorn, obstore,
psycopg).
"""

from __future__ import annotations

import ctypes
import signal
from collections.abc import Iterator
from contextlib import contextmanager

from PIL import Image as Image  # ahead of pycolmap: the other way round, saving a PNG corrupts the heap

__all__ = ["pycolmap"]

# Python's own way to set a handler of the system. Unlike signal.signal it works in every thread, and with handlers
# that were not set in Python.
_handler_of = ctypes.pythonapi.PyOS_getsig
_handler_of.argtypes, _handler_of.restype = [ctypes.c_int], ctypes.c_void_p
_set_handler = ctypes.pythonapi.PyOS_setsig
_set_handler.argtypes, _set_handler.restype = [ctypes.c_int, ctypes.c_void_p], ctypes.c_void_p


@contextmanager
def _same_handlers() -> Iterator[None]:
    """Put back the handlers that change inside this context."""
    signals = signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP}
    before = {number: _handler_of(number) for number in signals}
    try:
        yield
    finally:
        for number, handler in before.items():
            if _handler_of(number) != handler:
                _set_handler(number, handler)


with _same_handlers():
    import pycolmap
