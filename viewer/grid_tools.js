// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0

const clipRate = 30; // frames/s

function save(blob, name) {
  const address = URL.createObjectURL(blob);
  Object.assign(document.createElement('a'), { href: address, download: name }).click();
  URL.revokeObjectURL(address);
}

/** What the canvas shows, as a PNG. */
export function saveSnapshot(canvas, name) {
  canvas.toBlob((blob) => save(blob, `${name}.png`));
}

/** A button that records the canvas of `canvasOf()` from one click to the next, and saves a WebM. */
export function recordClips(button, canvasOf, nameOf) {
  let recorder = null;
  button.hidden = !window.MediaRecorder || !HTMLCanvasElement.prototype.captureStream;
  button.onclick = () => {
    if (recorder) return recorder.stop();
    const parts = [];
    recorder = new MediaRecorder(canvasOf().captureStream(clipRate), { mimeType: 'video/webm' });
    recorder.ondataavailable = ({ data }) => parts.push(data);
    recorder.onstop = () => {
      save(new Blob(parts, { type: 'video/webm' }), `${nameOf()}.webm`);
      recorder = null;
      button.textContent = 'Clip';
    };
    recorder.start();
    button.textContent = 'End clip';
  };
}

/** The way that the vehicle has gone since the last jump of the player. */
export class Path {
  #points = [];
  #stamp = -Infinity; // stamp of the last point
  #kept = 5000;
  #gap = 1; // s: longer is a jump

  add(stamp, [x, y]) {
    if (stamp < this.#stamp || stamp > this.#stamp + this.#gap) this.#points = [];
    this.#points.push([x, y]);
    this.#stamp = stamp;
    if (this.#points.length > this.#kept) this.#points.shift();
  }

  /** In a context whose coordinates are the world's. */
  trace(context) {
    for (const point of this.#points) context.lineTo(...point);
  }
}
