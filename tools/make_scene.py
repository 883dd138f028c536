#!/usr/bin/env python3
"""Writes a scene of hard visibility: scene.xml (Mitsuba 3) and binary PLY meshes. Standard library only.

    make_scene.py KIND OUT_FOLDER [--detail 1] [--size 640x360]

  hair-ball   about 565 000 triangles: curled hairs, thin tubes of three sides, fill the middle of a closed room
  foliage     about 180 000 triangles: leaves, one quad each, on the branches of six trees in a court under sun and sky
  colonnade   about  63 000 triangles: fluted columns, balustrades and steps in a hall lit from its aisles

In the rooms no lamp shines on what the camera shows first: lamps face walls and vaults, so that nearly all light comes
from virtual lights. In the court sun and sky are lights of their own. --detail D writes about D times as many triangles.
The same arguments write the same bytes: random numbers start from a constant. Prints the triangles. Units: metres.
"""
import argparse
import array
import math
import pathlib
import random
import re
import struct
import sys

TRIANGLES = {"hair-ball": 565_000, "foliage": 180_000, "colonnade": 63_000}


def add(a, b, scale=1.0):
    return (a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    n = 1 / math.sqrt(dot(a, a))
    return (n * a[0], n * a[1], n * a[2])


def across(axis):
    """Two unit vectors that complete the unit vector `axis` to an orthogonal frame."""
    first = unit(cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.7 else (0.0, 1.0, 0.0)))
    return first, cross(axis, first)


def on_sphere(rng):
    z, phi = 2 * rng.random() - 1, 2 * math.pi * rng.random()
    r = math.sqrt(1 - z * z)
    return (r * math.cos(phi), r * math.sin(phi), z)


class Mesh:
    """Triangles with shared vertices; every face keeps its own normal (face_normals in the scene)."""

    def __init__(self):
        self.positions, self.indices = array.array("f"), array.array("i")

    def triangles(self):
        return len(self.indices) // 3

    def vertex(self, p):
        self.positions.extend(p)
        return len(self.positions) // 3 - 1

    def face(self, a, b, c, d):
        self.indices.extend((a, b, c, a, c, d))

    def quad(self, a, b, c, d):
        self.face(*(self.vertex(p) for p in (a, b, c, d)))

    def box(self, low, high):
        x, y, z = zip(low, high)
        v = [self.vertex((x[k & 1], y[k >> 1 & 1], z[k >> 2])) for k in range(8)]
        for f in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3)):
            self.face(*(v[k] for k in f))

    def rings(self, rings):
        """Joins rings of equally many points by quads: 2 (rings - 1) sides triangles."""
        sides = len(rings[0])
        first = len(self.positions) // 3
        for ring in rings:
            for p in ring:
                self.positions.extend(p)
        for at in range(first, first + sides * (len(rings) - 1), sides):
            for k in range(sides):
                n = (k + 1) % sides
                self.face(at + k, at + n, at + sides + n, at + sides + k)

    def tube(self, points, radii, sides):
        """A bent tube without caps around the line of `points`; the frame is carried along, so that it does not twist."""
        rings, frame = [], None
        for k, (p, r) in enumerate(zip(points, radii)):
            axis = unit(add(points[min(k + 1, len(points) - 1)], points[max(k - 1, 0)], -1))
            if frame is None:
                frame = across(axis)
            u = unit(add(frame[0], axis, -dot(frame[0], axis)))
            frame = (u, cross(axis, u))
            rings.append([add(add(p, u, r * math.cos(2 * math.pi * s / sides)), frame[1],
                              r * math.sin(2 * math.pi * s / sides)) for s in range(sides)])
        self.rings(rings)

    def turned(self, base, profile, sides, flutes=0):
        """A body of revolution about y: `profile` lists (height, radius); every other edge of a flute is drawn in."""
        rings = []
        for height, radius in profile:
            ring = []
            for s in range(sides):
                phi = 2 * math.pi * s / sides
                r = radius * (1 - 0.07 * (0.5 - 0.5 * math.cos(flutes * phi))) if flutes else radius
                ring.append(add(base, (r * math.cos(phi), height, r * math.sin(phi))))
            rings.append(ring)
        self.rings(rings)

    def write(self, path):
        if sys.byteorder == "big":
            self.positions.byteswap()
        i = self.indices
        faces = b"".join(struct.pack("<B3i", 3, i[k], i[k + 1], i[k + 2]) for k in range(0, len(i), 3))
        header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(self.positions) // 3}\n"
                  "property float x\nproperty float y\nproperty float z\n"
                  f"element face {self.triangles()}\nproperty list uchar int vertex_indices\nend_header\n")
        path.write_bytes(header.encode() + self.positions.tobytes() + faces)


