"""tests/architecture/test_rules.py: drover obeys the architecture rules, and the check detects a violation of each."""
from pathlib import Path

import pytest
import rules

FIRST_LINE = "// file.hpp: what it contains\n"
PYTHON_FIRST_LINE = '"""file.py: what it contains."""\n'


def tree_with(folder, texts):
    """A small tree that obeys all rules, with the given files added."""
    good = {
        "include/drover/base/error.hpp": FIRST_LINE + "#include <string>\n",
        "include/drover/base/text.hpp": FIRST_LINE + '#include "drover/base/error.hpp"\n',
        "include/drover/numerics/grid.hpp": FIRST_LINE + '#include "drover/base/error.hpp"\n',
        "include/drover/physics/theory.hpp": FIRST_LINE + "#include <Eigen/Dense>\n",
        "src/numerics/fields/plans.hpp": FIRST_LINE,
        "src/numerics/fields/transform.cpp": FIRST_LINE + '#include <fftw3.h>\n#include "numerics/fields/plans.hpp"\n',
        "src/files/archive.cpp": FIRST_LINE + "#include <hdf5.h>\n",
        "src/files/hdf5_file.hpp": FIRST_LINE + '#include "files/overlay.hpp"\n',
        "src/files/system_calls.cpp": FIRST_LINE + "const int file = ::open(name, O_RDONLY);  // not ifstream\n",
        "src/files/overlay.hpp": FIRST_LINE,
        "src/io/scene.cpp": FIRST_LINE + "#include <toml++/toml.h>\n",
        "src/app/main.cpp": FIRST_LINE + '#include <CLI/CLI.hpp>\n#include "drover/numerics/grid.hpp"\n',
        "src/python/drover/figures/map.py": "from drover import error\n\nprint(error)\n",
        "README.md": "",
    }
    for name, text in {**good, **texts}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def test_drover_obeys_all_rules():
    assert rules.broken_rules(Path(__file__).resolve().parents[2]) == []


def test_a_tree_that_obeys_the_rules_passes(tmp_path):
    assert rules.broken_rules(tree_with(tmp_path, {})) == []
    assert rules.main([str(tmp_path)]) == 0


