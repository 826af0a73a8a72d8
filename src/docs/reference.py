"""src/docs/reference.py: the pages of the manual that the program writes: commands, keys, methods, Python, headers.

Needs the program alone: no Sphinx, no module of Python.  Nothing here repeats what the program knows.
"""
import ast
import functools
import json
import re
import subprocess
import tempfile
import tomllib
from pathlib import Path

import h5py

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[1]
KINDS = {"fields": "of rods and beads as fields", "model": "with a model of one's own", "particles": "of particles"}


@functools.cache
def asked(drover, *words):
    return subprocess.run([drover, *words], capture_output=True, text=True, check=True).stdout


def commands(drover):
    return json.loads(asked(drover, "schema", "--commands"))


def schema(drover, *words):
    return json.loads(asked(drover, "schema", "--json", *words))


def cell(text):
    """A text in a cell of a table in Markdown."""
    return str(text).replace("|", "\\|").replace("<", "&lt;").replace("$", "\\$").replace("*", "\\*").replace("\n", " ")


def table(heads, rows):
    return "\n".join(["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads),
                      *("| " + " | ".join(row) + " |" for row in rows)])


# --- commands

def option_text(option):
    """An option as in a synopsis."""
    value = f" {option['value']}" if option["value"] else ""
    if option["positional"]:
        text = option["name"].upper() + (" ..." if option["repeatable"] else "")
        return text if option["required"] else f"[{text}]"
    text = ", ".join(option["names"]) + value
    return text if option["required"] else f"[{text}]"


def synopsis(command):
    positional = [option_text(option) for option in command["options"] if option["positional"]]
    required = [f"{option['names'][-1]} {option['value']}" for option in command["options"]
                if option["required"] and not option["positional"]]
    return " ".join(["drover", command["name"], *positional, *required, "[OPTIONS]"])


def command_insertion(command):
    """Synopsis, options and exit statuses of a command."""
    rows = []
    for option in command["options"]:
        name = option["name"].upper() if option["positional"] else ", ".join(option["names"])
        value = f" {option['value']}" if option["value"] and not option["positional"] else ""
        notes = ". Required" * option["required"]
        if option["repeatable"] and "repeatable" not in option["doc"]:
            notes += ". Several may be given"
        rows.append((f"`{name}{value}`", cell(option["doc"].rstrip(".") + notes + ".")))
    statuses = [(str(row["status"]), cell(row["meaning"])) for row in command["exit_statuses"]]
    return "\n\n".join([f"```\n{synopsis(command)}\n```", "## Options", table(("option", "meaning"), rows),
                        "## Exit status", table(("status", "meaning"), statuses)])


# --- keys

def range_text(row):
    if row.get("choices"):
        return ", ".join(f"`{choice}`" for choice in row["choices"])
    parts = [f"> {row['more_than']:g}" if "more_than" in row else f">= {row['min']:g}" if "min" in row else "",
             f"<= {row['max']:g}" if "max" in row else ""]
    return " and ".join(part for part in parts if part)


def key_row(section, row):
    default = json.dumps(row["default"])
    return (f"`{section}.{row['name']}`", cell(row["type"]), f"`{default}`" if default != '""' else "", range_text(row),
            cell(row.get("unit", "")), cell(row["doc"]))


def keys_page(title, drover, kind):
    parts = [f"# {title}", f"All keys of scenes {KINDS[kind]}, as `drover schema --kind {kind}` prints them; "
             "`drover schema grid` prints one section. Units are mm, s and mg."]
    for section in schema(drover, "--kind", kind):
        parts += [f"## {section['name']}", section["doc"][:1].upper() + section["doc"][1:].rstrip(".") + ".",
                  table(("key", "type", "default", "range", "unit", "meaning"),
                        [key_row(section["name"], row) for row in section["rows"]])]
    return "\n\n".join(parts) + "\n"


# --- time steppers, from the one table of their coefficients

def stepper_names(drover):
    time = next(section for section in schema(drover) if section["name"] == "time")
    return next(row for row in time["rows"] if row["name"] == "stepper")["choices"]


