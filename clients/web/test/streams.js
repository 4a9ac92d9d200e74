// Files of frames: each after its length, a u32.

/**
 * @param {Uint8Array} bytes
 * @returns {ArrayBuffer[]} each as a WebSocket would give it
 */
export function split(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const frames = [];
  for (let at = 0; at < bytes.length;) {
    const length = view.getUint32(at, true);
    frames.push(Uint8Array.from(bytes.subarray(at + 4, at + 4 + length)).buffer);
    at += 4 + length;
  }
  return frames;
}
