"""Disclaimer of every page, report, file and command of this software."""

from typing import Final

NOT_A_DEVICE: Final = "Research software, not a medical device: not for use on people or animals."