# --- the Python module, from its stub and docstrings, without importing it

def python_names():
    """{public name of the module: kind} of __init__.py, and of drover.plot."""
    source = ast.parse((TREE / "src/python/drover/__init__.py").read_text(encoding="utf-8"))
    homes = next(ast.literal_eval(node.value) for node in source.body
                 if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "HOMES")
    kinds = {}
    for name, home in homes.items():
        tree = ast.parse((TREE / f"src/python/drover/{home}.py").read_text(encoding="utf-8"))
        node = next((node for node in tree.body if getattr(node, "name", "") == name), None)
        kinds[name] = "class" if isinstance(node, ast.ClassDef) else "function" if node is not None else "data"
    plot = ast.parse((TREE / "src/python/drover/plot.pyi").read_text(encoding="utf-8"))
    for node in plot.body:
        if isinstance(node, ast.FunctionDef):
            kinds[f"plot.{node.name}"] = "function"
    return homes, kinds


def python_page():
    homes, kinds = python_names()
    parts = ["# Python", (HERE / "python_intro.txt").read_text(encoding="utf-8").rstrip("\n")]

    def directive(kind, target):
        return f"```{{eval-rst}}\n.. auto{kind}:: {target}\n```"

    parts.append("## Classes")
    parts += [f"### {name}\n\n" + directive("class", f"drover.{homes[name]}.{name}") for name in sorted(homes)
              if kinds[name] == "class"]
    parts.append("## Functions")
    parts += [f"### {name}\n\n" + directive("function", f"drover.{homes[name]}.{name}") for name in sorted(homes)
              if kinds[name] == "function"]
    parts += [f"`{name}` is another name of `Error`." for name in sorted(homes) if kinds[name] == "data"]
    parts.append("## Figures: drover.plot")
    parts += [f"### {name}\n\n" + directive("function", f"drover.{name}") for name in sorted(kinds) if "." in name]
    return "\n\n".join(parts) + "\n"


# --- the C++ library

def first_sentence(path):
    """What the first line of a header says."""
    line = path.read_text(encoding="utf-8").splitlines()[0]
    return line.partition(": ")[2].rstrip(".")


def cpp_page():
    parts = ["# The C++ library", "Every public header. All declarations, with a search of their own, are in the "
             '<a href="cpp/index.html">reference of the library</a>. Link with `find_package(drover)` and the target '
             "`drover::drover`."]
    folder = TREE / "include" / "drover"
    for layer in sorted(path for path in folder.iterdir() if path.is_dir()):
        parts += [f"## {layer.name}", table(("header", "contents"), [
            (f"`drover/{layer.name}/{path.name}`", cell(first_sentence(path)))
            for path in sorted(layer.glob("*.hpp"))])]
    return "\n\n".join(parts) + "\n"


# --- observables, from archives of short runs

TINY = ["grid.nx=8", "grid.ny=8", "output.sample_every=0.01", "output.frame_every=0.01", "time.dt=0.01",
        "time.end=0.02", "analysis.warm_up=0"]
FEW = ["cell.lx=12", "cell.ly=12", "time.end=0.02", "output.sample_every=0.005", "output.frame_every=0.01",
       "analysis.warm_up=0"]
# Runs whose observables together are all: title, scene, settings.
RUNS = [("Fields of rods and beads", "flock", [*TINY, "output.powers=true"]),
        ("Fields of rods and beads", "isotropic", [*TINY, "output.powers=true"]),
        ("Fields of rods and beads", "barenblatt", TINY), ("Fields of rods and beads", "point-force", TINY),
        ("Particles", "bead-flock", FEW), ("Particles", "flower-flock", FEW), ("Particles", "bead-gas", FEW),
        ("Models of your own", "active-nematic", [*TINY, "output.powers=true"]),
        ("Models of your own", "toner-tu", TINY),
        ("Models of your own", "bidisperse-bed", TINY)]


