"""tests/studies.py: what studies share: settings as words of the program, and a table that is kept row by row."""
import csv
import json
import os
import resource
import subprocess


def settings_of(keys):
    """The words that set {"section.key": value}."""
    return [word for key, value in keys.items() for word in ("--set", f"{key}={json.dumps(value)}")]


def version_of(program):
    """The version that a program prints."""
    return subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.strip()


def timed(*command, **options):
    """A process that has ended, and its core seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ended = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return ended, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class KeptTable:
    """A csv file whose rows are written as they are found: a study that is started again goes on after them."""

    def __init__(self, path, columns):
        self.path, self.columns, self.rows = path, columns, []
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists():
            with open(path, newline="") as file:
                self.rows = list(csv.DictReader(file))

    def add(self, *rows):
        """Appends rows, all of them or none."""
        is_new = not self.rows
        self.rows += rows
        with open(self.path, "a", newline="") as file:
            writer = csv.DictWriter(file, self.columns, lineterminator="\n")
            if is_new:
                writer.writeheader()
            writer.writerows(rows)
            file.flush()
            os.fsync(file.fileno())
