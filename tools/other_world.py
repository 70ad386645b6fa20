"""Night scenes by a renderer that shares no code, model or library with the program: a pinhole camera,
lamps as soft discs with wings of light about them, roads straight or curved, dry or wet, photodiodes under a
power law. Written from the documents alone (docs/site.md, docs/outputs.md), so that a sign, a frame or a unit
that the program's own renderer and its estimators have wrong together comes to light.

Lengths in m, times in s, angles in degrees in a scene's `camera` and in rad elsewhere, light in units of a
white pixel. Needs python3-numpy, python3-yaml and ffmpeg.
"""
import csv
import dataclasses
import math
import pathlib
import subprocess

import numpy
import yaml

LAMP_HEIGHT_M = (0.68, 0.08)  # mean, standard deviation, here and below
LAMP_SEPARATION_M = (1.25, 0.12)
NEAREST_M = 3.0  # of a vehicle that is rendered
LAMP_LIGHT = 16000.0  # of a headlamp 1 m off at 800 px of focal length, in white pixels
TAIL_LAMP_LIGHT = 2500.0


@dataclasses.dataclass
class Vehicle:
    name: str
    lane: tuple  # id, lateral_m, direction
    speed_mps: float
    acceleration_mps2: float
    along_at_zero_m: float
    lateral_m: float
    height_m: float
    separation_m: float
    light: float

    def sign(self):
        return 1.0 if self.lane[2] == "receding" else -1.0

    def along_m(self, t_s):
        return self.along_at_zero_m + self.sign() * (self.speed_mps * t_s + 0.5 * self.acceleration_mps2 * t_s**2)


@dataclasses.dataclass
class Scene:
    random: numpy.random.Generator
    size_px: tuple = (960, 540)
    focal_px: float = 800.0
    radial: float = 0.0  # k1
    rate_hz: float = 30.0
    duration_s: float = 5.0
    readout_s: float = 0.0  # first row to last
    height_m: float = 5.0
    yaw_deg: float = 0.0
    pitch_deg: float = -4.0
    roll_deg: float = 0.0
    exposure: float = 1.0
    noise: float = 0.002  # standard deviation of a dark pixel, of white
    quality: int = 21  # of x264
    reflects: float = 0.0  # share of a lamp's light that the road throws to the camera
    drawn_out: bool = False  # a rough wet road; else a mirror
    bend: str = ""  # "", "left" or "right"
    straight_m: float = 0.0
    radius_m: float = 1e9
    ego_mps: float = 0.0
    lanes: tuple = (("near", -2.5, "oncoming"), ("middle", -6.0, "oncoming"), ("far", 2.0, "receding"))
    camera: bool = True
    photodiodes: int = 0
    vehicles: list = dataclasses.field(default_factory=list)

    def road_point(self, along_m, lateral_m):
        """The point x, y, 0 so far up the lane, and the unit vector up the lane there."""
        if not self.bend or along_m <= self.straight_m:
            return numpy.array([along_m, lateral_m, 0.0]), numpy.array([1.0, 0.0, 0.0])
        side = 1.0 if self.bend == "left" else -1.0
        lane_radius_m = self.radius_m - side * lateral_m
        arc = (along_m - self.straight_m) / lane_radius_m
        place = [self.straight_m + lane_radius_m * math.sin(arc),
                 side * (self.radius_m - lane_radius_m * math.cos(arc)), 0.0]
        return numpy.array(place), numpy.array([math.cos(arc), side * math.sin(arc), 0.0])

    def rotation(self):
        """Rows: the image's right, its down, and forward, in the road frame."""
        yaw, pitch, roll = (math.radians(angle) for angle in (self.yaw_deg, self.pitch_deg, self.roll_deg))
        forward = numpy.array([math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), math.sin(pitch)])
        level_right = numpy.array([math.sin(yaw), -math.cos(yaw), 0.0])
        level_down = numpy.cross(forward, level_right)
        right = math.cos(roll) * level_right + math.sin(roll) * level_down
        return numpy.array([right, numpy.cross(forward, right), forward])

    def pixel(self, point_m):
        """u, v and the distance of a point; None behind the camera."""
        ray = self.rotation() @ (point_m - numpy.array([0.0, 0.0, self.height_m]))
        if ray[2] < 0.5:
            return None
        x, y = ray[0] / ray[2], ray[1] / ray[2]
        stretch = 1.0 + self.radial * (x * x + y * y)
        width, height = self.size_px
        return ((width - 1) / 2 + self.focal_px * x * stretch, (height - 1) / 2 + self.focal_px * y * stretch,
                float(numpy.linalg.norm(ray)))

    def place(self, vehicle, t_s):
        """The middle of the vehicle's lamps on the ground and the unit vector up the lane."""
        return self.road_point(vehicle.along_m(t_s) - self.ego_mps * t_s, vehicle.lateral_m)

    def lamp(self, vehicle, side, t_s):
        """A lamp in the picture of t_s (side: 1 to the left of a view up the road, -1) at its own row's time."""
        row_s = t_s
        for _ in range(3 if self.readout_s else 1):
            middle_m, up = self.place(vehicle, row_s)
            left = numpy.array([-up[1], up[0], 0.0])
            point_m = middle_m + side * vehicle.separation_m / 2 * left + numpy.array([0, 0, vehicle.height_m])
            seen = self.pixel(point_m)
            if seen is None:
                return None, point_m
            row_s = t_s + ((seen[1] + 0.5) / self.size_px[1] - 0.5) * self.readout_s
        return seen, point_m


