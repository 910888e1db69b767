"""Silence for foreign code that prints from C."""
import ctypes
import os
import sys
from contextlib import contextmanager


@contextmanager
def quiet():
    """Whatever is printed to standard output meanwhile, from Python or from C, is dropped."""
    libc = ctypes.CDLL(None)
    sys.stdout.flush()
    libc.fflush(None)
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        libc.fflush(None)
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
