"""Where the emulated line comes out: a pseudo-terminal, or a TCP port for those who ask for one."""

import os
import select
import socket
import tty
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit

from scout_driver.errors import ScoutError

CHUNK = 4096


class PortError(ScoutError):
    """The emulator cannot open the end of the line it was told to."""


class Port(Protocol):
    """The computer's end of the line, as the emulator holds it."""

    address: str
    """What a driver opens: a device path, or tcp://host:port."""

    def read(self, timeout_s: float) -> bytes:
        """Wait up to ``timeout_s`` wall seconds for bytes from the computer."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes to the computer; they are lost if it does not listen."""
        ...

    def unplug(self) -> None:
        """Take the line away; whoever had it open notices."""
        ...

    def plug(self) -> None:
        """Put the line back."""
        ...


class PtyPort:
    """A pseudo-terminal, found under a link of a fixed name if one is given."""

    def __init__(self, link: str = "") -> None:
        """Open it; raises PortError."""
        self._link = Path(link) if link else None
        self._master = self._slave = -1
        self.address = ""
        self.plug()

    def read(self, timeout_s: float) -> bytes:
        """Wait for bytes."""
        if self._master < 0:
            select.select([], [], [], timeout_s)
            return b""
        ready, _, _ = select.select([self._master], [], [], timeout_s)
        return os.read(self._master, CHUNK) if ready else b""

    def write(self, data: bytes) -> None:
        """Send bytes, as far as the terminal's buffer takes them."""
        if self._master >= 0 and select.select([], [self._master], [], 0.0)[1]:
            os.write(self._master, data)

    def unplug(self) -> None:
        """Close both ends."""
        if self._master >= 0:
            if self._link is not None:
                self._link.unlink(missing_ok=True)
            os.close(self._slave)
            os.close(self._master)
            self._master = self._slave = -1

    def plug(self) -> None:
        """Open a new terminal; our own hold on its far end keeps it alive between two drivers."""
        try:
            self._master, self._slave = os.openpty()
            tty.setraw(self._slave)
            self.address = os.ttyname(self._slave)
            if self._link is not None:
                if self._link.is_symlink():
                    self._link.unlink()
                self._link.symlink_to(self.address)
                self.address = str(self._link)
        except OSError as error:
            raise PortError(f"cannot open a pseudo-terminal: {error}") from error


class TcpPort:
    """One TCP client at a time; listens on the address asked for and no other."""

    def __init__(self, host: str, port: int) -> None:
        """Listen; raises PortError."""
        try:
            self._listener = socket.create_server((host, port), backlog=1)
        except OSError as error:
            raise PortError(f"cannot listen on {host}:{port}: {error}") from error
        self.address = f"tcp://{host}:{self._listener.getsockname()[1]}"
        self._client: socket.socket | None = None
        self._plugged = True

    def read(self, timeout_s: float) -> bytes:
        """Wait for bytes, or for a client."""
        if not self._plugged:
            select.select([], [], [], timeout_s)
            return b""
        waited = self._client or self._listener
        if not select.select([waited], [], [], timeout_s)[0]:
            return b""
        if self._client is None:
            self._client = self._listener.accept()[0]
            self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return b""
        try:
            data = self._client.recv(CHUNK)
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        return data

    def write(self, data: bytes) -> None:
        """Send bytes."""
        if self._client is not None:
            try:
                self._client.sendall(data)
            except OSError:
                self._hang_up()

    def unplug(self) -> None:
        """Hang up and take no calls."""
        self._hang_up()
        self._plugged = False

    def plug(self) -> None:
        """Take calls again."""
        self._plugged = True

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = None


def open_port(address: str) -> Port:
    """Open ``tcp://host:port``, or a pseudo-terminal linked from the path ``address`` (none if empty)."""
    if not address.startswith("tcp://"):
        return PtyPort(address)
    try:
        parts = urlsplit(address)
        host, number = parts.hostname, parts.port
    except ValueError as error:
        raise PortError(f"'{address}' is no tcp://host:port: {error}") from error
    if host is None or number is None:
        raise PortError(f"'{address}' is no tcp://host:port")
    return TcpPort(host, number)
