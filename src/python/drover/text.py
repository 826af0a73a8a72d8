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


def drawable(text):
    r"""A text that a figure shows as it is, and does not take for formulas: for all that comes from a file.

    >>> drawable("a $b$.toml")
    'a \\$b\\$.toml'
    """
    words = printable(text).replace("\n", " ").replace("\t", " ")
    words = words if len(words) <= LONGEST else words[:LONGEST - 3] + "..."
    return words.replace("$", r"\$")


def scene_name(run):
    """The name of the scene of a run or a theory, for a figure."""
    return drawable(run.attributes.get("scene_file", "?"))
