"""tests/app/test_crash.py: after kill -9, a damaged checkpoint or a full disk the run resumes to the same bytes."""
import contextlib
import os
import resource
import signal
import subprocess

import h5py
import pytest
from crash import BUSY, FRAMES, check_frames, kill_again_and_again, kill_at, make_whole
from support import (assert_same_bytes, checkpoint_step, checkpoints, damage, drover, end_group, environment, start,
                     tree, wait_until, write_scene)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return make_whole(tmp_path_factory.mktemp("whole"))


@pytest.mark.parametrize("checkpoint_minutes, kills, seed", [(0.0005, 3, 1), (0.0, 2, 2)])
def test_a_run_killed_at_any_time_resumes_to_the_same_bytes(checkpoint_minutes, kills, seed, tmp_path, whole):
    assert kill_again_and_again(tmp_path, whole, kills, seed, checkpoint_minutes) > 0


def test_a_run_killed_before_its_second_checkpoint_resumes_from_the_start(tmp_path):
    # Long enough for a commit by number of frames, however fast the machine is, and most of the run after it.
    scene = {**BUSY, "time.end": 6.0 * BUSY["time.end"], "output.checkpoint_minutes": 60.0}
    drover(tmp_path, "run", write_scene(tmp_path, scene, name="whole.toml"), "--quiet")
    whole = tmp_path / "whole.h5"
    process = start(tmp_path, "run", write_scene(tmp_path, scene, name="killed.toml"), "--quiet")
    try:
        kill_at(process, tmp_path / "killed.h5", 5, 0.0)
    finally:
        end_group(process)
    assert process.returncode == -signal.SIGKILL
    assert [checkpoint_step(file) for file in checkpoints(tmp_path / "killed.h5") if file.exists()] == [0]
    if (tmp_path / "killed.h5.journal").exists():  # killed within a commit: the first command completes it
        drover(tmp_path, "info", "killed.h5")
    check_frames(tmp_path / "killed.h5", whole, 5)
    drover(tmp_path, "restart", "killed.h5", "--quiet")
    assert_same_bytes(whole, tmp_path / "killed.h5")


def newest_and_other(archive):
    newest, other = sorted(checkpoints(archive), key=checkpoint_step, reverse=True)
    return newest, other


def cut(file):
    file.write_bytes(file.read_bytes()[:-100])


# Ways in which a checkpoint can be damaged.
DAMAGES = {
    "one bit in its middle": damage,
    "one bit of its first word": lambda file: damage(file, 3),
    "one bit of its version": lambda file: damage(file, 8),
    "one bit of its length": lambda file: damage(file, 17),
    "one bit of its step": lambda file: damage(file, 28),
    "one bit of its checksum": lambda file: damage(file, -1),
    "an end that is missing": cut,
    "nothing in it": lambda file: file.write_bytes(b""),
    "more than it had": lambda file: file.write_bytes(file.read_bytes() + b"rods"),
    "other bytes": lambda file: file.write_bytes(b"rods" * 2000),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_a_checkpoint_is_skipped_that_has(name, tmp_path):
    drover(tmp_path, "run", write_scene(tmp_path, name="whole.toml"), "--quiet")
    drover(tmp_path, "run", write_scene(tmp_path, {"time.end": 20.0, "output.checkpoint_minutes": 0.0}), "--quiet")
    newest, other = newest_and_other(tmp_path / "flock.h5")
    assert checkpoint_step(newest) == 200 and checkpoint_step(other) == 199
    DAMAGES[name](newest)
    ended = drover(tmp_path, "restart", "flock.h5", "--set", "time.end=40.0", "--set", "output.checkpoint_minutes=5.0",
                   "--quiet")
    warning = ended.stderr.splitlines()[0]
    assert "warning: " in warning and newest.name in warning, ended.stderr
    assert "using the other one, of step 199" in warning, ended.stderr
    assert_same_bytes(tmp_path / "whole.h5", tmp_path / "flock.h5")


@contextlib.contextmanager
def small_disk(folder, kilobytes):
    """A file system in memory of a given size, and a function that enlarges it."""
    if os.geteuid() != 0:
        pytest.skip("mounting a small disk needs root")
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "drover-test", folder],
                          capture_output=True, text=True,
                          check=False)
    if made.returncode != 0:
        pytest.skip(f"no small disk can be mounted here: {made.stderr.strip()}")

    def grow(more):
        subprocess.run(["mount", "-o", f"remount,size={more}k", folder], check=True, capture_output=True)

    try:
        yield grow
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True, capture_output=True)


def assert_reports_full(ended, what):
    """The message is one line with the bytes needed and free, and a remedy."""
    lines = ended.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and ended.stdout == "", ended.stderr
    assert what in lines[0] and "B were needed and" in lines[0] and "B are free" in lines[0], ended.stderr
    assert ("raise this limit, then" if "ulimit" in what else "make room, then") in lines[0], ended.stderr


