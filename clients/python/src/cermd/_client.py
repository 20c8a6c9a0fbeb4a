"""The socket of the daemon."""

from __future__ import annotations

import json
import os
import socket as sockets
import time
from types import TracebackType
from typing import Any, Dict, Generic, Iterator, Optional, Type, TypeVar

from ._reading import Event, Reading

DEFAULT_SOCKET = "/run/cermd/cermd.sock"

_PROTO_MAJOR = 1
_MAX_LINE_BYTES = 64 * 1024
# A busy daemon answers well within it.
_ANSWER_S = 2.0
_RETRY_S = 0.5
# The least that a connection is given, whatever the caller's time-out.
_LEAST_S = 0.05
# Answers that are none: no reading yet, or lines lost to a slow reader.
_PASSING = ("no-reading", "lost")


class CermdError(Exception):
    """What went wrong, and what to do."""


class _Gone(CermdError):
    """The daemon is not there now: it may come back."""


class _Connection:
    """One connection; its first line, VERSION, has been read."""

    def __init__(self, path: str, patience: float = _ANSWER_S) -> None:
        self.path = path
        self._patience = min(patience, _ANSWER_S)
        self._bytes = bytearray()
        self._socket = sockets.socket(sockets.AF_UNIX, sockets.SOCK_STREAM)
        try:
            self._socket.settimeout(self._patience)
            self._socket.connect(path)
        except PermissionError as error:
            self.close()
            raise CermdError(
                f"no permission for {path}: be in its group (sudo usermod -aG cermd $USER), then log in again"
            ) from error
        except OSError as error:
            self.close()
            raise _Gone(f"{path}: {error.strerror or error}: is cermd running? (systemctl status cermd)") from error
        try:
            self.version = self._greeting()
        except BaseException:
            self.close()
            raise

    def _greeting(self) -> Dict[str, Any]:
        message = self.receive(self._patience)
        if message is None:
            raise _Gone(f"no answer from cermd at {self.path} within {self._patience:.1f} s")
        if message["class"] == "ERROR":
            raise _Gone(f"cermd refused the connection: {message['message']}")
        if message["class"] != "VERSION" or message["proto_major"] != _PROTO_MAJOR:
            raise CermdError(f"{self.path} is not of protocol {_PROTO_MAJOR}: install the same release of both")
        return message

    def send(self, request: Dict[str, Any]) -> None:
        try:
            self._socket.settimeout(_ANSWER_S)
            self._socket.sendall(json.dumps(request).encode() + b"\n")
        except OSError as error:
            raise _Gone(f"cermd closed the connection: {error}") from error

    def receive(self, timeout: Optional[float]) -> Optional[Dict[str, Any]]:
        """The next message; None: nothing in so many seconds. None as the time-out waits for ever."""
        until = None if timeout is None else time.monotonic() + timeout
        while True:
            end = self._bytes.find(b"\n")
            if end >= 0:
                line = bytes(self._bytes[:end])
                del self._bytes[: end + 1]
                return self._read(line)
            if len(self._bytes) > _MAX_LINE_BYTES:
                raise CermdError(f"{self.path} sends a line that never ends: it is no cermd")
            try:
                # With 0 it takes what has come and does not wait.
                self._socket.settimeout(None if until is None else max(0.0, until - time.monotonic()))
                chunk = self._socket.recv(16 * 1024)
            except (sockets.timeout, TimeoutError, BlockingIOError):
                return None
            except OSError as error:
                raise _Gone(f"connection to cermd: {error}") from error
            if not chunk:
                raise _Gone("cermd closed the connection; it was stopped or restarted")
            self._bytes += chunk

    def _read(self, line: bytes) -> Dict[str, Any]:
        try:
            message = json.loads(line)
        except ValueError as error:
            raise CermdError(f"{self.path} sent what is not JSON: {error}") from error
        if not isinstance(message, dict) or "class" not in message:
            raise CermdError(f"{self.path} sent what is not a message of cermd")
        return message

    def close(self) -> None:
        try:
            # Whoever waits in another thread wakes up.
            self._socket.shutdown(sockets.SHUT_RDWR)
        except OSError:
            pass
        self._socket.close()


_T = TypeVar("_T")
_S = TypeVar("_S", bound="_Stream[Any]")


