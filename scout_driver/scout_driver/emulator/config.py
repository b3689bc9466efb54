"""What the emulated base does where no source says how the real one behaves."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter


@dataclass(frozen=True)
class EmulatorConfig(Configuration):
    """Parameters of the emulated base and its line."""

    baud: int = parameter(38400, "line speed", low=300, high=115200, unit="bit/s")
    processing_s: float = parameter(
        0.001, "from the end of a command to the start of its reply (assumed)", low=0.0, high=1.0, unit="s"
    )
    tick_ms: int = parameter(
        10, "resolution of the emulation; what a state tells was true at a tick", low=1, high=60, unit="ms"
    )
    exchange_s: float = parameter(
        0.0,
        "above 0: lock-step; each command moves the world on by so much and is answered at once",
        low=0.0,
        high=1.0,
        unit="s",
    )
    wheel_base_m: float = parameter(0.34519, "between the wheels", low=0.2, high=0.6, unit="m")
    wheel_speed_max_m_s: float = parameter(1.0, "a wheel's fastest speed", low=0.05, high=2.0, unit="m/s")
    acceleration_m_s2: float = parameter(0.762, "power-on AC, 300 units (assumed)", low=0.05, high=10.0, unit="m/s^2")
    sonar_no_echo: int = parameter(255, "inches reported when nothing was heard (assumed)", low=1, high=255, unit="in")
    state_feeds_watchdog: bool = parameter(False, "GS counts as a command for CONF_TM (unclear)")
    nak_bad_frames: bool = parameter(False, "a bad frame is answered by NAK instead of silence (not known)")
    silence_s: float = parameter(
        0.05, "a frame that pauses so long is given up (assumed)", low=0.005, high=1.0, unit="s"
    )
    bumper_hold_s: float = parameter(0.3, "how long a contact stays visible", low=0.0, high=5.0, unit="s")
    look_s: float = parameter(0.36, "time between two looks of the landmark sensor", low=0.01, high=60.0, unit="s")


@dataclass(frozen=True)
class FaultConfig(Configuration):
    """Chances of what can go wrong, all 0 by default; byte faults strike in both directions."""

    flipped: float = parameter(0.0, "a byte with one bit flipped, per byte", low=0.0, high=1.0)
    lost: float = parameter(0.0, "a byte lost, per byte", low=0.0, high=1.0)
    doubled: float = parameter(0.0, "a byte sent twice, per byte", low=0.0, high=1.0)
    late: float = parameter(0.0, "a byte, and all after it, held back, per byte", low=0.0, high=1.0)
    late_s: float = parameter(0.1, "how long a late byte is held back at most", low=0.0, high=5.0, unit="s")
    nak: float = parameter(0.0, "a command refused, per command", low=0.0, high=1.0)
    silent: float = parameter(0.0, "a command carried out but not answered, per command", low=0.0, high=1.0)
    deaf: float = parameter(0.0, "a command neither carried out nor answered, per command", low=0.0, high=1.0)
    short: float = parameter(0.0, "a state frame cut short before the board time, per command", low=0.0, high=1.0)
    repeated: float = parameter(0.0, "a reply sent twice, per command", low=0.0, high=1.0)
    late_reply: float = parameter(0.0, "a whole reply held back, per command", low=0.0, high=1.0)
    unplugged: float = parameter(0.0, "the line pulled out, per command", low=0.0, high=1.0)
    unplugged_s: float = parameter(2.0, "how long it stays out", low=0.0, high=60.0, unit="s")
