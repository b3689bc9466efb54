"""What the base answers: its whole state to most commands, or one group of values to the GET_* commands.

Offsets in the comments count from the start of the frame, as in the vendor's library; DATA begins at 4.
"""

from dataclasses import dataclass
from typing import NamedTuple

from scout_driver.errors import ProtocolError
from scout_driver.protocol.commands import SONARS, CommandKind
from scout_driver.protocol.framing import Frame
from scout_driver.protocol.numbers import decode_signed, decode_unsigned, encode_signed, encode_unsigned

STATE_DATA_MIN = 36
"""Bytes of DATA up to and with the motor status: what every source agrees on. Shorter is no state."""
_WITH_TIME = 40
_WITH_VOLTAGES = 42

STATE_REPLIES = frozenset(CommandKind) - {
    CommandKind.GET_SONAR,
    CommandKind.GET_POSE,
    CommandKind.GET_VELOCITY,
    CommandKind.GET_BUMPER,
}
"""The commands whose reply carries the whole state."""


class MotorStatus(NamedTuple):
    """The motor status byte taken apart."""

    moving: bool
    battery: int
    """0 low, 1 medium, 2 high."""
    plugged_in: bool
    charging: bool
    emergency_stop: bool


@dataclass(frozen=True, slots=True)
class State:
    """The state frame in wire units (0.1 in, 0.1 deg, 0.1 in/s, whole inches)."""

    sonar: tuple[int, ...]
    bumper: int
    x: int
    y: int
    heading: int
    right: int
    left: int
    motor: int = 0
    turret: int = 0
    third: int = 0
    compass: int = 0
    board_ms: int | None = None
    """The base's own clock; None in a frame too short to hold it."""
    processor_raw: int | None = None
    motor_raw: int | None = None
    """The two voltages as read by the base's converter, 0 to 255."""

    @property
    def motor_status(self) -> MotorStatus:
        """The motor status byte taken apart."""
        bits = self.motor
        return MotorStatus(bool(bits & 3), bits >> 2 & 3, bool(bits & 16), bool(bits & 32), bool(bits & 64))


def motor_byte(status: MotorStatus) -> int:
    """Return the byte that `State.motor_status` reads as ``status`` (both wheels move or neither)."""
    return (
        (3 if status.moving else 0)
        | (status.battery & 3) << 2
        | status.plugged_in << 4
        | status.charging << 5
        | status.emergency_stop << 6
    )


def state_to_frame(state: State, kind: CommandKind) -> Frame:
    """Return the reply to a command of ``kind``; leaves out what ``state`` does not know from the end."""
    data = bytes(state.sonar)  # 4-19
    data += encode_unsigned(state.bumper, 3)  # 20-22
    for value in (state.x, state.y, state.heading, state.turret):  # 23-30
        data += encode_signed(value)
    for value in (state.right, state.left, state.third):  # 31-36
        data += encode_signed(value)
    data += encode_signed(state.compass)  # 37-38
    data += encode_unsigned(state.motor, 1)  # 39
    if state.board_ms is not None:
        data += encode_unsigned(state.board_ms, 4)  # 40-43
        if state.processor_raw is not None and state.motor_raw is not None:
            data += bytes((state.processor_raw, state.motor_raw))  # 44, 45
    return Frame(kind, data)


def state_from_frame(frame: Frame) -> State:
    """Return the state in a reply; raises ProtocolError if the reply is no state or too short for one."""
    if frame.kind not in STATE_REPLIES:
        raise ProtocolError(f"a reply of type {frame.kind} carries no state")
    data = frame.data
    if len(data) < STATE_DATA_MIN:
        raise ProtocolError(f"a state of {len(data)} bytes, where {STATE_DATA_MIN} are the least")
    voltages = len(data) >= _WITH_VOLTAGES
    return State(
        sonar=tuple(data[:SONARS]),
        bumper=decode_unsigned(data, 16, 3),
        x=decode_signed(data, 19),
        y=decode_signed(data, 21),
        heading=decode_signed(data, 23),
        turret=decode_signed(data, 25),
        right=decode_signed(data, 27),
        left=decode_signed(data, 29),
        third=decode_signed(data, 31),
        compass=decode_signed(data, 33),
        motor=data[35],
        board_ms=decode_unsigned(data, 36, 4) if len(data) >= _WITH_TIME else None,
        processor_raw=data[40] if voltages else None,
        motor_raw=data[41] if voltages else None,
    )


def readings_to_frame(state: State, kind: CommandKind) -> Frame:
    """Return the reply to a GET_* command; raises ProtocolError for any other kind."""
    time = encode_unsigned(state.board_ms or 0, 4)
    if kind == CommandKind.GET_SONAR:
        return Frame(kind, bytes(state.sonar) + time)
    if kind == CommandKind.GET_BUMPER:
        return Frame(kind, encode_unsigned(state.bumper, 3) + time)
    if kind == CommandKind.GET_POSE:
        pose = (state.x, state.y, state.heading, state.turret)
        return Frame(kind, b"".join(encode_signed(value) for value in pose))
    if kind == CommandKind.GET_VELOCITY:
        return Frame(kind, b"".join(encode_signed(value) for value in (state.right, state.left, state.third)))
    raise ProtocolError(f"{kind.name} is answered with the whole state")
