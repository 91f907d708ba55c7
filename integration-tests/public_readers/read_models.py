#!/usr/bin/env python3
"""read_models.py WRITE_MODELS WORK PROGRAMS: opens a model's files, and the topics of a model server that holds it, with public readers
and compares them with the truth. PROGRAMS: where periplus-model and periplus-model-server stand.

A line "SKIPPED READER: ..." for each reader that is not here, with what nobody has read then.

Exit status: 0 all hold that was read, 1 some do not, 77 Python's packages cannot be had here.
"""
import csv
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import venv

# What must be there for the test to say anything, and readers that have no wheels everywhere.
NEEDED = ["numpy", "scipy", "trimesh", "pygltflib", "plyfile"]
OPTIONAL = ["open3d", "pyoctomap", "pypcd4", "cyclonedds"]


def skip(why):
    print("SKIPPED:", why)
    sys.exit(77)


def installed(command, seconds):
    """All of it together stays below the test's own time limit."""
    try:
        return subprocess.run(command, timeout=seconds).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def install(work):
    """Makes the environment once; a stamp says of which packages. Those that could not be had are asked for again."""
    home = work / "venv"
    python = home / "bin" / "python"
    stamp = home / "complete"
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--retries", "1", "--timeout", "20", "--only-binary=:all:"]
    there = stamp.read_text(encoding="ascii").split() if stamp.exists() else []
    if not set(NEEDED) <= set(there):
        try:
            venv.create(home, with_pip=True, clear=True)
        except (OSError, subprocess.CalledProcessError) as error:
            skip(f"no virtual environment can be made (python3-venv): {error}")
        if not installed([*pip, *NEEDED], 300):
            skip("Python's packages cannot be had here")
        there = list(NEEDED)
    there += [package for package in OPTIONAL if package not in there and installed([*pip, package], 140)]
    stamp.write_text(" ".join(there), encoding="ascii")
    return python


failures = []
unread = {}  # what, and why, by reader


def skipped(reader, what, why):
    unread.setdefault(reader, {})[what] = why


def conclude():
    """Exit status, after the last words."""
    for reader, parts in unread.items():
        print(f"SKIPPED {reader}: not read: {'; '.join(parts)} ({next(iter(parts.values()))})")
    print(f"{len(failures)} do not hold" if failures else "all hold of what was read" if unread else "all hold")
    return 1 if failures else 0


def hold(what, condition, detail=""):
    print("ok  " if condition else "FAIL", what, detail)
    if not condition:
        failures.append(what)


def near(a, b, tolerance=1e-5):
    import numpy
    return numpy.shape(a) == numpy.shape(b) and bool(numpy.allclose(a, b, rtol=0, atol=tolerance))


def unit(normals):
    import numpy
    return near(numpy.linalg.norm(normals, axis=1), numpy.ones(len(normals)), 1e-4)


def outward(points, normals, truth):
    """Mean cosine between the normals and the sphere's."""
    import numpy
    rays = numpy.asarray(points) - truth["sphere"]["center"]
    return float(numpy.mean(numpy.sum(normals * rays, axis=1) / numpy.linalg.norm(rays, axis=1)))


def read_meshes(work, truth):
    import numpy
    import trimesh
    mesh = truth["mesh"]
    for name in ("ball.ply", "ball.obj", "ball.glb"):
        read = trimesh.load(work / name, process=False, force="mesh")
        y_up = name.endswith("glb")
        vertices = numpy.asarray(read.vertices)
        if y_up:
            vertices = numpy.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
        hold(f"{name}: trimesh, vertices", len(vertices) == mesh["vertices"], f"{len(vertices)}")
        hold(f"{name}: trimesh, triangles", len(read.faces) == mesh["triangles"], f"{len(read.faces)}")
        hold(f"{name}: trimesh, bounds", near([vertices.min(axis=0), vertices.max(axis=0)], mesh["bounds"]))
        hold(f"{name}: trimesh, closed as the mesh is", bool(read.is_watertight) == mesh["closed"], str(read.is_watertight))
        # Of the triangles' own: those of the file are looked at by others.
        cosine = outward(vertices, vertices_normals(read, y_up), truth)
        hold(f"{name}: trimesh, triangles turn outward", cosine > 0.9, f"{cosine:.3f}")
        colors = None if y_up else numpy.asarray(read.visual.vertex_colors)[:, :3]
        for sample in mesh["samples"]:
            hold(f"{name}: trimesh, vertex {sample['index']}", near(vertices[sample["index"]], sample["position"]))
            if not y_up:  # read_glb looks at those of the glb
                hold(f"{name}: trimesh, colour {sample['index']}", near(colors[sample["index"]], sample["color"], 1))


