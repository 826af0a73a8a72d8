"""tests/app/crash.py: a run that is killed repeatedly at random times, and the checks after each kill.

Checks immediately after each kill -9, before any drover command touches the files:
- h5py and xarray read the archive, if it exists, as it is.  They fail only if the kill fell between the first and last
  write of a commit's overwriting, a tenth of a millisecond (about one kill in a hundred); then the journal that repairs
  the file is beside it, and the first drover command, here `info`, applies it.
- Every frame in it has the bytes of the uninterrupted run.
- Nothing that is known to have been committed is missing: the frames that a plain reader saw while the run went on, and
  those that the newest checkpoint on the disk counts.  A checkpoint of step s is only written after the frames up to s;
  with a checkpoint at each step (checkpoint_minutes = 0) the run was killed at step s or s + 1, so that at most one
  frame is lost.  The test of a diverging run in test_commands.py shows that its frames are committed, also without
  checkpoints.
"""
import random
import time

import h5py
import xarray
from support import assert_same_bytes, checkpoint_step, checkpoints, drover, end_group, frame_count, start, write_scene

STEPS_PER_FRAME = 2
FRAMES = 60
BUSY = {"grid.nx": 24, "grid.ny": 32, "time.end": 0.1 * STEPS_PER_FRAME * FRAMES,
        "output.frame_every": 0.1 * STEPS_PER_FRAME,
        "output.sample_every": 0.1, "output.checkpoint_minutes": 0.0005}
FIELDS = ("rod_density", "polar_order_x", "polar_order_y")


def make_whole(folder):
    """The uninterrupted run that all others are compared with."""
    drover(folder, "run", write_scene(folder, BUSY, name="whole.toml"), "--quiet")
    assert frame_count(folder / "whole.h5") == FRAMES + 1
    return folder / "whole.h5"


def frames_seen(archive):
    """Frames that a plain reader finds in an archive, possibly during a commit; 0: not readable now."""
    try:
        return frame_count(archive)
    except (OSError, KeyError, RuntimeError):
        return 0


def kill_at(process, archive, frames, delay):
    """Kills a run `delay` after it has some frames (0: after its start); returns the maximum number of frames seen."""
    seen, deadline = 0, None if frames else time.monotonic() + delay
    while process.poll() is None and (deadline is None or time.monotonic() < deadline):
        seen = max(seen, frames_seen(archive)) if frames else 0
        if deadline is None and seen >= frames:
            deadline = time.monotonic() + delay
    process.kill()
    process.wait()
    end_group(process)
    return seen


def check_frames(archive, whole, at_least):
    """All frames are those of the uninterrupted run, and there are enough; for h5py and for xarray."""
    with h5py.File(archive) as file, h5py.File(whole) as model:
        count = len(file["time"])
        assert at_least <= count <= len(model["time"])
        for name in ("time", *FIELDS):
            assert file[name][()].tobytes() == model[name][:count].tobytes(), name
        samples = len(file["observables/time"])
        assert samples >= (count - 1) * STEPS_PER_FRAME + (count > 0)
        assert file["observables/polar_order"][()].tobytes() == model["observables/polar_order"][:samples].tobytes()
    with xarray.open_dataset(archive) as frames, xarray.open_dataset(archive, group="observables") as observed:
        assert frames.sizes["time"] == count and frames["rod_density"].dims == ("time", "y", "x")
        assert observed.sizes["time"] == samples
    return count


def newest_step(archive):
    """The step of the newest checkpoint; None when there is none."""
    steps = [checkpoint_step(file) for file in checkpoints(archive) if file.exists()]
    return max(steps, default=None)


def check_after_kill(folder, archive, whole, seen):
    """The checks after a kill.  Returns whether the kill fell between two writes of a commit."""
    if not archive.exists():
        assert seen == 0 and newest_step(archive) is None
        return False
    step = newest_step(archive)
    committed = max(seen, 0 if step is None else step // STEPS_PER_FRAME + 1)
    torn = False
    try:
        count = check_frames(archive, whole, committed)
    except Exception:  # any error of a reader of a file between two commits
        torn = archive.with_name(archive.name + ".journal").exists()
        if not torn:
            raise
        drover(folder, "info", archive)
        count = check_frames(archive, whole, committed)
    assert step is not None or count <= 1  # the first frame is followed by a checkpoint
    return torn


def go_on(folder, archive, name):
    """The command that a user would give next."""
    if newest_step(archive) is not None:
        return ["restart", archive.name, "--quiet"]
    return ["run", name, "--quiet", "--overwrite"]


def kill_again_and_again(folder, whole, kills, seed, checkpoint_minutes):
    """A run that is killed `kills` times and ends with the same bytes.  Returns how many kills hit it while running."""
    dice = random.Random(seed)
    name = write_scene(folder, {**BUSY, "output.checkpoint_minutes": checkpoint_minutes}, name="killed.toml")
    archive = folder / "killed.h5"
    met = torn = 0
    for _ in range(kills):
        already = frames_seen(archive)
        # One in four during start-up; the others after some more frames, at a random time within about two frames.
        ahead = 0 if dice.random() < 0.25 else dice.randint(1, max(1, 3 * FRAMES // (2 * kills)))
        process = start(folder, *go_on(folder, archive, name))
        try:
            seen = kill_at(process, archive, min(already + ahead, FRAMES) if ahead else 0, dice.uniform(0.0, 0.06))
        finally:
            end_group(process)
        met += process.returncode == -9
        torn += check_after_kill(folder, archive, whole, seen)
    drover(folder, *go_on(folder, archive, name))
    assert_same_bytes(whole, archive)
    assert sorted(file.name for file in folder.glob("killed.h5*")) == [
        "killed.h5", "killed.h5.checkpoint-a", "killed.h5.checkpoint-b"]
    assert torn <= 2
    return met
