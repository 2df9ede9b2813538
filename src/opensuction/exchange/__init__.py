"""How the processes of one machine keep time and tell each other: deadlines, rings, requests."""