class Scene:
    """What becomes scene.xml: meshes with a two-sided diffuse colour or a radiance, one camera."""

    def __init__(self, origin, target, fov_deg):
        self.camera, self.parts, self.sky = (origin, target, fov_deg), [], ""

    def mesh(self, name, color):
        made = Mesh()
        self.parts.append((name, made, color, None))
        return made

    def lamp(self, name, radiance, a, b, c, d):
        """Emits on the side from which a, b, c, d run counter-clockwise."""
        made = Mesh()
        made.quad(a, b, c, d)
        self.parts.append((name, made, (0.5, 0.5, 0.5), radiance))

    def triangles(self):
        return sum(mesh.triangles() for _, mesh, _, _ in self.parts)

    def write(self, folder, size):
        folder.mkdir(parents=True, exist_ok=True)
        numbers = lambda values: ", ".join(f"{v:g}" for v in values)
        origin, target, fov_deg = self.camera
        lines = ['<scene version="3.0.0">',
                 '\t<integrator type="path"><integer name="max_depth" value="8"/></integrator>',
                 '\t<sensor type="perspective">', f'\t\t<float name="fov" value="{fov_deg:g}"/>',
                 f'\t\t<transform name="to_world"><lookat origin="{numbers(origin)}" target="{numbers(target)}" up="0, 1, 0"/>'
                 '</transform>',
                 '\t\t<film type="hdrfilm">', f'\t\t\t<integer name="width" value="{size[0]}"/>',
                 f'\t\t\t<integer name="height" value="{size[1]}"/>', '\t\t\t<rfilter type="tent"/>', '\t\t</film>', '\t</sensor>']
        for name, mesh, color, radiance in self.parts:
            mesh.write(folder / f"{name}.ply")
            lines += ['\t<shape type="ply">', f'\t\t<string name="filename" value="{name}.ply"/>',
                      '\t\t<boolean name="face_normals" value="true"/>',
                      '\t\t<bsdf type="twosided"><bsdf type="diffuse">'
                      f'<rgb name="reflectance" value="{numbers(color)}"/></bsdf></bsdf>']
            if radiance:
                lines.append(f'\t\t<emitter type="area"><rgb name="radiance" value="{numbers(radiance)}"/></emitter>')
            lines.append('\t</shape>')
        (folder / "scene.xml").write_text("\n".join(lines) + self.sky + "\n</scene>\n", newline="\n")


def hair(rng, segments):
    """Points of one hair: it leaves a core, curls about an axis of its own and is bent back at the ball's rim (radius 1)."""
    p = on_sphere(rng)
    heading, axis = unit(add(p, on_sphere(rng), 0.9)), on_sphere(rng)
    p = tuple(0.35 * x for x in p)
    step, curl, points = (0.9 + 0.5 * rng.random()) / segments, (2 + 7 * rng.random()) / segments, []
    for _ in range(segments + 1):
        points.append(p)
        heading = add(add(heading, cross(axis, heading), curl), on_sphere(rng), 1.6 / segments)
        r = math.sqrt(dot(p, p))
        if r > 0.8:
            heading = add(heading, p, -(r - 0.8) * 40 / segments)
        heading = unit(heading)
        p = add(p, heading, step)
    return points


def hair_ball(detail):
    scene = Scene((0.35, 1.75, 3.3), (0, 1.98, 0), 52)
    room = scene.mesh("room", (0.72, 0.7, 0.66))
    room.box((-3.5, 0, -3.5), (3.5, 4.4, 4.2))
    scene.mesh("left", (0.62, 0.25, 0.13)).quad((-3.49, 0, -3.5), (-3.49, 4.4, -3.5), (-3.49, 4.4, 4.2), (-3.49, 0, 4.2))
    scene.mesh("right", (0.15, 0.3, 0.55)).quad((3.49, 0, -3.5), (3.49, 0, 4.2), (3.49, 4.4, 4.2), (3.49, 4.4, -3.5))
    segments, radius_m, center = 32, 1.6, (0, 2.0, 0)
    shares = (("hair-gold", (0.85, 0.66, 0.36)), ("hair-red", (0.75, 0.36, 0.2)), ("hair-white", (0.86, 0.82, 0.76)))
    rng = random.Random(565)
    hairs = round((TRIANGLES["hair-ball"] * detail - 22) / (6 * segments))
    for part, (name, color) in enumerate(shares):
        mesh = scene.mesh(name, color)
        for _ in range(part, hairs, len(shares)):
            points = [add(center, p, radius_m) for p in hair(rng, segments)]
            width = 0.007 + 0.005 * rng.random()
            mesh.tube(points, [width * (1 - 0.6 * k / segments) for k in range(segments + 1)], 3)
    # Lamps near the camera's wall and behind the ball: they face ceiling, walls and floor.
    scene.lamp("lamp-top", (30, 27, 22), (-1.2, 3.95, 2.6), (-1.2, 3.95, 3.6), (1.2, 3.95, 3.6), (1.2, 3.95, 2.6))
    scene.lamp("lamp-left", (16, 13, 9), (-2.9, 0.6, 2.2), (-2.9, 0.6, 3.2), (-2.9, 2.8, 3.2), (-2.9, 2.8, 2.2))
    scene.lamp("lamp-back", (24, 24, 26), (-0.6, 1.4, -2.6), (-0.6, 2.6, -2.6), (0.6, 2.6, -2.6), (0.6, 1.4, -2.6))
    scene.lamp("lamp-right", (12, 13, 16), (2.9, 0.6, 2.2), (2.9, 2.8, 2.2), (2.9, 2.8, 3.2), (2.9, 0.6, 3.2))
    return scene


