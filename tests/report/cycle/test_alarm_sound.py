import io
import wave

import numpy as np
import pytest

from opensuction.report.cycle import page
from opensuction.safety.alarm import alarm_signal
from opensuction.safety.handling import Priority


@pytest.mark.parametrize("priority", [Priority.HIGH, Priority.MEDIUM, Priority.LOW])
def test_the_file_holds_the_pattern_of_its_priority(priority: Priority) -> None:
    with wave.open(io.BytesIO(page.encode_alarm(priority))) as file:
        rate_hz = file.getframerate()
        assert (file.getnchannels(), file.getsampwidth()) == (1, 2)
        assert file.getnframes() == page.SECONDS * rate_hz
        samples = np.frombuffer(file.readframes(file.getnframes()), dtype="<i2")
    meant = alarm_signal.repeat(priority, page.SECONDS, rate_hz)
    # Half a step of 16 bits.
    np.testing.assert_allclose(samples / 32767.0, meant, atol=0.5 / 32767.0 + 1e-12)
