"""timonel: the command gateway between helm stations and the CAN bus of a vehicle."""

__version__ = "0.1.0"
