"""Reports of a cycle for people: an HTML page, a terminal summary, a live display."""
