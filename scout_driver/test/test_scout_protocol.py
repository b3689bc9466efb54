"""Frames, numbers, commands and replies: the vectors of the protocol, round trips, and anything at all."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scout_driver.errors import ProtocolError
from scout_driver.protocol.commands import (
    NAK,
    SONARS,
    Command,
    CommandKind,
    command_from_frame,
    command_to_frame,
    sonar_command,
    wheel_command,
)
from scout_driver.protocol.framing import LENGTH_MAX, Frame, FrameParser, encode_frame
from scout_driver.protocol.numbers import decode_signed, encode_signed
from scout_driver.protocol.replies import (
    STATE_DATA_MIN,
    STATE_REPLIES,
    MotorStatus,
    State,
    motor_byte,
    readings_to_frame,
    state_from_frame,
    state_to_frame,
)

STANDARD_ORDER = (0, 2, 15, 1, 14, 3, 13, 4, 12, 5, 11, 6, 10, 7, 9, 8)
COMMAND_VECTORS = [
    (Command(CommandKind.STATE), "01 02 00 07 0A 5C"),
    (Command(CommandKind.STOP), "01 02 00 09 0C 5C"),
    (Command(CommandKind.LIMP), "01 02 00 0A 0D 5C"),
    (Command(CommandKind.ZERO), "01 02 00 0D 10 5C"),
    (wheel_command(CommandKind.VELOCITY, 100, 100), "01 08 00 05 64 00 64 00 00 00 D6 5C"),
    (wheel_command(CommandKind.VELOCITY, 47, -47), "01 08 00 05 2F 00 2F 80 00 00 EC 5C"),
    (wheel_command(CommandKind.VELOCITY, -300, 300), "01 08 00 05 2C 81 2C 01 00 00 E8 5C"),
    (Command(CommandKind.CONFIGURE_WATCHDOG, (5,)), "01 03 00 12 05 1B 5C"),
    (Command(CommandKind.DEFINE_POSITION, (0, 0)), "01 06 00 0C 00 00 00 00 13 5C"),
    (Command(CommandKind.DEFINE_ANGLE, (900, 0)), "01 06 00 1E 84 03 00 00 AC 5C"),
    (sonar_command(15, STANDARD_ORDER), "01 13 00 0F 0F 00 02 0F 01 0E 03 0D 04 0C 05 0B 06 0A 07 09 08 AA 5C"),
]
STATE_VECTOR = (
    "01 2C 00 07" + " FF" * 16 + " 00 00 00 64 00 32 80 84 03 00 00 64 00 64 00 00 00 00 00 0B 40 E2 01 00 C8 C8 47 5C"
)

signed = st.integers(-32767, 32767)
byte = st.integers(0, 255)
states = st.builds(
    State,
    sonar=st.tuples(*[byte] * SONARS),
    bumper=st.integers(0, 0xFFFFFF),
    x=signed,
    y=signed,
    heading=signed,
    right=signed,
    left=signed,
    motor=byte,
    turret=signed,
    third=signed,
    compass=signed,
    board_ms=st.integers(0, 2**32 - 1),
    processor_raw=byte,
    motor_raw=byte,
)
frames = st.builds(Frame, st.integers(0, 255), st.binary(max_size=LENGTH_MAX - 2))


def _from_hex(text: str) -> list[Frame]:
    return FrameParser().feed(bytes.fromhex(text))


@pytest.mark.parametrize(("command", "wire"), COMMAND_VECTORS)
def test_command_vectors(command: Command, wire: str) -> None:
    assert encode_frame(command_to_frame(command)) == bytes.fromhex(wire)
    assert [command_from_frame(frame) for frame in _from_hex(wire)] == [command]


def test_state_vector() -> None:
    (frame,) = _from_hex(STATE_VECTOR)
    state = state_from_frame(frame)
    assert (state.x, state.y, state.heading, state.right, state.left) == (100, -50, 900, 100, 100)
    assert state.sonar == (255,) * SONARS
    assert state.board_ms == 123456
    assert (state.processor_raw, state.motor_raw) == (200, 200)
    assert state.motor_status == MotorStatus(
        moving=True, battery=2, plugged_in=False, charging=False, emergency_stop=False
    )
    assert encode_frame(state_to_frame(state, CommandKind.STATE)) == bytes.fromhex(STATE_VECTOR)


def test_bare_nak_vector() -> None:
    assert _from_hex("01 02 00 08 0B 5C") == [Frame(NAK)]


def test_motor_status_bits() -> None:
    status = MotorStatus(moving=False, battery=1, plugged_in=True, charging=True, emergency_stop=True)
    assert motor_byte(status) == 0b1110100


def test_a_short_firing_order_is_ended_by_255() -> None:
    assert command_to_frame(sonar_command(15, (3, 4))).data == bytes([15, 3, 4] + [255] * 14)


def test_negative_zero_reads_as_zero() -> None:
    assert decode_signed(b"\x00\x80", 0) == 0


@given(signed)
def test_signed_numbers_round_trip(value: int) -> None:
    assert decode_signed(encode_signed(value), 0) == value


@pytest.mark.parametrize("value", [-32768, 32768])
def test_a_number_that_does_not_fit_is_refused(value: int) -> None:
    with pytest.raises(ProtocolError):
        encode_signed(value)
    with pytest.raises(ProtocolError):
        command_to_frame(wheel_command(CommandKind.VELOCITY, value, 0))


@given(states, st.sampled_from(sorted(STATE_REPLIES)))
def test_states_round_trip(state: State, kind: CommandKind) -> None:
    assert state_from_frame(state_to_frame(state, kind)) == state


@given(states, st.integers(STATE_DATA_MIN, 41))
def test_a_shorter_state_lacks_only_its_end(state: State, size: int) -> None:
    whole = state_to_frame(state, CommandKind.STATE)
    short = state_from_frame(Frame(whole.kind, whole.data[:size]))
    assert (short.x, short.motor, short.sonar) == (state.x, state.motor, state.sonar)
    assert short.board_ms == (state.board_ms if size >= 40 else None)
    assert short.motor_raw is None


def test_a_state_without_motor_status_is_refused() -> None:
    with pytest.raises(ProtocolError):
        state_from_frame(Frame(CommandKind.STATE, bytes(STATE_DATA_MIN - 1)))


@given(states)
def test_sizes_of_the_other_replies(state: State) -> None:
    sizes = {kind: len(encode_frame(readings_to_frame(state, kind))) for kind in set(CommandKind) - STATE_REPLIES}
    assert sizes == {
        CommandKind.GET_SONAR: 26,
        CommandKind.GET_POSE: 14,
        CommandKind.GET_VELOCITY: 12,
        CommandKind.GET_BUMPER: 13,
    }


@given(st.lists(frames, max_size=5), st.integers(1, 40))
def test_frames_survive_being_cut_anywhere(sent: list[Frame], chunk: int) -> None:
    stream = b"".join(encode_frame(frame) for frame in sent)
    parser = FrameParser()
    received = [f for i in range(0, len(stream), chunk) for f in parser.feed(stream[i : i + chunk])]
    assert received == sent
    assert parser.discarded == parser.pending == 0


@given(st.binary(max_size=300), frames)
def test_resynchronises_after_any_garbage(garbage: bytes, frame: Frame) -> None:
    parser = FrameParser()
    received = parser.feed(garbage)
    received += parser.line_silent()
    received += parser.feed(encode_frame(frame))
    received += parser.line_silent()
    assert received[-1] == frame


@given(st.binary(max_size=600))
def test_no_input_raises_anything_but_protocol_errors(noise: bytes) -> None:
    parser = FrameParser()
    for frame in parser.feed(noise) + parser.line_silent():
        for read in (command_from_frame, state_from_frame):
            try:
                read(frame)
            except ProtocolError:
                continue
    assert parser.pending == 0


@given(frames)
def test_any_valid_frame_is_read_or_refused(frame: Frame) -> None:
    try:
        command = command_from_frame(frame)
    except ProtocolError:
        return
    again = command_from_frame(command_to_frame(command))
    assert again == command


@given(st.sampled_from(COMMAND_VECTORS), st.integers(0, 500), st.integers(0, 7))
def test_one_flipped_bit_never_makes_another_command(vector: tuple[Command, str], where: int, bit: int) -> None:
    wire = bytearray.fromhex(vector[1])
    wire[where % len(wire)] ^= 1 << bit
    parser = FrameParser()
    assert parser.feed(bytes(wire)) + parser.line_silent() == []


def test_a_frame_behind_a_false_start_is_found_once_the_line_is_silent() -> None:
    parser = FrameParser()
    assert parser.feed(b"\x01\x50\x00" + bytes.fromhex("01 02 00 07 0A 5C")) == []
    assert parser.line_silent() == [Frame(CommandKind.STATE)]
