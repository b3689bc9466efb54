"""Turning a little to either side on the spot, so that a ring of sensors also hears what lies between its axes.

Not all round: odometry turns its errors into the map, and there and back they cancel.
"""

from hslam_gvg.driving.now import Now
from hslam_types.sensing import Velocity


def listening(began: float, now: Now) -> Velocity | None:
    """Return the turn to make since the odometer's angle was ``began`` (rad); None once it is over."""
    side, rate = now.config.listening_turn, now.config.listening_rad_s
    turned = now.around.turned - began
    if turned >= 4.0 * side:
        return None
    return Velocity(0.0, -rate if side <= turned < 3.0 * side else rate)
