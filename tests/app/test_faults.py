"""tests/app/test_faults.py: closed streams, signals, pipes, links, short memory, huge and hostile input."""
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import time

import h5py
import numpy
import pytest
from support import (DROVER, MODELS, assert_same_bytes, checkpoints, contents, damage, drover, end_group, environment,
                     start, tree, wait_until, write_scene)

SHORT = {"time.end": 4.0, "output.frame_every": 1.0, "output.checkpoint_minutes": 0.0}
LONG = {"time.end": 1e6, "output.checkpoint_minutes": 60.0}


def archive_of(folder, name="flock.toml", **changes):
    """The archive of a short run."""
    drover(folder, "run", write_scene(folder, {**SHORT, **changes}, name=name), "--quiet")
    return folder / name.replace(".toml", ".h5")


def one_sentence(ended):
    """The one line that a failed command prints."""
    lines = ended.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and "bug in drover" not in lines[0], ended.stderr
    return lines[0]


@pytest.mark.parametrize("closed", ["2>&-", "0>&- 2>&-", "0>&- 1>&- 2>&-"])
def test_a_run_with_closed_standard_streams_writes_its_archive(closed, tmp_path):
    whole = archive_of(tmp_path, "whole.toml")
    write_scene(tmp_path, SHORT)
    ended = subprocess.run(["sh", "-c", f'"{DROVER}" run flock.toml {closed}'], cwd=tmp_path, env=environment(),
                           stdout=subprocess.DEVNULL, check=False)
    assert ended.returncode == (1 if "1>&-" in closed else 0)  # 1: the results could not be printed
    assert_same_bytes(whole, tmp_path / "flock.h5")


def test_results_for_a_closed_standard_output_are_a_failure(tmp_path):
    archive_of(tmp_path)
    ended = subprocess.run(["sh", "-c", f'"{DROVER}" info flock.h5 1>&-'], cwd=tmp_path, env=environment(),
                           capture_output=True, text=True, check=False)
    assert ended.returncode == 1 and "could not be written to standard output" in one_sentence(ended)


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM, signal.SIGINT, signal.SIGUSR1, signal.SIGUSR2,
                                    signal.SIGXCPU])
def test_a_signal_stops_a_run_after_a_checkpoint(number, tmp_path):
    process = start(tmp_path, "run", write_scene(tmp_path, LONG), "--quiet")
    try:
        wait_until(checkpoints(tmp_path / "flock.h5")[0].exists, "the first checkpoint", process=process)
        process.send_signal(number)
        assert process.wait(20) == 3
        assert all(file.exists() for file in checkpoints(tmp_path / "flock.h5"))
    finally:
        end_group(process)


def test_a_limit_of_the_time_of_the_processor_stops_a_run_after_a_checkpoint(tmp_path):
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (1, 20))
    ended = drover(tmp_path, "run", write_scene(tmp_path, LONG), status=3, preexec_fn=limit)
    assert f"stopped by signal {int(signal.SIGXCPU)} at step" in ended.stderr


def test_a_run_ends_at_its_largest_time_and_its_sentence_resumes_it(tmp_path):
    scene = write_scene(tmp_path, {**LONG, "output.frame_every": 1.0})
    ended = drover(tmp_path, "run", scene, "--max-time", "0:01", status=3)
    last = ended.stderr.splitlines()[-1]
    assert "stopped by --max-time at step" in last
    words = last.partition("to resume: drover ")[2].split()
    assert words == ["restart", "flock.h5"]
    ended = drover(tmp_path, *words, "--max-time", "0.5", status=3)
    assert "stopped by --max-time" in ended.stderr
    drover(tmp_path, "run", scene, "--max-time", "1 year", status=2)
    drover(tmp_path, "run", write_scene(tmp_path, SHORT, name="short.toml"), "--max-time", "11:30:00")


