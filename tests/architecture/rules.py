"""tests/architecture/rules.py: the architecture rules as data, and the check of a source tree against them.

Usage: rules.py [TREE]    prints file:line and the problem for each violation; exit status 1 if there is any.
"""
import ast
import fnmatch
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import pyflakes.api
import pyflakes.reporter

# Each layer and the layers that it may include; what those may include is allowed too.
BELOW = {
    "base": (),
    "files": ("base",),
    "numerics": ("base",),
    "dem": ("base",),
    "model": ("numerics",),
    "theory": ("model",),
    "physics": ("theory",),
    "measure": ("numerics", "dem", "physics"),
    "calibrate": ("dem", "measure", "physics"),
    "io": ("base", "files", "numerics", "dem", "physics", "measure", "calibrate"),
    "run": ("io",),
    "analysis": ("run",),
    "jobs": ("analysis",),
    "report": ("jobs",),
    "app": ("report",),
    "python": ("report",),
}

# The subfolders of a layer: each may include itself and those before it.  Public headers have none.
SUBFOLDERS = {
    "numerics": ("algebra", "fields", "steppers", "solvers"),
    "dem": ("bodies", "impact", "flight", "neighbours", "packing", "contact", "world"),
    "run": ("loop", "fields", "warnings", "report", "particles"),
    "jobs": ("campaign", "calibration", "sweep", "tradeoff"),
}

# Third-party headers that are confined: library, include patterns, files that may include them, maximum number of
# files.
HOMES = [
    ("FFTW", ("fftw3*",), "src/numerics/*.cpp", 1),
    ("SUNDIALS", ("sundials/*", "nvector/*", "arkode/*", "cvode/*", "kinsol/*", "sun*/*"), "src/numerics/*", 3),
    ("HDF5", ("hdf5*", "H5*"), "src/files/*", None),
    ("toml++", ("toml++/*", "toml.hpp"), "src/io/scene*.cpp", 1),
    ("CLI11", ("CLI/*", "CLI11.hpp"), "src/app/*", None),
]

# Third-party headers that the public headers of a layer may include; other public headers include none, nor system
# headers.
PUBLIC_THIRD_PARTY = {layer: ("Eigen/*",) for layer in ("model", "theory", "physics")}

# Imports of the Python package that may close a circle.  A scene has a model, and a model makes a scene: the public
# interface has both.
PYTHON_CIRCLES = {("drover.model", "drover.scene")}

# Private headers of a module: header pattern, and the files that may include it.
INTERNALS = [
    ("files/overlay.hpp", ("src/files/overlay.cpp", "src/files/hdf5_file.hpp")),
    ("files/journal.hpp", ("src/files/journal.cpp", "src/files/overlay.hpp")),
]

# Ways to files that only the layer of files may use, so that every read and write is checked: what it is, a pattern of
# code, the files that may contain it.  /proc/meminfo is not there on every system; main opens /dev/null.
FILE_ACCESS = [
    ("a stream of files, whose failures are easily lost",
     re.compile(r"<fstream>|\bw?[io]?fstream\b|\bw?filebuf\b|\brdbuf\b|\bf(?:re|d)?open(?:64)?\s*\("),
     ("src/base/memory.cpp",)),
    ("a system call on files",
     re.compile(r"(?<![\w>])::(?:open|openat|creat|p?read|readv|pwrite|rename|unlink)\s*\("),
     ("src/files/*.cpp", "src/app/main.cpp")),
]

# Sentences for people, which code must not read: an outcome is a value.
SENTENCE = re.compile(r"\b\w*(?:failure|reason|remark|refusal|note|problem|unmet|missing|undefined|why_\w+|what\(\))\w*"
                      r"(?:\(\))?\.(?:find|rfind|starts_with|ends_with|contains|substr|compare)\(")

