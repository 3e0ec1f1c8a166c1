"""Tells catkin where this package's Python modules are; catkin runs it, you do not."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(packages=["qt_interface"], package_dir={"": "src"}))
