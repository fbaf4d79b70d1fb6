// SPDX-License-Identifier: Apache-2.0
import { connection } from './main.js';
import { inflated } from './recording.js';

const panel = document.getElementById('pair');
const outcome = document.getElementById('outcome');
const data = JSON.parse(document.getElementById('playground').textContent); // made by scripts/playground.py
const compiled = inflated(data.wasm).then((bytes) => WebAssembly.compile(bytes));

/**
 * Messages of a first frame, as a recording: {name, channels, stamps, frames}. `left`, `right`: ImageData of one size; `jpeg`: the
 * left image; `rig`: numbers as in calibration.yaml; without camera_height_m the extrinsics are estimated. Each call has an
 * instance of its own: after an error nothing of it may be used.
 */
async function computed(left, right, jpeg, rig) {
  if (left.width !== right.width || left.height !== right.height) {
    throw new Error(`The images differ in size: ${left.width} × ${left.height} and ${right.width} × ${right.height} px.`);
  }
  const channels = [];
  const parts = [];
  const bytesAt = (at, size) => new Uint8Array(memory.buffer, at, size);
  const textAt = (at, size) => new TextDecoder().decode(bytesAt(at, size));
  const page = {
    add: (topic, topicSize, type, typeSize, definition, definitionSize) => channels.push(
      { topic: textAt(topic, topicSize), type: textAt(type, typeSize), definition: textAt(definition, definitionSize) }),
    send: (channel, at, size) => parts.push(new Uint32Array([channel, size]), bytesAt(at, size).slice()),
    fail: (at, size) => { throw new Error(textAt(at, size)); },
  };
  const noFile = () => 8; // EBADF
  const wasi_snapshot_preview1 = { fd_close: noFile, fd_seek: noFile, fd_write: noFile, clock_time_get: (clock, precision, at) => {
    new DataView(memory.buffer).setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true);
    return 0;
  } };
  const { exports } = await WebAssembly.instantiate(await compiled, { page, wasi_snapshot_preview1 });
  const { memory, allocate, process } = exports;
  const placed = (bytes) => {
    const at = allocate(bytes.length);
    if (at === 0) throw new Error('There is too little memory for these images.');
    bytesAt(at, bytes.length).set(bytes);
    return at;
  };
  exports._initialize();
  process(placed(left.data), placed(right.data), left.width, left.height, placed(jpeg), jpeg.length, rig.focal_px, rig.cx_px, rig.cy_px,
    rig.baseline_m, rig.camera_height_m, rig.camera_pitch_rad || 0, rig.camera_roll_rad || 0, panel.elements.preset.value === 'robot');
  return { channels, stamps: [0], frames: [new Uint8Array(await new Blob(parts).arrayBuffer())] };
}

/** A file's pixels as they are stored, and as a JPEG. */
async function decoded(file) {
  const bitmap = await createImageBitmap(file, { colorSpaceConversion: 'none' })
    .catch(() => { throw new Error(`${file.name} is no image that this browser reads.`); });
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(bitmap, 0, 0);
  const jpeg = await canvas.convertToBlob({ type: 'image/jpeg', quality: 0.8 });
  return { pixels: context.getImageData(0, 0, canvas.width, canvas.height), jpeg: new Uint8Array(await jpeg.arrayBuffer()) };
}

/** Numbers of a calibration.yaml, or of KITTI's calib.txt (grey cameras), by the keys of the former. */
function calibrationIn(text) {
  const [left, right] = ['0', '1'].map((camera) => new RegExp(`^P(?:_rect_0)?${camera}:(.*)$`, 'm').exec(text)?.[1].trim().split(/\s+/).map(Number));
  if (left?.length === 12 && right?.length === 12) {
    return { focal_px: left[0], cx_px: left[2], cy_px: left[6], baseline_m: (left[3] - right[3]) / left[0] };
  }
  const found = Object.fromEntries([...text.matchAll(/(\w+): *([-+\d.eE]+)/g)].map(([, key, value]) => [key, Number(value)]));
  const missing = ['focal_px', 'cx_px', 'cy_px', 'baseline_m'].filter((key) => !Number.isFinite(found[key]));
  if (missing.length > 0) throw new Error(`The calibration has neither ${missing.join(', ')}, as calibration.yaml, nor P0 and P1, as KITTI's calib.txt.`);
  return found;
}

