"""Control software and digital twin for automated tracheal suctioning.

Research software: not a medical device, not for use on people or animals. Every performance
claim is in-silico.
"""

__version__ = "0.1.0"
