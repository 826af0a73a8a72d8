"""tests/architecture/test_layout_page.py: the page on the source names layers, files and types that exist."""
import re
from pathlib import Path

import rules

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "src" / "README.md").read_text(encoding="utf-8")
CODE = {path: path.read_text(encoding="utf-8")
        for folder in ("src", "include") for path in (ROOT / folder).rglob("*.?pp")}


def test_every_layer_and_subfolder_is_listed():
    table = PAGE.partition("| layer |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(\w+)/`", table, re.M) == [name for name in rules.BELOW if name != "python"]
    for layer, subfolders in rules.SUBFOLDERS.items():
        row = re.search(rf"^\| `{layer}/` \| (.*)$", table, re.M)[1]
        assert re.findall(r"`(\w+)/`", row) == list(subfolders)
        assert {path.name for path in (ROOT / "src" / layer).iterdir() if path.is_dir()} == set(subfolders)


def test_layers_are_in_an_order_in_which_each_includes_those_before_it():
    order = list(rules.BELOW)
    for layer in order:
        assert all(order.index(lower) <= order.index(layer) for lower in rules.allowed_layers(layer)), layer


def test_every_type_and_function_that_it_names_is_in_its_layer():
    named = re.findall(r"`(\w+)::((?:\w+::)*\w+)(?:\(\w*\))?`", PAGE)
    assert len(named) > 30
    for layer, name in named:
        last = name.rpartition("::")[2]
        inside = [code for path, code in CODE.items() if layer in path.parts]
        assert any(re.search(rf"\b{last}\b", code) for code in inside), f"{layer}::{name}"


def test_every_file_that_it_names_is_there():
    files = re.findall(r"`([\w/]+\.(?:[ch]pp|py|csv|toml))`", PAGE)
    assert len(files) > 15
    for file in files:
        found = [ROOT / "src" / file, ROOT / "include" / "drover" / file, ROOT / file,
                 *(ROOT / "src").rglob(Path(file).name), *(ROOT / "include").rglob(Path(file).name),
                 *(ROOT / "tests").rglob(Path(file).name)]
        assert any(path.is_file() for path in found), file


def test_every_constant_that_it_names_is_in_its_file():
    named = re.findall(r"`([A-Z]+)` of `([\w/]+\.py)`", PAGE)
    assert len(named) >= 2
    for name, file in named:
        found = [path for path in (ROOT / file, ROOT / "src" / file) if path.is_file()]
        assert found and re.search(rf"^{name} = ", found[0].read_text(encoding="utf-8"), re.M), f"{name} of {file}"


def test_every_model_that_a_page_names_is_in_the_repository():
    tracked = rules.tracked_files(ROOT)
    pages = [(ROOT / path).read_text(encoding="utf-8") for path in tracked if path.suffix == ".md"]
    named = {Path(name) for page in pages for name in re.findall(r"\bmodels/[\w./-]+\.(?:toml|h5|csv)\b", page)}
    assert len(named) > 20 and not named - set(tracked)