def vertices_normals(read, y_up):
    import numpy
    normals = numpy.asarray(read.vertex_normals)
    return numpy.stack([normals[:, 0], -normals[:, 2], normals[:, 1]], axis=1) if y_up else normals


def read_glb(work, truth):
    import numpy
    import pygltflib
    import pygltflib.validator
    gltf = pygltflib.GLTF2().load(str(work / "ball.glb"))
    try:
        pygltflib.validator.validate(gltf)
        hold("ball.glb: pygltflib's validator", True)
    except pygltflib.validator.GLTFValidatorException as error:
        hold("ball.glb: pygltflib's validator", False, str(error))
    blob = gltf.binary_blob()
    primitive = gltf.meshes[0].primitives[0]
    columns = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
    types = {5123: numpy.uint16, 5125: numpy.uint32, 5126: numpy.float32}

    def array(accessor_index):
        accessor = gltf.accessors[accessor_index]
        view = gltf.bufferViews[accessor.bufferView]
        hold(f"ball.glb: accessor {accessor_index} begins at a multiple of four", view.byteOffset % 4 == 0)
        flat = numpy.frombuffer(blob, types[accessor.componentType], accessor.count * columns[accessor.type], view.byteOffset)
        hold(f"ball.glb: accessor {accessor_index} fills its view", flat.nbytes == view.byteLength)
        return accessor, flat.reshape(accessor.count, -1)

    positions, p = array(primitive.attributes.POSITION)
    hold("ball.glb: min and max are the positions'", near(positions.min, p.min(axis=0)) and near(positions.max, p.max(axis=0)))
    _, normals = array(primitive.attributes.NORMAL)
    hold("ball.glb: normals of unit length", unit(normals))
    accessor, colors = array(primitive.attributes.COLOR_0)
    linear = colors[:, :3] / 65535
    srgb = 255 * numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    hold("ball.glb: colours are normalised", accessor.normalized)
    for sample in truth["mesh"]["samples"]:
        hold(f"ball.glb: colour {sample['index']} is linear", near(srgb[sample["index"]], sample["color"], 0.5))
    _, indices = array(primitive.indices)
    hold("ball.glb: indices", len(indices) == 3 * truth["mesh"]["triangles"] and indices.max() == truth["mesh"]["vertices"] - 1)
    hold("ball.glb: generator", gltf.asset.generator == "Periplus" and gltf.asset.version == "2.0")
    hold("ball.glb: one buffer as long as said", gltf.buffers[0].byteLength == len(blob.rstrip(b"")) or len(blob) - gltf.buffers[0].byteLength < 4)


def check_points(name, points, normals, colors, truth):
    import numpy
    points, normals, colors = (numpy.asarray(a, dtype=float) for a in (points, normals, colors))
    cloud = truth["points"]
    hold(f"{name}, points", len(points) == cloud["count"], f"{len(points)}")
    hold(f"{name}, bounds", near([points.min(axis=0), points.max(axis=0)], cloud["bounds"]))
    hold(f"{name}, normals of unit length and outward", unit(normals) and outward(points, normals, truth) > 0.85, f"{outward(points, normals, truth):.3f}")
    for sample in cloud["samples"]:
        i = sample["index"]
        hold(f"{name}, point {i}", near(points[i], sample["position"]) and near(normals[i], sample["normal"]) and near(colors[i], sample["color"], 1))


