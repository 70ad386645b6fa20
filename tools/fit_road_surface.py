#!/usr/bin/env python3
"""Fits the road surfaces of src/optics/road_surface.cpp to road reflection tables.

    tools/fit_road_surface.py FOLDER [TABLE...]

FOLDER holds r1.csv ... c2w4.csv: a header line `tan_gamma,<beta in degrees>...`, then one row per
tan(gamma) with r * 1e4 in 1/sr; `#` starts a comment; 0 means not measured. The observer looks down
by 1 degree. Prints one line per table: the parameters, the rms relative error weighted by r, and S1
and Q0 of the fit and of the table. Plain Python; a second or two per table.

The model: a diffuse albedo plus two lobes of Fresnel facets (GGX on dry roads, Beckmann under water)
with height-correlated Smith masking. Levenberg-Marquardt from several starts on the residuals
(model - r) / sqrt(r), with S1, Q0 and the conservation of energy as further residuals of high weight.
"""

import bisect
import math
import random
import sys

OBSERVER = math.radians(1.0)
DRY = ("ggx", 1.5)
WET = ("beckmann", 1.33)
TABLES = {"r1": DRY, "r2": DRY, "r3": DRY, "r4": DRY, "c2w3": WET, "c2w4": WET}
SCALAR_WEIGHT = 10.0  # of a relative error in S1 or Q0, beside an rms error
MOST_SENT_OUT = 0.98  # of the light that comes in: albedo and shares together
LEAST_ROUGHNESS, MOST_ROUGHNESS = 0.02, 1.0
STARTS = 6


def load(path):
    with open(path, encoding="utf-8") as file:
        rows = [line.split(",") for line in file if line.strip() and not line.startswith("#")]
    betas_deg = [float(cell) for cell in rows[0][1:]]
    tangents = [float(row[0]) for row in rows[1:]]
    table = [[float(cell) * 1e-4 for cell in row[1:]] for row in rows[1:]]
    return tangents, betas_deg, table


def fresnel(cosine, index):
    inside = math.sqrt(1 - (1 - cosine * cosine) / (index * index))
    across = (cosine - index * inside) / (cosine + index * inside)
    along = (index * cosine - inside) / (index * cosine + inside)
    return 0.5 * (across * across + along * along)


def smith_lambda(law, cosine, roughness):
    tangent = math.sqrt(max(0.0, 1 - cosine * cosine)) / cosine
    if law == "ggx":
        return 0.5 * (math.sqrt(1 + (roughness * tangent) ** 2) - 1)
    if tangent * roughness < 0.05:
        return 0.0
    a = 1 / (roughness * tangent)
    return 0.5 * (math.erf(a) - 1) + math.exp(-a * a) / (2 * a * math.sqrt(math.pi))


def facet_density(law, squared_cosine, roughness):
    squared_tangent = (1 - squared_cosine) / squared_cosine / roughness**2
    fall = (1 + squared_tangent) ** -2 if law == "ggx" else math.exp(-squared_tangent)
    return fall / (math.pi * (roughness * squared_cosine) ** 2)


def geometry(tangent, beta_deg, index):
    """cos(gamma), squared cosine of the facet's tilt, and its Fresnel reflectance."""
    cos_in = 1 / math.hypot(1.0, tangent)
    beta = math.radians(beta_deg)
    half = (tangent * cos_in * math.cos(beta) - math.cos(OBSERVER),
            tangent * cos_in * math.sin(beta), cos_in + math.sin(OBSERVER))
    length = math.sqrt(sum(part * part for part in half))
    return cos_in, (half[2] / length) ** 2, fresnel(0.5 * length, index)


def model_r(parameters, place, law):
    cos_in, squared_cosine, reflectance = place
    cos_out = math.sin(OBSERVER)
    brdf = parameters[0] / math.pi
    for share, roughness in (parameters[1:3], parameters[3:5]):
        shadow = 1 + smith_lambda(law, cos_in, roughness) + smith_lambda(law, cos_out, roughness)
        brdf += (share * reflectance * facet_density(law, squared_cosine, roughness)
                 / (4 * cos_in * cos_out * shadow))
    return brdf * cos_in**3


def average_weights(tangents, betas_deg, step=0.1):
    """Weight of each node in Q0 = (sum of r over the plane) / (solid angle): the area from 4 heights
    before to 12 beyond the point under the lamp and 3 to either side, r bilinear between nodes."""
    weights, solid_angle = {}, 0.0
    for i in range(round(16 / step)):
        for j in range(round(3 / step)):
            x, y = -4 + step * (i + 0.5), step * (j + 0.5)
            tangent, beta = math.hypot(x, y), math.degrees(math.atan2(y, x))
            a = min(len(tangents) - 2, max(0, bisect.bisect(tangents, tangent) - 1))
            b = min(len(betas_deg) - 2, max(0, bisect.bisect(betas_deg, beta) - 1))
            u = (tangent - tangents[a]) / (tangents[a + 1] - tangents[a])
            v = (beta - betas_deg[b]) / (betas_deg[b + 1] - betas_deg[b])
            for node, weight in (((a, b), (1 - u) * (1 - v)), ((a + 1, b), u * (1 - v)),
                                 ((a, b + 1), (1 - u) * v), ((a + 1, b + 1), u * v)):
                weights[node] = weights.get(node, 0.0) + weight
            solid_angle += (1 + tangent * tangent) ** -1.5
    return {node: weight / solid_angle for node, weight in weights.items()}


