"""Installs hslam_ros where `ros2 run` and `ros2 launch` look for it."""

from setuptools import find_packages, setup

setup(
    name="hslam_ros",
    version="0.1.0",
    packages=find_packages(include=["hslam_ros", "hslam_ros.*"]),
    package_data={"hslam_ros": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_ros"]),
        ("share/hslam_ros", ["package.xml", "config/fast_dds.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="What every node needs of ROS: message conversions, parameters from dataclasses, QoS, order of inputs.",
    license="Apache-2.0",
)