# Comparisons of code with words in quotes, which are right where the words come from outside: why, a pattern of the
# code, the files.  Whatever else decides by a word wants an enum or a value.
COMPARISON = re.compile(r'[!=]= "|\b(?:starts_with|ends_with|r?find|compare|contains)\("')
EVERYWHERE = ("src/*.cpp", "src/*.hpp", "include/*.hpp")
COMPARED_WORDS = [
    ("formulas, equations and their names are text", r"",
     ("src/base/expression_*.cpp", "src/base/formula_*.cpp", "src/model/lowering.cpp",
      "src/model/vector_operations.cpp", "src/io/scene_model.cpp")),
    ("terms are as they were written", r"\b(?:formula|text)\.(?:ends_with|find)", EVERYWHERE),
    ("results are known by their names in records of sweeps, and the observables of pilots",
     r'"(?:(?:size_)?mean_|variance_|_[xy]?|step_error|wavenumber)"',
     ("src/jobs/sweep/sweep_table.cpp", "src/report/tables.cpp", "src/report/report.cpp",
      "src/run/step_choice.cpp")),
    ("arguments of functions are named in a model file", r"\bname == ", ("src/physics/program_functions.cpp",)),
    ("users write durations and targets as text", r"",
     ("src/base/duration.cpp", "src/jobs/campaign/accuracy_target.cpp", "src/jobs/calibration/target_plan.cpp")),
    ("sections and keys of scenes are text", r"",
     ("src/io/scene_t*.cpp", "src/io/scene_model.cpp", "src/io/scene_declared.cpp", "src/physics/model_keys.cpp")),
    ("a key of a scene by its name",
     r'(?:(?:\b|_)keys?\b|\b(?:places|tables|section|row\.name|where)\b).*"', EVERYWHERE),
    ("methods of time stepping are rows of a table by name", r'\b(?:stepper|method\.name) [!=]= "', EVERYWHERE),
    ("units are text", r'\b(?:\w*units?|of_order|word|power|name|second)\b.*"(?:1|/|\[p\]|mm|none)', EVERYWHERE),
    ("files have extensions", r'extension\(\)|\bending\b|\bnames?\b.*"\.', EVERYWHERE),
    ("names within archives and files of other programs", r"",
     ("src/files/*.cpp", "src/io/trajectory.cpp", "src/io/calibration.cpp", "src/app/python_package.cpp",
      "src/run/loop/provenance.cpp", "src/run/run_scene.cpp", "src/base/memory.cpp")),
    ("attributes of archives", r'\bname != "scene"', EVERYWHERE),
]

MAX_LINES = 500
MAX_COLUMNS = 120
# Text files that people write, and files that the limit of columns exempts: data, generated tables, recorded output of
# programs, texts by others.
PROSE = {".cpp", ".hpp", ".py", ".cmake", ".txt", ".sh", ".toml", ".md", ".cff", ".yml", ".in"}
PROSE_NAMES = {"Makefile", "run", "setup"}
EXEMPT = ("LICENSE", "tests/bench/*/data/*", "tests/base/hostile_expressions.txt",
          "tests/app/read_with_mdanalysis.txt", "models/*.calibration/*", "build/*")
URL = re.compile(r"https?://\S+")
TOP_LEVEL = {"CITATION.cff", "CMakeLists.txt", "CMakePresets.json", "CHANGELOG.md", "LICENSE", "Makefile", "README.md",
             "include", "models", "notebooks", "pyproject.toml", "src", "tests"}
CPP = {".cpp", ".hpp"}
INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')


def allowed_layers(layer):
    """The layer and all layers below it."""
    return {layer}.union(*(allowed_layers(lower) for lower in BELOW[layer]))


def layer_of(path):
    """The layer of a path of the tree, or None."""
    parts = path.parts
    name = parts[1] if parts[0] == "src" else parts[2] if parts[:2] == ("include", "drover") else None
    return name if name in BELOW and len(parts) > 2 else None


def subfolder_of(path):
    """The layer and the subfolder of a path of the tree, or None."""
    parts = path.parts
    return parts[1:3] if parts[0] == "src" and len(parts) > 3 and parts[1] in SUBFOLDERS else None


def matches(name, patterns):
    return any(fnmatch.fnmatchcase(str(name), pattern) for pattern in patterns)


def target_of(tree, path, name):
    """The file of the tree that an include refers to, relative to the tree; None for a third-party header."""
    for folder in (path.parent, Path("include"), Path("src")):
        candidate = Path(os.path.normpath(tree / folder / name))
        if candidate.is_file() and candidate.is_relative_to(tree):
            return candidate.relative_to(tree)
    return Path("include", name) if name.startswith("drover/") else None  # not written yet or misspelt, but ours


def check_include(tree, path, name):
    """The violations of one include."""
    layer, target = layer_of(path), target_of(tree, path, name)
    is_public = path.parts[0] == "include"
    if target is not None:
        if layer and layer_of(target) and layer_of(target) not in allowed_layers(layer):
            lower = ", ".join(sorted(allowed_layers(layer) - {layer})) or "no other layer"
            yield f'{layer}/ includes "{name}" of {layer_of(target)}/; it may include {lower}'
        here, other = subfolder_of(path), subfolder_of(target)
        order = SUBFOLDERS[here[0]] if here and other and here[0] == other[0] else None
        if order and order.index(other[1]) > order.index(here[1]):
            yield f'{"/".join(here)}/ includes "{name}" of the later subfolder {other[1]}/'
        if is_public and target.parts[0] != "include":
            yield f'a public header includes "{name}", which is not installed'
        for header, users in INTERNALS:
            if target == Path("src", header) and path.as_posix() not in users:
                yield f'"{name}" is private to its module; only {", ".join(users)} may include it'
        return
    for library, patterns, home, _ in HOMES:
        if matches(name, patterns) and not matches(path, [home]):
            yield f"<{name}> of {library} is included; only {home} may"
    is_standard = re.fullmatch(r"[a-z_0-9]+", name)
    if is_public and not is_standard and not matches(name, PUBLIC_THIRD_PARTY.get(layer, ())):
        yield f"a public header includes <{name}>; it may include only drover's and standard C++ headers"


