"""tests/architecture/rules.py: the rules of the house, as data, and the check of a source tree against them.

Usage: rules.py [TREE]    prints one line for each broken rule, file:line first; exit status 1 if there is any.
"""
import fnmatch
import re
import subprocess
import sys
from pathlib import Path

# Each layer with those it may include; what these may include is allowed too.
BELOW = {
    "base": (),
    "numerics": ("base",),
    "dem": ("base",),
    "physics": ("numerics",),
    "measure": ("numerics", "dem", "physics"),
    "calibrate": ("dem", "measure", "physics"),
    "io": ("base", "numerics", "dem", "physics", "measure", "calibrate"),
    "run": ("io",),
    "app": ("run",),
}

# Third-party headers that stay in one place: name, include patterns, files that may have them, how many files at most.
HOMES = [
    ("FFTW", ("fftw3*",), "src/numerics/*.cpp", 1),
    ("SUNDIALS", ("sundials/*", "nvector/*", "arkode/*", "cvode/*", "sun*/*"), "src/numerics/*.cpp", 2),
    ("HDF5", ("hdf5*", "H5*"), "src/io/*", None),
    ("toml++", ("toml++/*", "toml.hpp"), "src/io/scene*.cpp", 1),
    ("CLI11", ("CLI/*", "CLI11.hpp"), "src/app/*", None),
]

# Third-party headers that the public headers of a layer may include; elsewhere none, and no system header.
PUBLIC_THIRD_PARTY = {"physics": ("Eigen/*",)}

MAX_LINES = 500
TOP_LEVEL = {"CMakeLists.txt", "CMakePresets.json", "CHANGELOG.md", "LICENSE", "Makefile", "README.md",
             "include", "models", "notebooks", "src", "tests"}
CPP = {".cpp", ".hpp"}
INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')


def allowed_layers(layer):
    """The layer itself and everything below it."""
    return {layer}.union(*(allowed_layers(lower) for lower in BELOW[layer]))


def layer_of(path):
    """The layer that a path of the tree belongs to, or None."""
    parts = path.parts
    name = parts[1] if parts[0] == "src" else parts[2] if parts[:2] == ("include", "drover") else None
    return name if name in BELOW and len(parts) > 2 else None


def matches(name, patterns):
    return any(fnmatch.fnmatchcase(str(name), pattern) for pattern in patterns)


def target_of(tree, path, name):
    """The file of the tree that an include means, relative to the tree, or None for someone else's."""
    for folder in (path.parent, Path("include"), Path("src")):
        candidate = (tree / folder / name).resolve()
        if candidate.is_file() and candidate.is_relative_to(tree):
            return candidate.relative_to(tree)
    return Path("include", name) if name.startswith("drover/") else None  # not written yet, or misspelt: still ours


def check_include(tree, path, name):
    """What is wrong with one include, as sentences."""
    layer, target = layer_of(path), target_of(tree, path, name)
    is_public = path.parts[0] == "include"
    if target is not None:
        if layer and layer_of(target) and layer_of(target) not in allowed_layers(layer):
            lower = ", ".join(sorted(allowed_layers(layer) - {layer})) or "nothing of ours"
            yield f'{layer}/ includes "{name}" of {layer_of(target)}/; it may include {lower}'
        if is_public and target.parts[0] != "include":
            yield f'a public header includes "{name}", which is not installed'
        return
    for library, patterns, home, _ in HOMES:
        if matches(name, patterns) and not matches(path, [home]):
            yield f"<{name}> of {library} is included; only {home} may"
    is_standard = re.fullmatch(r"[a-z_0-9]+", name)
    if is_public and not is_standard and not matches(name, PUBLIC_THIRD_PARTY.get(layer, ())):
        yield f"a public header includes <{name}>; only drover's and the standard C++ headers belong there"


def check_sources(tree):
    """Include rules of include/ and src/."""
    users = {library: {} for library, *_ in HOMES}
    for path in files(tree, ("include", "src"), CPP):
        for number, line in enumerate((tree / path).read_text().splitlines(), 1):
            if not (found := INCLUDE.match(line)):
                continue
            name = found.group(2)
            yield from (f"{path}:{number}: {sentence}" for sentence in check_include(tree, path, name))
            for library, patterns, home, _ in HOMES:
                if matches(name, patterns) and matches(path, [home]):
                    users[library].setdefault(path, number)
    for library, _, home, most in HOMES:
        if most and len(users[library]) > most:
            places = ", ".join(f"{path}:{number}" for path, number in users[library].items())
            yield f"{places}: {len(users[library])} files include {library}; at most {most} of {home} may"


def check_files(tree):
    """First lines and lengths."""
    for path in files(tree, ("include", "src", "tests"), CPP | {".py"}):
        lines = (tree / path).read_text().splitlines() or [""]
        if len(lines) > MAX_LINES:
            yield f"{path}:{len(lines)}: {len(lines)} lines; at most {MAX_LINES}: split it"
        if path.suffix in CPP and not re.match(r"// \S+ \S+ \S+", lines[0]):
            yield f"{path}:1: the first line is {lines[0]!r}; expected a // comment that says what lives there"


def check_top_level(tree):
    """The visible entries of the tree, without what git ignores."""
    entries = {entry.name for entry in tree.iterdir() if not entry.name.startswith(".")} - {"build"}
    git = ["git", "-c", "safe.directory=*", "-C", str(tree), "check-ignore", "--", *sorted(entries)]
    if (tree / ".git").exists():
        entries -= set(subprocess.run(git, capture_output=True, text=True, check=False).stdout.splitlines())
    for name in sorted(entries - TOP_LEVEL):
        yield f"{name}:1: a new entry at the top level, which is fixed: {', '.join(sorted(TOP_LEVEL))}"


def files(tree, folders, suffixes):
    """The files below some folders, relative to the tree, in order."""
    found = (path for folder in folders for path in (tree / folder).rglob("*") if path.suffix in suffixes)
    return sorted(path.relative_to(tree) for path in found if path.is_file())


def broken_rules(tree):
    tree = Path(tree).resolve()
    return [*check_sources(tree), *check_files(tree), *check_top_level(tree)]


def main(arguments):
    tree = Path(arguments[0]) if arguments else Path(__file__).resolve().parents[2]
    if not (tree / "src").is_dir():
        print(f"{tree}: no folder src there; expected the top folder of drover", file=sys.stderr)
        return 2
    found = broken_rules(tree)
    print(*(found or ["every rule of the house holds"]), sep="\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
