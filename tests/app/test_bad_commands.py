"""tests/app/test_bad_commands.py: errors in outputs, sweeps, restarts, archives and command lines give one line.

As in test_bad_input.py: exit status 2, one line on standard error, nothing on standard output, the folder unchanged.
"""
import h5py
import numpy as np
import pytest
from rejection import SHORT, cut_in_two, make_archive, not_as_root, rejected
from support import checkpoints, damage, drover, write_scene

# An invalid path of the archive: how to prepare the folder, the name, and what the message must contain.
def make_locked_folder(folder):
    (folder / "locked").mkdir(mode=0o555)


OUTPUTS = {
    "a file that exists": (lambda folder: make_archive(folder, "flock.h5"), "flock.h5",
                           ["flock.h5", "exists", "--overwrite"]),
    "a file of someone else": (lambda folder: (folder / "notes").write_text("rods"), "notes", ["notes", "exists"]),
    "the scene itself": (lambda folder: None, "flock.toml", ["flock.toml"]),
    "a folder": (lambda folder: (folder / "out").mkdir(), "out", ["out", "is a folder"]),
    "a name that ends like a folder": (lambda folder: (folder / "out").mkdir(), "out/", ["out", "is a folder"]),
    "a missing folder": (lambda folder: None, "there/flock.h5", ["there", "does not exist", "make it first"]),
    "a file as folder": (lambda folder: (folder / "notes").write_text("rods"), "notes/flock.h5",
                         ["notes", "does not exist"]),
    "a folder that takes no files": (lambda folder: None, "/proc/flock.h5", ["/proc/flock.h5", "cannot be written"]),
    "a device": (lambda folder: None, "/dev/null", ["/dev/null"]),
    "no name": (lambda folder: None, "", ["--output", "is empty", "expected a name"]),
    "a name too long": (lambda folder: None, "f" * 300 + ".h5", ["fff.h5"]),
    "a name too long for its checkpoints": (lambda folder: None, "f" * 240 + ".h5", ["9 bytes too long", "shorter"]),
}


@pytest.mark.parametrize("name", OUTPUTS)
def test_an_output_is_rejected_that_is(name, tmp_path):
    prepare, output, says = OUTPUTS[name]
    prepare(tmp_path)
    write_scene(tmp_path, base=SHORT)
    rejected(tmp_path, ["run", "flock.toml", "-o", output], says)


@pytest.mark.parametrize("output", ["flock.toml", "/dev/null", "."])
def test_even_overwriting_does_not_replace(output, tmp_path):
    write_scene(tmp_path, base=SHORT)
    rejected(tmp_path, ["run", "flock.toml", "--overwrite", "-o", output], [output])


@not_as_root
def test_an_output_is_rejected_whose_folder_is_read_only(tmp_path):
    make_locked_folder(tmp_path)
    write_scene(tmp_path, base=SHORT)
    rejected(tmp_path, ["run", "flock.toml", "-o", "locked/flock.h5"], ["locked/flock.h5", "Permission denied"])


