"""Another arithmetic on the same machine: a C library that is told what its processor lacks."""

import platform
from pathlib import Path

ANOTHER_WAY = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable,-FMA4"}
"""Environment in which glibc computes exp and its like as on a processor without these."""


def takes_another_way() -> bool:
    """Whether that makes a difference here."""
    try:
        features = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").split()
    except OSError:
        return False
    return platform.libc_ver()[0] == "glibc" and {"avx2", "fma"} <= set(features)
