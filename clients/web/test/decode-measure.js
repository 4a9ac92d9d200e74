// Times the decoder, in whichever engine runs this: for Node and for a page.

import { Decoder } from '../src/decode.js';

/**
 * @param {ArrayBuffer[]} frames in sending order
 * @param {number} rounds how often all of them are decoded
 * @returns {{kind: string, ticks: number, samples: number, bytes: number, p50: number, p95: number, steady95: number}[]}
 *   `steady95` is the 95th percentile over ticks of the median over rounds: what a tick takes when nothing interrupts it
 */
export function measure(frames, rounds) {
  const kinds = new Map();
  for (let round = -1; round < rounds; round++) {
    const decoder = new Decoder(2 ** 25);
    for (let i = 0; i < frames.length;) {
      const began = performance.now();
      const first = decoder.decode(frames[i++]);
      let samples = first.channels * first.n * first.n, { bytes } = first;
      while (i < frames.length && tickOf(frames[i]) === first.tick) {
        const frame = decoder.decode(frames[i++]);
        samples += frame.channels * frame.n * frame.n;
        bytes += frame.bytes;
      }
      const ms = performance.now() - began;
      if (round < 0) continue; // until the engine has compiled it
      const kind = first.depth === 0 ? 'depth 0' : first.depth < 3 ? `depth ${first.depth}` : first.depth === 3 ? 'layer 0' : 'layers 1 and 2';
      for (const name of [kind, 'all']) {
        if (!kinds.has(name)) kinds.set(name, { kind: name, ms: [], ofTick: new Map(), samples: 0, bytes: 0 });
        const of = kinds.get(name);
        of.ms.push(ms);
        of.ofTick.set(first.tick, [...of.ofTick.get(first.tick) ?? [], ms]);
        of.samples += samples;
        of.bytes += bytes;
      }
    }
  }
  return [...kinds.values()].map(({ kind, ms, ofTick, samples, bytes }) => {
    const medians = [...ofTick.values()].map((rounds) => at(rounds, 0.5));
    return {
      kind, ticks: ms.length, samples: samples / ms.length, bytes: bytes / ms.length,
      p50: at(ms, 0.5), p95: at(ms, 0.95), steady95: at(medians, 0.95),
    };
  });
}

function at(values, share) {
  values.sort((a, b) => a - b);
  return values[Math.min(values.length - 1, Math.floor(values.length * share))];
}

function tickOf(buffer) {
  return Number(new DataView(buffer).getBigUint64(24, true));
}
