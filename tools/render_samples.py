#!/usr/bin/env python3
"""Render the samples of data_samples/ anew and bring the checksums of their manifests up to date.

    tools/render_samples.py build/release/pipelines/vildar [SAMPLE ...]

Clips depend on the version of the codec libraries; everything else must come out the same.
"""
import hashlib
import pathlib
import subprocess
import sys

SAMPLES = pathlib.Path(__file__).resolve().parent.parent / "data_samples"


def main() -> int:
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    program, names = sys.argv[1], sys.argv[2:]
    for scenario in sorted(SAMPLES.glob("*/scenario.yaml")):
        folder = scenario.parent
        if names and folder.name not in names:
            continue
        subprocess.run([program, "render", scenario, "--out", folder], check=True,
                       stdout=subprocess.DEVNULL)
        manifest = folder / "manifest.yaml"
        text = manifest.read_text().split("sha256:\n")[0] + "sha256:\n"
        for file in sorted(folder.iterdir()):
            if file != manifest:
                text += f"  {file.name}: {hashlib.sha256(file.read_bytes()).hexdigest()}\n"
        manifest.write_text(text)
        total = sum(file.stat().st_size for file in folder.iterdir())
        print(f"{folder.name}: {total} bytes")
        if total >= 1_000_000:
            print(f"{folder.name} is over 1 MB; lower its bit rate or duration", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
