"""The bedside console: what people see and press in a browser, and the interface that it uses.

It reads the control loop's ring and asks by its mailbox, as anybody else may: it can die at any
time, and the controller goes on.
"""
