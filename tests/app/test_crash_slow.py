"""tests/app/test_crash_slow.py: fifty kills at random times; crash.py lists the checks after each."""
import pytest
from crash import kill_again_and_again, make_whole


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return make_whole(tmp_path_factory.mktemp("whole"))


@pytest.mark.parametrize("checkpoint_minutes", [0.0005, 0.0])
@pytest.mark.parametrize("seed", range(5))
def test_a_run_killed_five_times_resumes_to_the_same_bytes(checkpoint_minutes, seed, tmp_path, whole):
    assert kill_again_and_again(tmp_path, whole, 5, 100 + seed, checkpoint_minutes) > 0