def grow(rng, wood, tips, start, heading, length, radius, level):
    """One branch of three bent pieces, then its children; `tips` collects (point, heading) where leaves may sit."""
    points, radii = [start], [radius]
    for k in range(3):
        heading = unit(add(add(heading, on_sphere(rng), 0.22), (0, 1, 0), 0.06))
        points.append(add(points[-1], heading, length / 3))
        radii.append(radius * (1 - 0.45 * (k + 1) / 3))
        if level <= 1:
            tips.append((points[-1], heading, length / 3))
    wood.tube(points, radii, 8 if level > 2 else 5 if level > 0 else 3)
    if level == 0:
        return
    for k in range(4 if level > 1 else 5):
        u, v = across(heading)
        phi, spread = 2 * math.pi * (k / 4 + 0.2 * rng.random()), 0.75 + 0.5 * rng.random()
        side = add(add((0, 0, 0), u, math.cos(phi)), v, math.sin(phi))
        grow(rng, wood, tips, points[-1 - (k % 2)], unit(add(heading, side, spread)), length * (0.62 + 0.2 * rng.random()),
             radii[-1] * 0.72, level - 1)


def foliage(detail):
    scene = Scene((0.3, 1.5, 5.9), (0, 2.3, 0), 62)
    court = scene.mesh("court", (0.68, 0.62, 0.53))
    court.box((-8, 0, -6.4), (8, 7, -6)), court.box((-8.4, 0, -6.4), (-8, 7, 9)), court.box((8, 0, -6.4), (8.4, 5, 9))
    court.box((-8.4, 0, 9), (8.4, 5, 9.4))
    scene.mesh("ground", (0.42, 0.36, 0.27)).box((-8.4, -0.3, -6.4), (8.4, 0, 9.4))
    rng = random.Random(180)
    wood, tips = scene.mesh("wood", (0.3, 0.22, 0.15)), []
    level = 4 if detail > 0.5 else 2 if detail > 0.03 else 1
    trees = ((-4.4, -2.4, 1.25), (-1.6, -3.4, 1.4), (1.6, -2.6, 1.25), (4.8, -3.0, 1.3), (-2.5, 1.2, 0.8), (2.7, 1.0, 0.85))
    for x, z, size in trees:
        grow(rng, wood, tips, (x, -0.1, z), unit((0.15 * rng.random(), 1, 0.15 * rng.random())), 1.5 * size, 0.13 * size, level)
    kinds = [scene.mesh(name, color) for name, color in (("leaves-light", (0.42, 0.55, 0.14)), ("leaves-dark", (0.2, 0.4, 0.1)),
                                                         ("leaves-gold", (0.6, 0.47, 0.12)))]
    leaves = (round(TRIANGLES["foliage"] * detail) - scene.triangles()) // 2
    for k in range(leaves):
        p, heading, reach = tips[int(rng.random() * len(tips))]
        center = add(add(p, heading, -reach * rng.random()), on_sphere(rng), 0.14 * rng.random())
        along = unit(add(add(heading, on_sphere(rng), 1.2), (0, -1, 0), 0.3))
        wide = unit(add(across(along)[0], on_sphere(rng), 0.8))
        wide = unit(add(wide, along, -dot(wide, along)))
        size = 0.045 + 0.035 * rng.random()
        kinds[0 if k % 7 < 3 else 1 if k % 7 < 6 else 2].quad(
            center, add(add(center, along, size), wide, 0.45 * size), add(center, along, 2 * size),
            add(add(center, along, size), wide, -0.45 * size))
    scene.sky = ('\n\t<emitter type="constant"><rgb name="radiance" value="0.35, 0.5, 0.75"/></emitter>'
                 '\n\t<emitter type="directional"><vector name="direction" value="0.75, -0.62, -0.35"/>'
                 '<rgb name="irradiance" value="6.5, 5.6, 4.2"/></emitter>')
    return scene


