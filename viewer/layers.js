// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
import { isDark, rgb } from './theme.js';

/**
 * What the grid view draws: cells with x fastest, the corner of the smallest x and y, and for each cell a colour and a
 * text. Made of nav_msgs/OccupancyGrid, and of grid_map_msgs/GridMap.
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

function occupancyColours() {
  const [free, unknown, occupied] = ['--cell-free', '--cell-unknown', '--cell-occupied'].map(rgb);
  return (percent) => {
    if (percent < 0 || percent > 100) return unknown;
    return percent < 50 ? mix(free, unknown, percent / 50) : mix(unknown, occupied, percent / 50 - 1);
  };
}

// Colours of tables, so that a cell is a look-up: grids have hundreds of thousands of them, thirty times a second.
const hues = 64;
const strengths = 32;

/** Of a cell: the pixel of the heading's hue, the stronger the faster. */
function velocityPixels() {
  const unknown = packed(rgb('--cell-unknown'));
  const standing = rgb('--cell-free');
  const fastest = 10; // m/s and more have the full colour
  const channel = (hue, shift) => 255 * clamp(Math.abs(((hue + shift) % 6) - 3) - 1) * (isDark() ? 1 : 0.85);
  const table = Int32Array.from({ length: hues * strengths }, (_, i) => {
    const hue = 6 * (Math.floor(i / strengths) / hues + 1);
    return packed(mix(standing, [0, 4, 2].map((shift) => channel(hue, shift)), (i % strengths) / (strengths - 1)));
  });
  return (vx, vy, moving) => {
    if (vx !== vx) return unknown; // NaN
    const strength = Math.round(clamp((Math.sqrt(vx * vx + vy * vy) / fastest) * 0.75 + 0.25) * moving * (strengths - 1));
    if (strength === 0) return table[0];
    return table[((Math.round((Math.atan2(vy, vx) / (2 * Math.PI)) * hues) + hues) % hues) * strengths + strength];
  };
}

/** Of a share from 0 to 1. */
function rampPixels() {
  const [low, high, unknown] = ['--ramp-low', '--ramp-high', '--cell-unknown'].map(rgb);
  const table = Int32Array.from({ length: 256 }, (_, i) => packed(mix(low, high, i / 255)));
  const none = packed(unknown);
  return (share) => (share !== share ? none : table[Math.round(clamp(share) * 255)]);
}

/** `pixelOf`: of each cell, packed. */
function bitmapOf(width, height, pixelOf) {
  const bitmap = new ImageData(width, height);
  const pixels = new Int32Array(bitmap.data.buffer);
  for (let i = 0; i < pixels.length; ++i) pixels[i] = pixelOf(i);
  return bitmap;
}

export function occupancyLayer(message) {
  const { resolution, width, height, origin } = message.info;
  const colours = occupancyColours();
  const table = Int32Array.from({ length: 256 }, (_, i) => packed(colours((i << 24) >> 24)));
  return {
    frame: message.header.frame_id,
    corner: [origin.position.x, origin.position.y],
    resolution, width, height,
    pixels: bitmapOf(width, height, (i) => table[message.data[i] & 255]),
    textOf: (i) => (message.data[i] < 0 ? 'unknown' : `occupied ${message.data[i]} %`),
  };
}

/** `kind`: velocity, moving or age. Grid maps begin at the corner of the largest x and y: our order, backwards. */
export function gridMapLayer(message, kind) {
  const { resolution, length_x, length_y, pose } = message.info;
  const [width, height] = [Math.round(length_x / resolution), Math.round(length_y / resolution)];
  const last = width * height - 1;
  const layer = (name) => message.data[message.layers.indexOf(name)].data;
  const [occupancy, vx, vy, moving, age] = ['occupancy', 'velocity_x', 'velocity_y', 'moving', 'age'].map(layer);
  const velocity = velocityPixels();
  const ramp = rampPixels();
  const oldest = 3; // s
  const pixelOf = {
    velocity: (i) => velocity(vx[i], vy[i], clamp(2 * moving[i])),
    moving: (i) => ramp(moving[i]),
    age: (i) => ramp(age[i] / oldest),
  }[kind];
  const textOf = (i) => (Number.isNaN(age[i]) ? 'never observed' :
    `occupied ${(100 * occupancy[i]).toFixed(0)} %, moving ${(100 * moving[i]).toFixed(0)} % at ` +
    `${Math.hypot(vx[i], vy[i]).toFixed(1)} m/s, seen ${age[i].toFixed(1)} s ago`);
  return {
    frame: message.header.frame_id,
    corner: [pose.position.x - length_x / 2, pose.position.y - length_y / 2],
    resolution, width, height,
    pixels: bitmapOf(width, height, (i) => pixelOf(last - i)),
    textOf: (i) => textOf(last - i),
  };
}
