"""src/docs/build.py: builds the manual: stages the pages, writes the generated ones, calls Sphinx, checks all links.

    build.py --drover build/release/drover --output build/docs [--quick]

Needs the packages of `.ci/setup docs`, and the module drover on PYTHONPATH.  Notebooks are executed where they have
changed since the last build; --quick leaves them, and the gallery, without results.
"""
import argparse
import base64
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[1]
sys.path.insert(0, str(HERE))

import blocks  # noqa: E402  pylint: disable=wrong-import-position
import links  # noqa: E402  pylint: disable=wrong-import-position
import reference  # noqa: E402  pylint: disable=wrong-import-position

MATHJAX = Path("/usr/share/javascript/mathjax")
MATHJAX_PARTS = ("MathJax.js", "config/TeX-AMS_SVG.js", "extensions", "jax/output/SVG", "jax/element", "jax/input/TeX",
                 "localization/en")
EMPTY = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJ"
                         "RU5ErkJggg==")
# Pages that live beside what they describe, and their names in the manual.
ELSEWHERE = {"src/files/README.md": "durable-files.md", "tests/bench/README.md": "performance.md",
             "models/README.md": "scenes.md", "notebooks/README.md": "tutorials/index.md",
             "CHANGELOG.md": "changes.md", "src/README.md": "layers.md"}


def staged_pages():
    """{file of the tree: page of the manual}."""
    pages = {path.relative_to(TREE).as_posix(): path.relative_to(HERE).as_posix() for path in HERE.rglob("*.md")}
    notebooks = {f"notebooks/{path.name}": f"tutorials/{path.name}" for path in (TREE / "notebooks").glob("*.ipynb")}
    return {**pages, **ELSEWHERE, **notebooks}


def rewritten(text, source, pages):
    """Links to files of the tree as links to pages; where a file has no page, its name alone."""
    def link(found):
        label, target = found[2], found[3]
        file, _, anchor = target.partition("#")
        if "://" in target or not file or target.startswith("mailto:"):
            return found[0]
        name = os.path.normpath(os.path.join(os.path.dirname(source), file))
        page = pages.get(name)
        if name in pages.values() and name not in pages:
            page = name
        here = os.path.dirname(pages[source])
        if page is not None:
            return f"{found[1]}[{label}]({os.path.relpath(page, here or '.')}{'#' + anchor if anchor else ''})"
        if Path(name).parts[:2] == ("src", "docs"):  # a generated page, or a picture
            inside = Path(name).relative_to("src/docs").as_posix()
            return f"{found[1]}[{label}]({os.path.relpath(inside, here or '.')}{'#' + anchor if anchor else ''})"
        if name.startswith("models/") and name.endswith(".toml"):
            return f"[{label}]({os.path.relpath('gallery.md', here or '.')}#{Path(name).stem})"
        return f"{label} (`{name}`)" if label.strip("`") != name else label
    return re.sub(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)", link, text)


def stage(folder, drover):
    """Writes the sources of the manual, generated pages included, to a folder."""
    pages = staged_pages()
    generated = reference.generated_pages(drover)
    kept = {"tutorials", "_extra", "gallery", "drawn"}
    for entry in folder.glob("*"):
        if entry.name not in kept:
            shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
    for source, page in pages.items():
        if not page.endswith(".md"):
            continue
        text = (TREE / source).read_text(encoding="utf-8")
        for name, inserted in reference.insertions(drover).items():
            text = text.replace(f"<!-- generated: {name} -->", inserted)
        if page == "tutorials/index.md":
            text += "\n```{toctree}\n:hidden:\n" + "\n".join(re.findall(r"\(([a-z-]+)\.ipynb\)", text)) + "\n```\n"
        target = folder / page
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(rewritten(text, source, pages), encoding="utf-8")
    for page, text in generated.items():
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        (folder / page).write_text(text, encoding="utf-8")
    for path in HERE.glob("*.png"):
        shutil.copy(path, folder)
    (folder / "_extra").mkdir(exist_ok=True)
    for name in ("particles.mp4", "particles.png"):  # of the film, which Sphinx does not see
        shutil.copy(HERE / name, folder / "_extra")
    shutil.copy(HERE / "conf.py", folder)
    shutil.copytree(HERE / "_static", folder / "_static")
    return pages


