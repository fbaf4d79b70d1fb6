// SPDX-License-Identifier: Apache-2.0
//
// Usage: node check.mjs MCAP_EXCHANGE. The format's own library reads what we write, and we read what it writes.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";

import lz4 from "@foxglove/wasm-lz4";
import * as zstd from "@foxglove/wasm-zstd";
import { McapIndexedReader, McapStreamReader, McapWriter } from "@mcap/core";

await lz4.isLoaded;
await zstd.isLoaded;
const decompressHandlers = {
  lz4: (bytes, size) => new Uint8Array(lz4(bytes, Number(size))),
  zstd: (bytes, size) => new Uint8Array(zstd.decompress(bytes, Number(size))),
};

const exchange = (...words) =>
  execFileSync(process.argv[2], words, { encoding: "utf8", maxBuffer: 1 << 28 }).replace(/\n$/, "").split("\n");

const line = (channel, schema, message) =>
  [channel.topic, schema.name, schema.data.byteLength, channel.metadata.get("offered_qos_profiles").replaceAll("\n", "|"),
    message.sequence, message.logTime, message.publishTime, Buffer.from(message.data).toString("hex")].join("\t");

const readable = (bytes) => ({
  size: async () => BigInt(bytes.byteLength),
  read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
});

async function checkIndexed(bytes, expected) {
  const reader = await McapIndexedReader.Initialize({ readable: readable(bytes), decompressHandlers });
  assert.equal(reader.header.profile, "ros2");
  assert.equal(reader.header.library, "stereogrid ü");
  assert.equal(reader.statistics.messageCount, 2000n);
  assert.equal(reader.statistics.chunkCount, reader.chunkIndexes.length);
  assert.ok(reader.chunkIndexes.length > 10);
  const of = (message) => {
    const channel = reader.channelsById.get(message.channelId);
    return line(channel, reader.schemasById.get(channel.schemaId), message);
  };
  const lines = [];
  for await (const message of reader.readMessages({ validateCrcs: true })) lines.push(of(message));
  assert.deepEqual(lines, expected);
  const some = [];
  const [startTime, endTime] = [1700000000500000000n, 1700000000900000000n];
  for await (const message of reader.readMessages({ topics: ["/b/c"], startTime, endTime })) some.push(of(message));
  const time = (text) => BigInt(text.split("\t")[5]);
  assert.deepEqual(some, expected.filter((text) => text.startsWith("/b/c\t") && time(text) >= startTime && time(text) <= endTime));
  assert.ok(some.length > 100);
  const metadata = [];
  for await (const record of reader.readMetadata()) metadata.push([record.name, [...record.metadata]]);
  assert.deepEqual(metadata, [["run", [["empty", ""], ["preset", "default"]]]]);
}

function checkStreamed(bytes, expected) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const [schemas, channels, lines] = [new Map(), new Map(), []];
  for (let at = 0; at < bytes.length; at += 1000) {
    reader.append(bytes.subarray(at, at + 1000));
    for (let record; (record = reader.nextRecord()); ) {
      if (record.type === "Schema") schemas.set(record.id, record);
      if (record.type === "Channel") channels.set(record.id, record);
      if (record.type !== "Message") continue;
      const channel = channels.get(record.channelId);
      lines.push(line(channel, schemas.get(channel.schemaId), record));
    }
  }
  assert.ok(reader.done());
  assert.deepEqual(lines.sort(), [...expected].sort());
}

for (const compression of ["none", "lz4", "zstd"]) {
  const expected = exchange("write", "ours.mcap", compression);
  assert.equal(expected.length, 2000);
  const bytes = new Uint8Array(readFileSync("ours.mcap"));
  await checkIndexed(bytes, expected);
  checkStreamed(bytes, expected);
  console.log(`ours, ${compression}: 2000 messages read, with index and as a stream`);
}

async function writeTheirs(file, options) {
  const parts = [];
  let size = 0;
  const writable = {
    position: () => BigInt(size),
    write: async (bytes) => {
      parts.push(bytes.slice());
      size += bytes.byteLength;
    },
  };
  const writer = new McapWriter({ writable, chunkSize: 5000, ...options });
  await writer.start({ profile: "ros2", library: "theirs" });
  const schema = { name: "pkg/msg/T", encoding: "ros2msg", data: new TextEncoder().encode("int8 x\n") };
  const schemaId = await writer.registerSchema(schema);
  const channels = [];
  for (const topic of ["/x", "/y"]) {
    const channel = { topic, schemaId, messageEncoding: "cdr", metadata: new Map([["offered_qos_profiles", "- a: 1\n"]]) };
    channels.push({ ...channel, id: await writer.registerChannel(channel) });
  }
  await writer.addAttachment({ name: "a.txt", mediaType: "text/plain", logTime: 1n, createTime: 1n, data: new Uint8Array(9000) });
  const expected = [];
  for (let i = 0; i < 500; ++i) {
    const channel = channels[i % 3 === 0 ? 0 : 1];
    const data = new Uint8Array((i * 37) % 200).fill(i);
    const message = { channelId: channel.id, sequence: i, logTime: BigInt(10000 - 7 * i), publishTime: BigInt(i), data };
    await writer.addMessage(message);
    expected.unshift(line(channel, schema, message)); // the last one has the earliest time
  }
  await writer.end();
  writeFileSync(file, Buffer.concat(parts));
  return expected;
}

const compressChunk = (bytes) => ({ compression: "zstd", compressedData: zstd.compress(bytes) });
const bare = { useStatistics: false, useSummaryOffsets: false, useMessageIndex: false, useChunkIndex: false };
for (const [name, options] of Object.entries({ plain: {}, zstd: { compressChunk }, unchunked: { useChunks: false },
  bare, bareZstd: { ...bare, compressChunk, repeatSchemas: false, repeatChannels: false } })) {
  const expected = await writeTheirs("theirs.mcap", options);
  assert.deepEqual(exchange("read", "theirs.mcap"), expected);
  console.log(`theirs, ${name}: 500 messages read`);
}
console.log("passed");
