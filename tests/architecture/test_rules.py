"""tests/architecture/test_rules.py: drover keeps the rules of its house, and the check sees each of them broken."""
from pathlib import Path

import pytest
import rules

SENTENCE = "// a file that says what lives in it\n"


def tree_with(folder, texts):
    """A small tree that keeps every rule, and the given files."""
    good = {
        "include/drover/base/error.hpp": SENTENCE + "#include <string>\n",
        "include/drover/numerics/grid.hpp": SENTENCE + '#include "drover/base/error.hpp"\n',
        "include/drover/physics/theory.hpp": SENTENCE + "#include <Eigen/Dense>\n",
        "src/numerics/plans.hpp": SENTENCE,
        "src/numerics/transform.cpp": SENTENCE + '#include <fftw3.h>\n#include "numerics/plans.hpp"\n',
        "src/io/scene.cpp": SENTENCE + "#include <toml++/toml.h>\n#include <hdf5.h>\n",
        "src/app/main.cpp": SENTENCE + '#include <CLI/CLI.hpp>\n#include "drover/numerics/grid.hpp"\n',
        "README.md": "",
    }
    for name, text in {**good, **texts}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def test_drover_keeps_every_rule():
    assert rules.broken_rules(Path(__file__).resolve().parents[2]) == []


def test_a_tree_that_keeps_the_rules_passes(tmp_path):
    assert rules.broken_rules(tree_with(tmp_path, {})) == []
    assert rules.main([str(tmp_path)]) == 0


# What is broken: the file that breaks it, its text, and how the message begins.
BROKEN = {
    "an upward include of a public header": (
        "src/numerics/bad.cpp", '#include "drover/physics/theory.hpp"',
        'src/numerics/bad.cpp:2: numerics/ includes "drover/physics/theory.hpp"'),
    "an upward include of a header not written yet": (
        "include/drover/base/bad.hpp", '#include "drover/run/loop.hpp"',
        'include/drover/base/bad.hpp:2: base/ includes "drover/run/loop.hpp"'),
    "an upward include of a private header": (
        "src/base/bad.cpp", '#  include "numerics/plans.hpp"',
        'src/base/bad.cpp:2: base/ includes "numerics/plans.hpp"'),
    "an upward include by a relative path": (
        "src/base/bad.cpp", '#include "../numerics/plans.hpp"',
        "src/base/bad.cpp:2: base/ includes"),
    "a sideward include": (
        "src/dem/bad.cpp", '#include "drover/numerics/grid.hpp"',
        'src/dem/bad.cpp:2: dem/ includes "drover/numerics/grid.hpp"'),
    "a private header in a public one": (
        "include/drover/numerics/bad.hpp", '#include "numerics/plans.hpp"',
        'include/drover/numerics/bad.hpp:2: a public header includes "numerics/plans.hpp"'),
    "a third-party header in a public one": (
        "include/drover/base/bad.hpp", "#include <fmt/format.h>",
        "include/drover/base/bad.hpp:2: a public header includes <fmt/format.h>"),
    "Eigen in a public header below physics": (
        "include/drover/numerics/bad.hpp", "#include <Eigen/Dense>",
        "include/drover/numerics/bad.hpp:2: a public header includes <Eigen/Dense>"),
    "FFTW in a second file of numerics": (
        "src/numerics/bad.cpp", "#include <fftw3.h>",
        "src/numerics/bad.cpp:2, src/numerics/transform.cpp:2: 2 files include FFTW"),
    "FFTW outside numerics": (
        "src/measure/bad.cpp", "#include <fftw3.h>",
        "src/measure/bad.cpp:2: <fftw3.h> of FFTW"),
    "HDF5 outside io": (
        "src/run/bad.cpp", "#include <hdf5.h>",
        "src/run/bad.cpp:2: <hdf5.h> of HDF5"),
    "toml++ outside the scene": (
        "src/io/bad.cpp", "#include <toml++/toml.hpp>",
        "src/io/bad.cpp:2: <toml++/toml.hpp> of toml++"),
    "toml++ in a second file": (
        "src/io/scene_text.cpp", "#include <toml++/toml.h>",
        "src/io/scene.cpp:2, src/io/scene_text.cpp:2: 2 files include toml++"),
    "CLI11 outside app": (
        "src/run/bad.cpp", "#include <CLI/CLI.hpp>",
        "src/run/bad.cpp:2: <CLI/CLI.hpp> of CLI11"),
    "a long file": (
        "src/base/bad.cpp", "\n" * 500,
        "src/base/bad.cpp:501: 501 lines; at most 500"),
    "a long test": (
        "tests/app/test_bad.py", "\n" * 500,
        "tests/app/test_bad.py:501: 501 lines; at most 500"),
    "a new visible entry at the top": (
        "docs/page.md", "",
        "docs:1: a new entry at the top level"),
}


@pytest.mark.parametrize("rule", BROKEN)
def test_the_check_fails_and_names_the_place_of(rule, tmp_path, capsys):
    name, text, expected = BROKEN[rule]
    tree = tree_with(tmp_path, {name: SENTENCE + text})
    found = rules.broken_rules(tree)
    assert len(found) == 1 and found[0].startswith(expected), found
    assert rules.main([str(tree)]) == 1
    assert expected in capsys.readouterr().out


@pytest.mark.parametrize("first_line", ["", "#pragma once", "//", "// code", "/* a file that says */"])
def test_the_check_fails_where_a_file_does_not_say_what_lives_there(first_line, tmp_path):
    found = rules.broken_rules(tree_with(tmp_path, {"tests/base/bad.cpp": first_line + "\n"}))
    assert len(found) == 1 and found[0].startswith("tests/base/bad.cpp:1: the first line is"), found


def test_hidden_entries_the_build_folder_and_ignored_files_are_no_new_top_level_entries(tmp_path):
    tree = tree_with(tmp_path, {".hidden/a": "", "build/a": "", "flock.h5": "", ".gitignore": "*.h5\n"})
    assert len(rules.broken_rules(tree)) == 1  # without git, nothing is ignored
    rules.subprocess.run(["git", "init", "--quiet", str(tree)], check=True)
    assert rules.broken_rules(tree) == []
