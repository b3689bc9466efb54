"""What this package installs to be run."""

from hslam_ros.start import executable

scan_landmarks_node = executable("hslam_landmarks.scan_landmarks_node")