def read_points(work, truth):
    import numpy
    import plyfile
    vertex = plyfile.PlyData.read(str(work / "ball.points.ply"))["vertex"]
    check_points("ball.points.ply: plyfile", *(numpy.stack([vertex[n] for n in names], axis=1) for names in (("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue"))), truth)
    mesh = plyfile.PlyData.read(str(work / "ball.ply"))
    hold("ball.ply: plyfile", mesh["vertex"].count == truth["mesh"]["vertices"] and mesh["face"].count == truth["mesh"]["triangles"])
    read_pcd(work, truth)
    try:
        import open3d
    except (ImportError, OSError) as error:
        skipped("open3d", "ball.points.ply, ball.pcd and the meshes", error)
        return
    for name in ("ball.points.ply", "ball.pcd"):
        cloud = open3d.io.read_point_cloud(str(work / name))
        check_points(f"{name}: Open3D", cloud.points, cloud.normals, numpy.asarray(cloud.colors) * 255, truth)
    for name in ("ball.ply", "ball.obj", "ball.glb"):
        read = open3d.io.read_triangle_mesh(str(work / name))
        hold(f"{name}: Open3D, triangles", len(read.triangles) == truth["mesh"]["triangles"], f"{len(read.triangles)}")
        if name == "ball.obj":
            normals = numpy.asarray(read.vertex_normals)
            hold(f"{name}: Open3D, normals of unit length and outward", unit(normals) and outward(read.vertices, normals, truth) > 0.9)


def read_pcd(work, truth):
    import numpy
    header = (work / "ball.pcd").read_bytes().split(b"DATA", 1)[0].decode().splitlines()
    keys = [line.split()[0] for line in header if not line.startswith("#")]
    # In this order, which the format demands; version 0.7 is 0.6 with a viewpoint.
    hold("ball.pcd: header", keys == ["VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS"], " ".join(keys))
    try:
        import pypcd4
    except (ImportError, OSError) as error:
        skipped("pypcd4", "ball.pcd", error)
        return
    cloud = pypcd4.PointCloud.from_path(work / "ball.pcd")
    columns = dict(zip(cloud.fields, numpy.asarray(cloud.numpy()).T))
    hold("ball.pcd: pypcd4, version", cloud.metadata.version in ("0.7", ".7"), cloud.metadata.version)
    points, normals = (numpy.stack([columns[n] for n in names], axis=1) for names in (("x", "y", "z"), ("normal_x", "normal_y", "normal_z")))
    check_points("ball.pcd: pypcd4", points, normals, pypcd4.PointCloud.decode_rgb(columns["rgb"].astype(numpy.float32)), truth)


