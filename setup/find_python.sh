#!/bin/sh
# Prints the Python that the set-up uses, or says in one line which one is missing.
# Usage: find_python.sh [command]   (default: the first that fits; ROS from apt is tied to the system's Python)
# The Python behind a virtual environment is named, not the environment's: that one may be about to be made anew.
look='import sys
if not (3, 11) <= sys.version_info[:2] <= (3, 13): sys.exit(1)
print(getattr(sys, "_base_executable", sys.executable))'
if [ -n "$1" ]; then
    candidates=$1
elif [ -e "${HSLAM_ROS:-/opt/ros/jazzy}/setup.sh" ]; then
    candidates=/usr/bin/python3
else
    candidates="python3 python3.13 python3.12 python3.11"
fi
for candidate in $candidates; do
    if "$candidate" -c "$look" 2>/dev/null; then
        exit 0
    fi
done
echo "set-up: no Python 3.11 to 3.13 found (looked for: $candidates); on Debian or Ubuntu: apt install python3 python3-venv python3-dev" >&2
exit 1
