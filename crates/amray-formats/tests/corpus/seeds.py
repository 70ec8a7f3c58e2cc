"""Makes the seeds of this corpus that are not amray's own output, with h5py and by hand: python3 seeds.py"""

import base64
import gzip
import os
import struct
import zlib

import h5py
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))


def place(*names):
    path = os.path.join(HERE, *names)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    return path


def write(content, *names):
    with open(place(*names), "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())


def hdf5(*names):
    # The oldest layout has no checksums, which would keep changes from getting any further.
    return h5py.File(place(*names), "w", libver=("earliest", "v108"))


def octree():
    """Eight blocks of 4^3 at level 0, the first one refined: levels and places."""
    blocks = [(0, i, j, k) for k in range(2) for j in range(2) for i in range(2)][1:]
    return blocks + [(1, i, j, k) for k in range(2) for j in range(2) for i in range(2)]


def athena(name, **storage):
    blocks = octree()
    with hdf5("amr/seeds", name, "a.athdf") as file:
        for axis in (1, 2, 3):
            file.attrs[f"RootGridX{axis}"] = np.array([0, 1, 1], "<f4")
        file.attrs["RootGridSize"] = np.array([8] * 3, ">i4")
        file.attrs["MeshBlockSize"] = np.array([4] * 3, ">i4")
        file.attrs["NumMeshBlocks"] = np.int32(len(blocks))
        file.attrs["MaxLevel"] = np.int32(1)
        file.attrs["NumVariables"] = np.array([2], ">i4")
        file.attrs["DatasetNames"] = np.array(["prim"], "S21")
        file.attrs["VariableNames"] = np.array(["rho", "press"], "S21")
        file.attrs["Coordinates"] = np.bytes_("cartesian")
        file.attrs["Time"] = 0.5
        file["Levels"] = np.array([block[0] for block in blocks], ">i4")
        file["LogicalLocations"] = np.array([block[1:] for block in blocks], ">i8")
        for axis in (1, 2, 3):
            faces = [(block[axis] + np.arange(5) / 4) / 2 / 2 ** block[0] for block in blocks]
            file[f"x{axis}f"] = np.array(faces, "<f4")
            file[f"x{axis}v"] = np.array([(face[1:] + face[:-1]) / 2 for face in faces], "<f4")
        values = np.arange(2 * len(blocks) * 64, dtype="<f4").reshape(2, len(blocks), 4, 4, 4)
        file.create_dataset("prim", data=values, **storage)


def flash():
    blocks = [(0, 0, 0, 0)] + [(level + 1, i, j, k) for level, i, j, k in octree()]
    # The root of 4^3 cells, and below it the octree.
    with hdf5("amr/seeds/flash/flash_hdf5_chk_0000") as file:
        width = [0.5**block[0] for block in blocks]
        bounds = [[[n * w, (n + 1) * w] for n in block[1:]] for block, w in zip(blocks, width)]
        file["bounding box"] = np.array(bounds)
        file["refine level"] = np.array([block[0] + 1 for block in blocks], "<i4")
        file["node type"] = np.array([2] + [1] * (len(blocks) - 1), "<i4")
        integers = [("nxb", 4), ("nyb", 4), ("nzb", 4), ("dimensionality", 3), ("globalnumblocks", len(blocks))]
        file["integer scalars"] = np.array([(n.ljust(80), v) for n, v in integers], [("name", "S80"), ("value", "<i4")])
        file["real scalars"] = np.array([("time".ljust(80), 0.25)], [("name", "S80"), ("value", "<f8")])
        file["unknown names"] = np.array([["dens"], ["pres"]], "S4")
        for name in ("dens", "pres"):
            file[name] = np.arange(len(blocks) * 64, dtype="<f8").reshape(len(blocks), 4, 4, 4)


def enzo():
    grids = [((4, 4, 4), (0, 0, 0), (1, 1, 1)), ((4, 2, 2), (0, 0, 0), (0.5, 0.25, 0.25))]
    name = "DD0000"
    write(
        "TopGridDimensions = 4 4 4\nTopGridRank = 3\nDomainLeftEdge = 0 0 0\nDomainRightEdge = 1 1 1\nRefineBy = 2\n"
        "InitialTime = 0.5\nDataLabel[0] = Density\nDataUnits[0] = none\n#DataCGSConversionFactor[0] = 2\n"
        "MaximumRefinementLevel = 1\nVersionNumber = 2.0\n",
        "amr/seeds/enzo", name,
    )
    text = ""
    for number, (cells, low, high) in enumerate(grids, 1):
        text += (
            f"\nGrid = {number}\nTask = 0\nGridRank = 3\nGridDimension = {cells[0]+6} {cells[1]+6} {cells[2]+6}\n"
            f"GridStartIndex = 3 3 3\nGridEndIndex = {cells[0]+2} {cells[1]+2} {cells[2]+2}\n"
            f"GridLeftEdge = {low[0]} {low[1]} {low[2]}\nGridRightEdge = {high[0]} {high[1]} {high[2]}\n"
            f"Time = 0.5\nNumberOfBaryonFields = 1\nFieldType = 0\nBaryonFileName = ./{name}/{name}.cpu0000\n"
        )
        if number == 1:
            text += "Pointer: Grid[1]->NextGridThisLevel = 0\nPointer: Grid[1]->NextGridNextLevel = 2\n"
        else:
            text += "Pointer: Grid[2]->NextGridNextLevel = 0\nPointer: Grid[2]->NextGridThisLevel = 0\n"
    write(text, "amr/seeds/enzo", name + ".hierarchy")
    with hdf5("amr/seeds/enzo", name + ".cpu0000") as file:
        for number, (cells, _, _) in enumerate(grids, 1):
            values = np.arange(np.prod(cells), dtype="<f8").reshape(cells[::-1])
            file.create_group(f"Grid{number:08}")["Density"] = values


def amrex(name, byte_order, header_version):
    boxes = [["((0,0,0) (3,3,3) (0,0,0))"], ["((0,0,0) (3,3,3) (0,0,0))", "((4,0,0) (7,3,3) (0,0,0))"]]
    cells = [64, 64]
    write(
        "HyperCLaw-V1.1\n1\nphi\n3\n0.5\n1\n0 0 0\n1 1 1\n2\n((0,0,0) (3,3,3) (0,0,0)) ((0,0,0) (7,7,7) (0,0,0))\n0 0\n"
        "0.25 0.25 0.25\n0.125 0.125 0.125\n0\n0\n"
        + "".join(
            f"{level} {len(of)} 0.5\n0\n" + "0 1\n0 1\n0 1\n" * len(of) + f"Level_{level}/Cell\n"
            for level, of in enumerate(boxes)
        ),
        "amr/seeds", name, "Header",
    )
    order = "(8 7 6 5 4 3 2 1)" if byte_order == "<" else "(1 2 3 4 5 6 7 8)"
    for level, of in enumerate(boxes):
        data, places = b"", ""
        for box in of:
            places += f"FabOnDisk: Cell_D_00000 {len(data)}\n"
            if header_version == 1:
                data += f"FAB ((8, (64 11 52 0 1 12 0 1023)),(8, {order})){box} 1\n".encode()
            data += np.arange(cells[level], dtype=byte_order + "f8").tobytes()
        table = f"{len(of)},1\n" + "0,\n" * len(of) + "\n"
        end = {1: table + table, 2: f"((8, (64 11 52 0 1 12 0 1023)),(8, {order}))\n"}[header_version]
        head = f"{header_version}\n1\n1\n0\n({len(of)} 0\n" + "\n".join(of) + f"\n)\n{len(of)}\n{places}\n"
        write(head + end, "amr/seeds", name, f"Level_{level}/Cell_H")
        write(data, "amr/seeds", name, f"Level_{level}/Cell_D_00000")


def vtkhdf():
    with hdf5("amr/seeds/vtkhdf_chunked/a.vtkhdf") as file:
        vtk = file.create_group("VTKHDF")
        vtk.attrs["Type"] = np.bytes_("OverlappingAMR")
        vtk.attrs["Version"] = [1, 0]
        vtk.attrs["GridDescription"] = np.bytes_("XYZ")
        vtk.attrs["Origin"] = [0.0, 0.0, 0.0]
        for level, boxes in enumerate([[[0, 3] * 3], [[0, 3] * 3, [4, 7, 0, 3, 0, 3]]]):
            group = vtk.create_group(f"Level{level}")
            group.attrs["Spacing"] = [0.5**level] * 3
            group["AMRBox"] = np.array(boxes, "<i4")
            count = 64 * len(boxes)
            cells = group.create_group("CellData")
            cells.create_dataset("v", data=np.arange(3.0 * count).reshape(count, 3), chunks=(40, 2), compression="gzip")
            cells["vtkGhostType"] = np.array([32] + [0] * (count - 1), "u1")
            group.create_group("PointData")["p"] = np.arange(125 * len(boxes), dtype="<f4")


def image(arrays, appended=b"", attributes=""):
    head = (
        f'<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" {attributes}>\n'
        '<ImageData WholeExtent="0 4 0 3 0 2" Origin="1 2 3" Spacing="1 .5 2"><Piece Extent="0 4 0 3 0 2">\n'
        f"{arrays}</Piece></ImageData>\n"
    )
    return head.encode() + appended + b"</VTKFile>\n"


def volumes():
    text = "<InformationKey name=\"RANGE\">7</InformationKey>" + " ".join(map(str, range(24)))
    write(image(f'<CellData><DataArray type="Int16" Name="n" format="ascii">{text}</DataArray></CellData>'),
          "volumes/seeds/vti_text/a.vti")
    data = np.arange(60, dtype="<f4").tobytes()
    inline = base64.b64encode(struct.pack("<I", len(data)) + data).decode()
    write(image(f'<PointData><DataArray type="Float32" Name="p" format="binary">{inline}</DataArray></PointData>'),
          "volumes/seeds/vti_base64/a.vti")
    blocks = [zlib.compress(data[start:start + 128]) for start in range(0, len(data), 128)]
    head = struct.pack(f"<{3 + len(blocks)}Q", len(blocks), 128, len(data) % 128, *map(len, blocks))
    array = '<PointData Scalars="p"><DataArray type="Float32" Name="p" format="appended" offset="0"/></PointData>'
    appended = b'<AppendedData encoding="raw">_' + head + b"".join(blocks) + b"</AppendedData>"
    attributes = 'header_type="UInt64" compressor="vtkZLibDataCompressor"'
    write(image(array, appended, attributes), "volumes/seeds/vti_zlib/a.vti")

    header = "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 5\nendian: little\nspacings: 1 2 .5\nencoding: {}\n\n"
    shorts = np.arange(60, dtype="<i2").tobytes()
    write(header.format("raw").encode() + shorts, "volumes/seeds/nrrd_raw/a.nrrd")
    write(header.format("gzip").encode() + gzip.compress(shorts, mtime=0), "volumes/seeds/nrrd_gzip/a.nrrd")
    write(header.format("text") + " ".join(map(str, range(60))), "volumes/seeds/nrrd_text/a.nrrd")
    os.makedirs(place("volumes/seeds/npy_fortran/a")[:-2], exist_ok=True)
    np.save(place("volumes/seeds/npy_fortran/a.npy"), np.asfortranarray(np.arange(60.0).reshape(5, 3, 4)))
    nifti = bytearray(352)
    struct.pack_into("<i", nifti, 0, 348)
    struct.pack_into("<8h", nifti, 40, 3, 4, 3, 5, 1, 1, 1, 1)
    struct.pack_into("<hh", nifti, 70, 4, 16)
    struct.pack_into("<4f", nifti, 76, 1, 1, 2, 0.5)
    struct.pack_into("<3f", nifti, 108, 352, 2, 1)
    nifti[344:348] = b"n+1\0"
    write(bytes(nifti) + shorts, "volumes/seeds/nifti/a.nii")
    write(gzip.compress(bytes(nifti) + shorts, mtime=0), "volumes/seeds/nifti_gzip/a.nii.gz")


athena("athena")
athena("athena_chunked", chunks=(1, 3, 4, 4, 4), compression="gzip")
flash()
enzo()
amrex("amrex", "<", 1)
amrex("amrex_big_endian_v2", ">", 2)
vtkhdf()
volumes()