class _Stream(Generic[_T]):
    """What comes of one class, for ever: connected again, unless asked not to, whenever the daemon restarts.

    An iterator and a context manager; `close` ends it, also from another thread.
    """

    _class = ""

    def __init__(
        self,
        *channels: str,
        socket: Optional[str] = None,
        max_hz: Optional[float] = None,
        reconnect: bool = True,
    ) -> None:
        self._channels = channels
        self._path = _path(socket)
        self._max_hz = max_hz
        self._reconnect = reconnect
        self._closed = False
        self._connection: Optional[_Connection] = None

    def _read(self, message: Dict[str, Any]) -> _T:
        raise NotImplementedError

    def get(self, timeout: Optional[float] = None) -> Optional[_T]:
        """The next one; None: there is none within so many seconds, or `close` was called.

        Raises CermdError where waiting does not help, and without reconnect also where it would."""
        until = None if timeout is None else time.monotonic() + timeout
        while not self._closed:
            left = None if until is None else max(0.0, until - time.monotonic())
            try:
                if self._connection is None:
                    # Never waited for in vain: a local daemon greets within milliseconds.
                    self._connect(_ANSWER_S if left is None else max(left, _LEAST_S))
                    if self._closed:
                        self._drop()
                    continue
                message = self._connection.receive(left)
            except _Gone:
                self._drop()
                if self._closed:
                    break
                if not self._reconnect:
                    raise
                if left is not None and left <= _RETRY_S:
                    time.sleep(left)
                    return None
                time.sleep(_RETRY_S)
                continue
            if message is None:
                return None
            if message["class"] == "VERSION":
                self._look_for_channels(message)
            # Other channels' are from before the request was read.
            if message["class"] == self._class and (not self._channels or message["channel"] in self._channels):
                return self._read(message)
            if message["class"] == "ERROR" and message["code"] not in _PASSING:
                raise CermdError(f"cermd: {message['message']}")
        return None

    def _look_for_channels(self, version: Dict[str, Any]) -> None:
        known = [channel["id"] for channel in version["channels"]]
        for channel in self._channels:
            if channel not in known:
                self._drop()
                raise CermdError(f'no channel "{channel}": there is {", ".join(known)}')

    def _connect(self, patience: float = _ANSWER_S) -> None:
        self._connection = connection = _Connection(self._path, patience)
        self._look_for_channels(connection.version)
        request: Dict[str, Any] = {"class": "WATCH"}
        if self._channels:
            request["channels"] = list(self._channels)
        if self._max_hz is not None:
            request["max_hz"] = self._max_hz
        connection.send(request)

    def _drop(self) -> None:
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.close()

    def close(self) -> None:
        """The end, also for who waits in another thread."""
        self._closed = True
        connection = self._connection
        if connection is not None:
            connection.close()

    def __iter__(self) -> Iterator[_T]:
        return self

    def __next__(self) -> _T:
        found = self.get()
        if found is None:
            raise StopIteration
        return found

    def __enter__(self: _S) -> _S:
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self.close()


class Readings(_Stream[Reading]):
    """Readings as they come."""

    _class = "READING"

    def _read(self, message: Dict[str, Any]) -> Reading:
        return Reading.of(message)


class Events(_Stream[Event]):
    """What the triggers of channels say; first, and after each restart of the daemon, what is so."""

    _class = "EVENT"

    def _read(self, message: Dict[str, Any]) -> Event:
        return Event.of(message)


def readings(
    *channels: str, socket: Optional[str] = None, max_hz: Optional[float] = None, reconnect: bool = True
) -> Readings:
    """Readings of these channels, or of all; at most max_hz of each a second."""
    return Readings(*channels, socket=socket, max_hz=max_hz, reconnect=reconnect)


def events(*channels: str, socket: Optional[str] = None, reconnect: bool = True) -> Events:
    """Events of these channels, or of all that have a trigger. While the daemon is gone nothing comes."""
    # Readings come besides, and are passed over: one a minute of each.
    return Events(*channels, socket=socket, max_hz=1 / 60, reconnect=reconnect)


def latest(channel: str, socket: Optional[str] = None, timeout: float = 5.0) -> Reading:
    """The last reading of a channel; of an instrument that has just started, the first one.

    Raises CermdError if there is no daemon, no such channel, or no reading within the time-out (s)."""
    with Readings(channel, socket=socket, reconnect=False) as stream:
        stream._connect()
        assert stream._connection is not None
        stream._connection.send({"class": "POLL"})
        reading = stream.get(timeout)
    if reading is None:
        raise CermdError(f"no reading of {channel} within {timeout} s: cermctl stats tells whether cermd measures")
    return reading


def stats(socket: Optional[str] = None) -> Dict[str, Any]:
    """What the daemon has counted and learned: STATS of the protocol; units stand in the names."""
    connection = _Connection(_path(socket))
    try:
        connection.send({"class": "STATS"})
        until = time.monotonic() + _ANSWER_S
        while True:
            message = connection.receive(max(0.0, until - time.monotonic()))
            if message is None:
                raise CermdError(f"no answer from cermd at {connection.path} within {_ANSWER_S} s")
            if message["class"] == "STATS":
                return message
    finally:
        connection.close()


def _path(socket: Optional[str]) -> str:
    return socket or os.environ.get("CERMD_SOCKET") or DEFAULT_SOCKET
