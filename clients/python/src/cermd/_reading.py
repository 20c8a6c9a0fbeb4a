"""What is known of a sensor at an instant, and what its trigger said."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import Any, Mapping, Optional


@dataclass(frozen=True)
class Reading:
    """One reading. What is unknown is None; uncertainties are 1 sigma."""

    channel: str
    #: "ok": there is a number. "open": above ohms_min. "short": below ohms_max. "fault": see fault.
    status: str
    #: Counts the readings of the instrument.
    seq: int
    #: When it was measured, on the clock of time.monotonic_ns().
    monotonic_ns: int
    ohms: Optional[float] = None
    ohms_u: Optional[float] = None
    newtons: Optional[float] = None
    #: All of the force's uncertainty.
    newtons_u: Optional[float] = None
    #: That of the readout alone: how well two readings of one sensor can be told apart.
    newtons_repeat_u: Optional[float] = None
    #: What any channel shows, in `unit`: a force, what its law gives, or the resistance where it has neither.
    value: Optional[float] = None
    #: All of its uncertainty; None also where nobody has said how well the law is known.
    value_u: Optional[float] = None
    #: That of the readout alone; not of a resistance.
    value_repeat_u: Optional[float] = None
    #: Of the values: "N", "ohm", "degC", "lx", "mm", or as a table says.
    unit: Optional[str] = None
    value_min: Optional[float] = None
    value_max: Optional[float] = None
    ohms_min: Optional[float] = None
    ohms_max: Optional[float] = None
    newtons_min: Optional[float] = None
    newtons_max: Optional[float] = None
    #: Why there is no number: "missed-edge" and its like.
    fault: Optional[str] = None
    #: What on the board a fault looks like, for people.
    hint: Optional[str] = None
    #: The sensor changed while it was read; the uncertainty contains that.
    moving: bool = False
    #: The uncertainty is a guess: still a wide prior, or stamps are late often.
    settling: bool = False
    #: Force or value is outside of where its law holds.
    extrapolated: bool = False
    #: Readings that were missed since the one before.
    lost: int = 0
    #: Everything that the daemon said, also what this release does not know.
    raw: Mapping[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def is_ok(self) -> bool:
        """Whether there is a number."""
        return self.status == "ok"

    @property
    def time(self) -> datetime:
        """When it was measured, to the microsecond, UTC."""
        text = str(self.raw["time"]).rstrip("Z")
        whole, _, fraction = text.partition(".")
        instant = datetime.strptime(whole, "%Y-%m-%dT%H:%M:%S")
        return instant.replace(microsecond=int((fraction + "000000")[:6]), tzinfo=timezone.utc)

    def age(self) -> float:
        """Seconds since it was measured; of a daemon on this machine."""
        return (time.monotonic_ns() - self.monotonic_ns) * 1e-9

    @classmethod
    def of(cls, message: Mapping[str, Any]) -> Reading:
        """From a READING of the stream."""
        return cls(
            channel=message["channel"],
            status=message["status"],
            seq=message["seq"],
            monotonic_ns=message["t_mono_ns"],
            ohms=message.get("r_ohm"),
            ohms_u=message.get("r_u_ohm"),
            newtons=message.get("f_n"),
            value=message.get("value"),
            value_u=message.get("value_u"),
            value_repeat_u=message.get("value_repeat_u"),
            unit=message.get("unit"),
            value_min=message.get("value_min"),
            value_max=message.get("value_max"),
            newtons_u=message.get("f_u_n"),
            newtons_repeat_u=message.get("f_repeat_u_n"),
            ohms_min=message.get("r_min_ohm"),
            ohms_max=message.get("r_max_ohm"),
            newtons_min=message.get("f_min_n"),
            newtons_max=message.get("f_max_n"),
            fault=message.get("fault"),
            hint=message.get("hint"),
            moving=message.get("moving", False),
            settling=message.get("settling", False),
            extrapolated=message.get("extrapolated", False),
            lost=message.get("lost", 0),
            raw=message,
        )


@dataclass(frozen=True)
class Event:
    """What is known of the trigger of a channel has changed."""

    channel: str
    #: "pressed" or "released".
    event: str
    #: When that was so, on the clock of time.monotonic_ns().
    monotonic_ns: int
    #: Released, but not known to be: "fault" (readings without a number) or "stale" (no readings).
    reason: Optional[str] = None
    #: Everything that the daemon said, also what this release does not know.
    raw: Mapping[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def is_pressed(self) -> Optional[bool]:
        """Whether it is; None: not known."""
        return self.event == "pressed" if self.reason is None else None

    @classmethod
    def of(cls, message: Mapping[str, Any]) -> Event:
        """From an EVENT of the stream."""
        return cls(
            channel=message["channel"],
            event=message["event"],
            monotonic_ns=message["t_mono_ns"],
            reason=message.get("reason"),
            raw=message,
        )