# Violation: the file with it, its text, and the start of the message.
BROKEN = {
    "an upward include of a public header": (
        "src/numerics/bad.cpp", '#include "drover/physics/theory.hpp"',
        'src/numerics/bad.cpp:2: numerics/ includes "drover/physics/theory.hpp"'),
    "an upward include of a header not written yet": (
        "include/drover/base/bad.hpp", '#include "drover/run/loop.hpp"',
        'include/drover/base/bad.hpp:2: base/ includes "drover/run/loop.hpp"'),
    "an upward include of a private header": (
        "src/base/bad.cpp", '#  include "numerics/fields/plans.hpp"',
        'src/base/bad.cpp:2: base/ includes "numerics/fields/plans.hpp"'),
    "an upward include by a relative path": (
        "src/base/bad.cpp", '#include "../numerics/fields/plans.hpp"',
        "src/base/bad.cpp:2: base/ includes"),
    "a sideward include": (
        "src/dem/bad.cpp", '#include "drover/numerics/grid.hpp"',
        'src/dem/bad.cpp:2: dem/ includes "drover/numerics/grid.hpp"'),
    "a private header in a public one": (
        "include/drover/numerics/bad.hpp", '#include "numerics/fields/plans.hpp"',
        'include/drover/numerics/bad.hpp:2: a public header includes "numerics/fields/plans.hpp"'),
    "a third-party header in a public one": (
        "include/drover/base/bad.hpp", "#include <fmt/format.h>",
        "include/drover/base/bad.hpp:2: a public header includes <fmt/format.h>"),
    "Eigen in a public header below physics": (
        "include/drover/numerics/bad.hpp", "#include <Eigen/Dense>",
        "include/drover/numerics/bad.hpp:2: a public header includes <Eigen/Dense>"),
    "a subfolder including a later one": (
        "src/numerics/algebra/bad.cpp", '#include "numerics/fields/plans.hpp"',
        'src/numerics/algebra/bad.cpp:2: numerics/algebra/ includes "numerics/fields/plans.hpp" of the later subfolder '
        "fields/"),
    "FFTW in a second file of numerics": (
        "src/numerics/bad.cpp", "#include <fftw3.h>",
        "src/numerics/bad.cpp:2, src/numerics/fields/transform.cpp:2: 2 files include FFTW"),
    "FFTW outside numerics": (
        "src/measure/bad.cpp", "#include <fftw3.h>",
        "src/measure/bad.cpp:2: <fftw3.h> of FFTW"),
    "HDF5 outside files": (
        "src/run/bad.cpp", "#include <hdf5.h>",
        "src/run/bad.cpp:2: <hdf5.h> of HDF5"),
    "HDF5 in io": (
        "src/io/bad.cpp", "#include <hdf5.h>",
        "src/io/bad.cpp:2: <hdf5.h> of HDF5"),
    "the files layer including a higher one": (
        "src/files/bad.cpp", '#include "drover/numerics/grid.hpp"',
        'src/files/bad.cpp:2: files/ includes "drover/numerics/grid.hpp" of numerics/; it may include base'),
    "a private header outside its module": (
        "src/files/bad.cpp", '#include "files/overlay.hpp"',
        'src/files/bad.cpp:2: "files/overlay.hpp" is private to its module; only src/files/overlay.cpp, '),
    "a component cycle by a header and a source": (
        "src/base/error.cpp", '#include "drover/base/text.hpp"',
        "base/error: component cycle: base/error -> base/text -> base/error; expected no cycle"),
    "a long line of a source": (
        "src/base/bad.cpp", "// " + "x" * 118,
        "src/base/bad.cpp:2: 121 columns; at most 120"),
    "a long line of prose": (
        "models/README.md", "x" * 121,
        "models/README.md:2: 121 columns; at most 120"),
    "toml++ outside the scene": (
        "src/io/bad.cpp", "#include <toml++/toml.hpp>",
        "src/io/bad.cpp:2: <toml++/toml.hpp> of toml++"),
    "toml++ in a second file": (
        "src/io/scene_text.cpp", "#include <toml++/toml.h>",
        "src/io/scene.cpp:2, src/io/scene_text.cpp:2: 2 files include toml++"),
    "CLI11 outside app": (
        "src/run/bad.cpp", "#include <CLI/CLI.hpp>",
        "src/run/bad.cpp:2: <CLI/CLI.hpp> of CLI11"),
    "a stream of a file": (
        "src/io/bad.cpp", "std::ifstream from(file);  // text",
        "src/io/bad.cpp:2: ifstream is a stream of files"),
    "a stream in the layer of files": (
        "src/files/bad.cpp", "#include <fstream>",
        "src/files/bad.cpp:2: <fstream> is a stream of files"),
    "a file of the C library": (
        "src/run/bad.cpp", 'if (FILE* file = std::fopen(name, "r"))',
        "src/run/bad.cpp:2: fopen is a stream of files"),
    "a system call outside the layer of files": (
        "src/run/bad.cpp", "const int file = ::open(name, O_RDONLY);",
        "src/run/bad.cpp:2: ::open is a system call on files"),
    "a decision by a word": (
        "src/run/bad.cpp", 'if (part == "grid") return;',
        "src/run/bad.cpp:2: decides by a word in quotes"),
    "a decision by a sentence": (
        "src/run/bad.cpp", 'if (trial.failure.starts_with(not_run)) return;',
        "src/run/bad.cpp:2: failure.starts_with(...) reads a sentence"),
    "a long file": (
        "src/base/bad.cpp", "\n" * 500,
        "src/base/bad.cpp:501: 501 lines; at most 500"),
    "a long test": (
        "tests/app/test_bad.py", "\n" * 500,
        "tests/app/test_bad.py:501: 501 lines; at most 500"),
    "a name that no module defines": (
        "src/python/drover/bad.py", "\n\ndef stop():\n    raise Error('')\n",
        "src/python/drover/bad.py:5:11: undefined name 'Error'"),
    "a new visible entry at the top": (
        "docs/page.md", "",
        "docs:1: a new entry at the top level"),
}


@pytest.mark.parametrize("rule", BROKEN)
def test_the_check_reports_the_location_of(rule, tmp_path, capsys):
    name, text, expected = BROKEN[rule]
    tree = tree_with(tmp_path, {name: (PYTHON_FIRST_LINE if name.endswith(".py") else FIRST_LINE) + text})
    found = rules.broken_rules(tree)
    assert len(found) == 1 and found[0].startswith(expected), found
    assert rules.main([str(tree)]) == 1
    assert expected in capsys.readouterr().out


@pytest.mark.parametrize("first_line", ["", "#pragma once", "//", "// code", "/* file.cpp: a comment */"])
def test_the_check_reports_a_file_without_a_descriptive_first_line(first_line, tmp_path):
    found = rules.broken_rules(tree_with(tmp_path, {"tests/base/bad.cpp": first_line + "\n"}))
    assert len(found) == 1 and found[0].startswith("tests/base/bad.cpp:1: the first line is"), found


def test_the_check_reports_a_circle_of_python_modules_by_an_import_within_a_function(tmp_path):
    late = "def late():\n    from .figures import map\n    return map\n"
    tree = tree_with(tmp_path, {"src/python/drover/error.py": late})
    circle = "drover.error -> drover.figures.map -> drover.error"
    assert rules.broken_rules(tree) == [f"drover.error: module cycle: {circle}; expected no cycle"]


def test_hidden_entries_the_build_folder_and_ignored_files_are_allowed_at_the_top_level(tmp_path):
    tree = tree_with(tmp_path, {".hidden/a": "", "build/a": "", "flock.h5": "", ".gitignore": "*.h5\n"})
    assert len(rules.broken_rules(tree)) == 1  # without git, nothing is ignored
    rules.subprocess.run(["git", "init", "--quiet", str(tree)], check=True)
    assert rules.broken_rules(tree) == []