# Disks that are full at different times: while the archive grows, or at a checkpoint.
@pytest.mark.parametrize("kilobytes", [560, 700, 1000])
@pytest.mark.parametrize("checkpoint_minutes", [0.0, 60.0])
def test_a_run_on_a_full_disk_keeps_its_data_and_can_resume(kilobytes, checkpoint_minutes, tmp_path, whole):
    disk = tmp_path / "disk"
    disk.mkdir()
    with small_disk(disk, kilobytes) as grow:
        scene = write_scene(tmp_path, {**BUSY, "output.checkpoint_minutes": checkpoint_minutes,
                                       "output.file": "disk/flock.h5"})
        assert_reports_full(drover(tmp_path, "run", scene, "--quiet", status=1), "the disk is full")
        before = check_frames(disk / "flock.h5", whole, 1)
        assert before < FRAMES
        again = drover(tmp_path, "restart", "disk/flock.h5", "--quiet",
                       status=1)  # still full: the same message, no data lost
        assert_reports_full(again, "the disk is full")
        check_frames(disk / "flock.h5", whole, 1)
        grow(8000)
        drover(tmp_path, "restart", "disk/flock.h5", "--quiet")
        assert_same_bytes(whole, disk / "flock.h5")


def test_a_disk_too_full_to_start_is_left_unchanged(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    with small_disk(disk, 64):
        scene = write_scene(tmp_path, {**BUSY, "output.file": "disk/flock.h5"})
        ended = drover(tmp_path, "run", scene, "--quiet", status=1)
        assert "the disk is full" in ended.stderr and len(ended.stderr.splitlines()) == 1
        assert tree(disk) == {}


@pytest.mark.parametrize("kilobytes", [300, 450])
def test_the_file_size_limit_stops_a_run_like_a_full_disk(kilobytes, tmp_path, whole):
    scene = write_scene(tmp_path, BUSY)

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (1024 * kilobytes, 1024 * kilobytes))

    ended = drover(tmp_path, "run", scene, "--quiet", status=1, preexec_fn=limit)
    assert_reports_full(ended, "the largest file size allowed (ulimit -f) is reached")
    assert check_frames(tmp_path / "flock.h5", whole, 1) < FRAMES
    drover(tmp_path, "restart", "flock.h5", "--quiet")
    assert_same_bytes(whole, tmp_path / "flock.h5")


def test_two_runs_do_not_write_the_same_archive(tmp_path):
    process = start(tmp_path, "run", write_scene(tmp_path, {"time.end": 10000.0}), "--quiet")
    try:
        wait_until(checkpoints(tmp_path / "flock.h5")[0].exists, "the first checkpoint", process=process)
        for words in (["restart", "flock.h5"], ["run", "flock.toml", "--overwrite"]):
            ended = drover(tmp_path, *words, "--quiet", status=2)
            assert "another process is writing this file" in ended.stderr, ended.stderr
        assert process.poll() is None
    finally:
        end_group(process)


def test_a_run_that_was_killed_before_its_first_checkpoint_is_started_anew_by_restart(tmp_path, whole):
    drover(tmp_path, "run", write_scene(tmp_path, BUSY), "--quiet")
    archive = tmp_path / "flock.h5"
    for checkpoint in checkpoints(archive):
        checkpoint.unlink()
    assert "has no checkpoint; expected" in drover(tmp_path, "restart", archive, status=2).stderr

    def cut(name, item):  # to what a run has when it writes its first checkpoint
        if isinstance(item, h5py.Dataset) and item.maxshape and item.maxshape[0] is None:
            item.resize(1, axis=0)

    with h5py.File(archive, "r+") as file:
        del file["summary"]
        file.visititems(cut)
    assert "has no checkpoint yet: the run starts anew" in drover(tmp_path, "restart", archive).stderr
    assert_same_bytes(whole, archive)


@pytest.mark.skipif("DROVER_SHIM" not in os.environ, reason="DROVER_SHIM is not set; ctest sets it")
def test_workers_that_cannot_send_their_results_end_a_sweep(tmp_path):
    scene = write_scene(tmp_path, {"time.end": 2.0, "output.frame_every": 1.0, "sweep.seeds": 2})
    failing = environment(LD_PRELOAD=os.environ["DROVER_SHIM"], DROVER_FAULT="write:1:EIO:always")
    ended = drover(tmp_path, "sweep", scene, "--quiet", "--workers", "1", status=1, env=failing)
    assert ended.stderr.startswith("error: ") and "could not send its results" in ended.stderr
    drover(tmp_path, "sweep", scene, "--quiet")