def draw_pages(folder, drover, runs):
    """Pictures that the blocks of a page draw; without runs an empty one for each that there is not yet."""
    drawn = folder / "drawn"
    drawn.mkdir(exist_ok=True)
    for page in sorted(folder.rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        missing = [name for name in re.findall(r"!\[[^\]]*\]\(([\w-]+\.png)\)", text)
                   if not (page.parent / name).exists()]
        key, kept = hashlib.sha256(text.encode()).hexdigest(), drawn / f"{page.stem}.key"
        if missing and runs and not (kept.exists() and kept.read_text() == key):
            print(f"docs: running the blocks of {page.name}", flush=True)
            with tempfile.TemporaryDirectory() as scratch:
                blocks.run(text, scratch, drover, TREE / "models")
                for name in missing:
                    shutil.copy(Path(scratch) / name, drawn)
            kept.write_text(key)
        for name in missing:
            (page.parent / name).write_bytes((drawn / name).read_bytes() if (drawn / name).exists() else EMPTY)


def executed(path, text):
    """A notebook with its results; runs in the folder of the notebooks, as a reader would."""
    import nbformat
    from nbconvert.preprocessors import ExecutePreprocessor

    notebook = nbformat.reads(text, as_version=4)
    ExecutePreprocessor(timeout=900, kernel_name="python3").preprocess(
        notebook, {"metadata": {"path": str(path.parent)}})
    for cell in notebook.cells:  # the progress of runs
        if cell.cell_type == "code":
            cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
    return nbformat.writes(notebook)


def stage_notebooks(folder, pages, execute):
    """Notebooks with their results, executed where they or the module have changed."""
    module = next(iter(Path(p) for p in os.environ.get("PYTHONPATH", "").split(":") if p), None)
    built = sorted((module / "drover").glob("_drover*.so")) if module else []
    stamp = built[0].stat().st_mtime_ns if built else 0
    for path in sorted((TREE / "notebooks").glob("*.ipynb")):
        source = path.relative_to(TREE).as_posix()
        text, target = path.read_text(encoding="utf-8"), folder / pages[source]
        target.parent.mkdir(exist_ok=True)
        key = hashlib.sha256(f"{text}{stamp}".encode()).hexdigest()
        kept = target.with_suffix(".key")
        if execute and not (kept.exists() and kept.read_text() == key):
            print(f"docs: executing {path.name}", flush=True)
            target.write_text(executed(path, text), encoding="utf-8")
            kept.write_text(key)
        elif not kept.exists():
            target.write_text(text, encoding="utf-8")
        notebook = json.loads(target.read_text(encoding="utf-8"))
        for cell in notebook["cells"]:
            if cell["cell_type"] == "markdown":
                cell["source"] = rewritten("".join(cell["source"]), source, pages).splitlines(keepends=True)
        target.write_text(json.dumps(notebook, indent=1, ensure_ascii=False), encoding="utf-8")


def copy_mathjax(output):
    target = output / "_static" / "mathjax"
    for part in MATHJAX_PARTS:
        if (MATHJAX / part).is_dir():
            shutil.copytree(MATHJAX / part, target / part, dirs_exist_ok=True)
        else:
            (target / part).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(MATHJAX / part, target / part)


def write_cpp_pages(staging):
    """Doxygen's pages of the public headers, with their own search, below cpp/."""
    output = staging / "_extra" / "cpp"
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    settings = (HERE / "Doxyfile").read_text() + f"\nINPUT={TREE}/include\nSTRIP_FROM_PATH={TREE}/include\n" \
        f'OUTPUT_DIRECTORY={output.parent}\nHTML_OUTPUT=cpp\nINPUT_FILTER="sed -E -f {HERE}/doxygen.sed"\n'
    done = subprocess.run(["doxygen", "-"], input=settings, text=True, capture_output=True, check=False)
    if done.returncode or done.stderr.strip():
        raise SystemExit(f"docs: doxygen complains:\n{done.stderr[:4000]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--output", required=True, type=Path)
    parser.add_argument("--quick", action="store_true", help="do not execute notebooks, nor draw the gallery")
    words = parser.parse_args()
    output, staging = words.output.resolve(), words.output.resolve().with_name(words.output.name + "-source")
    drover = str(Path(words.drover).resolve())
    staging.mkdir(parents=True, exist_ok=True)
    pages = stage(staging, drover)
    draw_pages(staging, drover, runs=not words.quick)
    import gallery
    gallery.write(staging, drover, **({"draw": None} if words.quick else {}))
    stage_notebooks(staging, pages, execute=not words.quick)
    write_cpp_pages(staging)
    os.environ["DROVER_VERSION"] = subprocess.run([drover, "--version"], capture_output=True, text=True,
                                                  check=True).stdout.split()[1]
    subprocess.run([sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q", "-j", "auto", "-d",
                    str(output.with_name(output.name + "-doctrees")), str(staging), str(output)], check=True)
    copy_mathjax(output)
    broken = links.broken(output)
    if broken:
        raise SystemExit("\n".join(["docs: dead links", *broken]))
    print(f"docs: {len(list(output.rglob('*.html')))} pages, no dead link: {output / 'index.html'}")


if __name__ == "__main__":
    main()
