"""tests/extremes/program.py: one run of the program, and the outcomes that need no physics."""
import subprocess

from studies import settings_of

limit = {"seconds": 60}


def call(program, folder, command, keys, *words):
    """Status, standard output and standard error of a command on the scene of these keys; status None: no end."""
    (folder / "empty.toml").write_text("")
    try:
        ended = subprocess.run([program, command, "empty.toml", *settings_of(keys), *words], cwd=folder,
                               capture_output=True, text=True, errors="replace", timeout=limit["seconds"], check=False)
    except subprocess.TimeoutExpired:
        return None, "", ""
    return ended.returncode, ended.stdout, ended.stderr


def failure(status, errors):
    """The outcome of a command that did not end with status 0; None: it did."""
    if status == 0:
        return None
    said = errors.strip().splitlines()
    sentence = said[-1] if said else ""
    if status is None:
        return "slow", "", f"no end within {limit['seconds']} s"
    if status not in (1, 2) or not sentence.startswith("error: ") or len(sentence) < 40:
        return "CRASH", "", f"status {status}: {sentence}"
    return "refused" if status == 2 else "stopped", "", sentence


def has_non_finite(value):
    """Whether any number of a JSON value is not finite."""
    if isinstance(value, dict):
        return any(has_non_finite(item) for item in value.values())
    if isinstance(value, list):
        return any(has_non_finite(item) for item in value)
    return isinstance(value, float) and not abs(value) < 1e305
