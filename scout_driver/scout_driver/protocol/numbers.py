"""Numbers on the wire: signed 16-bit values are sign-magnitude, all others plain; everything is little-endian."""

from scout_driver.errors import ProtocolError

SIGNED_MAX = 0x7FFF
SIGN_BIT = 0x8000


def encode_signed(value: int) -> bytes:
    """Return two bytes for ``value`` in +-32767; raises ProtocolError outside."""
    if not -SIGNED_MAX <= value <= SIGNED_MAX:
        raise ProtocolError(f"{value} does not fit a signed 16-bit field of +-{SIGNED_MAX}")
    magnitude = abs(value) | (SIGN_BIT if value < 0 else 0)
    return magnitude.to_bytes(2, "little")


def decode_signed(data: bytes, offset: int) -> int:
    """Return the signed value at ``offset``; negative zero reads as 0."""
    raw = data[offset] | data[offset + 1] << 8
    magnitude = raw & SIGNED_MAX
    return -magnitude if raw & SIGN_BIT else magnitude


def encode_unsigned(value: int, size: int) -> bytes:
    """Return ``size`` bytes for ``value``; raises ProtocolError if it does not fit."""
    if not 0 <= value < 1 << 8 * size:
        raise ProtocolError(f"{value} does not fit an unsigned field of {size} byte(s)")
    return value.to_bytes(size, "little")


def decode_unsigned(data: bytes, offset: int, size: int) -> int:
    """Return the unsigned value of ``size`` bytes at ``offset``."""
    return int.from_bytes(data[offset : offset + size], "little")
