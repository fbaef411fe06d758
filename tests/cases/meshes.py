#!/usr/bin/python3
"""Surfaces of triangles and profiles: the same bits on any number of ranks and after a restart, and what broken ones
lead to. The meshes are made here.
"""

import struct
import tempfile
from pathlib import Path

import bad_input as b
import case as c

SCENE = """\
particle_spacing: 0.1
end_time: 1
fluid: {blocks: [{mesh: {file: water.obj}}]}
boundary: {walls: [{name: tank, mesh: {file: tank.stl}}]}
"""
LAST = "    - {mesh: {file: rock.ply}, inside: solid}"


def box(low, high):
    """Vertices and outward quadrilaterals, counted from 0."""
    vertices = [[(low, high)[n >> a & 1][a] for a in range(3)] for n in range(8)]
    return vertices, [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def obj(vertices, faces):
    return "".join([f"v {x} {y} {z}\n" for x, y, z in vertices] +
                   ["f " + " ".join(str(k + 1) for k in face) + "\n" for face in faces]).encode()


def stl(vertices, faces):
    """Binary; quadrilaterals become two triangles."""
    triangles = [[face[0], face[k], face[k + 1]] for face in faces for k in (1, 2)]
    records = [struct.pack("<12fH", 0, 0, 0, *(x for k in triangle for x in vertices[k]), 0) for triangle in triangles]
    return bytes(80) + struct.pack("<I", len(records)) + b"".join(records)


def ply(vertices, faces):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\n" + "".join(f"property float {a}\n" for a in "xyz")
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    return (head + "".join(f"{x} {y} {z}\n" for x, y, z in vertices) +
            "".join(" ".join(map(str, [len(face), *face])) + "\n" for face in faces)).encode()


WATER, TANK = box((0, 0, 0), (0.4, 0.4, 0.4)), box((0, 0, 0), (1, 0.4, 1))
OPEN = (WATER[0], WATER[1][:5])
INWARD = (WATER[0], [face[::-1] for face in WATER[1]])
FLAT = (WATER[0][:4] + [[x, y, 0] for x, y, _ in WATER[0][4:]], WATER[1])
MANY = ([[x + 0.01 * n for x in v] for n in range(1100) for v in box((0, 0, 0), (0.004, 0.004, 0.004))[0]],
        [[8 * n + k for k in face] for n in range(1100) for face in WATER[1]])


def files(water=None, tank=None, **more):
    return {"water.obj": obj(*WATER) if water is None else water, "tank.stl": stl(*TANK) if tank is None else tank, **more}


def scene(old="", new="", more=""):
    assert old in SCENE
    return (SCENE.replace(old, new, 1) if old else SCENE) + more


def solid(shape):
    """A scene with a third surface in the tank, in a wall of its own."""
    return scene("tank.stl}}]", f"tank.stl}}}}, {{name: rock, {shape}, inside: solid}}]")


def profile(text):
    return solid(f"revolution: {{base: [0.7, 0.2, 0.5], profile: {text}}}")


ROCK = ply(*box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)))
# Name: the scene, the files beside it, and what the message must hold; places as in bad_input.py.
BROKEN = {
    "a missing mesh": (scene("water.obj", "none.obj"), files(), "3:32", "none.obj: cannot be opened", "No such file"),
    "an empty mesh": (SCENE, files(water=b""), "3:32", "water.obj: the file is empty"),
    "a folder": (scene("water.obj", "."), files(), "3:32", "must be a file of the kind .obj, .stl or .ply"),
    "another kind": (scene("water.obj", "water.step"), files(), "3:32", ".obj, .stl or .ply"),
    "no mesh at all": (SCENE, files(water=b"particle_spacing: 0.1\n"), "3:32", "water.obj"),
    "half a file": (SCENE, files(tank=stl(*TANK)[:300]), "4:46", "tank.stl: is cut short, or no STL file"),
    "points only": (SCENE, files(water=obj(WATER[0], [])), "3:32", "water.obj"),
    "an open block": (SCENE, files(water=obj(*OPEN)), "3:32", "4 of its edges belong to one triangle only", "not closed",
                      "the first from (0.4, 0, 0) "),
    "an open wall": (SCENE, files(tank=stl(TANK[0], TANK[1][1:])), "4:46", "not closed", "mesh.closed: false"),
    "a face turned": (SCENE, files(water=obj(WATER[0], [*OPEN[1], OPEN[1][0]])), "3:32", "of its edges"),
    "no area": (SCENE, files(water=obj(WATER[0] + [[0.2, 0, 0]], [*WATER[1], [0, 8, 1]])), "3:32", "have no area"),
    "flat": (SCENE, files(water=obj(*FLAT)), "3:32", "the mesh"),
    "no number": (SCENE, files(tank=stl(*TANK).replace(struct.pack("<f", 1), struct.pack("<f", float("nan")))), "4:46",
                  "must be finite"),
    "many shells": (SCENE, files(water=obj(*MANY)), "3:32", "1100 separate shells", "at most 1000"),
    "millimetres": (scene("water.obj", "water.obj, scale: 0.001"), files(), "3:32", "larger than particle_spacing",
                    "is mesh.scale"),
    "light years": (scene("water.obj", "water.obj, scale: 1e16"), files(), "3:32", "2^31 support radii", "is mesh.scale"),
    "vast": (scene("tank.stl", "tank.stl, scale: 1e5"), files(), "4:46", "is its scale right?"),
    "another checksum": (scene("water.obj", "water.obj, checksum: 00ff"), files(), "3:32", "has the checksum", "not 00ff"),
    "fluid in an obstacle": (solid("mesh: {file: rock.ply, translation: [0.3, 0.2, 0.2]}"), files(**{"rock.ply": ROCK}),
                             "fluid.blocks[0] must stay out of boundary.walls[1] \"rock\"", "within its surface"),
    "fluid behind a wall": (scene("water.obj", "water.obj, translation: [0.7, 0, 0]"), files(),
                            "fluid.blocks[0] must not reach into boundary.walls[0] \"tank\""),
    "fluid outside": (scene("water.obj", "water.obj, translation: [3, 0, 0]"), files(), "must lie within the containers"),
    "fluid in fluid": (scene("water.obj}}]", "water.obj}}, {mesh: {file: water.obj, translation: [0.2, 0, 0]}}]"),
                       files(), "fluid.blocks[1] must not overlap fluid.blocks[0]"),
    "thin fluid": (scene("water.obj}}]", "water.obj}}, {mesh: {file: thin.obj}}]"),
                   files(**{"thin.obj": obj(*box((0.5, 0, 0), (0.9, 0.3, 0.05)))}), "must be thick enough", "not 0.05 m"),
    "no file": (scene("file: water.obj", "scale: 2"), files(), "missing required key 'fluid.blocks[0].mesh.file'"),
    "two kinds of shape": (scene("water.obj}}]", "water.obj}, sphere: {center: [0, 0, 0], radius: 1}}]"), files(),
                           "it has sphere and mesh"),
    "no scale": (scene("water.obj", "water.obj, scale: 0"), files(), "mesh.scale must be > 0, not '0'"),
    "no axis": (scene("water.obj", "water.obj, rotation: {axis: [0, 0, 0], angle: 3}"), files(), "must not be zero"),
    "no angle": (scene("water.obj", "water.obj, rotation: {angle: 400}"), files(), "must be in [-360, 360]"),
    "no translation": (scene("water.obj", "water.obj, translation: 3"), files(), "must be a list of 3 numbers"),
    "a long path": (scene("water.obj", 600 * "w"), files(), "mesh.file must be at most 511 bytes long"),
    "closed of a block": (scene("water.obj", "water.obj, closed: false"), files(), "unknown key 'fluid.blocks[0].mesh.closed'"),
    "closed: a word": (scene("tank.stl", "tank.stl, closed: maybe"), files(), "must be true or false, not 'maybe'"),
    "inside of a sheet": (scene("tank.stl}", "tank.stl, closed: false}, inside: solid"), files(),
                          "inside must not be solid: the surface is not closed"),
    "inside of nothing": (scene("tank.stl}", "tank.stl}, inside: air"), files(), "one of fluid, solid"),
    "no profile": (solid("revolution: {base: [0, 0, 0]}"), files(), "missing required key 'boundary.walls[1].revolution.profile'"),
    "a profile of numbers": (profile("[0, 1, 2]"), files(), "revolution.profile[0] must be a pair of numbers, not '0'"),
    "a word for a profile": (profile("glass"), files(), "must be a list of pairs", "not 'glass'"),
    "a profile of words": (profile("[[0, a], [1, 2]]"), files(), "revolution.profile[0] must be a number, not 'a'"),
    "a triple": (profile("[[0, 0], [1, 2, 3]]"), files(), "revolution.profile[1] must be a pair of numbers, not a list of 3"),
    "across the axis": (profile("[[0, 0], [-0.1, 0.1], [0, 0.2]]"), files(), "revolution.profile[1] must have r >= 0, not -0.1"),
    "on the axis": (profile("[[0, 0], [0, 1], [0, 2]]"), files(), "profile must leave the axis"),
    "a short profile": (profile("[[0, 0], [0.1, 0.1]]"), files(), "at least 3 different points, and has 2"),
    "an empty profile": (profile("[]"), files(), "at least 3 different points, and has 0"),
    "a profile in mm": (profile("[[0, 0], [1e9, 0], [0, 1e9]]"), files(), "is its unit m?"),
    "a small profile": (profile("[[0, 0], [0.01, 0], [0, 0.01]]"), files(), "larger than particle_spacing"),
    "a profile without axis": (profile("[[0, 0], [1, 0], [0, 1]], axis: [0, 0, 0]"), files(), "must not be zero"),
    "an endless base": (profile("[[0, 0], [0.2, 0], [0, 0.2]], axis: [0, 0, .inf]"), files(), "must be finite"),
}


