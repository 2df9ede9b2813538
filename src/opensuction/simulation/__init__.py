"""The compiled closed loop of controller and twin: one of the two drivers of the core."""
