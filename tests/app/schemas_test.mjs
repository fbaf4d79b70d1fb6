// SPDX-License-Identifier: Apache-2.0
//
// Usage: node schemas_test.mjs VIEWER. What hostile schemas of a recording cost the page in folder VIEWER, and what other
// channels lose by them.
import assert from 'node:assert';
import { pathToFileURL } from 'node:url';

const viewer = pathToFileURL(`${process.argv[2]}/`);
const limitMs = 200;

/** The bytes of a message: little-endian CDR, then 32-bit `words` and zeros. */
function message(size, words = []) {
  const bytes = new Uint8Array(4 + size);
  bytes[1] = 1;
  words.forEach((word, i) => new DataView(bytes.buffer).setUint32(4 + 4 * i, word, true));
  return bytes;
}

/** Types B0 … of a field each, the last of `leaf`. */
const chain = (length, first, next, leaf) => [
  first, ...Array.from({ length }, (_, i) => `MSG: a/B${i}\n${next.replaceAll('#', `B${i + 1}`)}`),
  `MSG: a/B${length}\n${leaf}`].join('\n===\n');

const hostile = {
  'arrays of arrays of a type without fields': [chain(3, 'B0[150] x', '#[150] x', ''), message(150)],
  'the same with an array of no number': [chain(3, 'B0[150] x', '#[150] x', 'uint8[0] x'), message(150)],
  'two fields of the next type each': [chain(200, 'B0 x', '# x\n# y', 'uint8[0] x'), message(150)],
  'types in types in a long array': [chain(2000, 'B0[] x', '# x', 'uint8 x'), message(1e6, [9e5])],
  'large arrays in large arrays': [chain(2000, 'B0[] x', '#[100000] x', 'uint8 x'), message(1e6, [9e5])],
  'a million strings': ['string[] x', message(4e6, [1e6])],
  'a type of itself': ['A x\nA y', message(150)],
  'a million fields': ['uint8 x\n'.repeat(1e6), message(1e6)],
  'a type of every object': ['toString[] x', message(150, [100])],
  'a section without a name': ['uint8 x\n===\nuint8 y', message(150)],
};

async function checkReader() {
  const { MessageReader } = await import(new URL('cdr.js', viewer));
  for (const [name, [definition, bytes]] of Object.entries(hostile)) {
    const begin = process.cpuUsage();
    assert.throws(() => new MessageReader('a/msg/A', definition).read(bytes), name);
    const { user, system } = process.cpuUsage(begin); // µs
    assert.ok(user + system < 1000 * limitMs, `${name}: ${(user + system) / 1000} ms`);
  }
  const empties = new MessageReader('a/msg/A', 'B[3] b\nuint8 last\n===\nMSG: a/B\n');
  assert.deepStrictEqual(empties.read(Uint8Array.from([0, 1, 0, 0, 0, 0, 0, 7])), { b: [{}, {}, {}], last: 7 });
}

/** A channel that cannot be read has a fault; those advertised with it are subscribed and read. */
async function checkConnection() {
  let socket;
  globalThis.WebSocket = class {
    static OPEN = 1;
    readyState = 1;
    sent = [];
    constructor() { socket = this; }
    send(text) { this.sent.push(JSON.parse(text)); }
  };
  globalThis.CustomEvent ??= class extends Event { // Node.js 18
    constructor(type, { detail }) { super(type); this.detail = detail; }
  };
  const { Connection } = await import(new URL('connection.js', viewer));
  const connection = new Connection('ws://localhost/');
  const [faults, taken] = [[], []];
  connection.addEventListener('fault', ({ detail }) => faults.push(detail));
  for (const topic of ['/bad', '/good']) connection.subscribe(topic, (read) => taken.push([topic, read.x]));
  connection.open();
  const channels = [['/bad', hostile['a section without a name'][0]], ['/good', 'uint8 x']].map(
    ([topic, schema], id) => ({ id, topic, schema, schemaName: 'a/msg/A', encoding: 'cdr', schemaEncoding: 'ros2msg' }));
  socket.onmessage({ data: JSON.stringify({ op: 'advertise', channels }) });
  assert.match(faults.join(), /^\/bad: /);
  const [{ id, channelId }] = socket.sent.flatMap((request) => request.subscriptions);
  assert.strictEqual(channelId, 1);
  socket.onmessage({ data: Uint8Array.from([1, id, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 7]).buffer });
  assert.deepStrictEqual(taken, [['/good', 7]]);
}

await checkReader();
await checkConnection();
