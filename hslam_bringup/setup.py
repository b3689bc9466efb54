"""Installs hslam_bringup where `ros2 run` and `ros2 launch` look for it."""

from glob import glob

from setuptools import find_packages, setup

setup(
    name="hslam_bringup",
    version="0.1.0",
    packages=find_packages(include=["hslam_bringup", "hslam_bringup.*"]),
    package_data={"hslam_bringup": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_bringup"]),
        ("share/hslam_bringup", ["package.xml"]),
        ("share/hslam_bringup/launch", glob("launch/*.launch.py")),
        ("share/hslam_bringup/config", glob("config/*.yaml")),
        ("share/hslam_bringup/rviz", glob("rviz/*.rviz")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Launch files, parameters, viewer layouts and the hslam command.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["hslam = hslam_bringup.executables:hslam"]},
)
