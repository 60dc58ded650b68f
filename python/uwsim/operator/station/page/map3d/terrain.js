// The true bed as a shaded mesh in a muted colour, so that the map stands out.
import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
} from '../vendor/three.js';

const MOST = 192; // maximum vertices along an axis; more would be invisible, but slow every frame
const DEEP = [22, 36, 50]; // sRGB
const SHOAL = [74, 92, 100];
const LAND = [70, 82, 62];

// heights: rows from the south, each from the west. Return { mesh, low_m, high_m, height(x, y) }.
export function makeTerrain(heights, { rows, columns, west_m, south_m, spacing_m: [dx, dy] }, drop_m) {
  const step = Math.max(1, Math.ceil(Math.max(rows, columns) / MOST));
  const [wide, tall] = [Math.floor((columns - 1) / step) + 1, Math.floor((rows - 1) / step) + 1];
  const at = (i, j) => heights[Math.min(j * step, rows - 1) * columns + Math.min(i * step, columns - 1)];
  let [low, high] = [Infinity, -Infinity];
  for (const z of heights) if (z < low) low = z;
  for (const z of heights) if (z > high) high = z;
  const top = Math.min(high, 0);
  const positions = new Float32Array(wide * tall * 3);
  const colours = new Uint8Array(wide * tall * 3);
  for (let j = 0, k = 0; j < tall; j += 1) {
    for (let i = 0; i < wide; i += 1, k += 3) {
      const z = at(i, j);
      positions.set([west_m + i * step * dx, south_m + j * step * dy, (Number.isNaN(z) ? low : z) - drop_m], k);
      const east = (at(Math.min(i + 1, wide - 1), j) - at(Math.max(i - 1, 0), j)) / (2 * step * dx);
      const north = (at(i, Math.min(j + 1, tall - 1)) - at(i, Math.max(j - 1, 0))) / (2 * step * dy);
      const light = Math.max(0.2, (1 + 0.9 * east - 1.1 * north) / Math.hypot(1, east, north) / 1.25);
      const share = Math.max(0, Math.min(1, (z - low) / Math.max(top - low, 0.1)));
      for (let c = 0; c < 3; c += 1) {
        const colour = z > 0 ? LAND[c] : DEEP[c] + (SHOAL[c] - DEEP[c]) * share;
        colours[k + c] = linear(Math.min(255, colour * light));
      }
    }
  }
  const mesh = new Mesh(
    grid(positions, colours, wide, tall, at),
    new MeshBasicMaterial({
      vertexColors: true,
      side: DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 2,
      polygonOffsetUnits: 8,
    }),
  );
  return { mesh, low_m: low, high_m: top };
}

// sRGB to linear light, both 0 to 255, as three.js needs a vertex's colour.
const linear = (value) => Math.round(255 * (value / 255) ** 2.2);

function grid(positions, colours, wide, tall, at) {
  const index = [];
  for (let j = 0; j + 1 < tall; j += 1) {
    for (let i = 0; i + 1 < wide; i += 1) {
      const [a, b] = [j * wide + i, (j + 1) * wide + i];
      if ([at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)].some(Number.isNaN)) continue;
      index.push(a, a + 1, b, b, a + 1, b + 1);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('color', new BufferAttribute(colours, 3, true));
  geometry.setIndex(new BufferAttribute(new Uint32Array(index), 1));
  return geometry;
}

// Give a mesh's faces normals of their own, without which they would be black.
export function faceted(mesh) {
  const plain = mesh.geometry.index ? mesh.geometry.toNonIndexed() : mesh.geometry;
  plain.computeVertexNormals();
  mesh.geometry = plain;
}

// The water's surface as a grid of lines 50 m apart, which shows the scale.
export function makeSurface({ rows, columns, west_m, south_m, spacing_m: [dx, dy] }, height_m) {
  const [east, north] = [west_m + (columns - 1) * dx, south_m + (rows - 1) * dy];
  const points = [];
  for (let x = Math.ceil(west_m / 50) * 50; x <= east; x += 50) points.push(x, south_m, height_m, x, north, height_m);
  for (let y = Math.ceil(south_m / 50) * 50; y <= north; y += 50) points.push(west_m, y, height_m, east, y, height_m);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  return new LineSegments(geometry, new LineBasicMaterial({ color: 0x4f93b5, transparent: true, opacity: 0.28 }));
}