@pytest.mark.parametrize("command", ["sweep", "calibrate"])
def test_jobs_end_at_their_largest_time(command, tmp_path):
    scene = write_long_trials(tmp_path) if command == "calibrate" else write_scene(
        tmp_path, {**LONG, "sweep.seeds": 2, "sweep.workers": 2})
    ended = drover(tmp_path, command, scene, "--max-time", "2s", status=3, seconds=60)
    assert "stopped by --max-time" in ended.stderr and "re-run the same command to resume" in ended.stderr


def test_a_run_under_nohup_goes_on_after_a_hangup(tmp_path):
    process = start(tmp_path, "run", write_scene(tmp_path, LONG), "--quiet",
                    preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    try:
        wait_until(checkpoints(tmp_path / "flock.h5")[0].exists, "the first checkpoint", process=process)
        process.send_signal(signal.SIGHUP)
        time.sleep(0.3)
        assert process.poll() is None
    finally:
        end_group(process)


def test_a_second_interrupt_ends_a_run_at_once(tmp_path):
    process = start(tmp_path, "calibrate", write_long_trials(tmp_path), "--quiet")
    try:
        wait_until(lambda: list(tmp_path.glob("long.calibration/claims/damping-*")), "the first trial", 60.0, process)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        assert process.wait(3) == -signal.SIGINT
    finally:
        end_group(process)


def write_long_trials(folder):
    """A calibration whose single trial lasts minutes."""
    (folder / "long.toml").write_text("""
[cell]
lx = 13.5
ly = 13.5
[plates]
amplitude = 0.05
[beads]
area_fraction = 0.5
[time]
dt = 2e-5
[calibrate]
bead_area_fractions = [0.5]
assays = ["damping"]
workers = 1
[calibrate.damping]
time = 1000.0
""")
    return "long.toml"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_a_command_that_cannot_be_resumed(number, tmp_path):
    scene = write_scene(tmp_path, {"stability.wavenumbers": 4096, "stability.angles": 4096,
                                   "initial.kind": "uniform"})
    process = start(tmp_path, "stability", scene, "-o", "maps.h5")
    try:
        time.sleep(1.5)
        assert process.poll() is None
        process.send_signal(number)
        assert process.wait(3) == -number
    finally:
        end_group(process)


def test_a_killed_sweep_takes_its_workers_with_it_and_resumes_at_once(tmp_path):
    changes = {"time.end": 100.0, "output.checkpoint_minutes": 60.0, "sweep.vary": ["relaxation.rate = 0.5, 1"],
               "sweep.workers": 2}
    scene = write_scene(tmp_path, changes)
    process = start(tmp_path, "sweep", scene, "--quiet")
    try:
        first = tmp_path / "flock.sweep" / "point-0000-seed-7.h5"
        wait_until(checkpoints(first)[0].exists, "the first checkpoint", process=process)
        os.kill(process.pid, signal.SIGKILL)
        ended = drover(tmp_path, "sweep", scene, "--quiet")
        assert "damaged" not in ended.stderr and "failed" not in ended.stderr
    finally:
        end_group(process)


def test_two_sweeps_in_one_folder_share_the_runs(tmp_path):
    scene = write_scene(tmp_path, {**SHORT, "sweep.seeds": 6, "sweep.workers": 1})
    processes = [start(tmp_path, "sweep", scene, "--quiet") for _ in range(2)]
    try:
        assert [process.wait(timeout=60) for process in processes] == [0, 0]
    finally:
        for process in processes:
            end_group(process)
    assert len(list((tmp_path / "flock.sweep").glob("*.h5"))) == 6


def test_a_reader_never_calls_an_archive_damaged_that_is_being_written(tmp_path):
    changes = {"time.end": 1e5, "output.frame_every": 0.2, "output.sample_every": 0.1, "grid.nx": 32, "grid.ny": 32}
    process = start(tmp_path, "run", write_scene(tmp_path, changes), "--quiet")
    try:
        wait_until(checkpoints(tmp_path / "flock.h5")[0].exists, "the first checkpoint", process=process)
        time.sleep(0.2)
        for _ in range(12):
            drover(tmp_path, "info", "flock.h5")
        assert process.poll() is None
    finally:
        end_group(process)


@pytest.mark.parametrize("words", [["info", "pipe.h5"], ["restart", "pipe.h5"], ["export", "pipe.h5", "-o", "x.xyz"],
                                   ["run", "flock.toml", "-o", "pipe.h5", "--overwrite"],
                                   ["run", "flock.toml", "--set", "initial.kind=file", "--set",
                                    "initial.file=pipe.h5"]])
def test_a_pipe_as_archive_is_rejected_and_not_waited_for(words, tmp_path):
    os.mkfifo(tmp_path / "pipe.h5")
    write_scene(tmp_path, SHORT)
    one_sentence(drover(tmp_path, *words, status=2, seconds=10))


@pytest.mark.parametrize("name", ["checkpoint-a", "journal"])
def test_a_pipe_beside_an_archive_is_rejected_and_not_waited_for(name, tmp_path):
    archive = archive_of(tmp_path)
    beside = archive.with_name(f"flock.h5.{name}")
    beside.unlink(missing_ok=True)
    os.mkfifo(beside)
    ended = drover(tmp_path, "restart", "flock.h5", "--set", "time.end=5", status=None, seconds=10)
    assert "is not a plain file" in ended.stderr


def test_a_run_whose_archive_is_deleted_says_what_can_be_done_and_that_works(tmp_path):
    archive = tmp_path / "flock.h5"
    process = start(tmp_path, "run", write_scene(tmp_path, {**LONG, "output.frame_every": 0.0}), "--quiet")
    try:
        wait_until(checkpoints(archive)[0].exists, "the first checkpoint", process=process)
        archive.unlink()
        process.send_signal(signal.SIGTERM)
        _, log = process.communicate(timeout=20)
        assert process.returncode == 1 and "the archive was deleted while the run wrote it" in log
        assert "to resume: drover restart flock.h5" in log
    finally:
        end_group(process)
    drover(tmp_path, "restart", "flock.h5", "--quiet", "--set", "time.end=2.0")  # from the checkpoint of the start
    whole = {**LONG, "output.frame_every": 0.0, "time.end": 2.0}
    drover(tmp_path, "run", write_scene(tmp_path, whole, name="whole.toml"), "--quiet")
    assert_same_bytes(tmp_path / "whole.h5", archive)


@pytest.mark.parametrize("loss, words", [
    (lambda archive: archive.rename(archive.with_name("away.h5")), "was moved to "),
    (lambda archive: archive.write_bytes(b"a thesis"), "cut the archive to 8 of ")])
def test_the_next_commit_of_a_run_notices_that_its_archive_is_lost(loss, words, tmp_path):
    process = start(tmp_path, "run", write_scene(tmp_path, LONG), "--quiet")
    try:
        wait_until(checkpoints(tmp_path / "flock.h5")[0].exists, "the first checkpoint", process=process)
        loss(tmp_path / "flock.h5")
        _, log = process.communicate(timeout=60)
        assert process.returncode == 1 and words in log and log.count("\n") == 1
        assert ("drover restart" in log) == (tmp_path / "away.h5").exists()
    finally:
        end_group(process)


def test_an_archive_behind_a_symbolic_link_is_replaced_and_resumed_like_the_file_itself(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link.h5").symlink_to("there/flock.h5")
    whole = archive_of(tmp_path, "whole.toml", **{"time.end": 6.0})
    drover(tmp_path, "run", write_scene(tmp_path, SHORT), "--quiet", "-o", "link.h5")
    drover(tmp_path, "run", "flock.toml", "--quiet", "-o", "link.h5", "--overwrite")
    assert (tmp_path / "link.h5").is_symlink()
    drover(tmp_path, "restart", "link.h5", "--quiet", "--set", "time.end=6.0")
    assert_same_bytes(whole, tmp_path / "there" / "flock.h5")
    assert sorted(tree(tmp_path / "there")) == ["flock.h5", "flock.h5.checkpoint-a", "flock.h5.checkpoint-b"]


@pytest.mark.parametrize("changes, words", [
    ({"grid.nx": 65536, "grid.ny": 65536}, "choose a smaller grid"),
    ({"sweep.vary": ["relaxation.rate = 1:2:100000", "noise.order = 1:2:100000"]}, "a sweep of 1e+10 runs")])
def test_check_rejects_huge_scenes_at_once(changes, words, tmp_path):
    ended = drover(tmp_path, "check", write_scene(tmp_path, changes), status=2, seconds=10,
                   preexec_fn=limit_memory)
    assert words in one_sentence(ended)


def limit_memory():
    """One gigabyte."""
    resource.setrlimit(resource.RLIMIT_DATA, (1 << 30, 1 << 30))


@pytest.mark.parametrize("text", [".".join(["a"] * 40000) + " = 1\n", "[" + ".".join(["a"] * 40000) + "]\n",
                                  "[a]\nb = " + "[" * 40000, "a = { " + ".".join(["a"] * 40000) + " = 1 }\n",
                                  "'" + ".".join(["a"] * 40000) + "' = 1\n"])
def test_deep_toml_is_an_error_with_a_place(text, tmp_path):
    (tmp_path / "deep.toml").write_text(text)
    assert "deep.toml:" in one_sentence(drover(tmp_path, "check", "deep.toml", status=2, seconds=10))


def test_dots_in_texts_and_comments_are_not_parts_of_keys(tmp_path):
    name = write_scene(tmp_path)
    dots = "." * 100
    written = (tmp_path / name).read_text()
    (tmp_path / name).write_text(f"# {dots} \" '\n" + written.replace(
        "[output]", f"[output]\nfile = \"a{dots}b.h5\" # {dots}").replace(
        "[initial]", f"[stability] # '''\n\n[initial]\nfile = '''{dots}'\n{dots}'''"))
    drover(tmp_path, "check", name)


def test_a_file_that_inflates_to_gigabytes_is_rejected(tmp_path):
    archive = archive_of(tmp_path)
    with h5py.File(archive, "r+") as file:
        del file["observables/time"]
        data = numpy.zeros(15_000_000)  # 300 times the size of the file
        file["observables"].create_dataset("time", data=data, chunks=(1_000_000,), compression=9)
    ended = drover(tmp_path, "info", "flock.h5", status=2, preexec_fn=limit_memory)
    assert "expected no more than a file of that size can hold" in one_sentence(ended)


def test_an_archive_of_many_groups_is_rejected_at_once(tmp_path):
    archive = archive_of(tmp_path)
    with h5py.File(archive, "r+") as file:
        for number in range(20000):
            file.create_group(f"extra-{number}")
    ended = drover(tmp_path, "restart", "flock.h5", "--set", "time.end=5", status=2, seconds=10)
    assert "more than 5000 objects; expected at most that many" in one_sentence(ended)


def test_escape_sequences_of_a_file_are_not_printed(tmp_path):
    archive = archive_of(tmp_path)
    with h5py.File(archive, "r+") as file:
        file.attrs["host"] = numpy.bytes_(b"\x1b]0;owned\x07\xc2\x9b2J\x9b")
    for words in (["info", "flock.h5"], ["info", "flock.h5", "--scene"]):
        out = subprocess.run([DROVER, *words], cwd=tmp_path, capture_output=True, env=environment(), check=True).stdout
        assert rb"\x1b]0;owned\x07" in out and b"\x1b" not in out and b"\x9b" not in out
    json.loads(drover(tmp_path, "info", "flock.h5", "--json").stdout)


def test_a_start_from_a_file_with_other_units_is_rejected(tmp_path):
    archive = archive_of(tmp_path, "first.toml")
    with h5py.File(archive, "r+") as file:
        file["rod_density"].attrs["units"] = numpy.bytes_("cm-2")
    scene = write_scene(tmp_path, {"initial.kind": "file", "initial.file": "first.h5"})
    ended = drover(tmp_path, "run", scene, status=2)
    assert "has rod_density in cm-2; expected" in one_sentence(ended)


def test_a_start_that_overflows_leaves_no_frame(tmp_path):
    scene = write_scene(tmp_path, {"initial.kind": "random", "initial.amplitude": 1e308})
    ended = drover(tmp_path, "run", scene, "--quiet", status=1)
    assert "NaN or infinite" in one_sentence(ended) and sorted(tree(tmp_path)) == ["flock.toml"]


@pytest.mark.parametrize("place", [0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.95])
def test_a_damaged_archive_is_resumed_or_rejected_without_a_signal(place, tmp_path):
    archive = archive_of(tmp_path)
    size = archive.stat().st_size
    for shift in (0, 40, 4096):
        copy = tmp_path / "copy.h5"
        copy.write_bytes(archive.read_bytes())
        for other, mine in zip(checkpoints(archive), checkpoints(copy)):
            mine.write_bytes(other.read_bytes())
        damage(copy, min(size - 1, int(size * place) + shift))
        ended = drover(tmp_path, "restart", "copy.h5", "--quiet", "--set", "time.end=5.0", status=None, seconds=20)
        assert ended.returncode in (0, 2), ended
        if ended.returncode == 2:
            one_sentence(ended)


def test_a_short_memory_ends_a_run_with_a_sentence_or_within_hdf5(tmp_path):
    archive_of(tmp_path, "whole.toml")
    write_scene(tmp_path, SHORT)
    expected = contents(tmp_path / "whole.h5")
    statuses = set()
    for kilobytes in range(20000, 100000, 2000):
        loads = f'ulimit -v {kilobytes}; "{DROVER}" --version > /dev/null 2>&1 || exit 127'  # too little for libraries
        ended = subprocess.run(["sh", "-c", f'{loads}; "{DROVER}" run flock.toml --quiet --overwrite'],
                               cwd=tmp_path, env=environment(), capture_output=True, text=True, check=False)
        assert ended.returncode in (0, 1, 2, 127) or ended.returncode > 128, (kilobytes, ended)  # a signal, of HDF5
        if ended.returncode == 0:
            assert contents(tmp_path / "flock.h5") == expected
        elif ended.returncode < 127:
            one_sentence(ended)
        statuses.add(ended.returncode)
    assert 0 in statuses


def test_a_read_that_fails_is_not_the_end_of_a_scene(tmp_path):
    for words in (["check", "/proc/self/mem"], ["run", "/proc/self/mem", "--quiet", "-o", "x.h5"]):
        ended = drover(tmp_path, *words, status=1)
        assert "/proc/self/mem: the disk reports a failure: read: Input/output error" in one_sentence(ended)
    assert tree(tmp_path) == {}


RESULTS = {"stability": ["stability", "flock.toml", "--set", "stability.wavenumbers=8", "--set", "stability.angles=4"],
           "boundary": ["boundary", "flock.toml", "--x", "relaxation.rate = 0.5:1", "--y", "uniform.rod_density = 1:2",
                        "--set", "boundary.map=2", "--set", 'boundary.lines=["onset"]'],
           "states": ["states", "band.toml", "--wave", "x", "--set", "grid.nx=256", "--set", "grid.ny=8"]}


def write_scenes(folder, changes=None):
    """Those of RESULTS; a copy, since a version with a mistake may overwrite it."""
    write_scene(folder, changes)
    shutil.copy(MODELS / "band.toml", folder / "band.toml")


@pytest.mark.parametrize("command", RESULTS)
def test_the_archive_of_a_result_appears_complete_or_not_at_all(command, tmp_path):
    write_scenes(tmp_path)
    words = [*RESULTS[command], "-o", "x.h5"]
    drover(tmp_path, *words)
    whole = contents(tmp_path / "x.h5")
    for kilobytes in (1, 8, 24):
        for old in (whole, None):
            if old is None:
                (tmp_path / "x.h5").unlink()
            ended = subprocess.run(["sh", "-c", f'ulimit -f {2 * kilobytes}; exec "$0" "$@" --overwrite', DROVER,
                                    *map(str, words)], cwd=tmp_path, capture_output=True, text=True, check=False,
                                   env=environment())
            if ended.returncode != 0:
                assert "the largest file size allowed (ulimit -f) is reached" in one_sentence(ended)
                assert old is None or contents(tmp_path / "x.h5") == old
            assert set(tree(tmp_path)) <= {"flock.toml", "band.toml", "x.h5"}
            assert (tmp_path / "x.h5").exists() == (old is not None or ended.returncode == 0)
            drover(tmp_path, *words, "--overwrite")


@pytest.mark.parametrize("command", RESULTS)
def test_info_describes_the_archive_of_a_result(command, tmp_path):
    write_scenes(tmp_path)
    drover(tmp_path, *RESULTS[command], "-o", "x.h5")
    text = drover(tmp_path, "info", "x.h5").stdout
    found = json.loads(drover(tmp_path, "info", "x.h5", "--json").stdout)
    assert found["attributes"]["title"].startswith(f"drover {command} of ") and found["attributes"]["title"] in text
    with h5py.File(tmp_path / "x.h5") as file:
        for array in found["arrays"]:
            stored = file[array["name"]]
            values = numpy.array(array["values"], dtype=float)  # null: not finite
            assert list(stored.shape) == array["shape"] and array["name"] in text
            assert numpy.array_equal(values, stored[()].ravel(), equal_nan=True)
    assert set(contents(tmp_path / "x.h5")) == {array["name"][1:] for array in found["arrays"]}


@pytest.mark.parametrize("command", [*RESULTS, "run"])
def test_overwrite_replaces_an_archive_and_never_an_input_or_another_file(command, tmp_path):
    archive_of(tmp_path, "start.toml")
    write_scenes(tmp_path, {"initial.kind": "file", "initial.file": "start.h5"})
    (tmp_path / "notes.txt").write_text("notes")
    (tmp_path / "link").symlink_to("start.h5")
    words = ["run", "flock.toml", "--quiet"] if command == "run" else RESULTS[command]
    scene = words[1]
    before = tree(tmp_path)
    inputs = {scene: "is an input of this command", "notes.txt": "is not an HDF5 file"}
    if scene == "flock.toml":
        inputs |= {"start.h5": "is an input of this command", "./link": "is an input of this command"}
    for output, sentence in inputs.items():
        assert sentence in one_sentence(drover(tmp_path, *words, "-o", output, "--overwrite", status=2))
        assert tree(tmp_path) == before
    assert "exists; choose another name" in one_sentence(drover(tmp_path, *words, "-o", "notes.txt", status=2))


@pytest.mark.parametrize("kilobytes", [64, 128, 256, 512, 1024, 2040, 2048, 8192])
@pytest.mark.parametrize("which", ["-s", "-S -s"])
def test_a_short_stack_is_enough_or_ends_with_a_sentence(which, kilobytes, tmp_path):
    """-S: the limit may be raised again, which the program does."""
    write_scene(tmp_path, SHORT)
    ended = subprocess.run(["sh", "-c", f'ulimit {which} {kilobytes}; "{DROVER}" run flock.toml --quiet'], cwd=tmp_path,
                           env=environment(), capture_output=True, text=True, check=False)
    if which == "-S -s" or kilobytes >= 2048:
        assert ended.returncode == 0, ended
    else:
        assert ended.returncode == 2 and "raise the limit" in one_sentence(ended), ended


SHIM = os.environ.get("DROVER_SHIM")


@pytest.mark.skipif(not SHIM, reason="DROVER_SHIM is not set; ctest sets it")
@pytest.mark.parametrize("call", [1, 2])  # of the text that claims the folder, and of the first claim of a job
def test_a_folder_without_hard_links_is_told_so_and_kept_clean(call, tmp_path):
    scene = write_scene(tmp_path, {**SHORT, "sweep.seeds": 2})
    without = environment(LD_PRELOAD=SHIM, DROVER_FAULT=f"link:{call}:EPERM:always")
    words = one_sentence(drover(tmp_path, "sweep", scene, "--quiet", "-o", "s", status=2, env=without))
    assert words.startswith("error: s") and "does not support hard links" in words and "NFS, Lustre" in words
    assert not [name for name in tree(tmp_path / "s") if ".sweep.toml" in name or name.endswith(".h5")]
    drover(tmp_path, "sweep", scene, "--quiet", "-o", "s")


@pytest.mark.skipif(not SHIM, reason="DROVER_SHIM is not set; ctest sets it")
@pytest.mark.parametrize("reason", ["ENOLCK", "EOPNOTSUPP", "ENOSYS"])
def test_a_file_system_without_locks_is_used_only_if_the_user_says_so(reason, tmp_path):
    whole = archive_of(tmp_path, "whole.toml")
    scene = write_scene(tmp_path, SHORT)
    without = environment(LD_PRELOAD=SHIM, DROVER_FAULT_LOCKS=reason)
    assert "set DROVER_NO_LOCKS=1" in one_sentence(drover(tmp_path, "run", scene, "--quiet", status=2, env=without))
    assert sorted(tree(tmp_path)) == sorted({"flock.toml", *(name for name in tree(tmp_path) if "whole" in name)})
    allowed = {**without, "DROVER_NO_LOCKS": "1"}
    ended = drover(tmp_path, "run", scene, "--quiet", "--set", "time.end=2", env=allowed)
    assert ended.stderr.count("is written without a lock") == 1
    drover(tmp_path, "restart", "flock.h5", "--quiet", "--set", "time.end=4", env=allowed)
    drover(tmp_path, "info", "flock.h5", env=without)  # reads without a lock
    assert_same_bytes(whole, tmp_path / "flock.h5")
    drover(tmp_path, "sweep", write_scene(tmp_path, {**SHORT, "sweep.seeds": 2}), "--quiet", env=allowed)
    assert "set DROVER_NO_LOCKS=1" in drover(tmp_path, "sweep", scene, "--quiet", "-o", "other", status=2,
                                             env=without).stderr
    if reason != "ENOLCK":
        return
    study = ["tradeoff", write_scene(tmp_path, {**SHORT, "time.end": 4000.0, "time.max_error": 0.5}), "--quiet",
             "--want", "polar_order=30%", "-o", "study"]
    assert "set DROVER_NO_LOCKS=1" in drover(tmp_path, *study, "--budget", "2s", status=2, env=without).stderr
    for budget in ("1s", "3s"):  # the second goes on from runs of the first
        drover(tmp_path, *study, "--budget", budget, status=None, env=allowed)
    assert re.search(r"[1-9]\d* trials done", drover(tmp_path, *study, "--status").stdout)


@pytest.mark.skipif(bool(os.environ.get("DROVER_SANITIZE")), reason="sanitizers begin before the check")
def test_a_processor_without_the_instructions_of_the_build_gets_a_sentence(tmp_path):
    """A tunable of the C library hides a feature of the processor."""
    ended = drover(tmp_path, "--version", status=1, env=environment(GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX2"))
    assert one_sentence(ended).startswith("error: this processor has no AVX2")
