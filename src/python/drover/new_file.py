"""drover/new_file.py: files that appear under their name when they are complete and on the disk."""
import os
from contextlib import contextmanager
from pathlib import Path

from drover.error import Error


def create(path):
    """An empty file of this process alone, in place of a left-over or a link of that name; returns its descriptor."""
    path.unlink(missing_ok=True)
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)


@contextmanager
def part_of(path):
    """A name beside a path, for a file that replaces it at the end of the block; removed after an exception."""
    place = Path(os.path.realpath(path))
    part = place.with_name(f".{place.name}.part")
    try:
        file = create(part)
    except OSError as error:
        raise Error(f"{path} cannot be written ({error.strerror}); choose another path") from error
    try:
        yield part
        if not is_at(file, part):
            raise Error(f"{path}: another process wrote this file at the same time; write to another path, or wait for "
                        "it", fault="run")
        sync(part)
        os.replace(part, place)
        sync(place.parent)
    finally:
        if is_at(file, part):
            part.unlink()
        os.close(file)


def is_at(file, path):
    """Whether an open file has this name."""
    try:
        return os.path.samestat(os.fstat(file), os.stat(path, follow_symlinks=False))
    except FileNotFoundError:
        return False


def write(path, content):
    """Writes the complete bytes or nothing."""
    with part_of(path) as part:
        part.write_bytes(content)


def sync(path):
    """Waits until a file or folder is on the disk."""
    file = os.open(path, os.O_RDONLY)
    try:
        os.fsync(file)
    finally:
        os.close(file)
