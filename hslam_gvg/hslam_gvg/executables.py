"""What this package installs to be run."""

from hslam_ros.start import executable

gvg_node = executable("hslam_gvg.gvg_node")
