"""A force sensor as a device of gpiozero. No pin is touched: cermd has them."""

from __future__ import annotations

import threading
import time
from typing import Any, Iterator, Optional

from gpiozero import Device, EventsMixin
from gpiozero.threads import GPIOThread

from ._client import CermdError, Readings
from ._reading import Reading

# How long the thread waits for a reading before it looks whether the last one is still fresh.
_LOOK_S = 0.1


class _NoPins:
    """The clock of a pin factory, and nothing else of it."""

    def ticks(self) -> float:
        return time.monotonic()

    def ticks_diff(self, later: float, earlier: float) -> float:
        return later - earlier


class ForceSensor(EventsMixin, Device):  # type: ignore[misc]
    """A channel of cermd with a force. `value` is 0 to 1 of `full_scale`, or None where there is no number.

    Active from `threshold` on until the force is below `release` (0.8 of the threshold without it), there is no number,
    or nothing fresh is heard for `stale` seconds. Forces are in newtons. `error`: the CermdError for which nothing is heard,
    such as a channel that is no more.
    """

    def __init__(
        self,
        channel: str,
        *,
        full_scale: float = 10.0,
        threshold: float = 1.0,
        release: Optional[float] = None,
        stale: float = 1.0,
        socket: Optional[str] = None,
    ) -> None:
        self._readings: Optional[Readings] = None
        self._thread: Any = None
        self._last: Optional[Reading] = None
        self._pressed = False
        self._stopping = threading.Event()
        self.error: Optional[CermdError] = None
        super().__init__(pin_factory=_NoPins())
        self.channel = channel
        self.full_scale = full_scale
        self.threshold = threshold
        self.release = 0.8 * threshold if release is None else release
        self.stale = stale
        self._readings = Readings(channel, socket=socket)
        self._thread = GPIOThread(self._listen, (self._readings, self._stopping))
        self._thread.start()

    def _listen(self, readings: Readings, stopping: threading.Event) -> None:
        while not stopping.is_set():
            try:
                reading = readings.get(_LOOK_S)
                self.error = None
            except CermdError as error:
                # Nothing is known, which is an event, too; what is wrong may be put right.
                self.error, reading = error, None
                stopping.wait(_LOOK_S)
            if reading is not None:
                self._last = reading
            force = self.force
            self._pressed = force is not None and force >= (self.release if self._pressed else self.threshold)
            self._fire_events(self.pin_factory.ticks(), self._pressed)

    def close(self) -> None:
        """Ends the connection; no event comes any more."""
        readings, self._readings = getattr(self, "_readings", None), None
        thread, self._thread = getattr(self, "_thread", None), None
        if thread is not None:
            self._stopping.set()
        if readings is not None:
            readings.close()
        if thread is not None:
            thread.join()
        super().close()

    @property
    def closed(self) -> bool:
        return getattr(self, "_readings", None) is None

    @property
    def reading(self) -> Optional[Reading]:
        """The last reading while it is fresh."""
        last = self._last
        return last if last is not None and last.age() < self.stale else None

    @property
    def force(self) -> Optional[float]:
        """In newtons; None: unknown."""
        reading = self.reading
        return None if reading is None or not reading.is_ok else reading.newtons

    @property
    def value(self) -> Optional[float]:
        """0 to 1 of the full scale; None: unknown."""
        force = self.force
        return None if force is None else min(1.0, max(0.0, force / self.full_scale))

    @property
    def values(self) -> Iterator[float]:
        """`value` again and again, for the `source` of an output, which takes numbers only: 0.0 where nothing is known."""
        while not self.closed:
            yield self.value or 0.0

    @property
    def is_active(self) -> bool:
        return self._pressed and self.force is not None
