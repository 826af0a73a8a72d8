"""tests/fuzz/storm.py: libFuzzer on every reader of files and texts, under the address and undefined sanitizers.

    cmake --preset fuzz && cmake --build build/fuzz --target drover_fuzz
    python3 tests/fuzz/storm.py build/fuzz/tests/drover_fuzz --seconds 1800 --folder DIR [--only scene table]

Each reader (a folder of corpora/) gets --seconds of one core.  A crash, a report of a sanitizer, an input that takes
more than 10 s or more than 1 GB ends it; the input is kept in DIR/READER.  DIR/storm.csv gets a row for each reader,
and DIR/READER/found the inputs that reached new code, from which the next call goes on.  Status 1 if anything is found.
"""
import argparse
import os
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from studies import KeptTable, timed  # noqa: E402

CORPORA = Path(__file__).resolve().parent / "corpora"
# Short stacks: the sanitizer keeps each stack of an allocation for good, and a parser that calls itself has ever more
# of them; with whole stacks the formulas take 1 GB after 2 million inputs.
OPTIONS = "detect_leaks=1:detect_stack_use_after_return=1:allocator_may_return_null=1:malloc_context_size=4"


def storm(program, reader, seconds, folder):
    """A row of the table."""
    found = folder / reader / "found"
    found.mkdir(parents=True, exist_ok=True)
    ended, core_seconds = timed(
        program, f"-max_total_time={seconds}", "-timeout=10", "-rss_limit_mb=1024", "-malloc_limit_mb=1024",
        "-max_len=65536", "-len_control=0", "-print_final_stats=1", "-verbosity=0",
        f"-artifact_prefix={folder / reader}/", str(found), str(CORPORA / reader),
        env={**os.environ, "DROVER_FUZZ": reader, "ASAN_OPTIONS": OPTIONS})
    executed = re.search(r"number_of_executed_units: (\d+)", ended.stderr)
    if ended.returncode != 0:
        print(f"{reader}: {ended.stderr[-3000:]}", file=sys.stderr)
    return {"reader": reader, "inputs": int(executed[1]) if executed else 0, "core_seconds": round(core_seconds),
            "kept": len(list(found.iterdir())), "status": ended.returncode}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--seconds", type=int, default=1800)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--only", nargs="+", default=sorted(entry.name for entry in CORPORA.iterdir()))
    options = parser.parse_args()
    table = KeptTable(options.folder / "storm.csv", ["reader", "inputs", "core_seconds", "kept", "status"])
    failed = False
    for reader in options.only:
        row = storm(options.program, reader, options.seconds, options.folder)
        table.add(row)
        print(row, flush=True)
        failed |= row["status"] != 0
    return failed


if __name__ == "__main__":
    sys.exit(main())