def normal(random, mean_and_std):
    return random.normal(*mean_and_std)


def fill(scene, count, oncoming_only=True):
    """Up to `count` vehicles that keep 12 m apart in their lanes."""
    random = scene.random
    lanes = [lane for lane in scene.lanes if lane[2] == "oncoming" or not oncoming_only]
    for number in range(count):
        lane = lanes[random.integers(len(lanes))]
        speed_mps, acceleration_mps2 = random.uniform(8, 33), random.normal(0, 0.7)
        if speed_mps + acceleration_mps2 * scene.duration_s < 4:
            acceleration_mps2 = 0.0
        leaves_s = random.uniform(2.5, scene.duration_s + 1)
        start_m = random.uniform(5, 20) if lane[2] == "receding" else (
            15 + (speed_mps + scene.ego_mps) * leaves_s + 0.5 * acceleration_mps2 * leaves_s**2)
        vehicle = Vehicle(f"v{number + 1}", lane, speed_mps, acceleration_mps2, start_m,
                          lane[1] + random.normal(0, 0.25), max(0.4, normal(random, LAMP_HEIGHT_M)),
                          max(0.8, normal(random, LAMP_SEPARATION_M)), random.uniform(0.6, 1.6))
        if all(other.lane != lane or abs(other.along_m(t_s) - vehicle.along_m(t_s)) > 12
               for other in scene.vehicles for t_s in numpy.linspace(0, scene.duration_s, 30)):
            scene.vehicles.append(vehicle)
    return scene


def scene_of(kind, seed, number):
    random = numpy.random.default_rng([seed, number, *kind.encode()])
    told = {
        "mast": {}, "low_mast": dict(height_m=1.5, pitch_deg=0.0), "high_mast": dict(height_m=8.0, pitch_deg=-9.0),
        "bend_left": dict(bend="left"), "bend_right": dict(bend="right"),
        "wide": dict(focal_px=420.0, radial=-0.1), "tele": dict(focal_px=2000.0, pitch_deg=-2.5),
        "rolling": dict(rate_hz=60.0, readout_s=0.012), "slow_frames": dict(rate_hz=12.0),
        "wet": dict(reflects=0.5, drawn_out=True), "mirror": dict(reflects=0.15), "both_ways": {},
        "dashcam": dict(height_m=1.25, pitch_deg=0.0, lanes=(("own", 0.0, "receding"), ("opposite", 3.5, "oncoming"))),
        "mast_photodiodes": dict(photodiodes=2), "photodiodes": dict(photodiodes=2, camera=False, duration_s=8.0),
    }
    scene = Scene(random, **told[kind])
    scene.yaw_deg += random.normal(0, 2)
    scene.pitch_deg += random.normal(0, 0.5)
    scene.roll_deg += random.normal(0, 0.5)
    scene.exposure = math.exp(random.uniform(math.log(0.2), math.log(5)))
    if scene.bend:
        scene.straight_m, scene.radius_m = random.uniform(0, 30), random.uniform(80, 300)
    if kind == "dashcam":
        scene.ego_mps = random.uniform(8, 25)
    if scene.photodiodes:
        scene.lanes = scene.lanes[:1] + scene.lanes[2:]
    return fill(scene, {"both_ways": 5}.get(kind, 1 if scene.bend or scene.photodiodes else 2), kind != "both_ways")


