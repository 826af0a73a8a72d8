"""tests/app/test_python_api.py: the Python module has what the program has; its stubs, docstrings and examples hold."""
import ast
import doctest
import importlib
import inspect
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from support import drover as program

import drover

PACKAGE = Path(drover.__file__).parent
# Each command with its Python function, and each of its options with the parameter of that function, or with how else
# Python does it, which begins with a capital letter.
EVERYWHERE = {"scene": "Scene.load", "--set": "Scene.set", "--help": "Docstrings", "--json": "The value returned",
              "--max-time": "Ctrl-C, after which it can be resumed",
              "--stop-when": "Ctrl-C, after which it can be resumed"}
COMMANDS = {
    "run": (drover.Scene.run, {"--accuracy": "accuracy", "--output": "output", "--threads": "threads",
                               "--overwrite": "overwrite",
                               "--quiet": "quiet"}),
    "restart": (drover.restart, {"archive": "archive", "--set": "end", "--threads": "threads", "--quiet": "quiet"}),
    "sweep": (drover.sweep, {"--output": "folder", "--vary": "vary", "--seeds": "seeds", "--ramp": "ramp",
                             "--refine": "refine", "--refine-levels": "refine_levels",
                             "--want": "want", "--max-seeds": "max_seeds",
                             "--keep": "keep", "--workers": "workers", "--quiet": "quiet", "--slurm": "slurm",
                             "--status": "SlurmSweep.status, of sweep(slurm=...)",
                             "--collect": "SlurmSweep.collect, of sweep(slurm=...)",
                             "--share": "Drover.sweep(slurm=...)"}),
    "tradeoff": (drover.tradeoff, {"--want": "want", "--budget": "budget", "--output": "folder", "--workers": "workers",
                                   "--collect": "collect", "--slurm": "slurm", "--share": "Drover.tradeoff(slurm=...)",
                                   "--status": "Submitted.status, of tradeoff(slurm=...)", "--quiet": "quiet"}),
    "calibrate": (drover.calibrate, {"--want": "want", "--budget": "budget", "--output": "folder",
                                     "--workers": "workers", "--share": "share", "--collect": "collect",
                                     "--status": "Submitted.status, of calibrate(slurm=...)",
                                     "--slurm": "slurm", "--quiet": "quiet"}),
    "stability": (drover.Scene.stability, {"--output": "output", "--threads": "threads", "--overwrite": "overwrite"}),
    "boundary": (drover.Scene.boundary, {"--x": "x", "--y": "y", "--convention": "conventions", "--output": "output",
                                         "--threads": "threads", "--overwrite": "overwrite", "--draws": "draws",
                                         "--slurm": "slurm", "--share": "Drover.Scene.boundary(slurm=...)",
                                         "--status": "Submitted.status, of Scene.boundary(slurm=...)",
                                         "--collect": "Submitted.collect, of Scene.boundary(slurm=...)",
                                         "--workers": "Drover.Scene.boundary(threads=...)",
                                         "--varied": "Drover.onset(table, varied=...)",
                                         "--cell": "Drover.onset(table, cell=...)",
                                         "--point": "Drover.onset(table, points=...)",
                                         "--quiet": "Python shows no progress"}),
    "states": (drover.Scene.states, {"--wave": "wave", "--speed": "speed", "--settle": "settle", "--follow": "follow",
                                     "--points": "points", "--output": "output", "--threads": "threads",
                                     "--overwrite": "overwrite"}),
    "check": (drover.Scene.check, {"--output": "Scene.with_output", "--threads": "Scene.with_output",
                                   "--resolved": "Scene.to_toml"}),
    "explain": (drover.Scene.explain, {"--output": "Scene.with_output", "--threads": "Scene.with_output"}),
    "info": (drover.info, {"archive": "file", "--scene": "The attribute scene of what it returns"}),
    "export": (drover.export, {"archive": "archive", "--output": "output", "--frame": "frame", "--every": "every",
                               "--bodies": "bodies", "--overwrite": "overwrite"}),
    "fit": (drover.fit, {"archive": "archive", "keys": "keys", "--scene": "scene", "--max-wavenumber": "max_wavenumber",
                         "--from": "begin", "--to": "end", "--every": "every"}),
    "film": (drover.film, {"archive": "run", "--output": "output", "--every": "every", "--rate": "rate",
                           "--field": "field"}),
    "serve": (drover.serve, {"run": "run", "--port": "port"}),
    "diff": (drover.diff, {"one": "one", "other": "other"}),
    "schema": (drover.schema, {"--kind": "kind", "--coefficients": "Drover.coefficients",
                               "part": "Elements of the list returned", "--commands": "Of the program alone"}),
}
WITHOUT_COUNTERPART = set()  # commands that are newer than the module


