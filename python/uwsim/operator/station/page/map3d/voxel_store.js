// The occupied voxels of the map, in blocks of 16 x 16 x 16 bits, as they are transmitted.

import { BLOCK_EDGE } from '../wire/messages.js';

const ROWS = BLOCK_EDGE * BLOCK_EDGE; // one 16-bit row of x for each y and z
const OCCUPIED = 0x8000;

const keyOf = (x, y, z) => (x + 32768) * 2 ** 32 + (y + 32768) * 65536 + (z + 32768);

export class VoxelStore {
  #blocks = new Map(); // key: { x, y, z, rows: Uint16Array }
  count = 0;
  resolution_m = 0;
  sequence = -1;

  get blocks() {
    return this.#blocks.values();
  }

  block(x, y, z) {
    return this.#blocks.get(keyOf(x, y, z));
  }

  clear() {
    this.#blocks.clear();
    this.count = 0;
  }

  // Apply a uwsim_msgs/MapChanges; return the changed blocks.
  apply({ snapshot, resolution, sequence, blocks, counts, cells }) {
    if (snapshot) this.clear();
    this.resolution_m = resolution;
    this.sequence = sequence;
    const changed = [];
    let next = 0;
    for (let k = 0; k < counts.length; k += 1) {
      const block = this.#at(blocks[3 * k], blocks[3 * k + 1], blocks[3 * k + 2]);
      for (const end = next + counts[k]; next < end; next += 1) this.#set(block.rows, cells[next]);
      changed.push(block);
    }
    return changed;
  }

  #at(x, y, z) {
    const key = keyOf(x, y, z);
    let block = this.#blocks.get(key);
    if (!block) {
      block = { x, y, z, rows: new Uint16Array(ROWS) };
      this.#blocks.set(key, block);
    }
    return block;
  }

  #set(rows, cell) {
    const row = (cell >> 4) & 0xff; // y, then z
    const bit = 1 << (cell & 0xf);
    const isSet = (rows[row] & bit) !== 0;
    if (cell & OCCUPIED) {
      if (!isSet) this.count += 1;
      rows[row] |= bit;
    } else {
      if (isSet) this.count -= 1;
      rows[row] &= ~bit;
    }
  }
}
