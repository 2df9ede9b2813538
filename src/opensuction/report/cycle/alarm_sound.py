"""The sound of an alarm as a file that any player opens."""

import io

import numpy as np
from scipy.io import wavfile

from opensuction.safety.alarm import auditory_signal
from opensuction.safety.priority import Priority

SAMPLE_RATE_HZ = 16_000
"""More than twice the highest harmonic of the highest tone (3300 Hz)."""
SECONDS = 10.0
"""Two bursts of a high alarm with the interval between them."""
FULL_SCALE = 32767
"""Largest sample of 16 bits."""


def encode(priority: Priority) -> bytes:
    """Sound of an alarm of this priority for `SECONDS`, as a WAV file of one channel."""
    samples = auditory_signal.repeat(priority, SECONDS, SAMPLE_RATE_HZ)
    buffer = io.BytesIO()
    wavfile.write(buffer, SAMPLE_RATE_HZ, np.round(samples * FULL_SCALE).astype("<i2"))
    return buffer.getvalue()
