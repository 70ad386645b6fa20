#!/usr/bin/env python3
"""Damage clips at random and run the program on each: every run must end by itself with an exit code of the
contract for damaged input (0, 2, 3 or 4), in time, within memory, and with whole outputs or none.

    tools/mutate_clips.py PROGRAM FOLDER [FOLDER ...] [--count 500] [--seed 1] [--keep DIR]

PROGRAM is best the one of the asan preset (build/asan/pipelines/vildar): it ends with another code at the first
fault of memory or of arithmetic. A FOLDER is one of data_samples/ or of `vildar render`: a clip and site.yaml. They are
taken in turn; each copy has 1 to 3 kinds of damage. Clips that broke the rule are kept in DIR. Prints one JSON object;
exit code 1 where any run broke the rule.
"""
import argparse
import collections
import json
import pathlib
import random
import resource
import subprocess
import sys
import tempfile

ALLOWED = (0, 2, 3, 4)
LIMIT_S = 300
LIMIT_RSS_KB = 1 << 20
OUTPUTS = {"speeds.csv", "methods.csv", "tracks.csv", "run.json", "report.html"}


def flipped(data: bytearray, draw: random.Random) -> None:
    for _ in range(max(1, int(len(data) * 10 ** draw.uniform(-5, -2)))):
        data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)


def head_flipped(data: bytearray, draw: random.Random) -> None:
    """Container headers stand at the start or at the end."""
    zone = min(4096, len(data))
    start = draw.choice((0, len(data) - zone))
    for _ in range(draw.randint(1, 20)):
        data[start + draw.randrange(zone)] = draw.randrange(256)


def cut(data: bytearray, draw: random.Random) -> None:
    del data[draw.randrange(len(data)):]


def removed(data: bytearray, draw: random.Random) -> None:
    start = draw.randrange(len(data))
    del data[start:start + draw.randint(1, max(1, len(data) // 4))]


def repeated(data: bytearray, draw: random.Random) -> None:
    start = draw.randrange(len(data))
    data[start:start] = data[start:start + draw.randint(1, max(1, len(data) // 8))]


def zeroed(data: bytearray, draw: random.Random) -> None:
    start = draw.randrange(len(data))
    end = min(len(data), start + draw.randint(1, max(1, len(data) // 4)))
    data[start:end] = bytes(end - start)


def extreme(data: bytearray, draw: random.Random) -> None:
    """Sizes, counts and time stamps of containers are 32-bit big-endian words."""
    for _ in range(draw.randint(1, 4)):
        at = draw.randrange(max(1, len(data) - 4))
        data[at:at + 4] = draw.choice((0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)).to_bytes(4, "big")


DAMAGES = (flipped, head_flipped, cut, removed, repeated, zeroed, extreme)


def mutated(clip: bytes, draw: random.Random) -> tuple[bytes, list[str]]:
    data, names = bytearray(clip), []
    for damage in draw.sample(DAMAGES, draw.randint(1, 3)):
        if data:
            damage(data, draw)
            names.append(damage.__name__)
    return bytes(data), names


def fault(ran: subprocess.CompletedProcess, out: pathlib.Path) -> str:
    """What is wrong with a run that has ended, or nothing."""
    if ran.returncode not in ALLOWED:
        return f"exit {ran.returncode}: {ran.stderr[-400:]}"
    if ran.returncode in (2, 3) and not ran.stderr.strip():
        return "no message"
    written = {file.name for file in out.iterdir()} if out.exists() else set()
    if written and written != OUTPUTS:
        return f"outputs: {sorted(written)}"
    if ran.returncode in (0, 4) and not written:
        return "no outputs"
    return ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path, default=pathlib.Path("mutated_clips"))
    options = parser.parse_args()
    clips = [sorted(folder.glob("clip.*"))[0] for folder in options.folders]

    codes, damages, faults = collections.Counter(), collections.Counter(), []
    with tempfile.TemporaryDirectory() as place:
        for number in range(options.count):
            draw = random.Random(options.seed * 1_000_003 + number)
            source = clips[number % len(clips)]
            bad, names = mutated(source.read_bytes(), draw)
            clip, out = pathlib.Path(place) / f"clip{source.suffix}", pathlib.Path(place) / f"out_{number}"
            clip.write_bytes(bad)
            try:
                ran = subprocess.run([options.program, "run", clip, "--site", source.parent / "site.yaml", "--out", out],
                                     capture_output=True, text=True, errors="replace", timeout=LIMIT_S)
                told = fault(ran, out)
                codes[ran.returncode] += 1
            except subprocess.TimeoutExpired:
                told = f"still running after {LIMIT_S} s"
            damages.update(names)
            if told:
                options.keep.mkdir(parents=True, exist_ok=True)
                kept = options.keep / f"{number}{source.suffix}"
                kept.write_bytes(bad)
                faults.append({"clip": str(kept), "of": str(source), "damage": names, "fault": told})
    peak_kb = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print(json.dumps({"runs": options.count, "exit_codes": dict(sorted(codes.items())), "damages": dict(damages),
                      "peak_rss_mb": peak_kb // 1024, "faults": faults}, indent=1))
    return 1 if faults or peak_kb > LIMIT_RSS_KB else 0


if __name__ == "__main__":
    sys.exit(main())