def observables_of_run(drover, scene, settings, folder):
    """The observables in the archive of a short run: {name: (unit, axes, meaning)}."""
    archive = Path(folder) / f"{scene}.h5"
    done = subprocess.run([drover, "run", TREE / "models" / f"{scene}.toml", "-o", archive, "--quiet", "--threads", "1",
                           *(word for setting in settings for word in ("--set", setting))], capture_output=True,
                          text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{scene}: {done.stderr}")
    rows = {}
    with h5py.File(archive) as file:
        group = file["observables" if "observables" in file else "series"]
        axes = {name for name, data in group.items() if text_of(data.attrs.get("CLASS", "")) == "DIMENSION_SCALE"}
        for name in sorted(set(group) - axes):
            data = group[name]
            along = [data.dims[axis][0].name.rpartition("/")[2] for axis in range(1, data.ndim)]
            rows[name] = tuple(text_of(data.attrs.get(key, "")) for key in ("units", "comment", "long_name")) + (along,)
    return rows


def text_of(value):
    return value.decode() if isinstance(value, bytes) else str(value)


@functools.cache
def observables(drover):
    """{title: {name: row}}."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for title, scene, settings in RUNS:
            for name, row in observables_of_run(drover, scene, settings, folder).items():
                found.setdefault(title, {}).setdefault(generic(name, scene), row)
    return found


def generic(name, scene):
    """The name of an observable of a scene with fields of its own, F for each of these."""
    values = tomllib.loads((TREE / "models" / f"{scene}.toml").read_text(encoding="utf-8"))
    names = [field["name"] + end for field in values.get("field", [])
             for end in (("_re", "_im", "") if field.get("rank") == "complex" else ("",))]
    for field in sorted(names, key=len, reverse=True):
        name = name.replace(field, "F")
    return name


def observables_page(drover):
    parts = ["# Observables", "What samples (`run.observables`) and tables of results (`run.summary`) contain. In the "
             "last section F is the name of any field of the scene."]
    for title, rows in observables(drover).items():
        parts += [f"## {title}", table(("name", "unit", "axes", "meaning"), [
            (f"`{name}`", cell(unit), cell(", ".join(along)), cell(comment or long_name))
            for name, (unit, comment, long_name, along) in rows.items()])]
    return "\n\n".join(parts) + "\n"


def insertions(drover):
    """{name: text} for the marks <!-- generated: name --> in pages."""
    result = {f"command {command['name']}": command_insertion(command) for command in commands(drover)}
    result["coefficients"] = asked(drover, "schema", "--coefficients").strip()
    result["commands"] = table(("command", "what it does"), [
        (f"[{command['name']}](commands/{command['name']}.md)", cell(command["doc"])) for command in commands(drover)])
    result["commands"] += "\n\n```{toctree}\n:hidden:\n" + "\n".join(
        f"commands/{command['name']}" for command in commands(drover)) + "\n```"
    return result


def generated_pages(drover):
    """{page: text} of the pages that have no source."""
    titles = {"fields": "Keys of field scenes", "model": "Keys of scenes with a model of your own",
              "particles": "Keys of particle scenes"}
    pages = {f"reference/keys-{kind}.md": keys_page(title, drover, kind) for kind, title in titles.items()}
    pages["reference/coefficients.md"] = "# Coefficients of the equations of rods and beads\n\n" \
        "The equations are [here](../equations.md). A coefficient with a star may depend on the densities.\n\n" + \
        asked(drover, "schema", "--coefficients")
    pages["reference/observables.md"] = observables_page(drover)
    listed = "\n".join(re.sub(r"\.md$", "", page.removeprefix("reference/")) for page in pages)
    pages["reference/index.md"] = "# Reference\n\nWritten by the program: every key with its type, default, range, " \
        "unit and meaning, every coefficient, every observable. On the command line: `drover schema`.\n\n" \
        f"```{{toctree}}\n{listed}\n```\n"
    pages["python.md"], pages["cpp.md"] = python_page(), cpp_page()
    return pages
