"""The ROS 2 package of the pilot."""

from setuptools import setup

setup(
    name="pilot",
    version="0.1.0",
    packages=["pilot"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/pilot"]),
        ("share/pilot", ["package.xml"]),
        ("share/pilot/launch", ["launch/course.launch.py"]),
    ],
    entry_points={"console_scripts": ["node = pilot.node:main"]},
)
