"""What the simulated base says beyond the readings that `hslam_ros` converts: TF, battery, diagnostics, truth."""

import math

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState
from tf2_msgs.msg import TFMessage

from hslam_ros.conversions import header, odometry_to_msg, yaw_to_quaternion
from hslam_sim.simulation import Battery, SimStep
from hslam_types.sensing import OdometrySample


def transform_to_msg(odom: OdometrySample) -> TFMessage:
    """Return the transform odom -> base_link."""
    msg = TransformStamped(header=header(odom.stamp_ns, "odom"), child_frame_id="base_link")
    msg.transform.translation.x = odom.base_in_odom.x
    msg.transform.translation.y = odom.base_in_odom.y
    msg.transform.rotation = yaw_to_quaternion(odom.base_in_odom.theta)
    return TFMessage(transforms=[msg])


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


def diagnostics_to_msg(step: SimStep) -> DiagnosticArray:
    """Return the base's health (REP-107)."""
    status = DiagnosticStatus(
        level=DiagnosticStatus.WARN if step.bumped else DiagnosticStatus.OK,
        name="sim: base",
        message="held by a wall" if step.bumped else "ok",
        hardware_id="simulated Scout",
        values=[
            KeyValue(key="contacts", value=str(step.collisions)),
            KeyValue(key="battery_v", value=f"{step.battery.voltage_v:.2f}"),
        ],
    )
    return DiagnosticArray(header=header(step.stamp_ns, ""), status=[status])
