"""MSH files of a bar of two parts, written by hand."""
import itertools

import numpy


def two_part_bar(n=8):
    """Nodes and tetrahedra (with a part, 1 or 2) of a bar 200 x 20 x 20 mm of two halves."""
    nodes = [(0.2 * i / n, 0.02 * j, 0.02 * k) for i in range(n + 1) for j in (0, 1) for k in (0, 1)]
    tetrahedra = []
    for i in range(n):
        for path in itertools.permutations(range(3)):  # Kuhn's six tetrahedra of a cell
            corner = [0, 0, 0]
            tet = []
            for axis in (None, *path):
                if axis is not None:
                    corner[axis] = 1
                tet.append((i + corner[0]) * 4 + corner[1] * 2 + corner[2])
            a, b, c, d = (numpy.array(nodes[t]) for t in tet)
            if numpy.dot(numpy.cross(b - a, c - a), d - a) < 0:
                tet[2], tet[3] = tet[3], tet[2]
            tetrahedra.append((1 if i < n // 2 else 2, tet))
    return nodes, tetrahedra


GROUPS = '$PhysicalNames\n2\n3 1 "left"\n3 2 "right"\n$EndPhysicalNames\n'


def msh_2(nodes, tetrahedra):
    lines = ["$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + GROUPS + f"$Nodes\n{len(nodes)}"]
    lines += ["%d %.12g %.12g %.12g" % (i + 1, *p) for i, p in enumerate(nodes)]
    lines.append(f"$EndNodes\n$Elements\n{len(tetrahedra)}")
    lines += ["%d 4 2 %d %d %d %d %d %d" % (i + 1, part, part, *(t + 1 for t in tet))
              for i, (part, tet) in enumerate(tetrahedra)]
    return "\n".join(lines) + "\n$EndElements\n"


def msh_4(nodes, tetrahedra):
    box = "0 0 0 0.2 0.02 0.02"
    lines = ["$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + GROUPS + "$Entities\n0 0 0 2",
             f"1 {box} 1 1 0\n2 {box} 1 2 0\n$EndEntities",
             f"$Nodes\n1 {len(nodes)} 1 {len(nodes)}\n3 1 0 {len(nodes)}"]
    lines += [str(i + 1) for i in range(len(nodes))]
    lines += ["%.12g %.12g %.12g" % p for p in nodes]
    lines.append(f"$EndNodes\n$Elements\n2 {len(tetrahedra)} 1 {len(tetrahedra)}")
    number = 0
    for part in (1, 2):
        own = [tet for p, tet in tetrahedra if p == part]
        lines.append(f"3 {part} 4 {len(own)}")
        for tet in own:
            number += 1
            lines.append("%d %d %d %d %d" % (number, *(t + 1 for t in tet)))
    return "\n".join(lines) + "\n$EndElements\n"
