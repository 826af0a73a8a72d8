"""src/docs/shell.py: man pages, and completion for bash, zsh and fish, from what the program says of itself.

    shell.py --drover build/release/drover --output FOLDER      writes drover.1, drover-run.1, ..., drover.bash, ...
"""
import argparse
import json
import subprocess
from pathlib import Path



def asked(drover, *words):
    return json.loads(subprocess.run([drover, "schema", *words], capture_output=True, text=True, check=True).stdout)


def version_of(drover):
    return subprocess.run([drover, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]


# --- man pages

def roff(text):
    """A text as roff reads it."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq")
    return "\n".join("\\&" + line if line.startswith(".") else line for line in text.split("\n"))


def synopsis(command):
    words = [f"\\fBdrover {command['name']}\\fR"]
    for option in command["options"]:
        if option["positional"]:
            name = f"\\fI{roff(option['name'].upper())}\\fR" + (" ..." if option["repeatable"] else "")
            words.append(name if option["required"] else f"[{name}]")
        elif option["required"]:
            words.append(f"\\fB{roff(option['names'][-1])}\\fR \\fI{roff(option['value'])}\\fR")
    return " ".join([*words, "[\\fIOPTIONS\\fR]"])


def page_of_command(command, version):
    parts = [f'.TH DROVER\\-{command["name"].upper()} 1 "" "drover {version}" "drover"', ".SH NAME",
             f"drover\\-{command['name']} \\- {roff(command['doc'])}", ".SH SYNOPSIS", synopsis(command), ".SH OPTIONS"]
    for option in command["options"]:
        name = f"\\fI{roff(option['name'].upper())}\\fR" if option["positional"] else \
            ", ".join(f"\\fB{roff(name)}\\fR" for name in option["names"])
        value = f" \\fI{roff(option['value'])}\\fR" if option["value"] and not option["positional"] else ""
        parts += [".TP", name + value, roff(option["doc"])]
    parts += [".SH EXIT STATUS"]
    for row in command["exit_statuses"]:
        parts += [".TP", str(row["status"]), roff(row["meaning"])]
    return "\n".join([*parts, ".SH SEE ALSO", "\\fBdrover\\fR(1)", ""])


def main_page(commands, version):
    parts = [f'.TH DROVER 1 "" "drover {version}" "drover"', ".SH NAME",
             "drover \\- hydrodynamics of flocks carried by a passive medium, and fields of your own", ".SH SYNOPSIS",
             "\\fBdrover\\fR \\fICOMMAND\\fR [\\fIARGUMENTS\\fR]", ".SH DESCRIPTION",
             "A scene (input file, TOML) describes a run. \\fBdrover schema\\fR lists its keys.", ".SH COMMANDS"]
    for command in commands:
        parts += [".TP", f"\\fBdrover\\-{command['name']}\\fR(1)", roff(command["doc"])]
    parts += [".SH EXIT STATUS"]
    for row in next(command for command in commands if command["name"] == "run")["exit_statuses"]:
        parts += [".TP", str(row["status"]), roff(row["meaning"])]
    return "\n".join([*parts, ".SH ENVIRONMENT", ".TP", "\\fBDROVER_NO_LOCKS\\fR",
                      roff("1 allows a file system without locks; then let one process at a time use a folder"), ""])


# --- completion

def flags(command):
    return [name for option in command["options"] if not option["positional"] for name in option["names"]]


def bash(commands, keys):
    cases = "\n".join(f"    {command['name']}) words='{' '.join(flags(command))}' ;;" for command in commands)
    return f"""# drover.bash: completion of drover for bash.
_drover() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} words=''
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    words='{' '.join(command['name'] for command in commands)} --help --version'
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
    return
  fi
  if [ "$before" = --set ]; then
    compopt -o nospace
    mapfile -t COMPREPLY < <(compgen -S = -W '{' '.join(keys)}' -- "$current")
    return
  fi
  case ${{COMP_WORDS[1]}} in
{cases}
  esac
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  else
    compopt -o filenames
    mapfile -t COMPREPLY < <(compgen -f -- "$current")
  fi
}}
complete -F _drover drover
"""


def quoted(text):
    """A text in single quotes of zsh's _arguments, or of fish."""
    return text.replace("\\", "").replace("'", "").replace("[", "(").replace("]", ")").replace(":", ",")


def zsh(commands, keys):
    names = "\n".join(f"    '{command['name']}:{quoted(command['doc'])}'" for command in commands)
    cases = []
    for command in commands:
        rows = []
        for option in command["options"]:
            if option["positional"]:
                continue
            for name in option["names"]:
                value = "" if not option["value"] else ":key:_drover_keys" if name == "--set" else \
                    f":{quoted(option['value'])}:_files"
                many = "*" if option["repeatable"] else ""
                rows.append(f"      '{many}{name}[{quoted(option['doc'])}]{value}'")
        cases.append(f"    {command['name']}) _arguments \\\n" + " \\\n".join([*rows, "      '*:file:_files'"]) + " ;;")
    newline = "\n"
    return f"""#compdef drover
# _drover: completion of drover for zsh.
_drover_keys() {{
  compadd -S = -- {' '.join(keys)}
}}
_drover() {{
  local -a commands
  commands=(
{names}
  )
  if (( CURRENT == 2 )); then
    _describe command commands
    return
  fi
  local command=$words[2]
  shift words
  (( CURRENT-- ))
  case $command in
{newline.join(cases)}
  esac
}}
_drover "$@"
"""


def fish(commands, keys):
    lines = ["# drover.fish: completion of drover for fish."]
    for command in commands:
        lines.append(f"complete -c drover -n __fish_use_subcommand -f -a {command['name']} "
                     f"-d '{quoted(command['doc'])}'")
    for command in commands:
        for option in command["options"]:
            if option["positional"]:
                continue
            names = " ".join(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}"
                             for name in option["names"])
            value = "" if not option["value"] else f" -x -a '{' '.join(key + '=' for key in keys)}'" \
                if "--set" in option["names"] else " -r"
            lines.append(f"complete -c drover -n '__fish_seen_subcommand_from {command['name']}' {names}{value} "
                         f"-d '{quoted(option['doc'])}'")
    return "\n".join(lines) + "\n"


def written(drover):
    """{name of a file: text} of all."""
    commands, version = asked(drover, "--commands"), version_of(drover)
    keys = sorted({f"{section['name']}.{row['name']}" for section in asked(drover, "--json") for row in section["rows"]
                   if not section["name"].startswith("[")})
    files = {f"drover-{command['name']}.1": page_of_command(command, version) for command in commands}
    return {**files, "drover.1": main_page(commands, version), "drover.bash": bash(commands, keys),
            "_drover": zsh(commands, keys), "drover.fish": fish(commands, keys)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True)
    parser.add_argument("--output", required=True, type=Path)
    words = parser.parse_args()
    words.output.mkdir(parents=True, exist_ok=True)
    for name, text in written(words.drover).items():
        (words.output / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