def add_lamp(image, at_px, light, radius_px, colour):
    """A disc with a soft rim, and a share of 7 % in wings of light that fall with the cube of the distance."""
    u, v = at_px
    reach = int(min(150, max(14, 8 * radius_px) * max(1.0, 0.02 * light) ** 0.4))
    height, width = image.shape[:2]
    x0, x1 = max(0, int(u) - reach), min(width, int(u) + reach + 2)
    y0, y1 = max(0, int(v) - reach), min(height, int(v) + reach + 2)
    if x0 >= x1 or y0 >= y1:
        return
    off_px = numpy.hypot(numpy.arange(x0, x1) - u, (numpy.arange(y0, y1) - v)[:, None])
    wings = 1 / (1 + (off_px / 2) ** 2) ** 1.5 / (8 * math.pi)
    small = radius_px < 0.7
    width_px = math.hypot(0.8, radius_px / 2)
    disc = (numpy.exp(-0.5 * (off_px / width_px) ** 2) if small
            else 1 / (1 + numpy.exp(numpy.clip(2.1 * (off_px - radius_px), -50, 50))))
    rings_px = numpy.arange(0.005, 6 + 8 * radius_px, 0.01)  # the whole disc, also where the image cuts it
    ring = numpy.exp(-0.5 * (rings_px / width_px) ** 2) if small else 1 / (1 + numpy.exp(
        numpy.clip(2.1 * (rings_px - radius_px), -50, 50)))
    disc /= 2 * math.pi * 0.01 * (ring * rings_px).sum()
    image[y0:y1, x0:x1] += (light * (0.93 * disc + 0.07 * wings))[..., None] * colour


def add_streak(image, at_px, drop_px, light, width_px, shape, colour):
    """The lamp's image on a rough wet road: drawn out up to the lamp and down toward the camera."""
    u, v = at_px
    height, width = image.shape[:2]
    x0, x1 = max(0, int(u - 6 * width_px)), min(width, int(u + 6 * width_px) + 2)
    y0, y1 = max(0, int(v - 0.8 * drop_px)), min(height, int(v + 1.4 * drop_px) + 2)
    if x0 >= x1 or y0 >= y1:
        return
    along = numpy.interp((numpy.arange(y0, y1) - v) / max(drop_px, 1), numpy.linspace(-0.55, 1.1, shape.size), shape,
                         left=0, right=0)
    across = numpy.exp(-0.5 * ((numpy.arange(x0, x1) - u) / width_px) ** 2) / (width_px * math.sqrt(2 * math.pi))
    image[y0:y1, x0:x1] += (light * along[:, None] / max(along.sum(), 1e-9) * across)[..., None] * colour


def draw_vehicle(scene, image, vehicle, t_s, streak):
    """Adds its lamps; their pixels, left one first, None where out of the image."""
    pixels = []
    oncoming = vehicle.lane[2] == "oncoming"
    colour = numpy.array((1.0, 0.97, 0.9) if oncoming else (1.0, 0.1, 0.05))
    lamp_light = vehicle.light * scene.exposure * (LAMP_LIGHT if oncoming else TAIL_LAMP_LIGHT)
    for side in (1, -1):
        seen, point_m = scene.lamp(vehicle, side, t_s)
        if seen is None or point_m[0] < NEAREST_M:
            pixels.append(None)
            continue
        u, v, distance_m = seen
        per_metre_px = scene.focal_px / distance_m
        aside = math.atan2(abs(point_m[1]), point_m[0])
        light = lamp_light * (0.1 + 0.9 * math.exp(-(aside / 0.5) ** 2)) / distance_m**2 * (scene.focal_px / 800) ** 2
        add_lamp(image, (u, v), light, 0.07 * per_metre_px, colour)
        mirrored = scene.pixel(point_m * numpy.array([1, 1, -1])) if scene.reflects else None
        if mirrored and scene.drawn_out:
            add_streak(image, mirrored[:2], mirrored[1] - v, light * scene.reflects, max(1, 0.1 * per_metre_px), streak,
                       colour)
        elif mirrored:
            add_lamp(image, mirrored[:2], light * scene.reflects, 0.08 * per_metre_px, colour)
        inside = -0.5 < u < scene.size_px[0] - 0.5 and -0.5 < v < scene.size_px[1] - 0.5
        pixels.append((u, v) if inside else None)
    return pixels


