"""The controller against the clock: its loop, what it publishes, what it is asked, who watches."""
