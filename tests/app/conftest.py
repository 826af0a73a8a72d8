"""tests/app/conftest.py: the marker of tests that `make test-slow` runs and `make test` does not."""


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: run by `make test-slow`; see tests/CMakeLists.txt")
