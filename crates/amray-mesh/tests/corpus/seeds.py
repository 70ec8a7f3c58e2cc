"""Makes the seeds of this corpus, one square of two triangles in every format: python3 seeds.py"""

import base64
import os
import struct
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.5)]
FACES = [(0, 1, 2), (0, 2, 3)]


def write(content, case, name):
    os.makedirs(os.path.join(HERE, "seeds", case), exist_ok=True)
    with open(os.path.join(HERE, "seeds", case, name), "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())


def line(numbers):
    return " ".join(map(str, numbers)) + "\n"


obj = "".join("v " + line([*p, 1, 0.5, 0]) for p in POINTS) + "vn 0 0 1\nf 1//1 2//1 3//1 4//1\nf -4 -3 \\\n-2\n"
write(obj, "obj", "a.obj")

facets = "".join(
    "facet normal 0 0 1\nouter loop\n" + "".join("vertex " + line(POINTS[n]) for n in face) + "endloop\nendfacet\n"
    for face in FACES
)
write("solid a\n" + facets + "endsolid a\n", "stl_text", "a.stl")
binary = bytes(80) + struct.pack("<I", 2)
for face in FACES:
    binary += struct.pack("<12fH", 0, 0, 1, *(x for n in face for x in POINTS[n]), 0x8123)
write(binary, "stl_binary", "a.stl")

head = (
    "ply\nformat {} 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n"
)
body = "".join(line([*p, 255, 128, 0]) for p in POINTS) + "".join(line([3, *f]) for f in FACES)
write(head.format("ascii") + body, "ply_text", "a.ply")
for name, order in [("binary_little_endian", "<"), ("binary_big_endian", ">")]:
    body = b"".join(struct.pack(order + "3f3B", *p, 255, 128, 0) for p in POINTS)
    body += b"".join(struct.pack(order + "B3i", 3, *f) for f in FACES)
    write(head.format(name).encode() + body, "ply_" + name, "a.ply")

arrays = [
    ("Points", "Float32", "Points", 3, struct.pack("<12f", *(x for p in POINTS for x in p))),
    ("Polys", "Int32", "connectivity", 1, struct.pack("<6i", *(n for f in FACES for n in f))),
    ("Polys", "Int32", "offsets", 1, struct.pack("<2i", 3, 6)),
]


def vtp(attributes, array):
    inside = {"Points": "", "Polys": ""}
    for section, kind, name, components, data in arrays:
        start, text = array(data)
        inside[section] += f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" {start}>{text}</DataArray>'
    head = f'<VTKFile type="PolyData" {attributes}><PolyData><Piece NumberOfPoints="4" NumberOfPolys="2">'
    body = "".join(f"<{section}>{text}</{section}>\n" for section, text in inside.items())
    return (head + body + "</Piece></PolyData>\n").encode()


def inline(data):
    return 'format="binary"', base64.b64encode(struct.pack("<I", len(data)) + data).decode()


store = b""


def appended(data):
    global store
    offset = len(store)
    packed = zlib.compress(data)
    store += struct.pack("<4I", 1, len(data), 0, len(packed)) + packed
    return f'format="appended" offset="{offset}"', ""


write(vtp("", inline) + b"</VTKFile>", "vtp_base64", "a.vtp")
xml = vtp('compressor="vtkZLibDataCompressor"', appended)
write(xml + b'<AppendedData encoding="raw">_' + store + b"</AppendedData></VTKFile>", "vtp_zlib", "a.vtp")
