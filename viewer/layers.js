// SPDX-License-Identifier: Apache-2.0
import { perTheme, rgb } from './theme.js';

/**
 * What the grid view draws: cells with x fastest, the corner of the smallest x and y, and for each cell a colour and a
 * text. Made of nav_msgs/OccupancyGrid, and of foxglove_msgs/Grid.
 */

const mix = (from, to, share) => from.map((value, i) => value + (to[i] - value) * share);
const clamp = (value) => Math.min(1, Math.max(0, value));

function yawOf({ x, y, z, w }) {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

/** [x, y, yaw] of a geometry_msgs/Pose. */
export const planePose = (pose) => [pose.position.x, pose.position.y, yawOf(pose.orientation)];

/** As a pixel of ImageData, whose bytes are red, green, blue, alpha. */
const packed = ([red, green, blue]) => (255 << 24) | (blue << 16) | (green << 8) | red;

/** Of an occupancy from 0 to 100, as the byte that it is in the message. */
const occupancyPixels = perTheme(() => {
  const [free, unknown, occupied] = ['--cell-free', '--cell-unknown', '--cell-occupied'].map(rgb);
  return Int32Array.from({ length: 256 }, (_, percent) => {
    if (percent > 100) return packed(unknown);
    return packed(percent < 50 ? mix(free, unknown, percent / 50) : mix(unknown, occupied, percent / 50 - 1));
  });
});

// Colours of tables, so that a cell is a look-up: grids have hundreds of thousands of them, thirty times a second.
const hues = 64;
const strengths = 32;

/** Of a cell: the pixel of the heading's colour, the stronger the faster. */
const velocityPixels = perTheme(() => {
  const unknown = packed(rgb('--cell-unknown'));
  const standing = rgb('--cell-free');
  const fastest = 10; // m/s and more have the full colour
  const leastMoving = 0.5 / (strengths - 1); // to be seen
  const wheel = Array.from({ length: 8 }, (_, i) => rgb(`--heading-${i}`));
  const table = Int32Array.from({ length: hues * strengths }, (_, i) => {
    const at = (Math.floor(i / strengths) / hues) * wheel.length;
    const heading = mix(wheel[Math.floor(at)], wheel[Math.ceil(at) % wheel.length], at % 1);
    return packed(mix(standing, heading, (i % strengths) / (strengths - 1)));
  });
  return (vx, vy, moving) => {
    if (moving !== moving) return unknown; // NaN
    if (moving < leastMoving) return table[0];
    const strength = Math.round(clamp((Math.sqrt(vx * vx + vy * vy) / fastest) * 0.75 + 0.25) * moving * (strengths - 1));
    return table[((Math.round((Math.atan2(vy, vx) / (2 * Math.PI)) * hues) + hues) % hues) * strengths + strength];
  };
});

/** Of a share from 0 to 1. */
const rampPixels = perTheme(() => {
  const [low, high, unknown] = ['--ramp-low', '--ramp-high', '--cell-unknown'].map(rgb);
  const table = Int32Array.from({ length: 256 }, (_, i) => packed(mix(low, high, i / 255)));
  const none = packed(unknown);
  return (share) => (share !== share ? none : table[Math.round(clamp(share) * 255)]);
});

/** Of an elevation, m: one colour below level ground, another above it, in full from 0.5 m on. */
const elevationPixels = perTheme(() => {
  const [below, level, above] = ['below', 'level', 'above'].map((name) => rgb(`--elevation-${name}`));
  const most = 0.5;
  const table = Int32Array.from({ length: 256 }, (_, i) => {
    const share = i / 127.5 - 1;
    return packed(mix(level, share < 0 ? below : above, Math.sqrt(Math.abs(share)))); // roots: steps of 3 cm are visible
  });
  const none = packed(rgb('--cell-unknown'));
  return (metres) => (metres !== metres ? none : table[Math.round(clamp(metres / (2 * most) + 0.5) * 255)]);
});

/** `pixelOf`: of each cell, packed. */
function bitmapOf(width, height, pixelOf) {
  const bitmap = new ImageData(width, height);
  const pixels = new Int32Array(bitmap.data.buffer);
  for (let i = 0; i < pixels.length; ++i) pixels[i] = pixelOf(i);
  return bitmap;
}

export function occupancyLayer(message) {
  const { resolution, width, height, origin } = message.info;
  const table = occupancyPixels();
  return {
    frame: message.header.frame_id,
    corner: [origin.position.x, origin.position.y],
    resolution, width, height,
    pixels: bitmapOf(width, height, (i) => table[message.data[i] & 255]),
    textOf: (i) => (message.data[i] < 0 ? 'unknown' : `occupied ${message.data[i]} %`),
  };
}

/** Of a witness byte: its kind in the lower four bits; older ones are paler. */
const witnesses = ['none', 'passable', 'ground', 'memory', 'source'];
const witnessPixels = perTheme(() => {
  const unknown = rgb('--cell-unknown');
  const kinds = witnesses.map((name) => (name === 'none' ? unknown : rgb(`--witness-${name}`)));
  return (byte) => packed(mix(kinds[byte & 15] ?? unknown, unknown, (byte >> 4) / 24));
});
const witnessText = (byte) => witnesses[byte & 15] + (byte >> 4 ? `, up to ${2 ** (byte >> 4) / 16} s ago` : '');

/** Ground over time, by TerrainClass. */
const terrains = ['unknown', 'drivable', 'obstacle', 'drop'];
const terrainPixels = perTheme(() => {
  const pixels = ['--cell-unknown', '--witness-ground', '--cell-occupied', '--obstacle-drop'].map((name) => packed(rgb(name)));
  return (kind) => pixels[kind] ?? pixels[0];
});

const oldest = 30; // tenths of a second
const cssOf = (pixel) => `rgb(${pixel & 255} ${(pixel >> 8) & 255} ${(pixel >> 16) & 255})`;

/**
 * The scale of a layer's colours: `stops` of a bar, evenly spaced, `labels` below it; `kinds` [colour, text]; `wheel`: colours
 * by heading, anticlockwise from the x axis of the world on.
 */
export function legendOf(kind) {
  const unknown = [cssOf(packed(rgb('--cell-unknown'))), 'unknown'];
  const bar = (pixelOf, count, labels) =>
    ({ stops: Array.from({ length: count }, (_, i) => cssOf(pixelOf(i / (count - 1)))), labels, kinds: [unknown] });
  switch (kind) {
    case 'velocity': {
      const pixelOf = velocityPixels();
      const heading = (i) => [(2 * Math.PI * i) / 24].flatMap((at) => [10 * Math.cos(at), 10 * Math.sin(at)]);
      return { wheel: Array.from({ length: 25 }, (_, i) => cssOf(pixelOf(...heading(i), 1))),
        labels: ['direction of motion; full colour: 10 m/s'], kinds: [[cssOf(pixelOf(0, 0, 0)), 'does not move'], unknown] };
    }
    case 'moving': return bar(rampPixels(), 2, ['moves: 0 %', '100 %']);
    case 'age': return bar(rampPixels(), 2, ['seen 0 s ago', `${oldest / 10} s`]);
    case 'elevation': return bar((share) => elevationPixels()(share - 0.5), 33, ['≤ −0.5 m', 'level', '≥ 0.5 m']);
    case 'witness': return { kinds: witnesses.map((text, i) => [cssOf(witnessPixels()(i)), text]) };
    case 'terrain': return { kinds: terrains.map((text, i) => [cssOf(terrainPixels()(i)), text]) };
    default: return bar((share) => occupancyPixels()[Math.round(100 * share)], 3, ['free', 'unknown', 'occupied']);
  }
}

/** `kind`: velocity, moving, age, elevation, terrain or witness. */
export function packedLayer(message, kind) {
  const { data, column_count: width, row_stride: rowBytes, cell_stride: step } = message;
  const offsetOf = (wanted) => message.fields.find(({ name }) => name === wanted)?.offset;
  const byte = (offset) => (i) => data[i * step + offset];
  const word = (offset) => (i) => ((data[i * step + offset + 1] << 24) >> 16) | data[i * step + offset];
  const [occupancy, moving, age] = ['occupancy_255ths', 'moving_255ths', 'age_ds'].map(offsetOf).map(byte);
  const [vx, vy] = ['velocity_x_cm_s', 'velocity_y_cm_s'].map(offsetOf).map(word);
  const elevationAt = offsetOf('elevation_cm'); // missing: ground.model is plane
  const elevation = elevationAt === undefined ? () => -32768 : word(elevationAt);
  const isSeen = (i) => elevation(i) !== -32768;
  const witnessAt = offsetOf('witness'); // missing: likewise
  const witness = witnessAt === undefined ? () => 0 : byte(witnessAt);
  const terrainAt = offsetOf('terrain'); // missing: likewise
  const terrain = terrainAt === undefined ? () => 0 : byte(terrainAt);
  const isKnown = (i) => age(i) !== 255;
  const velocity = velocityPixels();
  const ramp = rampPixels();
  const colourOf = elevationPixels();
  const colourOfWitness = witnessPixels();
  const colourOfTerrain = terrainPixels();
  const pixelOf = {
    velocity: (i) => velocity(vx(i) / 100, vy(i) / 100, isKnown(i) ? Math.min(1, moving(i) / 128) : NaN),
    moving: (i) => ramp(isKnown(i) ? moving(i) / 255 : NaN),
    age: (i) => ramp(isKnown(i) ? age(i) / oldest : NaN),
    elevation: (i) => colourOf(isSeen(i) ? elevation(i) / 100 : NaN),
    terrain: (i) => colourOfTerrain(terrain(i)),
    witness: (i) => colourOfWitness(witness(i)),
  }[kind];
  const percent = (share) => ((100 * share) / 255).toFixed(0);
  const { position } = message.pose;
  const height = data.length / rowBytes;
  return {
    frame: message.frame_id,
    corner: [position.x, position.y],
    resolution: message.cell_size.x, width, height,
    pixels: bitmapOf(width, height, pixelOf),
    textOf: (i) => (isKnown(i) ? `occupied ${percent(occupancy(i))} %, moving ${percent(moving(i))} % at ` +
      `${(Math.hypot(vx(i), vy(i)) / 100).toFixed(1)} m/s, seen ${(age(i) / 10).toFixed(1)} s ago` : 'never observed') +
      (isSeen(i) ? `, ${elevation(i)} cm high` : '') + (terrain(i) ? `, ${terrains[terrain(i)]}` : '') +
      (witnessAt === undefined ? '' : `; witness: ${witnessText(witness(i))}`),
  };
}

function part(name, text = '') {
  const made = document.createElement('span');
  made.className = name;
  made.textContent = text;
  return made;
}

/** Shows the scale of a layer (legendOf) in an element. */
export function showLegend(into, { stops, wheel, labels = [], kinds = [] }) {
  const parts = [];
  if (stops) {
    const bar = part('bar');
    bar.style.background = `linear-gradient(to right, ${stops.join(', ')})`;
    const scale = part('scale');
    const row = part('labels');
    row.append(...labels.map((label) => part('label', label)));
    scale.append(bar, row);
    parts.push(scale);
  }
  if (wheel) { // conic gradients run clockwise
    const disc = part('wheel');
    disc.style.background = `conic-gradient(${[...wheel].reverse().join(', ')})`;
    parts.push(disc, ...labels.map((label) => part('label', label)));
  }
  for (const [colour, text] of kinds) {
    const swatch = part('swatch');
    swatch.style.background = colour;
    const kind = part('kind');
    kind.append(swatch, text);
    parts.push(kind);
  }
  into.replaceChildren(...parts);
}

/** Turns the wheel of directions as the grid is turned: the vehicle heads up. */
export function turnLegend(legend, yaw) {
  const wheel = legend.querySelector('.wheel');
  if (wheel) wheel.style.transform = `rotate(${yaw}rad)`;
}
