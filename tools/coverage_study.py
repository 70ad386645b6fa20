#!/usr/bin/env python3
"""Do the 95 % intervals of speed hold, from the light in a picture, or before photodiodes, to the speed? Random scenes are
rendered, run and scored:

    tools/coverage_study.py PROGRAM --out FOLDER [--label NAME] [SET ...]

Scenes that FOLDER holds already are kept, and runs under the same label that are no older than
PROGRAM: a study that was broken off goes on, and another PROGRAM under another label has the same scenes. Sets: a mast and a dashcam on a dry and on a wet road,
both shaken by so many degrees (standard deviation up and down, two thirds of it sideways),
beside street lamps (four before a mast, one every 20 m or so along a dashcam's road) or beside none; a dashcam on bends of 120 to 500 m; and two photodiodes without a camera. Prints a line per set; ends with 1 where fewer intervals
hold than three binomial sigmas below 95 %.
"""
import argparse
import json
import math
import pathlib
import random
import re
import subprocess
import sys

SEED = 31
# Set: family of scenes, how many, shake in degrees, street lamps, wet road.
SETS = {
    "mast_dry": ("three-lanes", 14, 0.0, False, False),
    "mast_wet": ("three-lanes", 14, 0.0, False, True),
    "dash_dry": ("dashcam", 30, 0.0, False, False),
    "dash_wet": ("dashcam", 30, 0.0, False, True),
    "mast_0_lamps": ("three-lanes", 10, 0.0, True, False),
    "mast_0.05_lamps": ("three-lanes", 10, 0.05, True, False),
    "mast_0.15_lamps": ("three-lanes", 10, 0.15, True, False),
    "mast_0.3_lamps": ("three-lanes", 10, 0.3, True, False),
    "mast_0.05_none": ("three-lanes", 10, 0.05, False, False),
    "mast_0.15_none": ("three-lanes", 10, 0.15, False, False),
    "mast_0.3_none": ("three-lanes", 10, 0.3, False, False),
    "dash_0.15": ("dashcam", 20, 0.15, False, False),
    "dash_0.3": ("dashcam", 20, 0.3, False, False),
    "dash_0_lamps": ("dashcam", 20, 0.0, True, False),
    "dash_0.15_lamps": ("dashcam", 20, 0.15, True, False),
    "dash_0.3_lamps": ("dashcam", 20, 0.3, True, False),
    "dash_bend": ("dashcam", 30, 0.0, False, False),
    "dash_bend_0.3_lamps": ("dashcam", 20, 0.3, True, False),
    "photodiodes": ("photodiode", 200, 0.0, False, False),
}


def quietly(*command) -> None:
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def street_lamps(places_m: list) -> str:
    return "street_lamps:\n" + "".join(f"  - {{position_m: [{x:.2f}, {y:.2f}, {z:.2f}], intensity_cd: 900}}\n"
                                       for x, y, z in places_m)


def camera_scenario(text: str, number: int, shake_deg: float, lamps: bool, wet: bool) -> str:
    """A random scene for the camera alone, at 640 x 360 pixels, with what the set adds."""
    text = re.sub(r"^photodiode: .*\n", "", text, flags=re.M)
    text = re.sub(r"  photodiodes:\n(  - .*\n(    .*\n)*)+", "", text)
    for old, new in (("image_size_px: [960, 540]", "image_size_px: [640, 360]"),
                     ("focal_px: [800, 800]", "focal_px: [533.3, 533.3]"),
                     ("principal_px: [479.5, 269.5]", "principal_px: [319.5, 179.5]")):
        text = text.replace(old, new)
    draw = random.Random(100 + number)
    frequency_hz = draw.uniform(1, 4)
    if shake_deg:
        text += (f"shake: {{yaw_std_deg: {shake_deg * 2 / 3}, pitch_std_deg: {shake_deg}, "
                 f"frequency_hz: {frequency_hz}}}\n")
    if lamps and "ego:" in text:
        text += street_lamps([(along_m + draw.uniform(-5, 5), draw.choice((-6.0, 9.0)), draw.uniform(7, 9))
                              for along_m in range(20, 300, 20)])
    elif lamps:
        text += street_lamps([(draw.uniform(50, 100), 6.0 if lamp % 2 else -14.0, draw.uniform(7, 9))
                              for lamp in range(4)])
    return ("wet_road: true\nweather: {rain_mm_per_h: 5}\n" if wet else "") + text


