"""Ways to the base: a serial port or a TCP connection, behind one small interface.

Nothing here listens: a TCP transport is always the one that connects.
"""

import os
import select
import socket
import time
from collections.abc import Callable
from typing import Protocol
from urllib.parse import urlsplit

import serial

from scout_driver.errors import LineLostError

CHUNK = 4096
CONNECT_TIMEOUT_S = 2.0
PATIENCE_S = 0.2
"""How often a long wait looks up."""


class Transport(Protocol):
    """A two-way stream of bytes; every method raises LineLostError once the line is gone."""

    def write(self, data: bytes) -> None:
        """Send ``data``."""
        ...

    def read(self, timeout_s: float, settle_s: float = 0.0) -> bytes:
        """Wait up to ``timeout_s`` robot seconds for bytes and return what is there, maybe nothing.

        ``settle_s`` is waited first in any case: woken up once for many bytes is cheaper than for each few.
        """
        ...

    def close(self) -> None:
        """Let the line go; never raises."""
        ...


class SerialTransport:
    """A serial port: 8 data bits, no parity, 1 stop bit, no flow control, for this process alone."""

    def __init__(self, path: str, baud: int, time_factor: float = 1.0) -> None:
        """Open ``path``; ``time_factor`` is robot seconds a wall second. Raises LineLostError."""
        self._time_factor = time_factor
        try:
            self._port = serial.Serial(path, baud, timeout=0, write_timeout=1.0, exclusive=True)
        except (OSError, ValueError) as error:
            raise LineLostError(f"cannot open serial port {path}: {error}") from error
        self._descriptor = self._port.fileno()

    def write(self, data: bytes) -> None:
        """Send ``data``."""
        try:
            self._port.write(data)
        except OSError as error:
            raise LineLostError(f"serial port lost while writing: {error}") from error

    def read(self, timeout_s: float, settle_s: float = 0.0) -> bytes:
        """Wait up to ``timeout_s`` robot seconds for bytes, after ``settle_s`` in any case."""
        if settle_s > 0.0:
            time.sleep(settle_s / self._time_factor)
        try:
            if not select.select([self._descriptor], [], [], max(0.0, timeout_s / self._time_factor))[0]:
                return b""
            # pyserial's own read would wait a second time and cost as much again.
            data = os.read(self._descriptor, CHUNK)
        except OSError as error:
            raise LineLostError(f"serial port lost while reading: {error}") from error
        if not data:
            raise LineLostError("serial port lost while reading: nothing there")
        return data

    def close(self) -> None:
        """Close the port."""
        try:
            self._port.close()
        except OSError:
            return  # unplugged: there is nothing left to close


class TcpTransport:
    """A TCP connection to a serial server or to the emulator."""

    def __init__(self, host: str, port: int, time_factor: float = 1.0) -> None:
        """Connect; ``time_factor`` is robot seconds a wall second. Raises LineLostError."""
        self._time_factor = time_factor
        try:
            self._socket = socket.create_connection((host, port), CONNECT_TIMEOUT_S)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            raise LineLostError(f"cannot connect to {host}:{port}: {error}") from error

    def write(self, data: bytes) -> None:
        """Send ``data``."""
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise LineLostError(f"connection lost while writing: {error}") from error

    def read(self, timeout_s: float, settle_s: float = 0.0) -> bytes:
        """Wait up to ``timeout_s`` robot seconds for bytes, after ``settle_s`` in any case."""
        if settle_s > 0.0:
            time.sleep(settle_s / self._time_factor)
        try:
            ready, _, _ = select.select([self._socket], [], [], max(0.0, timeout_s / self._time_factor))
            data = self._socket.recv(CHUNK) if ready else None
        except (OSError, ValueError) as error:
            raise LineLostError(f"connection lost while reading: {error}") from error
        if data == b"":
            raise LineLostError("the other side closed the connection")
        return data or b""

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()


class PatientTransport:
    """A transport for lock-step: waits as long as it is told to, but no longer than somebody wants the answer."""

    def __init__(self, inner: Transport, wanted: Callable[[], bool]) -> None:
        """Take over ``inner``; ``wanted`` turns False when the run is over."""
        self._inner, self._wanted = inner, wanted
        self.write, self.close = inner.write, inner.close

    def read(self, timeout_s: float, settle_s: float = 0.0) -> bytes:
        """Wait up to ``timeout_s``; raises LineLostError when the bytes are no longer wanted."""
        left_s = timeout_s
        while True:
            data = self._inner.read(min(left_s, PATIENCE_S), settle_s)
            left_s -= PATIENCE_S
            if data or left_s <= 0.0:
                return data
            if not self._wanted():
                raise LineLostError("given up")


def open_transport(port: str, baud: int, time_factor: float = 1.0) -> Transport:
    """Open ``port``: a device path, or ``tcp://host:port``; raises LineLostError."""
    if not port.startswith("tcp://"):
        return SerialTransport(port, baud, time_factor)
    try:
        parts = urlsplit(port)
        host, number = parts.hostname, parts.port
    except ValueError as error:
        raise LineLostError(f"'{port}' is no tcp://host:port: {error}") from error
    if host is None or number is None:
        raise LineLostError(f"'{port}' is no tcp://host:port")
    return TcpTransport(host, number, time_factor)
