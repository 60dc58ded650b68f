// Blocks of voxels as points: position and shade in four bytes per point. Coarser levels OR 2, 4 or 8 voxels per axis.
import { BLOCK_EDGE } from '../wire/messages.js';

export const CHUNK_BLOCKS = 8; // along an axis
export const CHUNK_CELLS = CHUNK_BLOCKS * BLOCK_EDGE; // 128, which fits in a byte
export const LEVELS = 4;

const tops = new Int16Array(CHUNK_CELLS * CHUNK_CELLS);
const seen = new Uint8Array(BLOCK_EDGE ** 3);
const LIGHT = [-0.5, 0.62]; // from the north-west, as maps are shaded

// Return Uint8Array of (x, y, z, shade), cells of the level within the chunk whose first block is at (cx, cy, cz).
export function bake(blocks, [cx, cy, cz], level) {
  const wide = CHUNK_CELLS >> level;
  const cells = [];
  tops.fill(-1, 0, wide * wide);
  for (const block of blocks) {
    const [bx, by, bz] = [
      (block.x - cx) * (BLOCK_EDGE >> level),
      (block.y - cy) * (BLOCK_EDGE >> level),
      (block.z - cz) * (BLOCK_EDGE >> level),
    ];
    reduced(block.rows, level, (x, y, z) => {
      const column = (by + y) * wide + bx + x;
      cells.push(bx + x, by + y, bz + z);
      if (bz + z > tops[column]) tops[column] = bz + z;
    });
  }
  const points = new Uint8Array((cells.length / 3) * 4);
  for (let from = 0, to = 0; from < cells.length; from += 3, to += 4) {
    const [x, y, z] = [cells[from], cells[from + 1], cells[from + 2]];
    points[to] = x;
    points[to + 1] = y;
    points[to + 2] = z;
    points[to + 3] = shade(x, y, wide);
  }
  return points;
}

// Call visit for each cell of the level in which at least one voxel is occupied.
function reduced(rows, level, visit) {
  const edge = BLOCK_EDGE >> level;
  if (level > 0) seen.fill(0, 0, edge ** 3);
  for (let row = 0; row < rows.length; row += 1) {
    const [y, z] = [(row & 0xf) >> level, (row >> 4) >> level];
    for (let bits = rows[row]; bits; bits &= bits - 1) {
      const x = (31 - Math.clz32(bits & -bits)) >> level;
      if (level > 0) {
        const index = (z * edge + y) * edge + x;
        if (seen[index]) continue;
        seen[index] = 1;
      }
      visit(x, y, z);
    }
  }
}

// Return the light on the slope of the surrounding columns, 0 to 255.
function shade(x, y, wide) {
  const here = tops[y * wide + x];
  const height = (i, j) => {
    const top = i >= 0 && j >= 0 && i < wide && j < wide ? tops[j * wide + i] : -1;
    return top < 0 ? here : top;
  };
  const east = Math.max(-4, Math.min(4, (height(x + 2, y) - height(x - 2, y)) / 4));
  const north = Math.max(-4, Math.min(4, (height(x, y + 2) - height(x, y - 2)) / 4));
  const light = (1 - east * LIGHT[0] - north * LIGHT[1]) / Math.hypot(1, east, north) / Math.hypot(1, ...LIGHT);
  return Math.round(255 * Math.max(0.1, Math.min(1, light * 1.05)));
}