def bent(text: str, number: int, folder: pathlib.Path) -> str:
    """A dashcam's scene on a bend, told to 3 %; every other one with a trace of yaw rates."""
    draw = random.Random(500 + number)
    told_m, turn = draw.uniform(120.0, 500.0), draw.choice(("left", "right"))
    radius_m = told_m * draw.gauss(1.0, 0.03)
    true, told = text.split("told_site:")
    mean = r"speed_mps: (?:\{mean: )?([0-9.]+)"
    speed_mps = float(re.search(r"ego:\n    " + mean, true).group(1))
    trace = folder / "ego.csv"
    if number % 2:
        yaw_rate = speed_mps / radius_m * (1 if turn == "left" else -1)
        trace.write_text("t_s,speed_mps,yaw_rate_rad_per_s\n" +
                         "".join(f"{time},{speed_mps},{yaw_rate}\n" for time in range(-1, 10)))
    bend = 1.0 if turn == "left" else -1.0

    def beside_bend(place) -> str:
        along_m, lateral_m = float(place[1]), float(place[2])
        own_m, angle = radius_m - bend * lateral_m, along_m / radius_m
        return f"[{own_m * math.sin(angle):.2f}, {lateral_m + bend * own_m * (1.0 - math.cos(angle)):.2f}, {place[3]}]"
    told = re.sub(r"\[([0-9.]+), ([-0-9.]+), ([0-9.]+)\](?=, intensity_cd: 900)", beside_bend, told)

    def on_bend(part, radius):
        part = re.sub(r"kind: straight\n    straight_m: 0\n    turn: left\n",
                      f"kind: curved\n    straight_m: 0\n    turn: {turn}\n    radius_m: {radius}\n", part)
        return re.sub(r"ego:\n    .*\n", f"ego: {{trace: {trace.resolve()}, speed_std_mps: 0.15}}\n", part) \
            if number % 2 else part
    return on_bend(true, radius_m) + "told_site:" + on_bend(told, f"{{mean: {told_m}, std: {0.03 * told_m}}}")


def prepare(program: str, out: pathlib.Path, name: str) -> list:
    family, count, *change = SETS[name]
    changed = camera_scenario if family != "photodiode" else lambda text, *_: text
    base = out / f"base_{family}"
    if not base.is_dir():
        most = max(one[1] for one in SETS.values() if one[0] == family)
        quietly(program, "render", "--random", str(most), "--seed", str(SEED), "--preset", family,
                "--scenario-only", "--out", base)
    folders = []
    for number, scenario in enumerate(sorted(base.rglob("*.yaml"))[:count]):
        folder = out / name / f"{number:02d}"
        folders.append(folder)
        if (folder / "rendered").exists():
            continue
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / "scenario.yaml"
        text = changed(scenario.read_text(), number, *change)
        file.write_text(bent(text, number, folder) if "bend" in name else text)
        quietly(program, "render", file, "--out", folder)
        (folder / "rendered").touch()
    return folders


def scores_of(program: str, folder: pathlib.Path, label: str) -> dict:
    scores = folder / f"{label}.json"
    if not scores.exists() or scores.stat().st_mtime < pathlib.Path(program).stat().st_mtime:
        run = folder / label
        clip, power = folder / "clip.mp4", folder / "photodiode.csv"
        quietly(program, "run", *([clip] if clip.exists() else []), *(["--photodiode", power] if power.exists() else []),
                "--site", folder / "site.yaml", "--out", run)
        quietly(program, "evaluate", run, folder, "--out", scores)
    return json.loads(scores.read_text())


def tell(name: str, found: list) -> bool:
    """Prints what became of a set; whether its intervals hold."""
    vehicles = [dict(vehicle, scene=number) for number, scores in enumerate(found)
                for vehicle in scores["vehicles"]]
    measured = [one for one in vehicles if one["outcome"] == "measured" and one["z"]]
    reasons = {}
    for one in vehicles:
        if one["outcome"] not in ("measured", "not_in_view"):
            reason = one["withheld"] or one["outcome"]
            reasons[reason] = reasons.get(reason, 0) + 1
    for one in measured:
        if not one["inside_95"]:
            print(f"    scene {one['scene']:02d} {one['vehicle_id']}: {one['error_percent']:+.2f} % off, "
                  f"{one['z']:+.2f} sigmas")
    if not measured:
        print(f"{name}: nothing measured; {reasons}")
        return False
    count = len(measured)
    def root_mean_square(values):
        return math.sqrt(sum(value * value for value in values) / count)
    inside = sum(one["inside_95"] for one in measured) / count
    rmse = root_mean_square([one["error_percent"] for one in measured])
    sigma = root_mean_square([one["error_percent"] / one["z"] for one in measured])
    z = root_mean_square([one["z"] for one in measured])
    print(f"{name}: {count} measured, {100 * inside:.1f} % inside, RMSE {rmse:.2f} %, sigma {sigma:.2f} %, "
          f"z {z:.2f}; {reasons}", flush=True)
    return inside >= 0.95 - 3.0 * math.sqrt(0.95 * 0.05 / count)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("sets", nargs="*", metavar="SET", help=", ".join(SETS))
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--label", default="measured")
    arguments = parser.parse_intermixed_args()
    unknown = set(arguments.sets) - set(SETS)
    if unknown:
        parser.error(f"no such set: {', '.join(sorted(unknown))}")
    hold = True
    for name in arguments.sets or SETS:
        folders = prepare(arguments.program, arguments.out, name)
        hold &= tell(name, [scores_of(arguments.program, folder, arguments.label) for folder in folders])
    return 0 if hold else 1


if __name__ == "__main__":
    sys.exit(main())
