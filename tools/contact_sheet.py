#!/usr/bin/env python3
"""Put frames of each sample beside real night frames, to be looked at.

    VILDAR_SHARED=../shared tools/contact_sheet.py OUT.png [CLIP ...]

Without clips: those of data_samples/. Left of each row two frames of a sample, right two of a recording in
$VILDAR_SHARED/data. Needs the ffmpeg program.
"""
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
REAL = pathlib.Path(os.environ.get("VILDAR_SHARED", ROOT.parent / "shared")) / "data"
QUEUE, JUNCTION = "clips/dashcam_oncoming_queue.mp4", "clips/junction_high_viewpoint.mp4"
MOTORWAY, CURVE = "clips/dashcam_motorway_taillamps.mp4", "frames/rural_curve_oncoming_pair.png"
BESIDE = {"curve": CURVE, "dashcam": QUEUE, "wet_night": MOTORWAY}  # the others: the junction
TILE = "format=rgb24,scale=640:360:force_original_aspect_ratio=decrease,pad=640:360:(ow-iw)/2:(oh-ih)/2,setsar=1"


def length_s(file: pathlib.Path) -> float:
    found = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "format=duration", "-of", "csv=p=0",
                            file], check=True, capture_output=True, text=True).stdout.strip()
    return 0.0 if found in ("", "N/A") else float(found)


def main() -> int:
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    if not shutil.which("ffmpeg"):
        print("the ffmpeg program is not installed; on Debian: apt-get install ffmpeg", file=sys.stderr)
        return 3
    clips = [pathlib.Path(word) for word in sys.argv[2:]] or sorted(ROOT.glob("data_samples/*/clip.mp4"))
    tiles = []
    for clip in clips:
        beside = REAL / BESIDE.get(clip.resolve().parent.name, JUNCTION)
        if not beside.exists():
            print(f"{beside} is not there; set VILDAR_SHARED to the folder of the reference data",
                  file=sys.stderr)
            return 3
        tiles += [(file, share) for file in (clip, beside) for share in (0.35, 0.7)]
    command, graph = ["ffmpeg", "-v", "error", "-y"], ""
    for i, (file, share) in enumerate(tiles):
        command += ["-ss", f"{share * length_s(file):.2f}", "-i", str(file)]
        graph += f"[{i}:v]trim=end_frame=1,{TILE}[t{i}];"
    places = "|".join(f"{640 * (i % 4)}_{360 * (i // 4)}" for i in range(len(tiles)))
    graph += "".join(f"[t{i}]" for i in range(len(tiles))) + f"xstack=inputs={len(tiles)}:layout={places}"
    subprocess.run(command + ["-filter_complex", graph, "-frames:v", "1", sys.argv[1]], check=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
