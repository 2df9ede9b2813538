"""The twin behind emulated drives: two CiA 402 nodes and one CiA 401 node on a CANopen bus."""
