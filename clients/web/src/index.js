// @swellcast/client: what a program needs to show, or float on, the sea of a server.

/**
 * @typedef {import('./client.js').Events} Events
 * @typedef {import('./clock.js').Exchange} Exchange
 * @typedef {import('./connection.js').Listener} Listener
 * @typedef {import('./decode.js').DecodedFrame} DecodedFrame
 * @typedef {import('./fares.js').Report} Report
 * @typedef {import('./frame.js').Frame} Frame
 * @typedef {import('./gl.js').Gpu} Gpu
 * @typedef {import('./messages.js').Cascade} Cascade
 * @typedef {import('./messages.js').Hello} Hello
 * @typedef {import('./messages.js').Message} Message
 * @typedef {import('./messages.js').Status} Status
 * @typedef {import('./plan.js').Plan} Plan
 * @typedef {import('./plan.js').Wish} Wish
 * @typedef {import('./playback.js').Sampled} Sampled
 */

export { Client, connect } from './client.js';
export { Clock } from './clock.js';
export { Connection } from './connection.js';
export { Decoder, decodeFrame } from './decode.js';
export { Fields, meanSquareSlope } from './fields.js';
export { CLASSES, CODECS, FrameError, GROUPS } from './frame.js';
export { gpuOf } from './gl.js';
export { TICKS_PER_SECOND } from './messages.js';
export { Playback } from './playback.js';