def colonnade(detail):
    scene = Scene((0.9, 2.1, 13.6), (-0.5, 3.0, 0), 66)
    hall = scene.mesh("hall", (0.74, 0.7, 0.62))
    hall.box((-8, 0, -16), (8, 9, 15))
    scene.mesh("floor", (0.45, 0.3, 0.22)).quad((-8, 0.01, -16), (-8, 0.01, 15), (8, 0.01, 15), (8, 0.01, -16))
    stone = scene.mesh("stone", (0.78, 0.75, 0.7))
    rows, gap, aisle = min(10, max(2, round(100 * detail))), 2.8, 3.6
    flutes = max(2, round(12 * math.sqrt(detail)))
    sides, spokes, balusters = 4 * flutes, max(3, round(10 * math.sqrt(detail))), max(1, round(6 * math.sqrt(detail)))
    railed = [k for k in range(rows - 1) if k != 4]  # two passages stay open
    # What is left for the shafts after boxes (12 triangles each), lamps, floor and balusters decides their rings.
    others = 12 * (1 + 5 * rows + 2 + 8) + 20 + len(railed) * 2 * (24 + balusters * 16 * spokes)
    up = max(2, round((TRIANGLES["colonnade"] * detail - others) / (4 * rows * sides)) - 4)
    shaft = [(0.3 + 5.6 * k / up, 0.46 * (1 - 0.14 * (k / up) ** 1.6)) for k in range(up + 1)]
    shaft = [(0.2, 0.62), (0.3, 0.5)] + shaft + [(6.0, 0.43), (6.15, 0.62)]
    turn = [(0.0, 0.09), (0.08, 0.09), (0.11, 0.05), (0.2, 0.085), (0.32, 0.1), (0.5, 0.05), (0.62, 0.04), (0.7, 0.08), (0.78, 0.08)]
    for side in (-aisle, aisle):
        for k in range(rows):
            z = 12 - gap * k
            stone.turned((side, 0, z), shaft, sides, flutes)
            stone.box((side - 0.65, 0, z - 0.65), (side + 0.65, 0.2, z + 0.65))
            stone.box((side - 0.65, 6.15, z - 0.65), (side + 0.65, 6.4, z + 0.65))
            hall.box((-8, 8.3, z - 0.25), (8, 9, z + 0.25))
            if k not in railed:
                continue
            stone.box((side - 0.16, 0, z - gap + 0.65), (side + 0.16, 0.15, z - 0.65))
            stone.box((side - 0.16, 0.93, z - gap + 0.5), (side + 0.16, 1.05, z - 0.5))
            for n in range(balusters):
                stone.turned((side, 0.15, z - 0.65 - (gap - 1.3) * (n + 0.5) / balusters), turn, spokes)
        stone.box((side - 0.6, 6.4, -16), (side + 0.6, 7.2, 15))
    for k in range(8):
        stone.box((-aisle + 0.7, 0.16 * k, -15.9), (aisle - 0.7, 0.16 * (k + 1), -10.6 - 0.35 * k))
    # Lamps low in the aisles and above the beams face the outer walls and the vault.
    for k, z in enumerate((9.2, 0.8, -7.6)):
        warm = (8, 6, 3.8) if k % 2 == 0 else (6.6, 6.2, 5.8)
        scene.lamp(f"lamp-left-{k}", warm, (-6.2, 0.3, z - 1), (-6.2, 0.3, z + 1), (-6.2, 3.3, z + 1), (-6.2, 3.3, z - 1))
        scene.lamp(f"lamp-right-{k}", warm, (6.2, 0.3, z - 1), (6.2, 3.3, z - 1), (6.2, 3.3, z + 1), (6.2, 0.3, z + 1))
        scene.lamp(f"lamp-vault-{k}", (15, 15, 16), (3.1, 7.25, z - 2), (3.1, 7.25, z + 2), (4.1, 7.25, z + 2),
                   (4.1, 7.25, z - 2))
    return scene


MAKERS = {"hair-ball": hair_ball, "foliage": foliage, "colonnade": colonnade}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=sorted(MAKERS))
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--detail", type=float, default=1.0, help="share of the triangles, 0.005 to 4 (1)")
    parser.add_argument("--size", default="640x360", help="pixels of the camera (640x360)")
    args = parser.parse_args()
    size = re.fullmatch(r"([1-9]\d{0,4})x([1-9]\d{0,4})", args.size)
    if not size or not 0.005 <= args.detail <= 4:
        parser.error("--size is WIDTHxHEIGHT, --detail lies in 0.005 to 4")
    scene = MAKERS[args.kind](args.detail)
    scene.write(args.folder, (int(size[1]), int(size[2])))
    print(f"{args.folder / 'scene.xml'}: {scene.triangles()} triangles")


if __name__ == "__main__":
    main()
