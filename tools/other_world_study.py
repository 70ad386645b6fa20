#!/usr/bin/python3
"""Do speeds and intervals hold in scenes that the program did not render? Clips, traces and truth of
tools/other_world.py are run and scored:

    tools/other_world_study.py PROGRAM --out FOLDER [--scenes N] [--seed S] [KIND ...]

Scenes that FOLDER holds already are kept. Prints a line per kind, and the speeds outside; ends with 1 where fewer
intervals hold than three binomial sigmas below 95 %. Needs python3-numpy, python3-yaml and ffmpeg.
"""
import argparse
import pathlib
import sys

import coverage_study
import other_world

KINDS = ("mast", "low_mast", "high_mast", "bend_left", "bend_right", "wide", "tele", "rolling", "slow_frames", "wet",
         "mirror", "both_ways", "dashcam", "mast_photodiodes", "photodiodes")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--scenes", type=int, default=4, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--label", default="measured")
    arguments = parser.parse_intermixed_args()
    unknown = set(arguments.kinds) - set(KINDS)
    if unknown:
        parser.error(f"no such kind: {', '.join(sorted(unknown))}")
    hold = True
    for kind in arguments.kinds or KINDS:
        found = []
        for number in range(arguments.scenes):
            folder = arguments.out / f"{kind}_{arguments.seed}" / f"{number:02d}"
            if not (folder / "rendered").exists():
                other_world.render(other_world.scene_of(kind, arguments.seed, number), folder)
                (folder / "rendered").touch()
            found.append(coverage_study.scores_of(arguments.program, folder, arguments.label))
        hold &= coverage_study.tell(kind, found)
    return 0 if hold else 1


if __name__ == "__main__":
    sys.exit(main())