def write(folder, text, beside):
    (folder / "scenes").mkdir()
    (folder / "scenes/scene.yaml").write_text(text, encoding="utf-8")
    for name, data in beside.items():
        (folder / "scenes" / name).write_bytes(data)


def refuse(case, name, ranks):
    text, beside, *words = BROKEN[name]
    what = f"{name}, {ranks} ranks"
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        folder = Path(folder)
        write(folder, text, beside)
        before = b.tree(folder)
        arguments = ["check", "scenes/scene.yaml"] if ranks == 1 else ["run", "scenes/scene.yaml", "--quiet"]
        code, told = b.start(case, arguments, folder, ranks)
        places = [word for word in words if word[0].isdigit() and word[1] == ":"]
        b.expect_message(what, code, told, 2, ["halocline: error: ", *(word for word in words if word not in places)])
        c.expect(told.count("halocline: error: ") == 1, f"{what}: not one message\n{told[:3000]}")
        for place in places:
            b.expect_place(what, told, place)
        c.expect(b.tree(folder) == before, f"{what}: left {sorted(b.tree(folder))}")


def broken(case, _):
    return f"check refuses {b.all_of([(refuse, case, name, 1) for name in BROKEN])} scenes with broken surfaces"


def broken_on_ranks(case, _):
    return f"{b.all_of([(refuse, case, name, 3) for name in list(BROKEN)[::3]])} scenes with broken surfaces end as agreed on 3 ranks"


