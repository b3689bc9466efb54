"""Installs hslam_landmarks where `ros2 run` and `ros2 launch` look for it."""

from setuptools import find_packages, setup

setup(
    name="hslam_landmarks",
    version="0.1.0",
    packages=find_packages(include=["hslam_landmarks", "hslam_landmarks.*"]),
    package_data={"hslam_landmarks": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_landmarks"]),
        ("share/hslam_landmarks", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Landmarks out of a lidar's scans: corners and ends of walls, poles, reflectors.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["scan_landmarks_node = hslam_landmarks.executables:scan_landmarks_node"]},
)
