#!/usr/bin/env python3
"""Render the samples of data_samples/ anew, bring the checksums of their manifests up to date, and
write the scores that are expected of them (expected_scores.json: a run, then `vildar evaluate --json`).

    tools/render_samples.py build/release/pipelines/vildar [--scores] [SAMPLE ...]

Clips depend on the version of the codec libraries; everything else must come out the same.
--scores renders nothing: only the expected scores are written.
"""
import hashlib
import pathlib
import subprocess
import sys
import tempfile

SAMPLES = pathlib.Path(__file__).resolve().parent.parent / "data_samples"
SCORES = "expected_scores.json"


def quietly(*command) -> None:
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def render(program: str, folder: pathlib.Path) -> None:
    quietly(program, "render", folder / "scenario.yaml", "--out", folder)
    manifest = folder / "manifest.yaml"
    text = manifest.read_text().split("sha256:\n")[0] + "sha256:\n"
    for file in sorted(folder.iterdir()):
        if file not in (manifest, folder / SCORES):
            text += f"  {file.name}: {hashlib.sha256(file.read_bytes()).hexdigest()}\n"
    manifest.write_text(text)


def score(program: str, folder: pathlib.Path) -> None:
    clip, trace = folder / "clip.mp4", folder / "photodiode.csv"
    inputs = [clip] if clip.exists() else []
    inputs += ["--photodiode", trace] if trace.exists() else []
    with tempfile.TemporaryDirectory() as out:
        quietly(program, "run", *inputs, "--site", folder / "site.yaml", "--out", out)
        quietly(program, "evaluate", out, folder, "--out", folder / SCORES)


def main() -> int:
    words = [word for word in sys.argv[1:] if word != "--scores"]
    if not words or words[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    program, names = words[0], words[1:]
    known = {scenario.parent.name for scenario in SAMPLES.glob("*/scenario.yaml")}
    if not known.issuperset(names):
        print(f"no such sample: {', '.join(set(names) - known)}; there are {', '.join(sorted(known))}", file=sys.stderr)
        return 2
    for scenario in sorted(SAMPLES.glob("*/scenario.yaml")):
        folder = scenario.parent
        if names and folder.name not in names:
            continue
        if "--scores" not in sys.argv:
            render(program, folder)
        score(program, folder)
        total = sum(file.stat().st_size for file in folder.iterdir())
        print(f"{folder.name}: {total} bytes")
        if total >= 1_000_000:
            print(f"{folder.name} is over 1 MB; lower its bit rate or duration", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
