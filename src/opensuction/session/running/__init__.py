"""A machine that runs in real time: what is set up, who starts its cycles, what it has done."""
