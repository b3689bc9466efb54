"""Installs hslam_voronoi where `ros2 run` and `ros2 launch` look for it."""

from setuptools import find_packages, setup

setup(
    name="hslam_voronoi",
    version="0.1.0",
    packages=find_packages(include=["hslam_voronoi", "hslam_voronoi.*"]),
    package_data={"hslam_voronoi": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/hslam_voronoi"]),
        ("share/hslam_voronoi", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # by this `colcon test` knows what to run
    zip_safe=False,
    maintainer="The hslam maintainers",
    maintainer_email="maintainers@hslam.invalid",
    description="Graphs of Voronoi branches and the rules that reduce them to the GVG, which robot and truth share.",
    license="Apache-2.0",
)
