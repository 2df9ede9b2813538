"""A hazard table of one row, sound until a test breaks it."""

ROW = """
[[hazard]]
id = "OS-H01"
hazard = "Vacuum above the patient's limit"
cause = "Pump runs away"
effect = "Bleeding"
severity = "serious"
detection = "Line vacuum"
control = "Valve closed; out"
alarm = ["VACUUM_EXCEEDED", "PUMP_RUNAWAY"]
priority = "high"
safe_state = "out-without-suction"
detected_ms = 2000
safe_ms = 10000
because = "The line takes 2 s; 8 s to come out."
requirements = ["OS-R07"]
"""
FAULT = """
[[hazard.fault]]
name = "pump-runaway"
phases = ["inserting"]
"""
WEAK = """
[[hazard.fault]]
name = "pump-weak"
strengths = [0.7]
phases = ["closing"]
detected_ms = 500
"""
ON_ONE = 'patient = "adult-icu"\napproach = "travel"\nonly_because = "an example"\n'
"""Keys of a fault that is run on one patient only."""
