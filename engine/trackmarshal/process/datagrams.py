"""Datagrams on this machine, to and from a Supervisor that is a process of its own."""

from __future__ import annotations

import socket

from .messages import Layout, LinkError

_HERE = "127.0.0.1"
_ROOM = 1 << 20
#: s: of more, a socket counts milliseconds in an int, and does so wrong; it is waited without an end.
_LONG = 1e6


class Datagrams:
    """What a client sends to a port and hears from it. executing: it listens at this port (`--to` of the Supervisor) and sends nothing."""

    def __init__(self, layout: Layout, port: int, executing: bool = False) -> None:
        if not layout.datagrams:
            raise LinkError("a message is too long for a datagram: shared memory, or smaller capacities")
        self._longest = layout.longest
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _ROOM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _ROOM)
        if executing:
            self._socket.bind((_HERE, port))
        else:
            self._socket.connect((_HERE, port))

    @property
    def port(self) -> int:
        """This side's own."""
        return int(self._socket.getsockname()[1])

    def send(self, box: str, message: bytearray) -> bool:
        """Whether it went out; nobody knows whether it arrives. box: what shared memory has a mailbox for."""
        try:
            return self._socket.send(message) == len(message)
        except OSError:  # nobody listens, or not now
            return False

    def receive(self, seconds: float) -> bytes | None:
        """The next message; None where none comes."""
        self._socket.settimeout(None if seconds > _LONG else seconds if seconds > 0.0 else 0.0)
        try:
            return self._socket.recv(self._longest + 1)
        except OSError:
            return None

    def close(self) -> None:
        self._socket.close()
