// SPDX-License-Identifier: Apache-2.0
//
// Usage: node check.js PORT. Talks to served_channels.cpp as Foxglove's viewers do.
"use strict";

const assert = require("node:assert");
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { WebSocket } = require("ws");

const url = `ws://127.0.0.1:${process.argv[2]}`;

/** The next event of a client that passes the test. */
function next(client, event, test = () => true) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`no ${event} came`)), 10000);
    client.on("error", reject);
    const listener = (value) => {
      if (!test(value)) return;
      clearTimeout(timer);
      client.off(event, listener);
      resolve(value);
    };
    client.on(event, listener);
  });
}

async function checkClient(subprotocol) {
  const socket = new WebSocket(url, [subprotocol]);
  const client = new FoxgloveClient({ ws: socket });
  const [info, channels] = await Promise.all([next(client, "serverInfo"), next(client, "advertise")]);
  assert.strictEqual(socket.protocol, subprotocol);
  assert.strictEqual(info.name, "served channels");
  assert.deepStrictEqual([...info.capabilities].sort(), ["connectionGraph", "parameters", "parametersSubscribe", "time"]);
  assert.deepStrictEqual(channels.map((channel) => channel.topic), ["/latched", "/stream"]);
  for (const channel of channels) {
    const { encoding, schemaName, schema, schemaEncoding } = channel;
    assert.deepStrictEqual([encoding, schemaName, schema, schemaEncoding],
                           ["cdr", "std_msgs/msg/String", "string data", "ros2msg"]);
  }

  const latched = client.subscribe(channels[0].id);
  const last = await next(client, "message", (message) => message.subscriptionId === latched);
  assert.strictEqual(last.timestamp, 42n);
  assert.strictEqual(Buffer.from(last.data.buffer, last.data.byteOffset, last.data.byteLength).toString(), "last");

  const stream = client.subscribe(channels[1].id);
  let before = -1n;
  for (let i = 0; i < 20; ++i) {
    const message = await next(client, "message", (one) => one.subscriptionId === stream);
    assert.strictEqual(message.data.byteLength, 1000);
    assert.strictEqual(BigInt(message.data.getUint8(999)), message.timestamp & 255n);
    assert.ok(message.timestamp > before);
    before = message.timestamp;
  }
  assert.ok((await next(client, "time")).timestamp >= before);

  client.getParameters([], "all");
  const all = await next(client, "parameterValues", (values) => values.id === "all");
  assert.deepStrictEqual(all.parameters, [{ name: "gain", type: "float64", value: 1.5 },
                                          { name: "names", value: ["a", "b"] }]);
  client.setParameters([{ name: "gain", value: 1.5 }], "set");
  assert.strictEqual((await next(client, "parameterValues", (values) => values.id === "set")).parameters[0].value, 1.5);

  client.subscribeConnectionGraph();
  const graph = await next(client, "connectionGraphUpdate");
  assert.deepStrictEqual(graph.publishedTopics.map((topic) => topic.name), ["/latched", "/stream"]);
  assert.ok(graph.subscribedTopics.every((topic) => topic.subscriberIds.length === 1));
  client.unsubscribe(stream);
  const fewer = await next(client, "connectionGraphUpdate");
  assert.deepStrictEqual(fewer.subscribedTopics.map((topic) => topic.subscriberIds.length), [1, 0]);

  client.subscribe(9999);
  assert.match((await next(client, "status")).message, /no channel 9999/);
  client.close();
}

function checkRefusal(subprotocols) {
  return new Promise((resolve, reject) => {
    const socket = new WebSocket(url, subprotocols);
    socket.on("open", () => reject(new Error("connected without a sub-protocol of ours")));
    socket.on("error", reject);
    socket.on("unexpected-response", (request, response) => {
      request.destroy();
      resolve(response.statusCode);
    });
  });
}

async function main() {
  for (const subprotocol of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) await checkClient(subprotocol);
  for (const none of [[], ["other"]]) assert.strictEqual(await checkRefusal(none), 400);
  console.log("Foxglove's client agrees.");
  process.exit(0);
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