def octomap_tool(work, *arguments):
    """What a program of Debian's octomap-tools says, with its exit status."""
    done = subprocess.run(arguments, cwd=work, capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout + done.stderr


def read_with_octomap_tools(work, truth):
    """OctoMap's own programs: the trees are read, written again, and are the same."""
    if not shutil.which("compare_octrees"):
        skipped("octomap-tools", "ball.bt and ball.ot by OctoMap's own programs", "apt-get install octomap-tools")
        return
    # compare_octrees reads .ot alone, and compares what the cells were said to be.
    for source, target in (("ball.bt", "from-bt.ot"), ("ball.ot", "from-ot.bt"), ("from-ot.bt", "from-ot.ot")):
        (work / target).unlink(missing_ok=True)
        status, said = octomap_tool(work, "convert_octree", source, target)
        hold(f"{source}: convert_octree to {target}", status == 0 and (work / target).exists(), said.strip().rsplit("\n", 1)[-1])
    status, said = octomap_tool(work, "compare_octrees", "from-bt.ot", "from-ot.ot")
    hold("ball.bt and ball.ot: compare_octrees", status == 0 and "KLD: 0\n" in said + "\n", " ".join(said.split()[-2:]))
    octomap_tool(work, "bt2vrml", "ball.bt")
    sides = re.findall(r"Box { size ([0-9.]+) ", (work / "ball.bt.wrl").read_text(encoding="ascii"))
    cells = sum(round(float(side) / truth["voxel_m"]) ** 3 for side in sides)
    hold("ball.bt: bt2vrml, cells", cells == truth["voxels"]["occupied"], str(cells))


def check_leaves(name, tree, truth, coloured=False):
    cells, red = {True: 0, False: 0}, 0
    for leaf in tree.begin_leafs():
        # A pruned leaf stands for all cells it covers.
        occupied, covered = bool(tree.isNodeOccupied(leaf)), round(leaf.getSize() / truth["voxel_m"]) ** 3
        cells[occupied] += covered
        if coloured and occupied and tuple(leaf.current_node.getColor()) == (200, 40, 40):
            red += covered
    hold(f"{name}: pyoctomap, occupied", cells[True] == truth["voxels"]["occupied"], f"{cells[True]}")
    if coloured:
        hold(f"{name}: pyoctomap, leaves in the object's colour", red > 0.5 * cells[True], f"{red}")
    hold(f"{name}: pyoctomap, free", cells[False] == truth["voxels"]["free"], f"{cells[False]}")


def read_topics(work, truth, programs):
    try:
        import cyclonedds as _  # only whether it is there
    except (ImportError, OSError) as error:
        skipped("cyclonedds", "rt/octomap_binary and rt/object_points", error)
        return
    import read_ros_topics
    octomap, cloud = read_ros_topics.listen(programs, work)
    hold("rt/octomap_binary: read by cyclonedds", octomap is not None)
    hold("rt/object_points: read by cyclonedds", cloud is not None)
    if cloud is not None:
        hold("rt/object_points: frame, rows", (cloud.header.frame_id, cloud.row_step, cloud.is_dense) == ("world", cloud.width * cloud.point_step, True))
        check_points("rt/object_points", *read_ros_topics.points_of(cloud), truth)
    if octomap is None:
        return
    hold("rt/octomap_binary: head", (octomap.header.frame_id, octomap.binary, octomap.id, octomap.resolution) == ("world", True, "OcTree", truth["voxel_m"]))
    try:
        import pyoctomap
    except (ImportError, OSError) as error:
        skipped("pyoctomap", "the tree of rt/octomap_binary", error)
        return
    # A .bt file is a head that says how many nodes there are, and then what the message holds.
    head = (work / "ball.bt").read_bytes().split(b"data\n")[0] + b"data\n"
    (work / "topic.bt").write_bytes(head + bytes(octet & 0xff for octet in octomap.data))
    tree = pyoctomap.OcTree(0.1)
    hold("rt/octomap_binary: pyoctomap reads it", tree.readBinary(str(work / "topic.bt")))
    check_leaves("rt/octomap_binary", tree, truth)


def read_trees(work, truth):
    try:
        import pyoctomap
    except (ImportError, OSError) as error:
        skipped("pyoctomap", "ball.bt and ball.ot", error)
        return
    plain = pyoctomap.OcTree(0.1)
    hold("ball.bt: pyoctomap reads it", plain.readBinary(str(work / "ball.bt")))
    coloured = pyoctomap.ColorOcTree(0.1).read(str(work / "ball.ot"))
    for name, tree in (("ball.bt", plain), ("ball.ot", coloured)):
        hold(f"{name}: pyoctomap, resolution", near(tree.getResolution(), truth["voxel_m"], 1e-12))
        check_leaves(name, tree, truth, name == "ball.ot")


def read_features(work, truth):
    with open(work / "ball.features.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    hold("ball.features.csv: lines", len(rows) == truth["features"]["count"], f"{len(rows)}")
    hold("ball.features.csv: position", float(rows[0]["x_m"]) == truth["features"]["x"])
    hold("ball.features.csv: descriptors", all(len(bytes.fromhex(row["descriptor"])) == truth["features"]["octets"] for row in rows))


def main():
    writer, work, programs = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    work.mkdir(parents=True, exist_ok=True)
    if os.environ.get("PERIPLUS_PUBLIC_READERS") != "installed":
        python = install(work)
        sys.exit(subprocess.run([python, __file__, writer, work, programs], env={**os.environ, "PERIPLUS_PUBLIC_READERS": "installed"}).returncode)
    subprocess.run([writer, work], check=True)
    truth = json.loads((work / "truth.json").read_text())
    for read in (read_meshes, read_glb, read_points, read_trees, read_with_octomap_tools, read_features):
        read(work, truth)
    read_topics(work, truth, programs)
    sys.exit(conclude())


if __name__ == "__main__":
    main()
