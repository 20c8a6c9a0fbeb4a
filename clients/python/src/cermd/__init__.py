"""Readings of a cermd daemon.

>>> import cermd
>>> for reading in cermd.readings("thumb"):  # doctest: +SKIP
...     print(reading.newtons, reading.newtons_u)
"""

from ._client import DEFAULT_SOCKET, CermdError, Events, Readings, events, latest, readings, stats
from ._reading import Event, Reading

__all__ = [
    "DEFAULT_SOCKET",
    "CermdError",
    "Event",
    "Events",
    "Reading",
    "Readings",
    "events",
    "latest",
    "readings",
    "stats",
]
