// Curved faces: Lagrange triangles over an object's vertices.
import { uint32s } from "./arrays.js";

// {triangles: straight ones, order^2 for each face; onFace(triangle, weights): vertices and weights that
// interpolate a value at a point of one of them as the finite elements do}.
// lattice: barycentric coordinates of a face's nodes times the order.
export function surfaceOf({ order, lattice, faces: text }) {
  const faces = uint32s(text);
  const nodes = lattice.length;
  const pieces = cutIn(order, lattice);
  const count = faces.length / nodes;
  const triangles = new Uint32Array(3 * count * pieces.length);
  for (let face = 0, at = 0; face < count; ++face) {
    for (const piece of pieces) for (const node of piece) triangles[at++] = faces[face * nodes + node];
  }
  const onFace = (triangle, weights) => {
    const face = Math.floor(triangle / pieces.length);
    const corners = pieces[triangle % pieces.length].map((node) => lattice[node]);
    const place = [0, 1, 2].map((k) => corners.reduce((sum, corner, i) => sum + weights[i] * corner[k], 0));
    return {
      corners: Array.from(faces.subarray(face * nodes, (face + 1) * nodes)),
      weights: lattice.map((node) => node.reduce((product, degree, k) => product * silvester(degree, place[k]), 1)),
    };
  };
  return { triangles, onFace };
}

// A face's straight triangles, as nodes.
function cutIn(order, lattice) {
  const node = new Map(lattice.map((place, index) => [place.join(), index]));
  const at = (...place) => node.get(place.join());
  const pieces = [];
  for (let j = 0; j < order; ++j) {
    for (let k = 0; j + k < order; ++k) {
      const i = order - j - k;
      pieces.push([at(i, j, k), at(i - 1, j + 1, k), at(i - 1, j, k + 1)]);
      if (i >= 2) pieces.push([at(i - 1, j + 1, k), at(i - 2, j + 1, k + 1), at(i - 1, j, k + 1)]);
    }
  }
  return pieces;
}

// Silvester's polynomial: 1 at `degree`, 0 at the whole numbers below it.
function silvester(degree, place) {
  let product = 1;
  for (let s = 0; s < degree; ++s) product *= (place - s) / (s + 1);
  return product;
}

// Twice the volume over the surface [m]: of a plate, and of the walls of what is hollow, about their thickness.
export function meanThickness({ vertices, triangles }) {
  let [volume, area] = [0, 0];
  for (let at = 0; at < triangles.length; at += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => vertices.subarray(3 * triangles[at + k], 3 * triangles[at + k] + 3));
    const [u, v] = [b, c].map((corner) => [0, 1, 2].map((k) => corner[k] - a[k]));
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    area += Math.hypot(...normal) / 2;
    volume += (a[0] * normal[0] + a[1] * normal[1] + a[2] * normal[2]) / 6;
  }
  return (2 * Math.abs(volume)) / area;
}