def turned(case, _):
    """A mesh inside out is told of once and turned around."""
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        folder = Path(folder)
        write(folder, SCENE, files(water=obj(*INWARD)))
        for ranks in (1, 3):
            code, told = b.start(case, ["run", "scenes/scene.yaml", "--steps", "1", "-q", "--force"], folder, ranks)
            b.expect_message("inside out", code, told, 0, ["water.obj is inside out and is turned around"])
            c.expect(told.count("inside out") == 1, f"told more than once\n{told}")
        fluid = next(line for line in b.start(case, ["check", "scenes/scene.yaml"], folder, 1)[1].splitlines()
                     if line.startswith("fluid particles"))
        c.expect(" 64," in fluid, f"expected 64 particles: {fluid}")
    return "a mesh inside out is turned around, and said so once"


def same_bits(case, steps):
    """The tour's scene, coarse: meshes, profiles, forces on them; with METIS, and far away."""
    steps = steps or 40
    settings = ("particle_spacing=0.04", "output.snapshots.every=0.05", "boundary.layers=2")
    further = {"one": (1, ()), "two": (2, ()), "four": (4, ()), "metis": (3, ("parallel.decomposition=metis",
               "parallel.rebalance_every=7")), "away": (2, ("origin_cells=[1000, -2000, 3000]",))}
    runs = {name: case.run("scenes/meshes.yaml", name, ranks, (*settings, *more), ["--steps", steps])
            for name, (ranks, more) in further.items()}
    for name, run in runs.items():
        for table in ("steps.csv", "gauges.csv"):
            c.expect_same_text(runs["one"] / table, run / table)
        for left, right in zip(c.snapshots(runs["one"]), c.snapshots(run)):
            case.diff(left, right)
    case.call(["check", runs["two"] / "scene.yaml"])  # paths whole, profiles written
    return f"{steps} steps are the same on 1, 2, 3, 4 ranks, with METIS and far away"


