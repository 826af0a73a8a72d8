"""tests/app/test_manual.py: the manual has a page, and a shell its man page and completion, for all of the program."""
import json
import re
import subprocess
import sys
import tomllib

import matplotlib
import pytest
from support import DROVER, MODELS, scenes

TREE = MODELS.parent
DOCS = TREE / "src" / "docs"
sys.path.insert(0, str(DOCS))
matplotlib.use("Agg")
import gallery  # noqa: E402  # pylint: disable=wrong-import-position
import reference  # noqa: E402  # pylint: disable=wrong-import-position
import shell  # noqa: E402  # pylint: disable=wrong-import-position

GENERATED = reference.generated_pages(DROVER)


def text_of(page):
    return (DOCS / page).read_text(encoding="utf-8")


def asked(*words):
    return subprocess.run([DROVER, *words], capture_output=True, text=True, check=True).stdout


# --- a page for everything

def test_every_command_option_and_exit_status_has_its_page():
    pages = {path.stem for path in (DOCS / "commands").glob("*.md")}
    listed = re.findall(r"^  (\w+) ", asked("--help").partition("Subcommands:")[2], re.M)
    assert pages == set(listed) and len(listed) >= 15
    for command in listed:
        assert f"<!-- generated: command {command} -->" in text_of(f"commands/{command}.md")
        written = reference.insertions(DROVER)[f"command {command}"]
        told = asked(command, "--help")
        options = re.findall(r"^  (?:-\w,)?(--[a-z-]+)", told, re.M)
        assert len(options) > 1 or command == "check"
        for option in options:
            assert f"`{option}" in written or f", {option}" in written, (command, option)
        assert ("| 3 |" in written) == ("--max-time" in options)
        assert all(f"| {status} |" in written for status in (0, 1, 2)), command
        assert "*Cost.*" in text_of(f"commands/{command}.md"), command
    footer = asked("--help").rpartition("Exit status: ")[2]
    assert re.findall(r"\d", footer) == ["0", "1", "2", "3"]


@pytest.mark.parametrize("kind", ["fields", "model", "particles"])
def test_every_key_has_its_row_with_unit_range_default_and_meaning(kind):
    page, section = GENERATED[f"reference/keys-{kind}.md"], ""
    keys = 0
    for line in asked("schema", "--kind", kind).splitlines():  # the text for people, not the JSON of the page
        if line.startswith("["):
            section = line[1:line.index("]  #")]
        elif " = " in line and not line.startswith(("#", " ")):
            row = re.search(rf"^\| `{re.escape(section)}\.{line.split(' = ')[0]}` \|.*$", page, re.M)
            assert row, (section, line)
            unit = re.search(r" \[(.*)\]$", line.partition("  # ")[2])
            assert not unit or f"| {reference.cell(unit[1])} |" in row[0], (line, row[0])
            assert len(row[0].rstrip("| ").rpartition("| ")[2]) > 5, row[0]
            keys += 1
    assert keys >= 50


def test_every_coefficient_is_in_the_table_and_in_its_page():
    table = asked("schema", "--coefficients")
    assert table in GENERATED["reference/coefficients.md"] and table.count("\n| ") >= 27
    assert "<!-- generated: coefficients -->" in text_of("equations.md")


def test_every_observable_of_every_shipped_scene_has_its_row(tmp_path):
    page = GENERATED["reference/observables.md"]
    rows = set(re.findall(r"^\| `(\w+)` \|", page, re.M))
    tiny = {"fields": [*reference.TINY, "output.powers=true"], "model": reference.TINY, "particles": reference.FEW}
    number = 0
    for kind, settings in tiny.items():
        for scene in scenes(kind):
            values = tomllib.loads((MODELS / f"{scene}.toml").read_text())
            if scene in ("full-size", "paper-flock", "paper-poor"):
                continue  # the same observables as smaller scenes have
            given = [*settings, *(["grid.ny=1"] if values.get("grid", {}).get("ny") == 1 else [])]
            given += ["grid.nx=64", "grid.ny=64"] if scene == "foraging-flock" else []  # its start needs them
            if kind == "fields" and values.get("fields", {}).get("bead_velocity") == "slaved":
                given.remove("output.powers=true")
            for name in reference.observables_of_run(DROVER, scene, given, tmp_path):
                assert reference.generic(name, scene) in rows, (scene, name)
                number += 1
    assert number > 500
    assert all(len(row.split(" | ")) >= 4 and row.rstrip("| ").rpartition("| ")[2] for row in
               re.findall(r"^\| `\w+` \|.*$", page, re.M))


