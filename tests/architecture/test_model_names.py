"""tests/architecture/test_model_names.py: where code may name fields and coefficients of the shipped model.

What the Python package draws and reads it asks the archive, the scene or the model file; so do the layers of C++ that
know no rods and beads, and runs of fields.  Docstrings and comments may have examples.
"""
import ast
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src/python"
MODEL = tomllib.loads((ROOT / "src/physics/rod_bead.toml").read_text(encoding="utf-8"))
NAMES = [field["name"] for field in MODEL["field"]] + [row["key"] for row in MODEL["coefficient"]]
SECTIONS = {row["key"].partition(".")[0] for row in MODEL["coefficient"]}

# Files, and definitions in them, that may name them: what they have is of particles, of a calibration, or of the demo.
ALL = None
ALLOWED = {
    "particles.py": {"ORDER", "BEAD_ORDER"},      # measures of particles
    "particle_figure.py": ALL,
    "particle_panels.py": {"WORDS"},
    "onset_figure.py": {"draw_onset"},            # runs of particles by their order
    "compare.py": {"ROWS", "PARTICLE_SERIES"},    # what a calibration expects, and measures of particles
    "compare_panels.py": {"SERIES"},
    "demo.py": ALL,                               # the page about the shipped scenes
}
# Words that are sections of coefficients and something else, by the files in which they are that.
ALLOWED_SECTIONS = {
    "model.py": {"noise"},                        # of a [[field]]
    "typeset.py": {"current"},                    # of the currents of the model file
    "scene_page.py": {"noise"},                   # heading of a table
    "shown.py": {"noise"},                        # of a [[field]]
    "theory.py": {"drag"},                        # curves of a calibrated table
    "onset_figure.py": {"drag"},
    "compare.py": {"relaxation"},                 # a row of its table
}


# Layers of C++ that name none of them.  Measures of particles are apart.
LAYERS = ("numerics", "model", "theory", "physics", "measure", "run", "analysis", "jobs", "report")


def places_in(layer):
    """{file: places with a name} of a layer of C++."""
    found = {}
    for path in (*ROOT.glob(f"src/{layer}/**/*.[ch]pp"), *ROOT.glob(f"include/drover/{layer}/*.hpp")):
        code = without_comments(path.read_text(encoding="utf-8"))
        count = sum(code.count(name) for name in NAMES)
        if count and not path.name.startswith("particle"):
            found[str(path.relative_to(ROOT))] = count
    return found


def without_comments(code):
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", code, flags=re.DOTALL)


def docstrings(tree):
    """The ids of the nodes that are docstrings."""
    owners = (node for node in ast.walk(tree)
              if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)))
    firsts = (owner.body[0] for owner in owners if owner.body)
    return {id(first.value) for first in firsts
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)}


def words_of(node):
    """Texts and names that a node has in code."""
    for kind, key in ((ast.Constant, "value"), (ast.Attribute, "attr"), (ast.keyword, "arg"), (ast.Name, "id"),
                      (ast.arg, "arg"), (ast.FunctionDef, "name")):
        if isinstance(node, kind) and isinstance(getattr(node, key), str):
            yield getattr(node, key)


def definition_of(statement):
    """The name that a statement of a module defines."""
    if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
        return statement.targets[0].id
    return getattr(statement, "name", None)


def found_in(source):
    """(line, definition, name) of the names of the model in Python code, and (line, None, section) of its sections."""
    tree = ast.parse(source)
    skipped = docstrings(tree)
    for statement in tree.body:
        for node in ast.walk(statement):
            for word in words_of(node) if id(node) not in skipped else ():
                yield from ((node.lineno, definition_of(statement), name) for name in NAMES if name in word)
                if isinstance(node, ast.Constant) and word in SECTIONS:
                    yield node.lineno, None, word


def sources():
    return {path.name: path.read_text(encoding="utf-8") for path in sorted((PACKAGE / "drover").rglob("*.py"))}


def test_code_in_python_names_no_field_and_no_coefficient_of_the_shipped_model():
    wrong = []
    for file, source in sources().items():
        for line, definition, name in found_in(source):
            if name in SECTIONS and definition is None:
                is_allowed = name in ALLOWED_SECTIONS.get(file, ())
            else:
                is_allowed = file in ALLOWED and (ALLOWED[file] is ALL or definition in ALLOWED[file])
            if not is_allowed:
                wrong.append(f"{file}:{line}: {name}")
    assert wrong == [], "ask the archive, the scene or the model file (drover/fields.py, drover/roles.py) instead"


def test_the_bindings_name_none_either():
    wrong = []
    for path in sorted(PACKAGE.glob("*.[ch]pp")):
        code = without_comments(path.read_text(encoding="utf-8"))
        wrong += [f"{path.name}: {name}" for name in NAMES if name in code]
    assert wrong == []


def test_layers_of_cpp_name_none_of_them():
    found = {file: count for layer in LAYERS for file, count in places_in(layer).items()}
    assert found == {}, "ask the model (model::Field) or its file (physics/model_file.hpp) instead"


def test_what_is_allowed_is_there():
    found = {file: list(found_in(source)) for file, source in sources().items()}
    for file, definitions in ALLOWED.items():
        there = {definition for _, definition, name in found[file] if name in NAMES}
        assert there and (definitions is ALL or definitions == there), file
    for file, sections in ALLOWED_SECTIONS.items():
        assert sections <= {name for *_, name in found[file]}, file


def test_names_are_found_in_code_and_not_in_docstrings_and_comments():
    source = '''"""Of rod_density."""
def shown(run):
    """
    >>> run.frames.rod_density
    """
    return run.frames.rod_density, run["polar_order_x"]  # bead_density

RATE = f"relaxation.rate = {1}", dict(bead_velocity=2), scene["drag"]
'''
    assert sorted(found_in(source), key=str) == sorted([
        (6, "shown", "rod_density"), (6, "shown", "polar_order"), (8, "RATE", "relaxation.rate"),
        (8, "RATE", "bead_velocity"), (8, None, "drag")], key=str)
