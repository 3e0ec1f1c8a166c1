from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

# The tests of other packages use sdc_testing, with pytest and with rostest.
setup(
    **generate_distutils_setup(
        packages=[*find_packages("src"), "sdc_testing"],
        package_dir={"": "src", "sdc_testing": "test/sdc_testing"},
    )
)
