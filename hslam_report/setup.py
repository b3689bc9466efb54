"""Installs hslam_report where `ros2 run` and `ros2 launch` look for it."""

from setuptools import find_packages, setup

setup(
    name="hslam_report",
    version="0.1.0",
    packages=find_packages(include=["hslam_report", "hslam_report.*"]),
    package_data={"hslam_report": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_report"]),
        ("share/hslam_report", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Scores and figures of a finished run; the only part besides the simulator that may read the truth.",
    license="Apache-2.0",
)
