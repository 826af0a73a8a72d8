"""src/docs/conf.py: Sphinx's configuration of the manual; build.py calls Sphinx."""
import os
import re

project = "drover"
author = "the drover developers"
copyright = "the drover developers, GPL-3.0-or-later"  # pylint: disable=redefined-builtin
version = release = os.environ.get("DROVER_VERSION", "")

extensions = ["myst_parser", "nbsphinx", "sphinx.ext.mathjax", "sphinx.ext.autodoc"]
exclude_patterns = ["drawn", "**.ipynb_checkpoints"]
html_theme = "furo"
html_title = "drover"
html_static_path = ["_static"]
html_extra_path = ["_extra"]
html_css_files = ["drover.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"sidebar_hide_name": False}
pygments_style = "friendly"
highlight_language = "none"
smartquotes = False  # they would join the dashes of options

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header", "mathjax"]

autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": False}

def plain(_app, _what, _name, _object, _options, lines):
    """Docstrings of this project are plain text: as reST with nothing marked, tables and examples as they are."""
    parts = "\n".join(lines).strip("\n").split("\n\n")
    written = []
    for part in parts:
        rows = part.split("\n")
        if part.startswith(">>>"):
            written += [*rows, ""]
        elif any(row.startswith(" ") or "   " in row.strip() for row in rows):
            written += ["::", "", *("    " + row for row in rows), ""]
        else:
            written += [*(re.sub(r"([\\*|_])", r"\\\1", row) if "`" not in row else row for row in rows), ""]
    lines[:] = written


def setup(app):
    app.connect("autodoc-process-docstring", plain)


nbsphinx_execute = "never"  # build.py has executed them
nbsphinx_prolog = ""

# MathJax of Debian (2.7), copied beside the pages: works from file://.
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_SVG"
mathjax2_config = {
    "tex2jax": {"inlineMath": [["$", "$"], ["\\(", "\\)"]], "processEscapes": True, "ignoreClass": "document",
                "processClass": "math|output_area|tex2jax_process"},
    "SVG": {"font": "TeX", "linebreaks": {"automatic": True}},
    "showMathMenu": False,
}
