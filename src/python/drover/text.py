"""drover/text.py: texts and names of files, which may hold anything, for a terminal and for a figure."""
import re

CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")  # and bytes of a name that are not UTF-8
LONGEST = 200  # characters of a text in a figure


def printable(text):
    r"""A text without the control characters by which a file could command the terminal, as the program prints it.

    >>> printable("\x1b[2J"), printable(b"flock-\xff".decode(errors="surrogateescape"))
    ('\\x1b[2J', 'flock-\\xff')
    """
    return CONTROL.sub(lambda match: f"\\x{ord(match[0]) & 0xff:02x}", str(text))


def duration(seconds):
    """A duration as the program prints it.

    >>> duration(0.61234), duration(61), duration(7500), duration(float("inf"))
    ('0.612 s', '1 min 01 s', '2 h 05 min', 'unknown time')
    """
    if seconds < 60.0:
        return f"{seconds:.3g} s"
    if seconds == float("inf"):
        return "unknown time"
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes} min {rest:02d} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


def drawable(text):
    r"""A text that a figure shows as it is, and does not take for formulas: for all that comes from a file.

    >>> drawable("a $b$.toml")
    'a \\$b\\$.toml'
    """
    words = printable(text).replace("\n", " ").replace("\t", " ")
    words = words if len(words) <= LONGEST else words[:LONGEST - 3] + "..."
    return words.replace("$", r"\$")


def scene_name(run):
    """The name of the scene of a run or a theory, for a figure: without its folders."""
    return drawable(str(run.attributes.get("scene_file", "?")).rsplit("/", 1)[-1])
