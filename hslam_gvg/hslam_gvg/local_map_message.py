"""The obstacle points as what RViz, Nav2 and the rest of ROS take for obstacles: a point cloud in odom."""

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

from hslam_ros.conversions import header
from hslam_types.se2 import Array

_FIELDS = [
    PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, name in enumerate(("x", "y", "z"))
]


def local_map_to_msg(points: Array, stamp_ns: int) -> PointCloud2:
    """Return ``points`` (n x 2, m, odom) as a cloud at the height of the floor."""
    cloud = np.zeros((len(points), 3), dtype="<f4")
    cloud[:, :2] = points
    return PointCloud2(
        header=header(stamp_ns, "odom"),
        height=1,
        width=len(cloud),
        fields=_FIELDS,
        point_step=cloud.itemsize * 3,
        row_step=cloud.nbytes,
        data=cloud.tobytes(),
        is_dense=True,
    )
