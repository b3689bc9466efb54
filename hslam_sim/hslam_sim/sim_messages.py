"""What the simulated base says beyond what `hslam_ros` converts: battery, diagnostics, truth."""

import math

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from hslam_ros.conversions import header, odometry_to_msg
from hslam_sim.simulation import Battery, SimStep
from hslam_types.sensing import OdometrySample


def truth_to_msg(step: SimStep) -> Odometry:
    """Return the true pose of base_link in map, for scoring only."""
    return odometry_to_msg(OdometrySample(step.stamp_ns, step.truth, step.odom.velocity), parent="map")


def battery_to_msg(stamp_ns: int, battery: Battery) -> BatteryState:
    """Return the battery's state; what a Scout does not measure is NaN (sensor_msgs)."""
    return BatteryState(
        header=header(stamp_ns, "base_link"),
        voltage=battery.voltage_v,
        percentage=battery.charge,
        temperature=math.nan,
        current=math.nan,
        charge=math.nan,
        capacity=math.nan,
        design_capacity=math.nan,
        power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
        power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN,
        present=True,
    )


def diagnostics_to_msg(step: SimStep, messages_refused: int) -> DiagnosticArray:
    """Return the base's health (REP-107)."""
    status = DiagnosticStatus(
        level=DiagnosticStatus.WARN if step.bumped else DiagnosticStatus.OK,
        name="sim: base",
        message="held by a wall" if step.bumped else "ok",
        hardware_id="simulated Scout",
        values=[
            KeyValue(key="odometer_m", value=f"{step.odometer_m:.2f}"),
            KeyValue(key="contacts", value=str(step.collisions)),
            KeyValue(key="battery_v", value=f"{step.battery.voltage_v:.2f}"),
            KeyValue(key="messages_refused", value=str(messages_refused)),
        ],
    )
    return DiagnosticArray(header=header(step.stamp_ns, ""), status=[status])
