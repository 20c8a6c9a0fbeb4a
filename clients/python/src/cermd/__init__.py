"""Readings of a cermd daemon.

>>> import cermd
>>> for reading in cermd.readings("thumb"):  # doctest: +SKIP
...     print(reading.newtons, reading.newtons_u)
"""

from ._client import DEFAULT_SOCKET, CermdError, Readings, latest, readings, stats
from ._reading import Reading

__all__ = ["DEFAULT_SOCKET", "CermdError", "Reading", "Readings", "latest", "readings", "stats"]
