// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
import { MessageReader } from './cdr.js';

const headerBytes = 8; // channel and length of a message, 32 bits each

/** Bytes that `stereogrid export --web` has compressed. */
export async function inflated(base64) {
  const packed = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * A run within the page, as `stereogrid export --web` writes it: the interface of Connection, without a server. It also plays
 * as `stereogrid view` does (parameters "player.*").
 */
export class Recording extends EventTarget {
  #receivers = new Map(); // topic → function
  #timer = 0;
  #shown = -1; // the frame whose messages were given last
  #player = { frame: 0, time_s: 0, playing: false, speed: 1, frames: 0, duration_s: 0 };

  /**
   * `frames`: of each frame the messages, as bytes, or compressed and in base64; `stamps`: in seconds; `channels`: {topic, type,
   * definition}.
   */
  constructor(recorded) {
    super();
    this.#set(recorded);
  }

  /** Shows another run in place of this one. */
  replace(recorded) {
    this.#set(recorded);
    return this.open();
  }

  #set({ name, channels, stamps, frames }) {
    Object.assign(this, { name, stamps, frames });
    this.channels = channels.map(({ topic, type, definition }) => ({ topic, reader: new MessageReader(type, definition) }));
    Object.assign(this.#player, { frame: 0, frames: frames.length, duration_s: stamps.at(-1) - stamps[0] });
  }

  async open() {
    this.#notify('channels', this.channels.map(({ topic }) => topic));
    await this.#show(0); // its messages hold for later frames that do not repeat them
    this.#notify('state', 'connected');
    this.#notifyPlayer();
  }

  subscribe(topic, receive) {
    this.#receivers.set(topic, receive);
  }

  unsubscribe(topic) {
    this.#receivers.delete(topic);
  }

  watchParameters() {}

  setParameter(name, value) {
    const { frames } = this.#player;
    if (name === 'player.playing') {
      this.#player.playing = value;
      if (value && this.#player.frame === frames - 1) this.#goTo(0);
    }
    if (name === 'player.speed') this.#player.speed = value;
    if (name === 'player.frame') this.#goTo(Math.min(frames - 1, Math.max(0, value)));
    if (name === 'player.time_s') {
      const later = this.stamps.findIndex((stamp) => stamp - this.stamps[0] > value + 1e-9);
      this.#goTo(later < 0 ? frames - 1 : Math.max(0, later - 1));
    }
    this.#schedule();
  }

  #notify(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  #notifyPlayer() {
    for (const [name, value] of Object.entries(this.#player)) this.#notify('parameter', { name: `player.${name}`, value });
  }

  #schedule() {
    clearTimeout(this.#timer);
    const { frame, frames, speed } = this.#player;
    if (frame === frames - 1) this.#player.playing = false;
    this.#notifyPlayer();
    if (!this.#player.playing) return;
    const gap = (this.stamps[frame + 1] - this.stamps[frame]) / speed;
    this.#timer = setTimeout(() => { this.#goTo(frame + 1); this.#schedule(); }, 1000 * gap);
  }

  #goTo(frame) {
    this.#player.frame = frame;
    this.#player.time_s = this.stamps[frame] - this.stamps[0];
    this.#notifyPlayer();
    this.#show(frame);
  }

  async #show(frame) {
    try {
      const packed = this.frames[frame];
      const bytes = typeof packed === 'string' ? await inflated(packed) : packed;
      if (frame !== this.#player.frame && this.#shown >= 0) return; // another one is due by now
      this.#shown = frame;
      this.#give(bytes, this.stamps[frame]);
    } catch (error) {
      this.#notify('fault', `frame ${frame}: ${error.message}`);
    }
  }

  #give(bytes, stamp) {
    const view = new DataView(bytes.buffer);
    for (let at = 0; at < bytes.length;) {
      const { topic, reader } = this.channels[view.getUint32(at, true)];
      const end = at + headerBytes + view.getUint32(at + 4, true);
      this.#receivers.get(topic)?.(reader.read(bytes.subarray(at + headerBytes, end)), stamp);
      at = end;
    }
  }
}
