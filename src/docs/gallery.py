"""src/docs/gallery.py: the gallery: every scene of models/ with its picture, equations, cost and what its tests assert.

    gallery.py --drover build/release/drover --output FOLDER     runs the scenes and draws them, where they changed

Particle scenes are shortened, as their captions say.
"""
import argparse
import ast
import hashlib
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
MODELS = TREE / "models"
# Settings of runs that would take longer than half a minute.
SHORT = {
    "amorphous": ["time.end=3"], "bead-flock": ["time.end=10"], "bead-poor": ["time.end=10"],
    "circle-flock": ["time.end=3"], "flower-flock": ["time.end=3"], "flower-poor": ["time.end=3"],
    "paper-flock": ["time.end=2"], "paper-poor": ["time.end=2"], "paper-rod-in-beads": ["time.end=2"],
    "rod-in-beads": ["time.end=10"], "rods-alone": ["time.end=20"],
}
# Scenes without a run of their own here: the command that shows them, or why there is none.
COMMANDS = {"phase-boundary": "boundary", "calibrate-small": None, "calibrate-matched": None, "calibrate-paper": None,
            "calibrate-bed": None, "full-size": None}
# Tests of what scenes show.
PHYSICS = ("scenes", "shelf", "shelf_slow", "flock_as_equations", "particle_scenes", "calibrated", "calibrate",
           "states")
KINDS = (("Fields of rods and beads", "fields"), ("Models of your own", "model"), ("Particles", "particles"),
         ("For drover calibrate", "calibrate"))


def kind_of(values):
    return next((kind for section, kind in (("calibrate", "calibrate"), ("cell", "particles"), ("field", "model"))
                 if section in values), "fields")


def scenes():
    """{name: (text, values)}."""
    return {path.stem: (path.read_text(encoding="utf-8"), tomllib.loads(path.read_text(encoding="utf-8")))
            for path in sorted(MODELS.glob("*.toml"))}


def comments(text):
    """What a scene shows, how long it takes, and its further remarks."""
    lines = [line[2:] for line in text.splitlines() if line.startswith("# ")]
    shows = next(line.removeprefix("Shows: ") for line in lines if line.startswith("Shows: "))
    takes = next(line.removeprefix("Takes: ") for line in lines if line.startswith("Takes: "))
    head = text.split("\n\n")[1] if "\n\n" in text else ""
    remark = " ".join(line[2:] for line in head.splitlines() if line.startswith("# "))
    return shows, takes, remark


def assertions():
    """{scene: what tests that name it assert}, from the names of the tests, which are sentences."""
    found, known = {}, {path.stem for path in MODELS.glob("*.toml")}
    for path in (TREE / "tests" / "app" / f"test_{name}.py" for name in PHYSICS):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if not isinstance(node, ast.FunctionDef) or not node.name.startswith("test_"):
                continue
            sentence = node.name.removeprefix("test_").replace("_", " ")
            for part in ast.walk(node):
                if isinstance(part, ast.Constant) and isinstance(part.value, str):
                    name = re.sub(r"(^.*/|\.toml$)", "", part.value)
                    if name in known:
                        found.setdefault(name, {})[sentence] = path.name
    return found


def math(latex):
    return "$$\n" + latex.replace(r"\\ ", "\\\\\n") + "\n$$"


def escaped(text):
    return text.replace("*", "\\*").replace("_", "\\_").replace("<", "&lt;").replace("|", "\\|").replace("$", "\\$")


def entry(name, text, values, asserted, picture):
    shows, takes, remark = comments(text)
    parts = [f"### {name}", shows[:1].upper() + escaped(shows[1:])]
    if picture:
        note = f", shortened to {SHORT[name][0].partition('=')[2]} s" if name in SHORT else ""
        parts += [f"![{name}](gallery/{name}.png)", f"*`drover run models/{name}.toml`{note}.*" if name not in COMMANDS
                  else f"*`drover {COMMANDS[name]} models/{name}.toml`.*"]
    if kind_of(values) == "model":
        from drover import Scene
        parts.append(math(Scene.load(MODELS / f"{name}.toml").model.latex))
    if remark:
        parts.append(escaped(remark))
    parts.append(f"*Takes* {escaped(takes)} *File:* `models/{name}.toml`")
    if asserted:
        parts.append("*Tests:* " + "; ".join(f"{escaped(sentence)} (`{file}`)" for sentence, file in asserted.items())
                     + ".")
    return "\n\n".join(parts)


def page(pictures=()):
    """The page, with the pictures that there are."""
    parts = ["# Gallery", "Every scene of `models/` with what it shows, what it costs, and what its tests assert. "
             "`make docs` runs them again where they have changed."]
    asserted = assertions()
    for title, kind in KINDS:
        parts.append(f"## {title}")
        parts += [entry(name, text, values, asserted.get(name), name in pictures)
                  for name, (text, values) in scenes().items() if kind_of(values) == kind]
    return "\n\n".join(parts) + "\n"


def draw(name, drover, target):
    """Runs a scene and draws its figure."""
    with tempfile.TemporaryDirectory() as folder:
        archive = Path(folder) / f"{name}.h5"
        command = COMMANDS.get(name, "run")
        words = [drover, command, MODELS / f"{name}.toml", "--output", archive]
        words += [word for setting in SHORT.get(name, []) for word in ("--set", setting)]
        words += ["--quiet"] if command == "run" else []
        for command_line in (words, [sys.executable, "-P", "-m", "drover.figure", archive, "--output", target]):
            done = subprocess.run(command_line, cwd=MODELS, check=False, capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"docs: {name}: {' '.join(map(str, command_line))} failed with status "
                                 f"{done.returncode}:\n{done.stderr.strip()[-2000:]}")


def write(folder, drover, draw=draw):
    """Writes gallery.md and gallery/*.png below a folder; draw: None leaves out what has not been drawn before."""
    pictures, made = folder / "gallery", []
    pictures.mkdir(parents=True, exist_ok=True)
    stamp = subprocess.run([drover, "--version"], capture_output=True, text=True, check=True).stdout
    for name, (text, _) in scenes().items():
        target, kept = pictures / f"{name}.png", pictures / f"{name}.key"
        key = hashlib.sha256(f"{text}{SHORT.get(name)}{stamp}".encode()).hexdigest()
        if draw and COMMANDS.get(name, "run") and not (target.exists() and kept.exists() and kept.read_text() == key):
            print(f"docs: running {name}", flush=True)
            draw(name, drover, target)
            kept.write_text(key)
        if target.exists():
            made.append(name)
    (folder / "gallery.md").write_text(page(made), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True)
    parser.add_argument("--output", required=True, type=Path)
    words = parser.parse_args()
    words.output.mkdir(parents=True, exist_ok=True)
    write(words.output, str(Path(words.drover).resolve()))


if __name__ == "__main__":
    main()
