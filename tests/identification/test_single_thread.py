import subprocess
import sys

from threadpoolctl import threadpool_info

from opensuction.identification.single_thread import single_threaded


def count() -> list[int]:
    """Threads of every linear-algebra library that is loaded."""
    return [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]


def test_a_fit_runs_in_one_thread_and_leaves_the_others_as_they_were() -> None:
    import scipy.linalg  # noqa: F401 - has its own library

    before = count()
    assert set(single_threaded(count)()) == {1}
    assert count() == before


LATE = """
from threadpoolctl import ThreadpoolController

from opensuction.identification.single_thread import load, single_threaded

def threads():
    pools = ThreadpoolController().select(user_api="blas").info()
    return {pool["filepath"]: pool["num_threads"] for pool in pools}

@single_threaded
def inner():
    load("scipy.linalg")
    return threads()

@single_threaded
def outer():
    return inner(), threads()

ThreadpoolController().limit(limits=2, user_api="blas")
few = threads()
before, after = outer()
assert len(before) > len(few), "SciPy brought no library of its own"
assert set(before.values()) == set(after.values()) == {1}, (before, after)
assert {file: threads()[file] for file in few} == few
"""


def test_a_library_that_a_fit_loads_runs_in_one_thread_until_the_fit_ends() -> None:
    subprocess.run([sys.executable, "-c", LATE], check=True)
