"""Locks that a forked process finds open."""

from __future__ import annotations

import os
import threading
import weakref


class Lock:
    """A lock for `with`. It is new in a forked process, where the thread that holds it does not exist.

    A signal handler may enter it again in the same thread if it is reentrant, and gets a `RuntimeError` otherwise.
    """

    __slots__ = ("__weakref__", "_depth", "_lock", "_reentrant")

    def __init__(self, *, reentrant: bool = False) -> None:
        self._lock = threading.RLock()
        self._depth = 0
        self._reentrant = reentrant
        _locks.add(self)

    def __enter__(self) -> None:
        self._lock.acquire()
        if self._depth > 0 and not self._reentrant:
            self._lock.release()
            raise RuntimeError("the scene is changed by a call that this one has interrupted: call it after that has returned")
        self._depth += 1

    def __exit__(self, *exception: object) -> None:
        self._depth -= 1
        self._lock.release()


_locks: weakref.WeakSet[Lock] = weakref.WeakSet()


def _renew() -> None:
    for lock in _locks:
        lock._lock = threading.RLock()
        lock._depth = 0


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew)