def test_every_public_name_of_the_module_is_on_the_page_of_python_and_says_what_it_does():
    import drover
    page = GENERATED["python.md"]
    for name in drover.__all__:
        assert re.search(rf"(auto\w+:: drover\.\w+\.{name}$|^`{name}` is another name)", page, re.M), name
        assert getattr(drover, name).__doc__, name
    stub = (TREE / "src" / "python" / "drover" / "plot.pyi").read_text(encoding="utf-8")
    for name in re.findall(r"^def (\w+)", stub, re.M):
        assert f":: drover.plot.{name}\n" in page and getattr(drover.plot, name).__doc__, name


def test_every_header_is_on_the_page_of_the_library():
    for header in (TREE / "include").rglob("*.hpp"):
        assert header.relative_to(TREE / "include").as_posix() in GENERATED["cpp.md"]


def test_every_scene_is_in_the_gallery():
    page = gallery.page()
    for path in MODELS.glob("*.toml"):
        assert f"### {path.stem}\n" in page
    asserted = gallery.assertions()
    assert set(scenes("model")) <= set(asserted)


def test_every_time_stepper_is_explained():
    page = text_of("numerics.md") + text_of("checks/methods.md")
    for name in reference.stepper_names(DROVER):
        assert name in page or name.removeprefix("arkode-ark") in page.replace("`-ark", "`").replace("-ark", ""), name


def test_every_page_is_in_a_list_of_contents():
    contents = {"index"}
    for path in DOCS.rglob("*.md"):
        folder = path.parent.relative_to(DOCS)
        for block in re.findall(r"```\{toctree\}\n(.*?)```", path.read_text(encoding="utf-8"), re.S):
            contents |= {(folder / line).as_posix() for line in block.splitlines() if line and line[0] != ":"}
    pages = {path.relative_to(DOCS).with_suffix("").as_posix() for path in DOCS.rglob("*.md")}
    commands = {f"commands/{command['name']}" for command in reference.commands(DROVER)}
    assert pages - commands <= contents, pages - commands - contents
    assert commands <= pages


def test_the_titles_of_troubleshooting_are_parts_of_messages():
    sources = " ".join(path.read_text(encoding="utf-8") for path in (TREE / "src").rglob("*.cpp"))
    sources = re.sub(r'"\s*\n\s*"', "", sources)
    for title in re.findall(r"^### (.+)$", text_of("troubleshooting.md"), re.M):
        assert title in sources, title


# --- the shell

def test_man_pages_and_completion_have_every_command_option_and_key(tmp_path):
    files = shell.written(DROVER)
    commands = reference.commands(DROVER)
    for command in commands:
        page = files[f"drover-{command['name']}.1"].replace("\\-", "-")
        for option in command["options"]:
            assert all(name in page for name in option["names"]), (command["name"], option)
        assert f"\\fBdrover-{command['name']}\\fR(1)" in files["drover.1"].replace("\\-", "-")
    for name in ("drover.bash", "_drover", "drover.fish"):
        assert "grid.nx" in files[name] and "time.stepper" in files[name]
        assert all(command["name"] in files[name] for command in commands)
    script = tmp_path / "drover.bash"
    script.write_text(files["drover.bash"])
    for typed, expected in ((["drover", "sta"], ["stability", "states"]), (["drover", "run", "--thr"], ["--threads"]),
                            (["drover", "run", "x.toml", "--set", "grid.n"], ["grid.nx=", "grid.ny="])):
        words = " ".join(f"'{word}'" for word in typed)
        code = (f"compopt() {{ :; }}; source {script}; COMP_WORDS=({words}); COMP_CWORD={len(typed) - 1}; _drover; "
                'printf "%s\\n" "${COMPREPLY[@]}"')
        done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True)
        assert set(expected) <= set(done.stdout.split()), typed


def test_schema_prints_one_section_or_one_key():
    assert [part["name"] for part in json.loads(asked("schema", "--json", "grid"))] == ["grid"]
    rows = json.loads(asked("schema", "--json", "grid.nx"))[0]["rows"]
    assert [row["name"] for row in rows] == ["nx"] and "nx = " in asked("schema", "grid.nx")
    done = subprocess.run([DROVER, "schema", "gird"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "did you mean grid?" in done.stderr


def test_the_citation_has_the_version_of_the_program():
    citation = (TREE / "CITATION.cff").read_text(encoding="utf-8")
    version = re.search(r"^version: (\S+)$", citation, re.M)[1]
    assert version == asked("--version").split()[1]
    assert all(f"\n{key}:" in "\n" + citation for key in ("cff-version", "message", "title", "authors", "license"))


def test_containers_are_built_with_the_packages_of_the_setup():
    for name in ("Containerfile", "drover.def"):
        recipe = (TREE / ".ci" / name).read_text(encoding="utf-8")
        assert ".ci/setup" in recipe and "make package" in recipe and "debian:12" in recipe
