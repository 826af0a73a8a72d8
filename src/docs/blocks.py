"""src/docs/blocks.py: runs the code blocks of a page of the manual in their order, as a reader would paste them.

```sh blocks run in bash, ```python blocks in one namespace, and a ```toml block is written to the file that the text
before it names in backquotes.  `short`, {scene of models/: settings}, shortens runs of shipped scenes.
"""
import contextlib
import io
import os
import re
import stat
import subprocess
import sys
from pathlib import Path

BLOCK = re.compile(r"^```(toml|sh|python)\n(.*?)^```", re.M | re.S)
# Stands for the program in sh blocks: settings that shorten a shipped scene come before those of the line.
PROGRAM = """#!{python}
import os, re, sys
words, short = sys.argv[1:], {short!r}
for number, word in enumerate(words):
    found = re.fullmatch(r"(?:.*/)?models/([a-z-]+)\\.toml", word)
    if found and words[0] in ("run", "sweep", "tradeoff", "calibrate", "film"):
        given = [setting for key in short.get(found[1], []) for setting in ("--set", key)]
        words[number + 1:number + 1] = given
        break
os.execv({drover!r}, [{drover!r}, *words])
"""


def blocks_of(text):
    """(language, code, text before it) of each block."""
    at, result = 0, []
    for found in BLOCK.finditer(text):
        result.append((found[1], found[2], text[at:found.start()]))
        at = found.end()
    return result


def set_up(folder, drover, models, short):
    """A folder with the scenes of the tree, and a PATH on which drover is the shortening one."""
    folder = Path(folder)
    if not (folder / "models").exists():
        (folder / "models").symlink_to(models)
    binaries = folder / ".bin"
    binaries.mkdir(exist_ok=True)
    program = binaries / "drover"
    program.write_text(PROGRAM.format(python=sys.executable, drover=str(drover), short=short))
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    python = binaries / "python3"
    if not python.exists():
        python.symlink_to(sys.executable)
    paths = [os.path.abspath(path) for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "PATH": f"{binaries}:{os.environ['PATH']}",
            "MPLBACKEND": "Agg", "NO_COLOR": "1"}


def typed(value):
    """The value of "key=value" as a Python value."""
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(value)
    return value == "true" if value in ("true", "false") else value


def run(text, folder, drover, models, short=None):
    """Runs all blocks; returns what each Python block printed, as lists of lines.  Raises for one that fails."""
    import drover as module

    short = short or {}
    environment = set_up(folder, drover, models, short)
    printed, names, load = [], {}, vars(module.Scene)["load"]
    loaded = load.__func__

    def shortened(cls, path):
        scene, found = loaded(cls, path), re.search(r"models/([a-z-]+)\.toml$", str(path))
        changes = dict(setting.split("=", 1) for setting in short.get(found[1], [])) if found else {}
        return scene.set({key: typed(value) for key, value in changes.items()}) if changes else scene

    module.Scene.load = classmethod(shortened)
    try:
        with contextlib.chdir(folder):
            for number, (language, code, before) in enumerate(blocks_of(text), 1):
                if language == "toml":
                    named = re.findall(r"`([\w-]+\.toml)`", before)
                    Path(named[-1]).write_text(code, encoding="utf-8")
                elif language == "sh":
                    done = subprocess.run(["bash", "-euo", "pipefail", "-c", code], env=environment,
                                          capture_output=True, text=True, check=False)
                    if done.returncode:
                        raise RuntimeError(f"block {number} ended with status {done.returncode}:\n{code}\n"
                                           f"{done.stderr[-2000:]}")
                else:
                    with contextlib.redirect_stdout(io.StringIO()) as out:
                        exec(compile(code, f"block {number}", "exec"), names)  # pylint: disable=exec-used
                    printed.append([line for line in out.getvalue().splitlines() if line])
    finally:
        module.Scene.load = load
    return printed