def options_of(command, folder):
    """The positional arguments and options that the help of a command lists."""
    text = program(folder, command, "--help").stdout
    positional = re.findall(r"^  ([a-z]+) ", text.partition("Positionals:")[2].partition("Options:")[0], re.M)
    return {*positional, *re.findall(r"^  (?:-\w,)?(--[a-z-]+)", text, re.M)}


def test_every_command_has_a_python_counterpart(tmp_path):
    listed = program(tmp_path, "--help").stdout.partition("Subcommands:")[2]
    assert set(re.findall(r"^  ([a-z]+) ", listed, re.M)) - WITHOUT_COUNTERPART == set(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_of_a_command_has_a_python_counterpart(command, tmp_path):
    function, parameters = COMMANDS[command]
    known = {**EVERYWHERE, **parameters}
    found = options_of(command, tmp_path)
    assert found - {"--help"} and found <= set(known), found - set(known)
    assert set(parameters) <= found, set(parameters) - found
    for option in found:
        counterpart = known[option]
        if counterpart[0].islower():
            assert counterpart in inspect.signature(function).parameters, (option, counterpart)
        elif match := re.match(r"(Scene|Drover)\.(\w+)", counterpart):
            assert hasattr(drover.Scene if match[1] == "Scene" else drover, match[2])


# --- stubs

def functions_of_stubs():
    """(owner, name, parameters) of every function of the stubs."""
    for node in ast.parse((PACKAGE / "__init__.pyi").read_text()).body:
        inner = [node] if isinstance(node, ast.FunctionDef) else getattr(node, "body", [])
        for one in inner:
            if isinstance(one, ast.FunctionDef):
                owner = node.name if isinstance(node, ast.ClassDef) else ""
                names = [part.arg for part in (*one.args.posonlyargs, *one.args.args, *one.args.kwonlyargs)]
                yield owner, one.name, names, [ast.unparse(part) for part in one.decorator_list]


def test_the_stubs_are_those_of_the_package():
    seen = set()
    for owner, name, parameters, decorators in functions_of_stubs():
        seen.add(owner or name)
        if owner.startswith("_"):
            continue
        found = inspect.getattr_static(getattr(drover, owner), name) if owner else getattr(drover, name)
        if "property" in decorators:
            assert isinstance(found, property), (owner, name)
            continue
        found = found.__func__ if isinstance(found, classmethod) else found
        real = [one.name for one in inspect.signature(found).parameters.values()
                if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)]
        if "overload" in decorators and "slurm" not in parameters:  # which decides what comes back
            real.remove("slurm")
        assert parameters == real, (owner, name)
    assert {name for name in drover.__all__ if name != "DroverError"} <= seen | {"Run", "ParticleRun"}


def test_the_stubs_pass_mypy(tmp_path):
    if shutil.which("mypy") is None:
        pytest.skip("mypy is not installed")
    words = ["mypy", "--strict", "--follow-imports=skip", "--cache-dir", tmp_path / "cache"]
    use = tmp_path / "use.py"
    use.write_text("""from drover import Scene, Sweep, calibrate, sweep, tradeoff
def submitted(scene: Scene) -> list[str]:
    return [sweep(scene, {}, slurm=2).status(), calibrate(scene, slurm=2).status(), scene.boundary(slurm=2).status(),
            tradeoff(scene, "x=1%", slurm=2).status()]
def table(scene: Scene) -> Sweep:
    return sweep(scene, {}) if scene.kind else sweep(scene, {}, slurm=2).collect()
""")
    found = subprocess.run([*words, PACKAGE / "__init__.pyi", PACKAGE / "plot.pyi", use], capture_output=True,
                           text=True, check=False)
    assert found.returncode == 0, found.stdout


# --- docstrings

@pytest.mark.parametrize("name", drover.__all__)
def test_every_public_name_has_a_docstring(name):
    value = getattr(drover, name)
    assert inspect.getdoc(value)
    for part, member in vars(value).items() if inspect.isclass(value) else ():
        if not part.startswith("_") and (inspect.isfunction(member) or isinstance(member, (property, classmethod))):
            assert inspect.getdoc(getattr(value, part)) or part == "close", (name, part)


@pytest.mark.parametrize("module", ["calibration", "commands", "error", "lookup", "model", "plot", "scene",
                                    "simulation", "sweeping", "toml", "tradeoffs", "typeset"])
def test_the_examples_of_the_docstrings_run(module, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = doctest.testmod(importlib.import_module(f"drover.{module}"), optionflags=doctest.ELLIPSIS)
    assert found.failed == 0 and found.attempted > 0