# A sweep that cannot be planned: words after `sweep flock.toml`, and what the message must contain.
SWEEPS = {
    "nothing to sweep": ([], ["nothing to sweep", "--vary"]),
    "no values": (["--vary", "relaxation.rate"], ["relaxation.rate", "expected"]),
    "an empty list": (["--vary", "relaxation.rate = "], ["relaxation.rate", "at least one"]),
    "a hole in the list": (["--vary", "relaxation.rate = 1,,2"], ["relaxation.rate = 1,,2", "expected numbers"]),
    "a word": (["--vary", "relaxation.rate = 1, two"], ['"two"', "expected numbers"]),
    "not-a-number": (["--vary", "relaxation.rate = 1, nan"], ['"nan"', "expected numbers"]),
    "no section": (["--vary", "rate = 1, 2"], ["rate = 1, 2", "section.key"]),
    "an unknown key": (["--vary", "relaxation.rat = 1, 2"], ["relaxation.rat", "did you mean relaxation.rate?"]),
    "an unknown section": (["--vary", "relax.rate = 1, 2"], ["[relax]", "expected"]),
    "a range without count": (["--vary", "relaxation.rate = 1:2"], ["relaxation.rate = 1:2", "first:last:count"]),
    "a range of four": (["--vary", "relaxation.rate = 1:2:3:4"], ["1:2:3:4", "first:last:count"]),
    "a range of one": (["--vary", "relaxation.rate = 1:2:1"], ["1:2:1", "integer number"]),
    "a range of half a point": (["--vary", "relaxation.rate = 1:2:2.5"], ["1:2:2.5", "integer number"]),
    "a range of too many": (["--vary", "relaxation.rate = 1:2:1e9"], ["1:2:1e9", "integer number"]),
    "the same key twice": (["--vary", "relaxation.rate = 1", "--vary", "relaxation.rate = 2"],
                           ["relaxation.rate twice"]),
    "a value that the scene does not allow": (["--vary", "grid.nx = 16, 17"], ["grid.nx = 17", "even"]),
    "a value of the wrong type": (["--vary", "grid.nx = 16, 16.5"], ["grid.nx = 16.5", "an integer"]),
    "the seed, which has its own key": (["--vary", "run.seed = 1, 2"], ["run.seed", "sweep.seeds"]),
    "a ramp of no key": (["--ramp", "up", "--seeds", "2"], ["sweep.ramp", "without a varied key", "the last"]),
    "a ramp of the grid": (["--vary", "grid.nx = 16, 32", "--ramp", "up"], ["grid.nx", "ramp"]),
    "an unknown ramp": (["--vary", "relaxation.rate = 1, 2", "--ramp", "sideways"], ['"sideways"', "up-down"]),
    "a folder with other things in it": (["--vary", "relaxation.rate = 1, 2", "-o", "full"],
                                         ["full", "not empty", "--output"]),
    "a file as folder": (["--vary", "relaxation.rate = 1, 2", "-o", "full/notes"], ["full/notes", "folder"]),
}


@pytest.mark.parametrize("name", SWEEPS)
def test_a_sweep_is_rejected_with(name, tmp_path):
    words, says = SWEEPS[name]
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "notes").write_text("rods")
    write_scene(tmp_path, base=SHORT)
    rejected(tmp_path, ["sweep", "flock.toml", *words], says)


def test_a_sweep_is_rejected_in_the_folder_of_another_sweep(tmp_path):
    write_scene(tmp_path, base=SHORT)
    drover(tmp_path, "sweep", "flock.toml", "--vary", "relaxation.rate = 1, 2", "--quiet")
    rejected(tmp_path, ["sweep", "flock.toml", "--vary", "relaxation.rate = 1, 2", "--set", "grid.nx=8"],
            ["flock.sweep", "results of another scene", "--output"])


# An impossible restart: the change to a finished run, words after `restart`, and what the message must contain.
def remove_checkpoints(folder):
    for file in checkpoints(folder / "flock.h5"):
        file.unlink(missing_ok=True)


def damage_checkpoints(folder):
    for file in checkpoints(folder / "flock.h5"):
        damage(file)


def archive_of_another_grid(folder):
    make_archive(folder, "flock.h5", {"grid.nx": 32})


RESTARTS = {
    "a missing file": (lambda folder: None, ["lost.h5"], ["lost.h5", "run the scene again"]),
    "the scene": (lambda folder: None, ["flock.toml"], ["flock.toml", "checkpoint"]),
    "a folder": (lambda folder: (folder / "out").mkdir(), ["out"], ["out"]),
    "an archive without checkpoints": (remove_checkpoints, ["flock.h5"], ["flock.h5", "no checkpoint", "checkpoint-a"]),
    "an archive with both checkpoints damaged": (
        damage_checkpoints, ["flock.h5"], ["flock.h5", "checkpoint-a", "checkpoint-b", "damaged",
                                           "run the scene again"]),
    "checkpoints without their archive": (lambda folder: (folder / "flock.h5").unlink(), ["flock.h5"],
                                          ["flock.h5", "does not exist"]),
    "an archive cut short": (lambda folder: cut_in_two(folder / "flock.h5"), ["flock.h5"], ["flock.h5"]),
    "an archive that is text": (lambda folder: (folder / "flock.h5").write_text("rods\n"), ["flock.h5"],
                                ["flock.h5", "not an HDF5 file"]),
    "an archive of another grid": (archive_of_another_grid, ["flock.h5"], ["flock.h5", "expected"]),
    "another rate": (lambda folder: None, ["flock.h5", "--set", "relaxation.rate=2"],
                     ["--set relaxation.rate=2", "time.end, output.checkpoint_minutes and run.threads",
                      "start a new run"]),
    "another seed": (lambda folder: None, ["flock.h5", "--set", "run.seed=2"], ["--set run.seed=2", "start a new run"]),
    "an end that is past": (lambda folder: None, ["flock.h5", "--set", "time.end=0.5"],
                            ["flock.h5", "beyond time.end = 0.5", "give a later end"]),
    "an end between steps": (lambda folder: None, ["flock.h5", "--set", "time.end=1.23"],
                             ["time.end = 1.23", "choose"]),
    "a word as end": (lambda folder: None, ["flock.h5", "--set", "time.end=late"], ["--set time.end=late", "a number"]),
}