def solve(matrix, right):
    """Gauss elimination with pivots."""
    size = len(right)
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    for c in range(size):
        pivot = max(range(c, size), key=lambda r: abs(rows[r][c]))
        rows[c], rows[pivot] = rows[pivot], rows[c]
        for r in range(size):
            if r != c:
                factor = rows[r][c] / rows[c][c]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[c])]
    return [rows[k][size] / rows[k][k] for k in range(size)]


def minimise(residuals, start, low, high):
    """Levenberg-Marquardt within bounds; returns cost and place."""
    x, damping = start, 1e-2
    values = residuals(x)
    cost = sum(v * v for v in values)
    for _ in range(80):
        columns = []
        for k in range(len(x)):
            moved = x[:k] + [x[k] + 1e-6] + x[k + 1:]
            columns.append([(a - b) / 1e-6 for a, b in zip(residuals(moved), values)])
        normal = [[sum(a * b for a, b in zip(p, q)) for q in columns] for p in columns]
        slope = [-sum(a * b for a, b in zip(p, values)) for p in columns]
        for _ in range(10):
            damped = [[value * (1 + damping) + 1e-12 if i == j else value
                       for j, value in enumerate(row)] for i, row in enumerate(normal)]
            step = solve(damped, slope)
            trial = [min(h, max(l, a + max(-1.0, min(1.0, d))))
                     for a, d, l, h in zip(x, step, low, high)]
            trial_values = residuals(trial)
            trial_cost = sum(v * v for v in trial_values)
            if trial_cost < cost:
                break
            damping *= 4
        else:
            break
        gain = cost - trial_cost
        x, values, cost, damping = trial, trial_values, trial_cost, damping / 5
        if gain < 1e-10 * cost:
            break
    return cost, x


def fit(path, law, index):
    tangents, betas_deg, table = load(path)
    nodes = [(i, j) for i, row in enumerate(table) for j, r in enumerate(row) if r > 0]
    places = {n: geometry(tangents[n[0]], betas_deg[n[1]], index) for n in nodes}
    measured = {(i, j): table[i][j] for i, j in nodes}
    total = sum(measured.values())
    weights = average_weights(tangents, betas_deg)
    row_2 = tangents.index(2.0)

    def average(values):
        return sum(weights.get(n, 0.0) * r for n, r in values.items())

    def specular(values):
        return values[row_2, 0] / values[0, 0]

    q0, s1 = average(measured), specular(measured)

    def modelled(x):
        parameters = [math.exp(v) for v in x]
        return {n: model_r(parameters, places[n], law) for n in nodes}

    def residuals(x):
        r = modelled(x)
        surplus = max(0.0, math.exp(x[0]) + math.exp(x[1]) + math.exp(x[3]) - MOST_SENT_OUT)
        found = [(r[n] - measured[n]) / math.sqrt(measured[n] * total) for n in nodes]
        return found + [SCALAR_WEIGHT * (average(r) / q0 - 1),
                        SCALAR_WEIGHT * (specular(r) / s1 - 1), SCALAR_WEIGHT * surplus]

    low = [math.log(v) for v in (1e-3, 1e-5, LEAST_ROUGHNESS, 1e-5, LEAST_ROUGHNESS)]
    high = [math.log(v) for v in (0.9, 0.9, MOST_ROUGHNESS, 0.9, MOST_ROUGHNESS)]
    rng = random.Random(1)
    best = min(minimise(residuals,
                        [math.log(v) for v in (0.1, rng.uniform(0.01, 0.6), rng.uniform(0.05, 0.3),
                                               rng.uniform(0.2, 0.8), rng.uniform(0.3, 0.9))],
                        low, high) for _ in range(STARTS))
    r = modelled(best[1])
    rms = math.sqrt(sum(v * v for v in residuals(best[1])[:len(nodes)]))
    return [math.exp(v) for v in best[1]], rms, (specular(r), s1), (average(r), q0)


def main() -> int:
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    for name in sys.argv[2:] or TABLES:
        law, index = TABLES[name]
        p, rms, s1, q0 = fit(f"{sys.argv[1]}/{name}.csv", law, index)
        print(f"{name}: {law} index {index} albedo {p[0]:.5f} share {p[1]:.5f} roughness {p[2]:.5f}"
              f" share {p[3]:.5f} roughness {p[4]:.5f} | rms {rms:.3f}"
              f" S1 {s1[0]:.3f} of {s1[1]:.3f} Q0 {q0[0]:.4f} of {q0[1]:.4f}")
        if p[0] + p[1] + p[3] > 1:
            print(f"{name}: sends out more light than comes in", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
