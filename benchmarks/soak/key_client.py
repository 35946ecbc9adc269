"""A client that makes keys, uses and revokes them, and the rotation of everybody's key."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock

from sqlalchemy.exc import SQLAlchemyError

from benchmarks.soak.client_calls import Answer, ClientCalls
from benchmarks.soak.request_history import Act
from jobs.home.home import Home
from jobs.records.keys import KeyTable, Scope

__all__ = ["KeyDesk", "key_client"]

PAUSE = 4.0  # seconds between two keys
HANDOVER = 2.0  # seconds in which the old and the new key work


class KeyDesk:
    """The making and revoking of keys, as `hgs keys` does."""

    def __init__(self, calls: ClientCalls, home: Home) -> None:
        """Work on the home's database."""
        self.calls, self.board = calls, calls.board
        self._home = home
        self._made = 0
        self._rotation = Lock()

    def add(self, scope: Scope) -> str:
        """Make a key, and return its name; "" where the database does not answer."""
        self._made += 1
        name = f"{self.calls.name}-{self._made}"

        def add(table: KeyTable) -> None:
            self.board.keys[name] = table.add(name, {scope})

        return name if self._noted(Act.ADD_KEY, name, add) else ""

    def revoke(self, name: str) -> None:
        """Take a key back."""
        self._noted(Act.REVOKE_KEY, name, lambda table: table.revoke(name))

    def use(self, name: str) -> None:
        """Ask for the scenes with a key, revoked or not."""
        text = self.board.keys[name]
        self.calls.note(Act.USE_KEY, name, lambda: self.calls.ask("GET", "/v1/scenes", key=text))

    def rotate(self) -> None:
        """Give all clients a new key, and revoke the one that they had; one rotation at a time."""
        with self._rotation:
            old = {text: name for name, text in self.board.keys.items()}.get(self.board.key)
            if name := self.add(Scope.ADMIN):
                self.board.key = self.board.keys[name]
                self.calls.rest(HANDOVER)
                if old is not None:
                    self.revoke(old)

    def _noted(self, act: Act, name: str, change: Callable[[KeyTable], object]) -> bool:
        def ask() -> Answer:
            try:
                table = KeyTable(self._home)
                try:
                    change(table)
                finally:
                    table.close()
            except (SQLAlchemyError, OSError):
                return Answer(0)
            return Answer(200)

        return self.calls.note(act, name, ask).acknowledged


def key_client(desk: KeyDesk) -> None:
    """Make keys until the soak is over; revoke most, and use revoked ones, too."""
    dice, revoked = desk.calls.dice, list[str]()
    while desk.calls.rest(PAUSE):
        if not (name := desk.add(Scope.VIEW)):
            continue
        desk.use(name)
        if dice.random() < 0.7:
            desk.revoke(name)
            revoked.append(name)
        if revoked:
            desk.use(dice.choice(revoked))
