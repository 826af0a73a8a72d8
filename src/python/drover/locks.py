"""drover/locks.py: HDF5 from one thread at a time."""
import sys
import threading
from contextlib import contextmanager

# HDF5 is not thread-safe.  h5py, which shares the library, has a lock of its own.
LOCK = threading.RLock()


@contextmanager
def hdf5():
    """Holds the locks of HDF5: for calls that read or write archives.  Other threads wait for them."""
    with LOCK:
        if "h5py" not in sys.modules:
            yield
            return
        with sys.modules["h5py"]._objects.phil:  # documented, despite its underscore
            yield
