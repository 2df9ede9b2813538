"""Drives on a CANopen bus: CiA 301 communication, CiA 402 drives, CiA 401 inputs and outputs.

Two axes and one module of inputs and outputs make a machine. The driver (`canopen_machine`) is a
backend of `machine.port` and runs in the controller's process; what a particular machine's nodes
and units are stands in its device file. Nothing here was ever tried on hardware.
"""
