"""What the computer may ask of the base, to and from frames.

Wheel speeds are in 0.1 in/s, accelerations in 0.1 in/s^2, lengths in 0.1 in, angles in 0.1 deg.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

from scout_driver.errors import ProtocolError
from scout_driver.protocol.framing import Frame
from scout_driver.protocol.numbers import decode_signed, decode_unsigned, encode_signed, encode_unsigned

SONARS = 16
ORDER_END = 255
"""In a firing order: no further sonar."""
NAK = 8
"""TYPE of the base's refusal; never a command."""


class CommandKind(IntEnum):
    """TYPE of each command, with its mnemonic in the vendor's library."""

    ACCELERATION = 1  # AC: right, left, 0
    SPEED = 2  # SP, for MOVE: right, left, 0
    MOVE = 3  # PR: right, left, 0
    VELOCITY = 5  # VM: right, left, 0
    STATE = 7  # GS
    STOP = 9  # ST: stop and hold the position
    LIMP = 10  # LP: motors off
    DEFINE_POSITION = 12  # DP: x, y
    ZERO = 13  # ZR
    CONFIGURE_SONAR = 15  # CONF_SN: 4 ms units a ping, then the firing order
    CONFIGURE_WATCHDOG = 18  # CONF_TM: seconds, 0 = none
    GET_SONAR = 20  # GET_SN
    GET_POSE = 21  # GET_RC
    GET_VELOCITY = 22  # GET_RV
    GET_BUMPER = 27  # GET_BP
    DEFINE_ANGLE = 30  # DA: steer, turret
    WAIT_STOPPED = 31  # WS: three axis flags, time-out in s


_LAYOUT: dict[CommandKind, str] = dict.fromkeys(CommandKind, "") | {
    CommandKind.ACCELERATION: "uuu",
    CommandKind.SPEED: "uuu",
    CommandKind.MOVE: "sss",
    CommandKind.VELOCITY: "sss",
    CommandKind.DEFINE_POSITION: "ss",
    CommandKind.CONFIGURE_SONAR: "b" * (1 + SONARS),
    CommandKind.CONFIGURE_WATCHDOG: "b",
    CommandKind.DEFINE_ANGLE: "ss",
    CommandKind.WAIT_STOPPED: "bbbb",
}
"""DATA of each command: s = signed 16 bit, u = unsigned 16 bit, b = byte."""
_SIZE = {"s": 2, "u": 2, "b": 1}


class Command(NamedTuple):
    """One command with its values in wire units, in wire order."""

    kind: CommandKind
    values: tuple[int, ...] = ()


def wheel_command(kind: CommandKind, right: int, left: int) -> Command:
    """Return a command with one value a wheel (the third axis is 0 on a Scout)."""
    return Command(kind, (right, left, 0))


def sonar_command(rate: int, order: Sequence[int]) -> Command:
    """Return the sonar configuration: ``rate`` in 4 ms units a ping, and the sonars in order of firing."""
    padding = (ORDER_END,) * (SONARS - len(order))
    return Command(CommandKind.CONFIGURE_SONAR, (rate, *order, *padding))


def command_to_frame(command: Command) -> Frame:
    """Return the frame of ``command``; raises ProtocolError if a value does not fit or the count is wrong."""
    layout = _LAYOUT[command.kind]
    if len(layout) != len(command.values):
        raise ProtocolError(f"{command.kind.name} takes {len(layout)} values, not {len(command.values)}")
    data = b"".join(
        encode_signed(value) if code == "s" else encode_unsigned(value, _SIZE[code])
        for code, value in zip(layout, command.values, strict=True)
    )
    return Frame(command.kind, data)


def command_from_frame(frame: Frame) -> Command:
    """Return the command in ``frame``; raises ProtocolError if it is none or its length is wrong."""
    try:
        kind = CommandKind(frame.kind)
    except ValueError:
        raise ProtocolError(f"type {frame.kind} is no command") from None
    layout = _LAYOUT[kind]
    if sum(_SIZE[code] for code in layout) != len(frame.data):
        raise ProtocolError(f"{kind.name} with {len(frame.data)} bytes of data")
    values, offset = [], 0
    for code in layout:
        size = _SIZE[code]
        read = decode_signed(frame.data, offset) if code == "s" else decode_unsigned(frame.data, offset, size)
        values.append(read)
        offset += size
    return Command(kind, tuple(values))
