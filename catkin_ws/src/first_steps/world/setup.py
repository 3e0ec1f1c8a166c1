"""Register the Python modules of this package with catkin, which runs this file."""

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(packages=["world"], package_dir={"": "src"}))
