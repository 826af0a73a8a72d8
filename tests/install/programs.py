"""tests/install/programs.py: writes the C++ programs of the manual to a folder, as program_1.cpp and so on."""
import re
import sys
from pathlib import Path

page = Path(__file__).parents[2] / "src" / "docs" / "cpp.md"
folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
for number, text in enumerate(re.findall(r"```cpp\n(.*?)```", page.read_text(encoding="utf-8"), re.S), 1):
    (folder / f"program_{number}.cpp").write_text(text, encoding="utf-8")