def check_sources(tree):
    """Include rules of include/ and src/."""
    users = {library: {} for library, *_ in HOMES}
    for path in files(tree, ("include", "src"), CPP):
        for number, line in enumerate((tree / path).read_text().splitlines(), 1):
            if not (found := INCLUDE.match(line)):
                continue
            name = found.group(2)
            yield from (f"{path}:{number}: {problem}" for problem in check_include(tree, path, name))
            for library, patterns, home, _ in HOMES:
                if matches(name, patterns) and matches(path, [home]):
                    users[library].setdefault(path, number)
    for library, _, home, limit in HOMES:
        if limit and len(users[library]) > limit:
            locations = ", ".join(f"{path}:{number}" for path, number in users[library].items())
            yield f"{locations}: {len(users[library])} files include {library}; at most {limit} of {home} may"


def check_file_access(tree):
    """Files are read and written through src/files alone.  Comments do not count."""
    for path in files(tree, ("include", "src"), CPP):
        for number, line in enumerate((tree / path).read_text().splitlines(), 1):
            for what, pattern, homes in FILE_ACCESS:
                if (found := pattern.search(line.split("//")[0])) and not matches(path, homes):
                    yield (f"{path}:{number}: {found.group().strip(' (')} is {what}; expected the functions of "
                           "drover/files: input_file.hpp, new_file.hpp")


def component_of(path):
    """A header and its source are one: include/drover/dem/world.hpp and src/dem/world/world.cpp are dem/world."""
    parts = path.with_suffix("").parts
    parts = parts[2:] if parts[0] == "include" else parts[1:]
    return f"{parts[0]}/{parts[-1]}"


def component_graph(tree):
    """Each component with the components that it includes."""
    graph = {}
    for path in files(tree, ("include", "src"), CPP):
        component = component_of(path)
        edges = graph.setdefault(component, set())
        for line in (tree / path).read_text().splitlines():
            found = INCLUDE.match(line)
            target = target_of(tree, path, found.group(2)) if found else None
            if target is not None and component_of(target) != component:
                edges.add(component_of(target))
    return graph


def cycle_through(graph, start):
    """The shortest cycle of the graph through a component, or None."""
    routes, queue = {start: None}, [start]
    for component in queue:
        for target in sorted(graph.get(component, ())):
            if target == start:
                route = [component]
                while routes[route[-1]] is not None:
                    route.append(routes[route[-1]])
                return route[::-1]
            if target not in routes:
                routes[target] = component
                queue.append(target)
    return None


def check_cycles(tree):
    """Components of C++ (header and source as one) and modules of Python that include each other in a circle."""
    for what, graph in (("component", component_graph(tree)), ("module", module_graph(tree))):
        reported = set()
        for component in sorted(graph):
            cycle = cycle_through(graph, component)
            if cycle and not reported.intersection(cycle):
                yield f"{cycle[0]}: {what} cycle: {' -> '.join([*cycle, cycle[0]])}; expected no cycle"
            reported.update(cycle or ())


def module_graph(tree):
    """{module: modules that it imports} of the Python package; imports within functions count as well."""
    root = tree / "src/python"
    names = {".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path
             for path in sorted((root / "drover").rglob("*.py"))}
    graph = {}
    for name, path in names.items():
        package = name if path.stem == "__init__" else name.rpartition(".")[0]
        imported = {target for node in ast.walk(ast.parse(path.read_text())) for target in imports_of(node, package)}
        graph[name] = {target for target in imported & names.keys() - {name} if (name, target) not in PYTHON_CIRCLES}
    return graph


