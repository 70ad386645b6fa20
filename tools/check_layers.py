#!/usr/bin/env python3
"""Checks the include rule of the house: data moves one way and a stage never knows another stage.

    tools/check_layers.py [ROOT]

A room of src/ may include itself and the rooms that ALLOWED names for it; calib/ what stands there;
pipelines/, tools/ and tests/ may include anything. `int main` may stand only in pipelines/, tools/
and tests/. Prints every violation as file:line and exits 1 if there is one.
"""

import pathlib
import re
import sys

NOUNS = {"core", "types", "config", "optics"}
ALLOWED = {
    "core": set(),
    "types": {"core"},
    "config": {"core", "types", "optics"},
    "optics": {"core", "types"},
    "calib": NOUNS | {"detect", "estimate"},
    "simulate": NOUNS | {"estimate"},
}
FREE = {"pipelines", "tools", "tests"}
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]')
MAIN = re.compile(r"^\s*int\s+main\s*\(")


def room_of(path: pathlib.Path, root: pathlib.Path) -> str:
    parts = path.relative_to(root).parts
    return parts[1] if parts[0] == "src" else parts[0]


def violations(root: pathlib.Path):
    rooms = {folder.name for folder in (root / "src").iterdir() if folder.is_dir()}
    for top in ("src", "calib"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            room = room_of(path, root)
            allowed = ALLOWED.get(room, NOUNS) | {room}
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                place = f"{path.relative_to(root)}:{number}"
                if MAIN.match(line):
                    yield f"{place}: main() stands outside pipelines/"
                found = INCLUDE.match(line)
                if not found:
                    continue
                other = found.group(1).split("/")[0]
                if other in FREE or other == "calib" and room != "calib":
                    yield f"{place}: {room} includes {other}/"
                elif other in rooms and other not in allowed:
                    yield f"{place}: {room} includes {other}; it may include {', '.join(sorted(allowed))}"
                elif '"' in line and "/" not in found.group(1):
                    yield f"{place}: include \"{found.group(1)}\" must name its room"


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    found = list(violations(root.resolve()))
    for violation in found:
        print(violation, file=sys.stderr)
    print(f"layers: {len(found)} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
