"""Steering methods with a common interface, `Steering`."""

from sdc_package.steering.method import Steering

__all__ = ["Steering"]
