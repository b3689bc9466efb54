"""Installs hslam_ekf where `ros2 run` and `ros2 launch` look for it."""

from glob import glob

from setuptools import find_packages, setup

setup(
    name="hslam_ekf",
    version="0.1.0",
    packages=find_packages(include=["hslam_ekf", "hslam_ekf.*"]),
    package_data={"hslam_ekf": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_ekf"]),
        ("share/hslam_ekf", ["package.xml"]),
        ("share/hslam_ekf/launch", glob("launch/*.launch.py")),
        ("share/hslam_ekf/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Odometry and landmarks to edge-maps: one small EKF map along each edge of the graph.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["ekf_node = hslam_ekf.executables:ekf_node"]},
)
