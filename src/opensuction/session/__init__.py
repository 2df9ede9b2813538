"""From named choices to a result: a cycle, a day, a calibration, an identification."""
