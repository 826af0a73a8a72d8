"""src/docs/links.py: the links between the files of a built site, and those that lead nowhere."""
import os
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """The anchors of a page, and what it links to."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.targets = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if value and (name == "id" or (tag == "a" and name == "name")):
                self.anchors.add(value)
            elif value and name in ("href", "src", "poster"):
                self.targets.append(value)


def broken(folder):
    """A line for each link of the HTML files below a folder that leads to no file or no anchor.

    Doxygen links to a heading of nested classes also where it lists none: its anchors are not checked.
    """
    folder = Path(folder)
    pages = {path: Page(path.read_text(encoding="utf-8", errors="replace")) for path in folder.rglob("*.html")
             if "_static" not in path.parts}
    problems = []
    for path, page in sorted(pages.items()):
        for target in dict.fromkeys(page.targets):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc or target.startswith("javascript:"):
                continue
            file = Path(os.path.normpath(path.parent / unquote(parts.path))) if parts.path else path
            if file.is_dir():
                file = file / "index.html"
            if not file.exists():
                problems.append(f"{path.relative_to(folder)}: {target}: no such file")
            elif (parts.fragment and "cpp" not in path.parts and file in pages
                  and unquote(parts.fragment) not in pages[file].anchors):
                problems.append(f"{path.relative_to(folder)}: {target}: no such place")
    return problems