def restarted(case, _):
    """A run goes on to the same bits, also where the scene has moved, and not with another mesh."""
    more = "output: {snapshots: {every: 0.1}, checkpoints: {every_steps: 10}}\n"
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        folder = Path(folder)
        write(folder, scene(more=more), files())
        case.call(["run", folder / "scenes/scene.yaml", "-o", folder / "whole", "-q", "--steps", 30], 1)
        case.call(["run", folder / "scenes/scene.yaml", "-o", folder / "parts", "-q", "--steps", 10], 3)
        (folder / "scenes").rename(folder / "elsewhere")
        case.call(["run", folder / "elsewhere/scene.yaml", "-o", folder / "parts", "-q", "--steps", 30, "--restart"], 2)
        c.expect_same_text(folder / "whole/steps.csv", folder / "parts/steps.csv")
        for left, right in zip(c.snapshots(folder / "whole"), c.snapshots(folder / "parts")):
            case.diff(left, right)
        (folder / "elsewhere/water.obj").write_bytes(obj(*box((0, 0, 0), (0.3, 0.4, 0.4))))
        told = case.call(["run", folder / "elsewhere/scene.yaml", "-o", folder / "parts", "-q", "--restart"], 2, 2)
        c.expect("mesh.checksum: was" in told, f"nothing tells of the mesh that changed\n{told}")
        (folder / "elsewhere/water.obj").write_bytes(files()["water.obj"])
        case.call(["check", folder / "parts/scene.yaml"])
        sheet = "boundary: {walls: [{revolution: {profile: [[0, 0], [0.5, 0]], closed: false}}]}"
        (folder / "sheet.yaml").write_text(f"particle_spacing: 0.1\nend_time: 0.01\n{sheet}\nfluid: "
                                           "{blocks: [{box: {min: [-0.2, -0.2, 0], max: [0.2, 0.2, 0.2]}}]}\n")
        case.call(["run", folder / "sheet.yaml", "-o", folder / "sheet", "-q"])
        case.call(["run", folder / "sheet.yaml", "-o", folder / "sheet", "-q", "--restart"])
    return "a run goes on to the same bits where the scene has moved, and refuses a mesh that has changed"


if __name__ == "__main__":
    c.main(__doc__, {"broken": broken, "broken_on_ranks": broken_on_ranks, "turned": turned, "same_bits": same_bits,
                     "restarted": restarted})
