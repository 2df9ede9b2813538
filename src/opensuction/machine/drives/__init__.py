"""Emulated drives: the twin behind two CiA 402 drives and a CiA 401 module on a CANopen bus.

In-silico: a host on the bus finds nodes, and behind them numbers. What a drive does by itself, the
nodes do by themselves, whether a host lives or not.
"""
