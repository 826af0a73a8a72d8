"""drover/locks.py: HDF5 from one thread at a time."""
import os
import sys
import threading
from contextlib import contextmanager

from drover.error import Error

# HDF5 is not thread-safe.  h5py, which shares the library, has a lock of its own.
LOCK = threading.RLock()
was_held_at_fork = False


@contextmanager
def hdf5():
    """Holds the locks of HDF5: for calls that read or write archives.  Other threads wait for them."""
    require_usable_hdf5()
    with LOCK:
        if "h5py" not in sys.modules:
            yield
            return
        import h5py  # waits for a thread that is importing it
        with h5py._objects.phil:  # documented, despite its underscore
            yield


def require_usable_hdf5():
    """Raises Error in a process that was forked within a call of HDF5: it has the locks, and no thread to release them.
    """
    if was_held_at_fork:
        raise Error("another thread was using HDF5 when this process was forked, which has it in the middle of a call; "
                    'start processes by multiprocessing.get_context("spawn"), or before the threads', fault="run")


def after_fork_in_child():
    global LOCK, was_held_at_fork  # pylint: disable=global-statement
    for lock in (LOCK, getattr(getattr(sys.modules.get("h5py"), "_objects", None), "phil", None)):
        if lock is not None and not lock.acquire(blocking=False):
            was_held_at_fork = True
        elif lock is not None:
            lock.release()
    LOCK = threading.RLock()


os.register_at_fork(after_in_child=after_fork_in_child)