def srgb(light):
    return numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * numpy.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


def night(scene):
    """Dark sky, a road a little brighter toward the camera, each pixel of its own texture."""
    width, height = scene.size_px
    u, v = numpy.meshgrid(numpy.arange(width), numpy.arange(height))
    rays = numpy.stack([(u - (width - 1) / 2) / scene.focal_px, (v - (height - 1) / 2) / scene.focal_px,
                        numpy.ones((height, width))], -1) @ scene.rotation()
    light = numpy.where(rays[..., 2] < -0.01, 0.004 + 0.004 * numpy.exp(8 * rays[..., 2]), 0.0015)
    return light * (1 + 0.15 * scene.random.standard_normal(light.shape))


def film(scene, file):
    """Writes the clip; a row of truth per vehicle and frame."""
    width, height = scene.size_px
    encoder = subprocess.Popen(
        ["ffmpeg", "-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r",
         str(scene.rate_hz), "-i", "-", "-c:v", "libx264", "-preset", "fast", "-crf", str(scene.quality), "-pix_fmt",
         "yuv420p", "-threads", "1", file], stdin=subprocess.PIPE)
    dark = numpy.repeat(night(scene)[..., None], 3, 2)
    pieces = numpy.linspace(-0.55, 1.1, 41)
    streak = numpy.exp(-0.5 * (pieces / numpy.where(pieces < 0, 0.28, 0.5)) ** 2
                       + 0.3 * scene.random.standard_normal(pieces.size))
    rows = []
    for frame in range(int(scene.duration_s * scene.rate_hz)):
        t_s = frame / scene.rate_hz
        image = dark.copy()
        for vehicle in scene.vehicles:
            pixels = draw_vehicle(scene, image, vehicle, t_s, streak)
            rows.append(truth_row(scene, vehicle, frame, t_s, pixels))
        image += scene.random.standard_normal(image.shape, dtype=numpy.float32) * (
            scene.noise * numpy.sqrt(0.3 + numpy.clip(image, 0, 1)))
        encoder.stdin.write(numpy.rint(255 * srgb(numpy.clip(image, 0, 1))).astype(numpy.uint8).tobytes())
    encoder.stdin.close()
    if encoder.wait():
        raise RuntimeError(f"ffmpeg could not write {file}")
    return rows


def truth_row(scene, vehicle, frame, t_s, pixels):
    middle_m, _ = scene.place(vehicle, t_s)
    cells = [cell for pixel in pixels for cell in (("", "") if pixel is None else pixel)]
    speed_mps = vehicle.speed_mps + vehicle.acceleration_mps2 * t_s
    return [frame, t_s, vehicle.name, *cells, middle_m[0], middle_m[1], middle_m[0], speed_mps, 0]


PHOTODIODE = dict(gain_db=-45.0, exponent=2.0, apart_m=2.0, half_view_deg=40.0, ambient_w=2e-8, noise_w=2e-11)


def photodiode_position_m(scene, index):
    return numpy.array([PHOTODIODE["apart_m"] * index, 0.0, scene.height_m])


def listen(scene, file):
    """Power at 2 kHz: what each vehicle's place at lamp height sends under the law, times a beam that narrows
    light aside, ambient light and noise."""
    t_s = numpy.arange(0, scene.duration_s, 1 / 2000)
    columns = [t_s]
    for index in range(scene.photodiodes):
        position_m = photodiode_position_m(scene, index)
        power_w = numpy.full(t_s.size, PHOTODIODE["ambient_w"])
        for vehicle in scene.vehicles:
            if vehicle.lane[2] != "oncoming":
                continue
            lamp_m = numpy.stack([vehicle.along_m(t_s), numpy.full(t_s.size, vehicle.lateral_m),
                                  numpy.full(t_s.size, vehicle.height_m)], -1)
            off_m = lamp_m - position_m
            distance_m = numpy.linalg.norm(off_m, axis=1)
            from_axis = numpy.arccos(numpy.clip(off_m[:, 0] / distance_m, -1, 1))
            beam = numpy.exp(-0.5 * (from_axis / 0.9) ** 2)
            sees = from_axis < math.radians(PHOTODIODE["half_view_deg"])
            power_w += numpy.where(sees, vehicle.light * 10 ** (PHOTODIODE["gain_db"] / 10) * beam
                                   * distance_m ** -PHOTODIODE["exponent"], 0)
        columns.append(power_w + scene.random.normal(0, PHOTODIODE["noise_w"], t_s.size))
    header = ",".join(["t_s"] + [f"pd{index}_power_w" for index in range(scene.photodiodes)])
    numpy.savetxt(file, numpy.stack(columns, -1), delimiter=",", header=header, comments="", fmt="%.7g")