def imports_of(node, package):
    """Names that an import may mean as modules."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if not isinstance(node, ast.ImportFrom):
        return []
    above = package.split(".")[:len(package.split(".")) - node.level + 1] if node.level else []
    module = ".".join([*above, *([node.module] if node.module else [])])
    return [module, *(f"{module}.{alias.name}" for alias in node.names)]


def check_columns(tree):
    """Lines of text files that people write.  Exempt: rows of markdown tables, and lines that are long by a URL."""
    for path in tracked_files(tree):
        if not (path.suffix in PROSE or path.name in PROSE_NAMES) or matches(path.as_posix(), EXEMPT):
            continue
        for number, line in enumerate((tree / path).read_text().splitlines(), 1):
            is_table_row = path.suffix == ".md" and line.lstrip().startswith("|")
            if len(URL.sub("", line)) > MAX_COLUMNS and not is_table_row:
                yield f"{path}:{number}: {len(line)} columns; at most {MAX_COLUMNS}: wrap the line"


def tracked_files(tree):
    """The files that git tracks; of a tree without git, all files."""
    if not (tree / ".git").exists():
        return files(tree, (".",), PROSE)
    git = ["git", "-c", "safe.directory=*", "-C", str(tree), "ls-files", "-z"]
    names = subprocess.run(git, capture_output=True, text=True, check=True).stdout.split("\0")
    return [Path(name) for name in names if name and (tree / name).is_file()]


def check_files(tree):
    """First lines and numbers of lines."""
    for path in files(tree, ("include", "src", "tests"), CPP | {".py"}):
        lines = (tree / path).read_text().splitlines() or [""]
        if len(lines) > MAX_LINES:
            yield f"{path}:{len(lines)}: {len(lines)} lines; at most {MAX_LINES}: split it"
        if path.suffix in CPP and not re.match(r"// \S+ \S+ \S+", lines[0]):
            yield f"{path}:1: the first line is {lines[0]!r}; expected a // comment with the file's name and content"


def check_top_level(tree):
    """The visible entries of the tree that git does not ignore."""
    entries = {entry.name for entry in tree.iterdir() if not entry.name.startswith(".")} - {"build"}
    git = ["git", "-c", "safe.directory=*", "-C", str(tree), "check-ignore", "--", *sorted(entries)]
    if (tree / ".git").exists():
        entries -= set(subprocess.run(git, capture_output=True, text=True, check=False).stdout.splitlines())
    for name in sorted(entries - TOP_LEVEL):
        yield f"{name}:1: a new entry at the top level; the allowed entries are {', '.join(sorted(TOP_LEVEL))}"


def check_sentences(tree):
    """No code decides by a sentence that it wrote for people."""
    for path in files(tree, ("include", "src"), CPP):
        for number, line in enumerate((tree / path).read_text().splitlines(), 1):
            if found := SENTENCE.search(line.split("//")[0]):
                yield (f"{path}:{number}: {found.group()}...) reads a sentence for people; expected a value, such as "
                       "an enum")


def check_comparisons(tree):
    """Code compares with words in quotes only where the words come from outside."""
    for path in files(tree, ("include", "src"), CPP):
        allowed = [re.compile(around) for _, around, names in COMPARED_WORDS
                   if any(fnmatch.fnmatch(str(path), name) for name in names)]
        for number, line in enumerate((tree / path).read_text().splitlines(), 1):
            code = line.split("//")[0]
            if COMPARISON.search(code) and not any(around.search(code) for around in allowed):
                yield (f"{path}:{number}: decides by a word in quotes: {code.strip()}; expected an enum or a value, or "
                       "a reason in COMPARED_WORDS of tests/architecture/rules.py")


def check_defects(tree):
    """Each defect that tests/defects/plant.py plants has its place in the sources."""
    planted = tree / "tests/defects/plant.py"
    source = ast.parse(planted.read_text() if planted.exists() else "")
    tables = [ast.literal_eval(node.value) for node in source.body
              if isinstance(node, ast.Assign) and node.targets[0].id == "DEFECTS"]
    for defect, path, text, *_ in tables[0] if tables else ():
        count = (tree / path).read_text().count(text) if (tree / path).exists() else 0
        if count != 1:
            yield f"tests/defects/plant.py: {defect!r}: {path} has its text {count} times; expected once"


def check_python_names(tree):
    """Names that no module defines, which only a call would find, and imports that nothing uses."""
    said = io.StringIO()
    for path in files(tree, ("src", "tests"), (".py",)):
        pyflakes.api.check((tree / path).read_text(), str(path), pyflakes.reporter.Reporter(said, said))
    return said.getvalue().splitlines()


def files(tree, folders, suffixes):
    """The files below some folders, relative to the tree, sorted."""
    found = (path for folder in folders for path in (tree / folder).rglob("*") if path.suffix in suffixes)
    return sorted(path.relative_to(tree) for path in found if path.is_file())


def broken_rules(tree):
    tree = Path(tree).resolve()
    return [*check_sources(tree), *check_file_access(tree), *check_sentences(tree),
            *check_comparisons(tree), *check_cycles(tree),
            *check_files(tree), *check_columns(tree), *check_top_level(tree), *check_defects(tree),
            *check_python_names(tree)]


def main(arguments):
    tree = Path(arguments[0]) if arguments else Path(__file__).resolve().parents[2]
    if not (tree / "src").is_dir():
        print(f"{tree}: has no folder src; expected the top folder of drover", file=sys.stderr)
        return 2
    found = broken_rules(tree)
    print(*(found or ["no violation of the architecture rules"]), sep="\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
