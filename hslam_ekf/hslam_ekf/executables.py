"""What this package installs to be run."""

from hslam_ros.start import executable

ekf_node = executable("hslam_ekf.ekf_node")
