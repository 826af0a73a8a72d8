"""tests/architecture/test_version.py: the version of a build contains the commit that it was built from."""
import os
import shutil
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "src/base/version.cmake"


def git(tree, *arguments):
    author = ["-c", "user.name=nobody", "-c", "user.email=nobody@localhost", "-c", "commit.gpgsign=false"]
    command = ["git", "-C", str(tree), *author, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def stamp(tree, output):
    command = ["cmake", "-D", f"SOURCE={tree}", "-D", "VERSION=1.2.3", "-D", f"OUTPUT={output}", "-P", str(SCRIPT)]
    subprocess.run(command, check=True, capture_output=True)
    return output.read_text()


@pytest.fixture(name="checkout")
def a_checkout_with_one_commit(tmp_path):
    tree = tmp_path / "a checkout"
    (tree / "src").mkdir(parents=True)
    (tree / "src/flock.cpp").write_text("int flock;\n")
    (tree / "README.md").write_text("words\n")
    git(tree, "init", "--quiet")
    git(tree, "add", ".")
    git(tree, "commit", "--quiet", "-m", "Begin")
    return tree


def test_a_clean_checkout_has_its_hash(checkout, tmp_path):
    text = stamp(checkout, tmp_path / "version.cpp")
    assert f'.version = "1.2.3", .git_hash = "{git(checkout, "rev-parse", "HEAD")}", .dirty = false' in text


def test_changed_or_new_sources_make_it_dirty_and_changed_documents_do_not(checkout, tmp_path):
    output = tmp_path / "version.cpp"
    (checkout / "README.md").write_text("other words\n")
    assert ".dirty = false" in stamp(checkout, output)
    (checkout / "src/more.cpp").write_text("int more;\n")
    assert ".dirty = true" in stamp(checkout, output)
    (checkout / "src/more.cpp").unlink()
    (checkout / "src/flock.cpp").write_text("int herd;\n")
    assert ".dirty = true" in stamp(checkout, output)


def test_a_rebuild_of_the_same_commit_leaves_the_file_unchanged_and_a_new_commit_updates_it(checkout, tmp_path):
    output = tmp_path / "version.cpp"
    first = stamp(checkout, output)
    os.utime(output, (1, 1))
    assert stamp(checkout, output) == first and output.stat().st_mtime == 1
    git(checkout, "commit", "--quiet", "--allow-empty", "-m", "Continue")
    assert git(checkout, "rev-parse", "HEAD") in stamp(checkout, output)


def test_a_tree_without_git_has_no_commit_even_inside_another_checkout(checkout, tmp_path):
    tarball = checkout / "drover-1.2.3"
    tarball.mkdir()
    assert '.git_hash = "unknown", .dirty = false' in stamp(tarball, tmp_path / "version.cpp")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can change the owner of a file")
def test_a_checkout_of_another_user_has_its_hash(checkout, tmp_path):
    commit = git(checkout, "rev-parse", "HEAD")
    for path in [checkout, *checkout.rglob("*")]:
        shutil.chown(path, 65534, 65534)
    assert commit in stamp(checkout, tmp_path / "version.cpp")
