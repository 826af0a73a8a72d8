"""tests/app/test_boundary_shares.py: phase boundaries by several processes are those of one, to the byte."""
import os
import signal
import time

import h5py
import pytest
from support import MODELS, drover, end_group, not_sanitized, start

PLANE = ["--x", "coefficients.a = 2.5:4", "--y", "coefficients.b = 5:13", "--set", "boundary.cells=6", "--set",
         "boundary.map=3", "--set", 'boundary.errors=["coefficients.Du = 0.1"]', "--draws", "6"]
WORDS = ["boundary", MODELS / "brusselator.toml", *PLANE]


@pytest.fixture(name="alone", scope="module")
def fixture_alone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("alone")
    drover(folder, *WORDS, "-o", "plane.h5")
    return folder / "plane.h5"


def numbers_in(archive):
    found = {}
    with h5py.File(archive) as file:
        file.visititems(lambda name, item: found.update({name: item[...].tobytes()})
                        if isinstance(item, h5py.Dataset) else None)
    return found


@not_sanitized
def test_three_shares_one_of_which_is_killed_give_the_archive_of_one_process(alone, tmp_path):
    shares = [start(tmp_path, *WORDS, "-o", "plane.h5", "--quiet", "--workers", "1", "--share", f"{share}/3")
              for share in (1, 2, 3)]
    time.sleep(0.7)  # any moment will do
    end_group(shares[0])
    assert [share.wait(timeout=120) for share in shares[1:]] == [0, 0]
    assert not (tmp_path / "plane.h5").exists()
    assert " 0 failed, 0 running" in drover(tmp_path, *WORDS, "-o", "plane.h5", "--status").stdout
    drover(tmp_path, *WORDS, "-o", "plane.h5", "--collect")
    assert numbers_in(tmp_path / "plane.h5") == numbers_in(alone)


def test_collecting_before_the_end_says_what_to_do_and_the_plain_command_goes_on(alone, tmp_path):
    share = start(tmp_path, *WORDS, "-o", "plane.h5", "--quiet", "--workers", "1", "--share", "1/2")
    records = tmp_path / "plane.h5.shares" / "records"
    while not records.exists() or not any(file.stat().st_size for file in records.iterdir()):
        time.sleep(0.01)
    os.kill(share.pid, signal.SIGTERM)
    assert share.wait(timeout=60) in (0, 3)
    ended = drover(tmp_path, *WORDS, "-o", "plane.h5", "--collect", status=None)
    assert ended.returncode in (0, 1)
    if ended.returncode:
        assert "without --collect" in ended.stderr and not (tmp_path / "plane.h5").exists()
        drover(tmp_path, *WORDS, "-o", "plane.h5")
    assert numbers_in(tmp_path / "plane.h5") == numbers_in(alone)


def test_shares_of_another_plane_and_of_tables_are_refused(tmp_path):
    drover(tmp_path, *WORDS, "-o", "plane.h5", "--set", "boundary.map=0", "--share", "1/2", "--quiet")
    ended = drover(tmp_path, *WORDS, "-o", "plane.h5", "--set", "boundary.cells=8", "--share", "1/2", status=2)
    assert "cells" in ended.stderr and "another" in ended.stderr
    table = MODELS / "matched.calibration" / "table.h5"
    assert "apply to scenes" in drover(tmp_path, "boundary", table, "--share", "1/2", status=2).stderr


def test_a_plane_of_rods_and_beads_is_shared_with_its_errors(tmp_path):
    words = ["boundary", MODELS / "phase-boundary.toml", "--set", "boundary.map=0", "--set", "boundary.cells=6",
             "--draws", "6"]
    drover(tmp_path, *words, "-o", "alone.h5")
    drover(tmp_path, *words, "-o", "plane.h5", "--share", "1/2", "--quiet")
    drover(tmp_path, *words, "-o", "plane.h5", "--collect")
    assert numbers_in(tmp_path / "plane.h5") == numbers_in(tmp_path / "alone.h5")


def test_the_folder_of_another_plane_does_not_stop_a_plain_command(tmp_path):
    words = ["boundary", MODELS / "phase-boundary.toml", "--set", "boundary.map=0", "--set", "boundary.cells=16",
             "--draws", "0"]
    drover(tmp_path, *words, "-o", "plane.h5", "--share", "1/2", "--quiet")
    drover(tmp_path, *words, "--set", "boundary.cells=8", "-o", "plane.h5")
    assert "--overwrite" in drover(tmp_path, *words, "-o", "plane.h5", "--slurm", "3", status=2).stderr
    assert "--overwrite" in drover(tmp_path, *words, "-o", "plane.h5", "--slurm", "3", "--overwrite").stdout


def test_a_table_needs_draws(tmp_path):
    table = MODELS / "matched.calibration" / "table.h5"
    assert "expected at least 20" in drover(tmp_path, "boundary", table, "--draws", "0", status=2).stderr
