"""The core as plain Python: the same functions, in a process that compiles nothing."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run_plain(module: str, function: str) -> object:
    """Call a function without arguments as plain Python; its result has passed through JSON.

    Floats survive the journey exactly: JSON writes the shortest digits that read back the same.
    """
    program = f"import json, {module} as m; print(json.dumps(m.{function}()))"
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": "1",
        "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)]),
    }
    finished = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == 0, finished.stderr
    return json.loads(finished.stdout)
