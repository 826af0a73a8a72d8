"""drover/attributes.py: the attributes of arrays of runs in memory, as in archives."""


def about(name, unit, meaning):
    """Units; long_name, the name in words, for labels; comment, the meaning in full."""
    return {"units": unit, "long_name": name.replace("_", " "), "comment": meaning}
