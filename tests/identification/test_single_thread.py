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
