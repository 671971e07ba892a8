// Voxels seen from above and the side (isometric): the faces that look at the eye, painted from the
// farthest cell to the nearest.
// cells: bits of resolution^3 cells, axes x, y, z, the last fastest, the first bit the highest.
export function drawVoxels(cells, resolution, size) {
  const filled = (x, y, z) => {
    if (x < 0 || y < 0 || z < 0 || x >= resolution || y >= resolution || z >= resolution) return false;
    const index = (x * resolution + y) * resolution + z;
    return ((cells[index >> 3] >> (7 - (index & 7))) & 1) === 1;
  };
  const scale = 2;
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size * scale;
  canvas.style.width = canvas.style.height = `${size}px`;
  const pen = canvas.getContext("2d");
  const unit = (size * scale) / (2 * resolution);
  const place = (x, y, z) => [(size * scale) / 2 + (x - y) * unit * 0.866, size * scale - (x + y) * unit * 0.5 - z * unit];
  const face = (corners, shade) => {
    pen.fillStyle = pen.strokeStyle = shade;
    pen.beginPath();
    for (const corner of corners) pen.lineTo(...place(...corner));
    pen.closePath();
    pen.fill();
    pen.stroke();
  };
  for (let x = resolution - 1; x >= 0; --x) {
    for (let y = resolution - 1; y >= 0; --y) {
      for (let z = 0; z < resolution; ++z) {
        if (!filled(x, y, z)) continue;
        if (!filled(x, y, z + 1)) face([[x, y, z + 1], [x + 1, y, z + 1], [x + 1, y + 1, z + 1], [x, y + 1, z + 1]], "#8fb8d8");
        if (!filled(x - 1, y, z)) face([[x, y, z], [x, y + 1, z], [x, y + 1, z + 1], [x, y, z + 1]], "#3f7fb0");
        if (!filled(x, y - 1, z)) face([[x, y, z], [x + 1, y, z], [x + 1, y, z + 1], [x, y, z + 1]], "#5c9acb");
      }
    }
  }
  return canvas;
}
