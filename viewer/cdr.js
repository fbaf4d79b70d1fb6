// SPDX-License-Identifier: Apache-2.0
/** Sizes in bytes of the types that a message is made of in the end. No prototype: a type may be named "constructor". */
const primitiveSizes = {
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
function parseDefinition(typeName, text) {
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

const arrayTypes = {
  __proto__: null, byte: Uint8Array, char: Uint8Array, uint8: Uint8Array, int8: Int8Array, int16: Int16Array, uint16: Uint16Array,
  int32: Int32Array, uint32: Uint32Array, float32: Float32Array, float64: Float64Array, int64: BigInt64Array,
  uint64: BigUint64Array,
};

const getters = {
  __proto__: null,
  bool: (view, at) => view.getUint8(at) !== 0,
  byte: (view, at) => view.getUint8(at),
  char: (view, at) => view.getUint8(at),
  uint8: (view, at) => view.getUint8(at),
  int8: (view, at) => view.getInt8(at),
  int16: (view, at) => view.getInt16(at, true),
  uint16: (view, at) => view.getUint16(at, true),
  int32: (view, at) => view.getInt32(at, true),
  uint32: (view, at) => view.getUint32(at, true),
  float32: (view, at) => view.getFloat32(at, true),
  float64: (view, at) => view.getFloat64(at, true),
  int64: (view, at) => view.getBigInt64(at, true),
  uint64: (view, at) => view.getBigUint64(at, true),
};

const utf8 = new TextDecoder();
const headerBytes = 4;
const littleEndian = 1;
// Fields and elements of a message, numbers of typed arrays excluded. The largest message of a street has a tenth; as
// many take 0.05 s.
const valuesMax = 200000;

/** Goes through the bytes of one message. */
class Cursor {
  constructor(buffer) {
    this.buffer = buffer;
    this.view = new DataView(buffer);
    this.at = 0;
    this.valuesLeft = valuesMax;
  }

  /** A definition can have more values than the message has bytes: arrays of arrays of a type without data. */
  spend(count) {
    this.valuesLeft -= count;
    if (this.valuesLeft < 0) throw new Error(`more than ${valuesMax} values in a message`);
  }

  align(size) {
    this.at = Math.ceil(this.at / size) * size;
  }

  primitive(type) {
    if (type === 'string') return this.string();
    const size = primitiveSizes[type];
    this.align(size);
    const value = getters[type](this.view, this.at);
    this.at += size;
    return value;
  }

  string() {
    const length = this.primitive('uint32');
    const bytes = new Uint8Array(this.buffer, this.at, length);
    this.at += length;
    return utf8.decode(length > 0 ? bytes.subarray(0, length - 1) : bytes); // without the final zero
  }

  /** No copy: the array lies in the message. */
  numbers(type, count) {
    const size = primitiveSizes[type];
    if (count > 0) this.align(size);
    const values = new arrayTypes[type](this.buffer, count > 0 ? this.at : 0, count);
    this.at += count * size;
    return values;
  }
}

/** Reads CDR (XCDR1, little-endian, as ROS 2 writes it) by a definition in "ros2msg". */
export class MessageReader {
  constructor(typeName, definition) {
    const { root, types } = parseDefinition(typeName, definition);
    this.root = root;
    this.types = types;
  }

  /** The message as an object with the definition's field names; arrays of numbers are typed arrays. */
  read(bytes) {
    if (bytes.byteLength < headerBytes || bytes[1] !== littleEndian) {
      throw new Error(`${this.root}: the bytes are not little-endian CDR`);
    }
    // a copy, so that aligned values of the message are aligned in memory
    return this.#object(this.root, new Cursor(bytes.slice(headerBytes).buffer));
  }

  #object(type, cursor) {
    const fields = this.types.get(type);
    if (!fields) throw new Error(`${type} is not defined`);
    if (fields.length === 0) cursor.primitive('uint8'); // ROS 2 gives a type without fields a byte
    cursor.spend(fields.length);
    const made = {};
    for (const field of fields) made[field.name] = this.#field(field, cursor);
    return made;
  }

  #field(field, cursor) {
    const one = () => (field.known ? cursor.primitive(field.type) : this.#object(field.type, cursor));
    if (field.array === null) return one();
    const count = field.array === 'sequence' ? cursor.primitive('uint32') : field.array;
    if (field.type in arrayTypes) return cursor.numbers(field.type, count);
    cursor.spend(count);
    return Array.from({ length: count }, one);
  }
}
