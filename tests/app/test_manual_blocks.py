"""tests/app/test_manual_blocks.py: every block of the manual runs, shortened; test_python_model.py runs model.md."""
import sys

import matplotlib
import pytest
from support import DROVER, MODELS, slow_but

DOCS = MODELS.parent / "src" / "docs"
sys.path.insert(0, str(DOCS))
matplotlib.use("Agg")
import blocks  # noqa: E402  # pylint: disable=wrong-import-position

GRID = ["grid.nx=32", "grid.ny=32"]
# Settings that make the runs of pages short; what they show is tested elsewhere.
SHORT = {
    "active-nematic": [*GRID, "grid.lx=32", "grid.ly=32", "time.end=10"],
    "banding": ["grid.nx=128", "grid.ny=8", "time.end=20"],
    "bead-flock": ["cell.lx=15", "cell.ly=15", "time.end=0.3", "output.frame_every=0.05", "output.sample_every=0.01"],
    "bead-gas": ["time.end=0.2", "output.frame_every=0.05", "output.sample_every=0.01"],
    "calibrated-flock": ["time.end=200"],
    "isotropic": [*GRID, "time.end=100"],
    "noisy-flock": ["grid.nx=16", "grid.ny=16", "grid.lx=160", "grid.ly=160", "time.end=200"],
    "quench": [*GRID, "grid.lx=16", "grid.ly=16", "time.end=20"],
    "calibrate-small": ["cell.lx=10", "cell.ly=10", "time.dt=4e-5", "contacts.max_overlap=0.2",
                        "calibrate.bead_area_fractions=[0.3]", "calibrate.round=4", 'calibrate.assays=["damping"]',
                        "calibrate.max_trials=8", "calibrate.damping.time=0.2"],
}


def pages_with_blocks():
    return sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")
                  if blocks.blocks_of(path.read_text(encoding="utf-8")) and path.name != "model.md")


def test_pages_with_blocks_are_found():
    assert {"howto.md", "files.md", "clusters.md", "commands/run.md"} <= set(pages_with_blocks())
    assert len(blocks.blocks_of((DOCS / "howto.md").read_text(encoding="utf-8"))) >= 30


@pytest.mark.parametrize("page", slow_but(pages_with_blocks(), "howto.md", "clusters.md", "index.md", "commands/run.md",
                                          "commands/sweep.md"))
def test_every_block_of_a_page_runs(page, tmp_path):
    blocks.run((DOCS / page).read_text(encoding="utf-8"), tmp_path, DROVER, MODELS, SHORT)


def test_a_block_that_fails_is_reported_with_its_code(tmp_path):
    with pytest.raises(RuntimeError, match="block 1 ended with status 2"):
        blocks.run("```sh\ndrover check missing.toml\n```\n", tmp_path, DROVER, MODELS)
    with pytest.raises(ZeroDivisionError):
        blocks.run("```python\n1 / 0\n```\n", tmp_path, DROVER, MODELS)
