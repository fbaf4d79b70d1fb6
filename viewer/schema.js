// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0

/** Sizes in bytes of the types that a message is made of in the end. No prototype: a type may be named "constructor". */
export const primitiveSizes = {
  __proto__: null, bool: 1, byte: 1, char: 1, int8: 1, uint8: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, float32: 4,
  float64: 8, int64: 8, uint64: 8,
};

const isPrimitive = (type) => type in primitiveSizes || type === 'string';

const definitionMax = 1 << 20; // characters; definitions of ROS 2 have less than a tenth

/** "pkg/msg/Type" and "pkg/Type" are one. */
const shortName = (name) => name.replace('/msg/', '/');

/** "float32[<=5] name" → {name, type, array: null | 'sequence' | count}; constants and comments → null. */
function parseField(line, packageName) {
  const match = /^\s*([\w/]+)(?:<=\d+)?(\[(?:<=)?\d*\])?\s+(\w+)\s*(=)?/.exec(line.replace(/#.*/, ''));
  if (!match || match[4]) return null;
  const [, type, brackets, name] = match;
  const fixed = /^\[(\d+)\]$/.exec(brackets ?? '');
  const array = !brackets ? null : fixed ? Number(fixed[1]) : 'sequence';
  const known = isPrimitive(type);
  if (type === 'wstring') throw new Error(`${name}: wide strings are not read here`);
  return { name, array, type: known ? type : type.includes('/') ? shortName(type) : `${packageName}/${type}`, known };
}

/**
 * Reads a definition in schema encoding "ros2msg": the type's own fields, then those of each type within it, after a
 * line of "=" and "MSG: pkg/Type". Returns a map from type names to lists of fields, and the name of the first.
 */
export function parseDefinition(typeName, text) {
  const root = shortName(typeName);
  if (text.length > definitionMax) throw new Error(`${root}: a definition of more than ${definitionMax} characters`);
  const types = new Map();
  for (const [index, section] of text.split(/^=+\s*$/m).entries()) {
    const lines = section.split('\n');
    const heading = lines.findIndex((line) => line.startsWith('MSG:'));
    if (index > 0 && heading < 0) throw new Error(`${root}: a type of its definition has no line MSG: pkg/Type`);
    const name = index === 0 ? root : shortName(lines[heading].slice(4).trim());
    const packageName = name.split('/')[0];
    const fields = lines.slice(index === 0 ? 0 : heading + 1).map((line) => parseField(line, packageName));
    types.set(name, fields.filter((field) => field !== null));
  }
  return { root, types };
}
