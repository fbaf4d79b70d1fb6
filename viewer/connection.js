// SPDX-License-Identifier: Apache-2.0
import { MessageReader } from './cdr.js';

const subprotocol = 'foxglove.websocket.v1';
const messageOpcode = 1;
const messageHeaderBytes = 13; // opcode, subscription (uint32), stamp (uint64)
const allParameters = 'all'; // id of the first request
const retriesMs = [500, 1000, 2000, 5000];

/**
 * A client of the Foxglove WebSocket that comes back when the server does. Events: "state" (detail: a keyword), "channels"
 * (detail: topics), "parameter" (detail: {name, value}), "fault" (detail: a message).
 */
export class Connection extends EventTarget {
  #socket = null;
  #channels = new Map(); // id → channel
  #receivers = new Map(); // topic → function
  #readers = new Map(); // subscription id → {id, topic, reader}
  #parameters = [];
  #failures = 0;
  #nextSubscription = 1;

  constructor(url) {
    super();
    this.url = url;
    this.name = '';
  }

  open() {
    this.#notify('state', 'connecting');
    const socket = new WebSocket(this.url, [subprotocol]);
    this.#socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.#failures = 0;
      this.#notify('state', 'connected');
    };
    socket.onmessage = (event) => this.#receive(event.data);
    socket.onclose = () => this.#retry();
  }

  /** Names of the topics that are there. */
  topics() {
    return [...this.#channels.values()].map((channel) => channel.topic);
  }

  /** Calls `take` with each message on a topic, whether it is there yet or not. */
  subscribe(topic, take) {
    this.#receivers.set(topic, take);
    for (const channel of this.#channels.values()) if (channel.topic === topic) this.#ask(channel);
  }

  unsubscribe(topic) {
    this.#receivers.delete(topic);
    for (const [id, subscription] of this.#readers) {
      if (subscription.topic !== topic) continue;
      this.#readers.delete(id);
      this.#send({ op: 'unsubscribe', subscriptionIds: [id] });
    }
  }

  /** Requests these parameters, if the server has them, and all their changes. */
  watchParameters(names) {
    this.#parameters = names;
  }

  setParameter(name, value) {
    this.#send({ op: 'setParameters', parameters: [{ name, value }] });
  }

  #notify(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  #send(request) {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(request));
  }

  #retry() {
    this.#channels.clear();
    this.#readers.clear();
    this.#notify('state', 'disconnected');
    this.#notify('channels', []);
    const pause = retriesMs[Math.min(this.#failures++, retriesMs.length - 1)];
    setTimeout(() => this.open(), pause);
  }

  #ask(channel) {
    if (channel.encoding !== 'cdr' || channel.schemaEncoding !== 'ros2msg') return;
    const id = this.#nextSubscription++;
    try { // an unreadable definition concerns no other channel
      const reader = new MessageReader(channel.schemaName, channel.schema);
      this.#readers.set(id, { channel: channel.id, topic: channel.topic, reader });
    } catch (error) {
      return this.#notify('fault', `${channel.topic}: ${error.message}`);
    }
    this.#send({ op: 'subscribe', subscriptions: [{ id, channelId: channel.id }] });
  }

  #receive(data) {
    if (typeof data !== 'string') return this.#receiveMessage(data);
    const message = JSON.parse(data);
    if (message.op === 'serverInfo') this.#begin(message);
    if (message.op === 'advertise') this.#advertise(message.channels);
    if (message.op === 'unadvertise') this.#unadvertise(message.channelIds);
    if (message.op === 'status' && message.level > 0) this.#notify('fault', message.message);
    if (message.op === 'parameterValues') this.#takeParameters(message);
  }

  #begin(info) {
    this.name = info.name;
    this.#notify('state', 'connected');
    if (this.#parameters.length === 0 || !info.capabilities.includes('parametersSubscribe')) return;
    this.#send({ op: 'getParameters', parameterNames: [], id: allParameters });
  }

  #takeParameters({ parameters, id }) {
    const there = parameters.filter(({ name }) => this.#parameters.includes(name));
    for (const one of there) this.#notify('parameter', one);
    if (id !== allParameters || there.length === 0) return;
    this.#send({ op: 'subscribeParameterUpdates', parameterNames: there.map(({ name }) => name) });
  }

  #advertise(channels) {
    for (const channel of channels) {
      this.#channels.set(channel.id, channel);
      if (this.#receivers.has(channel.topic)) this.#ask(channel);
    }
    this.#notify('channels', this.topics());
  }

  #unadvertise(ids) {
    for (const id of ids) this.#channels.delete(id);
    for (const [id, subscription] of this.#readers) if (ids.includes(subscription.channel)) this.#readers.delete(id);
    this.#notify('channels', this.topics());
  }

  #receiveMessage(buffer) {
    const view = new DataView(buffer);
    if (view.getUint8(0) !== messageOpcode) return;
    const subscription = this.#readers.get(view.getUint32(1, true));
    if (!subscription) return;
    try {
      const message = subscription.reader.read(new Uint8Array(buffer, messageHeaderBytes));
      this.#receivers.get(subscription.topic)?.(message, Number(view.getBigUint64(5, true)) * 1e-9);
    } catch (error) {
      this.#notify('fault', `${subscription.topic}: ${error.message}`);
    }
  }
}
