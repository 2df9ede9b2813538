"""Set-up before a cycle: protocol, patient, travel length, transmission, catheter."""