def site_of(scene):
    width, height = scene.size_px
    site = {"version": 1}
    if scene.camera:
        site["camera"] = {
            "image_size_px": [width, height], "focal_px": [scene.focal_px] * 2,
            "principal_px": [(width - 1) / 2, (height - 1) / 2], "position_m": [0.0, 0.0, scene.height_m],
            "yaw_deg": float(scene.yaw_deg), "pitch_deg": float(scene.pitch_deg), "roll_deg": float(scene.roll_deg),
            "exposure_s": 0.002, "rolling_shutter_s": scene.readout_s, "response": {"kind": "srgb"}}
        if scene.radial:
            site["camera"]["distortion"] = {"model": "brown", "coefficients": [scene.radial, 0, 0, 0, 0]}
    if scene.photodiodes:
        site["photodiodes"] = [
            {"id": f"pd{index}", "position_m": [float(m) for m in photodiode_position_m(scene, index)], "yaw_deg": 0.0,
             "pitch_deg": 0.0, "half_field_of_view_deg": PHOTODIODE["half_view_deg"], "area_m2": 1e-4,
             **({"gain_ratio": {"mean": 1.0, "std": 0.002}} if index else {}), "time_offset_s": 0.0}
            for index in range(scene.photodiodes)]
        site["channel"] = {"path_loss_exponent": {"mean": PHOTODIODE["exponent"], "std": 0.05}}
    lanes = [dict(id=name, lateral_m=lateral_m, width_m=3.5, direction=way) for name, lateral_m, way in scene.lanes]
    site["road"] = {"kind": "curved" if scene.bend else "straight", "lanes": lanes}
    if scene.bend:
        site["road"].update(straight_m=float(scene.straight_m), radius_m=float(scene.radius_m), turn=scene.bend)
    site["lamps"] = {"height_m": dict(zip(("mean", "std"), LAMP_HEIGHT_M)),
                     "separation_m": dict(zip(("mean", "std"), LAMP_SEPARATION_M))}
    if scene.ego_mps:
        site["ego"] = {"speed_mps": float(scene.ego_mps)}
    return site


def write_table(file, header, rows):
    with open(file, "w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header.split(","))
        writer.writerows([f"{cell:.6f}" if isinstance(cell, float) else cell for cell in row] for row in rows)


def render(scene, folder: pathlib.Path):
    """Writes clip.mp4, photodiode.csv (as the scene has them), site.yaml and the truth as docs/evaluation.md
    wants it."""
    folder.mkdir(parents=True, exist_ok=True)
    if scene.camera:
        rows = film(scene, folder / "clip.mp4")
    else:
        rows = [truth_row(scene, vehicle, frame, frame / 100, (None, None))
                for frame in range(int(scene.duration_s * 100)) for vehicle in scene.vehicles]
    if scene.photodiodes:
        listen(scene, folder / "photodiode.csv")
    rows = [row for row in rows if row[7] > NEAREST_M]
    write_table(folder / "truth_tracks.csv", "frame,t_s,vehicle_id,u_left_px,v_left_px,u_right_px,v_right_px,x_m,y_m,"
                "range_m,speed_mps,occluded", sorted(rows, key=lambda row: (row[2], row[0])))
    t_s = scene.duration_s / 2
    vehicles = []
    for vehicle in scene.vehicles:
        middle_m, _ = scene.place(vehicle, t_s)
        vehicles.append([vehicle.name, vehicle.lane[2], vehicle.lane[0], t_s,
                         vehicle.speed_mps + vehicle.acceleration_mps2 * t_s, middle_m[0], middle_m[1],
                         vehicle.acceleration_mps2])
    write_table(folder / "truth_vehicles.csv", "vehicle_id,direction,lane,t_ref_s,speed_mps,range_ref_m,lateral_m,"
                "acceleration_mps2", vehicles)
    (folder / "site.yaml").write_text(yaml.safe_dump(site_of(scene), sort_keys=False))
