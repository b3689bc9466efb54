"""Every constant of the driver, those the sources leave open above all, and how the node meets time."""

from dataclasses import dataclass

from hslam_types.config import Configuration, parameter
from hslam_types.errors import ConfigurationError
from scout_driver.protocol.commands import SONARS


@dataclass(frozen=True)
class DriverConfig(Configuration):
    """Parameters of the driver core; times are in robot seconds."""

    port: str = parameter("/dev/ttyUSB0", "serial device, or tcp://host:port")
    baud: int = parameter(38400, "line speed; the base's default", low=300, high=115200, unit="bit/s")
    cycle_s: float = parameter(
        0.06, "one exchange a cycle; one ping of the default firing rate", low=0.02, high=0.2, unit="s"
    )
    reply_timeout_s: float = parameter(
        0.2, "wait for the first byte of a reply (vendor: 1.0)", low=0.01, high=60.0, unit="s"
    )
    gap_timeout_s: float = parameter(
        0.04,
        "a reply that pauses this long is broken (a USB adapter holds bytes for 16 ms)",
        low=0.005,
        high=10.0,
        unit="s",
    )
    reconnect_s: float = parameter(0.5, "pause between attempts to open a lost line", low=0.05, high=10.0, unit="s")

    command_timeout_s: float = parameter(
        0.5, "without a command for so long the base is stopped", low=0.05, high=1.0, unit="s"
    )
    line_timeout_s: float = parameter(
        0.5, "without a valid state for so long the base is stopped", low=0.1, high=1.0, unit="s"
    )
    watchdog_s: int = parameter(
        1, "CONF_TM: the base stops itself when the computer is silent", low=1, high=255, unit="s"
    )
    forward_max_m_s: float = parameter(0.6, "largest forward speed let through", low=0.0, high=1.0, unit="m/s")
    turn_max_rad_s: float = parameter(1.5, "largest turn rate let through", low=0.0, high=4.0, unit="rad/s")
    wheel_speed_max_m_s: float = parameter(
        1.0, "largest wheel speed (clamp seen in third-party drivers)", low=0.05, high=1.5, unit="m/s"
    )
    acceleration_m_s2: float = parameter(
        1.0, "limit on speeding up; slowing down is left to the wheels", low=0.05, high=3.0, unit="m/s^2"
    )
    turn_acceleration_rad_s2: float = parameter(6.0, "limit on speeding up a turn", low=0.1, high=20.0, unit="rad/s^2")
    wheel_acceleration_m_s2: float = parameter(
        1.0,
        "AC: what the base itself allows its wheels, whatever it is told (assumed)",
        low=0.05,
        high=3.0,
        unit="m/s^2",
    )
    bumper_mask: int = parameter(
        0xFFFFFF, "bumper bits that count as a contact (their number is not known)", low=0, high=0xFFFFFF
    )
    bumper_stop_s: float = parameter(
        0.5, "a contact stops the base altogether for so long", low=0.0, high=3600.0, unit="s"
    )
    bumper_resume_s: float = parameter(
        1.0, "from the contact's end on, forward motion stays forbidden so long", low=0.0, high=3600.0, unit="s"
    )
    bumper_reverse_m_s: float = parameter(
        0.1, "meanwhile, after the stop, how fast one may back off; 0 = not at all", low=0.0, high=0.2, unit="m/s"
    )
    bumper_turn_rad_s: float = parameter(
        0.5, "meanwhile, after the stop, how fast one may turn: the body is round", low=0.0, high=1.0, unit="rad/s"
    )

    wheel_base_m: float = parameter(
        0.34519, "between the wheels: vendor's 0.118597 in/deg; another driver has 0.34036", low=0.2, high=0.6, unit="m"
    )
    swap_wheels: bool = parameter(False, "the left wheel comes first on the wire (one third-party server's belief)")
    heading_clockwise: bool = parameter(False, "the base counts its heading clockwise")
    distance_scale: float = parameter(1.0, "true distance over reported distance, from calibration", low=0.8, high=1.25)
    rotation_scale: float = parameter(1.0, "true rotation over reported rotation, from calibration", low=0.8, high=1.25)
    rebase_at_m: float = parameter(
        60.0, "re-base the base's counters here; they overflow at 83.2 m", low=1.0, high=75.0, unit="m"
    )
    counter_span: int = parameter(
        65535,
        "units from one end of a position counter to the other (how it overflows is not known)",
        low=65534,
        high=65536,
    )

    sonar_rate: int = parameter(15, "4 ms units a ping (CONF_SN); 15 in every driver", low=1, high=255, unit="4 ms")
    sonar_order: str = parameter("0 2 15 1 14 3 13 4 12 5 11 6 10 7 9 8", "order of firing; the same in every driver")
    sonar_settle_s: float = parameter(
        0.04,
        "a reading is in the state frame this long after its firing (6.5 m and back: 38 ms)",
        low=0.0,
        high=0.2,
        unit="s",
    )
    sonar_no_echo: int = parameter(255, "inches that mean nothing was heard (assumed)", low=1, high=255, unit="in")

    def firing_order(self) -> tuple[int, ...]:
        """Return the sonars in order of firing; raises ConfigurationError if it is no such list."""
        try:
            order = tuple(int(word) for word in self.sonar_order.split())
        except ValueError:
            order = ()
        if not order or len(set(order)) != len(order) or not all(0 <= sensor < SONARS for sensor in order):
            raise ConfigurationError(
                f"parameter 'sonar_order' must list different sonars of 0 to {SONARS - 1}, not '{self.sonar_order}'"
            )
        return order

    def __post_init__(self) -> None:
        """Check every value; raises ConfigurationError."""
        super().__post_init__()
        self.firing_order()


@dataclass(frozen=True)
class NodeConfig(Configuration):
    """How the node meets time and its life."""

    autostart: bool = parameter(True, "configure and activate at start; false: a lifecycle manager does it")
    lockstep: bool = parameter(False, "speak to the base only in answer to a command; with an emulator in lock-step")
    board_stamps: bool = parameter(False, "stamp with the base's own clock, as the emulator stamps landmarks")
    time_factor: float = parameter(1.0, "emulated by wall time, as the emulator was told", low=0.01, high=100.0)