const rigFields = [...panel.querySelectorAll('input[type=number]')];
let calibratedSize = {}; // {width_px, height_px} of the calibration; missing: unknown

function fill(calibration) {
  for (const field of rigFields) field.value = calibration[field.name] ?? '';
  calibratedSize = { width_px: calibration.width_px, height_px: calibration.height_px };
}

/** Numbers of the fields; the principal point is the middle where it is left out. */
function rigFor({ width, height }) {
  const { width_px = width, height_px = height } = calibratedSize;
  if (width_px !== width || height_px !== height) {
    throw new Error(`The calibration is for ${width_px} × ${height_px} px, the images have ${width} × ${height} px.`);
  }
  const rig = Object.fromEntries(rigFields.map((field) => [field.name, field.valueAsNumber]));
  if (Number.isNaN(rig.focal_px) || Number.isNaN(rig.baseline_m)) throw new Error('Give the focal length and the baseline, or a calibration.');
  if (Number.isNaN(rig.camera_height_m) && (rig.camera_pitch_rad || rig.camera_roll_rad)) {
    throw new Error('Give the height of the camera, too, or neither pitch nor roll: all three are then estimated.');
  }
  if (Number.isNaN(rig.cx_px)) rig.cx_px = (width - 1) / 2;
  if (Number.isNaN(rig.cy_px)) rig.cy_px = (height - 1) / 2;
  return rig;
}

function report(text, isFault = false) {
  outcome.textContent = text;
  outcome.classList.toggle('fault', isFault);
}

let pair = {}; // files by the names of their fields
async function compute() {
  try {
    if (!pair.left || !pair.right) throw new Error('Give a left and a right image.');
    report('Computing …');
    const [left, right] = await Promise.all([pair.left, pair.right].map(decoded));
    const rig = rigFor(left.pixels);
    await compiled;
    await new Promise((resolve) => setTimeout(resolve, 20)); // to be painted
    const begin = performance.now();
    const recorded = await computed(left.pixels, right.pixels, left.jpeg, rig);
    const seconds = (performance.now() - begin) / 1000;
    await connection.replace({ name: pair.left.name, ...recorded });
    requestAnimationFrame(() => document.getElementById('home').click()); // when the new grid is drawn
    report(`Computed in ${seconds.toFixed(2)} s, in this page: nothing is uploaded.`);
  } catch (error) {
    report(error instanceof WebAssembly.RuntimeError ? `The computation has stopped: ${error.message}.` : error.message, true);
  }
}

/** Images in the order of their names, left first; and a calibration. */
async function receive(files) {
  try {
    const text = files.find(({ name }) => /\.(ya?ml|txt)$/i.test(name));
    if (text) fill(calibrationIn(await text.text()));
    const images = files.filter((file) => file !== text).sort((a, b) => (a.name < b.name ? -1 : 1));
    if (images.length === 2) [pair.left, pair.right] = images;
    else if (images.length > 0) throw new Error('Drop two images at a time, left and right.');
    report([pair.left?.name, pair.right?.name].filter(Boolean).join(', '));
  } catch (error) {
    report(error.message, true);
  }
}

async function useSample() {
  const fileOf = async (name) => new File([await (await fetch(`data:image/png;base64,${data[name]}`)).blob()], `${name}.png`, { type: 'image/png' });
  pair = { left: await fileOf('left'), right: await fileOf('right') };
  fill(calibrationIn(data.calibration));
  await compute();
}

for (const name of ['left', 'right']) {
  panel.elements[name].addEventListener('change', ({ target }) => { [pair[name]] = target.files; });
}
for (const field of rigFields) field.addEventListener('input', () => { calibratedSize = {}; });
panel.elements.calibration.addEventListener('change', ({ target }) => receive([...target.files]));
panel.elements.sample.addEventListener('click', useSample);
panel.addEventListener('submit', (event) => { event.preventDefault(); compute(); });
document.addEventListener('dragover', (event) => event.preventDefault());
document.addEventListener('drop', (event) => { event.preventDefault(); receive([...event.dataTransfer.files]); });
