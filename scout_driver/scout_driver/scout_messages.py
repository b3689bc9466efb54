"""What the Scout says beyond what `hslam_ros` converts: battery, diagnostics."""

import math
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import BatteryState

from hslam_ros.conversions import header
from scout_driver.driver import ScoutDriver
from scout_driver.motion_guard import Hold
from scout_driver.protocol.replies import State
from scout_driver.units import MOTOR_DIVIDER, volts

BATTERY_WORDS = ("low", "medium", "high", "unknown")


def battery_to_msg(stamp_ns: int, state: State) -> BatteryState:
    """Return the battery's state; what a Scout does not tell is NaN (sensor_msgs)."""
    status = state.motor_status
    charging = BatteryState.POWER_SUPPLY_STATUS_CHARGING
    resting = BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING if status.plugged_in else None
    return BatteryState(
        header=header(stamp_ns, "base_link"),
        voltage=math.nan if state.motor_raw is None else volts(state.motor_raw, MOTOR_DIVIDER),
        percentage=math.nan,
        temperature=math.nan,
        current=math.nan,
        charge=math.nan,
        capacity=math.nan,
        design_capacity=math.nan,
        power_supply_status=charging if status.charging else resting or BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
        power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN,
        present=True,
    )


def diagnostics_to_msg(
    stamp_ns: int, driver: ScoutDriver, state: State | None, messages_refused: int
) -> DiagnosticArray:
    """Return the health of the line, of the base and of what the node hears (REP-107)."""
    level, message = (DiagnosticStatus.WARN, "refused commands") if messages_refused else (DiagnosticStatus.OK, "ok")
    heard = _status("scout: inputs", level, message, {"messages_refused": messages_refused})
    return DiagnosticArray(
        header=header(stamp_ns, ""), status=[_line_status(driver), _base_status(driver, state), heard]
    )


def _line_status(driver: ScoutDriver) -> DiagnosticStatus:
    counts, hold = driver.counts, driver.hold()
    if not driver.connected:
        level, message = DiagnosticStatus.ERROR, driver.line_error or "not open"
    elif hold is Hold.LINE:
        level, message = DiagnosticStatus.ERROR, "open, but the base does not answer"
    else:
        level, message = DiagnosticStatus.OK, "ok"
    figures = {
        "exchanges": counts.exchanges,
        "answered": counts.answered,
        "silent": counts.silent,
        "broken": counts.broken,
        "refused": counts.refused,
        "unexpected": counts.unexpected,
        "bytes_discarded": counts.bytes_discarded,
        "line_losses": driver.line_losses,
    }
    return _status("scout: line", level, message, figures)


def _base_status(driver: ScoutDriver, state: State | None) -> DiagnosticStatus:
    hold = driver.hold()
    if state is None:
        return _status("scout: base", DiagnosticStatus.STALE, "no state yet", {})
    level, message = DiagnosticStatus.OK, "ok"
    if hold in (Hold.EMERGENCY_STOP, Hold.EMERGENCY_RELEASED, Hold.BUMPER):
        level, message = DiagnosticStatus.ERROR, f"held: {hold.value}"
    elif state.motor_status.battery == 0:
        level, message = DiagnosticStatus.WARN, "battery low"
    elif hold is not None:
        message = f"held: {hold.value}"
    odometry = driver.odometry
    figures = {
        "odometer_m": f"{odometry.odometer_m:.2f}",
        "battery": BATTERY_WORDS[state.motor_status.battery],
        "bumper_bits": f"{state.bumper:06x}",
        "stops": driver.guard.stops,
        "states_not_believed": odometry.rejected,
        "counters_lost": odometry.jumps,
        "counters_rebased": odometry.rebases,
        "sonar_phase_s": f"{driver.sonar.phase_s:.3f}",
    }
    return _status("scout: base", level, message, figures)


def _status(name: str, level: bytes, message: str, figures: Mapping[str, object]) -> DiagnosticStatus:
    values = [KeyValue(key=key, value=str(value)) for key, value in figures.items()]
    return DiagnosticStatus(level=level, name=name, message=message, hardware_id="Nomadic Scout", values=values)
