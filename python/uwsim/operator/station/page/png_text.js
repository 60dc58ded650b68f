// Text in a PNG file: iTXt chunks (PNG, third edition, 11.3.3.4) after its header.
const AFTER_HEADER = 33; // the signature, and the chunk IHDR

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit += 1) value = value & 1 ? 0xedb88320 ^ (value >>> 1) : value >>> 1;
  return value;
});

// The CRC-32 of ISO 3309, as in PNG and zip.
export function crc32(bytes) {
  let value = 0xffffffff;
  for (const byte of bytes) value = TABLE[(value ^ byte) & 0xff] ^ (value >>> 8);
  return (value ^ 0xffffffff) >>> 0;
}

function chunk(keyword, text) {
  // After the keyword: not compressed, no language, no translated keyword.
  const body = new TextEncoder().encode(`iTXt${keyword}\0\0\0\0\0${text}`);
  const bytes = new Uint8Array(body.length + 8);
  bytes.set(body, 4);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, body.length - 4);
  view.setUint32(body.length + 4, crc32(body));
  return bytes;
}

// Return the bytes of a PNG with texts, by keyword.
export function withText(png, texts) {
  const chunks = Object.entries(texts).map(([keyword, text]) => chunk(keyword, text));
  const parts = [png.subarray(0, AFTER_HEADER), ...chunks, png.subarray(AFTER_HEADER)];
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}
