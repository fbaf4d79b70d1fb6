// SPDX-License-Identifier: Apache-2.0
//
// Usage: node recording.mjs STEREOGRID. The format's own library reads a recording of a run, all checksums checked.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, rmSync } from "node:fs";

import * as zstd from "@foxglove/wasm-zstd";
import { McapIndexedReader } from "@mcap/core";

await zstd.isLoaded;
const frames = 12;
const topics = ["packed_grid", "obstacles", "odometry", "status"];
rmSync("run", { recursive: true, force: true });
rmSync("run.mcap", { force: true });
execFileSync(process.argv[2], ["-q", "run", `scene:street?frames=${frames}`, "--set", "grid.length_m=30", "--compact",
  "--layers", "occupancy", "--out", "run", "--mcap", "run.mcap", "--mcap-topics", topics.join()]);
const bytes = readFileSync("run.mcap");
const reader = await McapIndexedReader.Initialize({
  readable: {
    size: async () => BigInt(bytes.byteLength),
    read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
  },
  decompressHandlers: { zstd: (packed, size) => new Uint8Array(zstd.decompress(packed, Number(size))) },
});
assert.ok(reader.chunkIndexes.length > 0 && reader.chunkIndexes.every((chunk) => chunk.compression === "zstd"));
const counts = new Map();
for await (const message of reader.readMessages({ validateCrcs: true })) {
  const channel = reader.channelsById.get(message.channelId);
  assert.ok(reader.schemasById.get(channel.schemaId).data.byteLength > 0);
  counts.set(channel.topic, (counts.get(channel.topic) ?? 0) + 1);
}
for (const topic of topics) assert.equal(counts.get(`/stereo_grid/${topic}`), frames, `${topic}: ${[...counts]}`);
console.log(`${frames} frames, ${Math.round(bytes.byteLength / frames)} bytes each`);
