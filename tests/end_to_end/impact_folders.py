"""Folders in RealImpact's layout, made from a plate whose material is known."""
import h5py
import numpy

RATE = 48000
# Two of the gantry's distances, three angles and three microphones of its column.
ANGLES, DISTANCES, MICROPHONES = (0, 40, 80), (0, 333), (5, 7, 9)
MICROPHONE_STEP = 1.82 / 14


# Of the plate's upper face: it looks at the microphones, not past them.
NORMAL = numpy.array([numpy.sin(1.0), 0, numpy.cos(1.0)])


def plate(length, width, thickness, cells=(8, 6)):
    """Vertices and triangles of a closed box whose large faces have inner vertices, turned so that
    the upper one has NORMAL."""
    nx, ny = cells
    x = numpy.linspace(-length / 2, length / 2, nx + 1)
    y = numpy.linspace(-width / 2, width / 2, ny + 1)
    vertices = [(a, b, side * thickness / 2) for side in (-1, 1) for b in y for a in x]
    below = lambda i, j: j * (nx + 1) + i
    above = lambda i, j: below(i, j) + (nx + 1) * (ny + 1)
    quads = []
    for i in range(nx):
        for j in range(ny):
            quads.append((below(i, j), below(i, j + 1), below(i + 1, j + 1), below(i + 1, j)))
            quads.append((above(i, j), above(i + 1, j), above(i + 1, j + 1), above(i, j + 1)))
    for i in range(nx):
        quads.append((below(i, 0), below(i + 1, 0), above(i + 1, 0), above(i, 0)))
        quads.append((below(i + 1, ny), below(i, ny), above(i, ny), above(i + 1, ny)))
    for j in range(ny):
        quads.append((below(0, j + 1), below(0, j), above(0, j), above(0, j + 1)))
        quads.append((below(nx, j), below(nx, j + 1), above(nx, j + 1), above(nx, j)))
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    turn = numpy.array([[NORMAL[2], 0, NORMAL[0]], [0, 1, 0], [-NORMAL[0], 0, NORMAL[2]]])
    return numpy.array(vertices) @ turn.T, numpy.array(triangles)


def obj_text(vertices, triangles):
    lines = ["v %.9g %.9g %.9g" % tuple(v) for v in vertices]
    return "\n".join(lines + ["f %d %d %d" % tuple(t + 1) for t in triangles]) + "\n"


def microphones():
    """(angle, distance, number, position) of each, numbers first, as the dataset's rows go."""
    rows = []
    for angle in ANGLES:
        for distance in DISTANCES:
            for number in MICROPHONES:
                radius = 0.23 + distance / 1000
                turn = numpy.radians(angle)
                rows.append((angle, distance, number,
                             (radius * numpy.cos(turn), radius * numpy.sin(turn),
                              (number - 7) * MICROPHONE_STEP)))
    return rows


def shapes_at(modes, position):
    """Mode shapes at a point of the upper face, which need not be a node: the quadratic polynomial
    in the plane that fits those at the 14 nearest nodes of that face."""
    nodes = modes["surface/nodes"][:]
    face = numpy.flatnonzero(abs((nodes - position) @ NORMAL) < 1e-5)
    away = numpy.linalg.norm(nodes[face] - position, axis=1)
    near = face[numpy.argsort(away)[:14]]
    across = numpy.array([0.0, 1.0, 0.0])
    x, y = ((nodes[near] - position) @ axis for axis in (across, numpy.cross(NORMAL, across)))
    scale = numpy.abs([x, y]).max()
    x, y = x / scale, y / scale
    terms = numpy.stack([x ** 0, x, y, x * x, x * y, y * y], axis=1)
    values = modes["shapes"][:][:, near, :].astype(float)
    fits = numpy.linalg.lstsq(terms, values.transpose(1, 0, 2).reshape(len(near), -1), rcond=None)
    return fits[0][0].reshape(len(values), 3)


def ringing(modes_file, position, inward, decay_of, seconds, delay):
    """Acceleration of a point along its outward normal after an impulse of 1 N s, from the modes in
    a file: q'' of each mode in closed form, `delay` seconds late."""
    with h5py.File(modes_file) as modes:
        shapes = shapes_at(modes, position)
        eigenvalues = modes["eigenvalues"][:]
    time = numpy.arange(round(seconds * RATE)) / RATE - delay
    rings = time >= 0
    time = time[rings]
    sound = numpy.zeros(len(rings))
    for eigenvalue, shape in zip(eigenvalues, shapes):
        d = decay_of(eigenvalue)
        damped = numpy.sqrt(eigenvalue - d ** 2)
        gain = (shape @ -inward) * (shape @ inward)
        sound[rings] += gain * numpy.exp(-d * time) * (
            (d ** 2 - damped ** 2) / damped * numpy.sin(damped * time)
            - 2 * d * numpy.cos(damped * time))
    return sound


def write_folder(folder, mesh, strikes):
    """`strikes`: (vertex, sounds), a sound for each of microphones()."""
    vertices, triangles = mesh
    place = folder / "preprocessed"
    place.mkdir(parents=True)
    (place / "transformed.obj").write_text(obj_text(vertices, triangles))
    places = microphones()
    struck = [vertex for vertex, sounds in strikes for _ in sounds]
    numpy.save(place / "deconvolved_0db.npy",
               numpy.array([s for _, sounds in strikes for s in sounds], "<f4"))
    numpy.save(place / "vertexID.npy", numpy.array(struck, "<i8"))
    numpy.save(place / "vertexXYZ.npy", vertices[struck])
    labels = list(zip(*(places * len(strikes))))
    for name, values in zip(("angle", "distance", "micID"), labels):
        numpy.save(place / f"{name}.npy", numpy.array(values, "<i8"))
    numpy.save(place / "listenerXYZ.npy", numpy.array(labels[3]))
    return place