@pytest.mark.parametrize("name", RESTARTS)
def test_a_restart_is_rejected_that_has(name, tmp_path):
    prepare, words, says = RESTARTS[name]
    write_scene(tmp_path, base=SHORT)
    drover(tmp_path, "run", "flock.toml", "--quiet", "--set", "output.checkpoint_minutes=0")
    prepare(tmp_path)
    rejected(tmp_path, ["restart", *words], says)


# Files that are not archives, for `drover info`: how to prepare one, and what the message must contain.
def hdf5_from_elsewhere(folder):
    with h5py.File(folder / "flock.h5", "w") as file:
        file["time"] = np.arange(3.0)


def archive_without_samples(folder):
    make_archive(folder, "flock.h5")
    with h5py.File(folder / "flock.h5", "r+") as file:
        del file["observables"]


def archive_with_another_scene(folder):
    make_archive(folder, "flock.h5")
    with h5py.File(folder / "flock.h5", "r+") as file:
        file.attrs["scene"] = np.bytes_("[grid]\nnx = 17\n")


ARCHIVES = {
    "missing": (lambda folder: None, ["flock.h5", "does not exist"]),
    "a text": (lambda folder: (folder / "flock.h5").write_text("rods\n"), ["flock.h5", "not an HDF5 file"]),
    "a folder": (lambda folder: (folder / "flock.h5").mkdir(), ["flock.h5", "is a folder"]),
    "from elsewhere": (hdf5_from_elsewhere, ["flock.h5", "no attribute", "an archive of drover"]),
    "cut short": (lambda folder: (make_archive(folder, "flock.h5"), cut_in_two(folder / "flock.h5")), ["flock.h5"]),
    "without samples": (archive_without_samples, ["flock.h5", "/observables/time"]),
    "one with a scene that is wrong": (archive_with_another_scene, ["grid.nx = 17", "even"]),
}


@pytest.mark.parametrize("name", ARCHIVES)
def test_info_rejects_a_file_that_is(name, tmp_path):
    prepare, says = ARCHIVES[name]
    prepare(tmp_path)
    for words in (["info", "flock.h5"], ["info", "flock.h5", "--json"]):
        rejected(tmp_path, words, says)


# A wrong command line: CLI11 reports it, and where help is.
COMMANDS = {
    "no command": ([], ["subcommand"]),
    "an unknown command": (["simulate", "flock.toml"], ["simulate"]),
    "a command misspelt": (["restrat", "flock.h5"], ["restrat"]),
    "no scene": (["run"], ["scene"]),
    "two scenes": (["run", "flock.toml", "flock.toml"], ["flock.toml"]),
    "an unknown option": (["run", "flock.toml", "--colour"], ["--colour"]),
    "an option without its value": (["run", "flock.toml", "--output"], ["--output"]),
    "no threads": (["run", "flock.toml", "--threads", "0"], ["--threads"]),
    "a word for threads": (["run", "flock.toml", "--threads", "all"], ["--threads", "all"]),
    "no seeds": (["sweep", "flock.toml", "--seeds", "0"], ["--seeds"]),
    "negative workers": (["sweep", "flock.toml", "--workers", "-1"], ["--workers"]),
    "no archive": (["info"], ["archive"]),
    "two commands": (["check", "run"], ["run"]),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_line_is_rejected_that_has(name, tmp_path):
    words, says = COMMANDS[name]
    write_scene(tmp_path, base=SHORT)
    rejected(tmp_path, words, says, max_lines=2)
    assert len(drover(tmp_path, *words, status=2).stderr) < 300  # CLI11 would print the largest double in full
