// A rosbridge v2 client that sends JSON and receives JSON and CBOR. It reconnects and resubscribes automatically.
import { Decoder } from '../vendor/cbor.js';

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 5000;
const CALL_TIMEOUT_MS = 30000;

// A stamp of ROS 1 or ROS 2 in seconds.
export const seconds = (stamp) => (stamp.sec ?? stamp.secs) + 1e-9 * (stamp.nanosec ?? stamp.nsecs);

export class ServiceError extends Error {}

/** The answer of a service. Rejects with a ServiceError that contains the server's message if it refused.
 * @template T
 * @param {Promise<T>} promise
 * @returns {Promise<Exclude<T, import('./messages.js').Refused>>}
 */
export async function accepted(promise) {
  const answer = /** @type {any} */ (await promise);
  if (answer.success === false) throw new ServiceError(answer.message);
  return answer;
}

export class Rosbridge extends EventTarget {
  #url;
  /** @type {WebSocket | null} */
  #socket = null;
  #decoder = new Decoder({ mapsAsObjects: true, int64AsNumber: true });
  #topics = new Map(); // name: { options, listeners }
  #calls = new Map(); // id: { resolve, reject, timer }
  #count = 0;
  #waitMs = FIRST_WAIT_MS;
  #timer = 0;
  #closed = false;
  receivedMs = -Infinity; // time of the last message received

  constructor(url) {
    super();
    this.#url = url;
    this.bytes = 0;
    this.#connect();
  }

  get url() {
    return this.#url;
  }

  get connected() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  // The number of bytes waiting in this browser to be sent.
  get backlog() {
    return this.#socket?.bufferedAmount ?? 0;
  }

  // Abandon a connection over which nothing arrives any longer, and reconnect.
  drop() {
    this.#detach();
    this.#lost();
  }

  close() {
    this.#closed = true;
    clearTimeout(this.#timer);
    this.#socket?.close();
  }

  // Return a function that ends the subscription. options: throttle_rate [ms], queue_length, credit (see `acknowledge`).
  subscribe(topic, type, listener, options = {}) {
    let entry = this.#topics.get(topic);
    if (!entry) {
      entry = { type, options: { compression: 'cbor', queue_length: 1, ...options }, listeners: new Set() };
      this.#topics.set(topic, entry);
      this.#sendSubscription(topic, entry);
    }
    entry.listeners.add(listener);
    return () => {
      entry.listeners.delete(listener);
      if (entry.listeners.size === 0 && this.#topics.get(topic) === entry) {
        this.#topics.delete(topic);
        this.#send({ op: 'unsubscribe', topic });
      }
    };
  }

  // Return one credit: a message has been processed, and another may be sent.
  acknowledge(topic, count = 1) {
    this.#send({ op: 'ack', topic, count });
  }

  // Return the values of the answer. Rejects with a ServiceError that contains the server's message.
  call(service, args = {}) {
    const id = `call${(this.#count += 1)}`;
    return new Promise((resolve, reject) => {
      if (!this.#send({ op: 'call_service', id, service, args })) {
        reject(new ServiceError('the simulator is not connected'));
        return;
      }
      const timer = setTimeout(() => {
        this.#calls.delete(id);
        reject(new ServiceError(`${service} did not answer within ${CALL_TIMEOUT_MS / 1000} s`));
      }, CALL_TIMEOUT_MS);
      this.#calls.set(id, { resolve, reject, timer });
    });
  }

  #connect() {
    let socket;
    try {
      socket = new WebSocket(this.#url);
    } catch (error) {
      // not a valid address
      queueMicrotask(() => this.dispatchEvent(new CustomEvent('refused', { detail: error.message })));
      return;
    }
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.#waitMs = FIRST_WAIT_MS;
      this.receivedMs = performance.now();
      for (const [topic, entry] of this.#topics) this.#sendSubscription(topic, entry);
      this.dispatchEvent(new Event('open'));
    };
    socket.onmessage = (event) => this.#receive(event.data);
    socket.onclose = () => this.#lost();
    this.#socket = socket;
  }

  #detach() {
    const socket = this.#socket;
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    this.#socket = null;
    socket.close();
  }

  #lost() {
    for (const { reject, timer } of this.#calls.values()) {
      clearTimeout(timer);
      reject(new ServiceError('the connection was lost'));
    }
    this.#calls.clear();
    this.dispatchEvent(new Event('close'));
    if (this.#closed) return;
    this.#timer = setTimeout(() => this.#connect(), this.#waitMs);
    this.#waitMs = Math.min(2 * this.#waitMs, LONGEST_WAIT_MS);
  }

  #sendSubscription(topic, { type, options }) {
    this.#send({ op: 'subscribe', topic, ...(type ? { type } : {}), ...options });
  }

  #send(operation) {
    if (!this.#socket || !this.connected) return false;
    this.#socket.send(JSON.stringify(operation));
    return true;
  }

  #receive(data) {
    this.receivedMs = performance.now();
    this.bytes += data.byteLength ?? data.length;
    const operation = typeof data === 'string' ? JSON.parse(data) : this.#decoder.decode(new Uint8Array(data));
    if (operation.op === 'publish') {
      for (const listener of this.#topics.get(operation.topic)?.listeners ?? []) {
        listener(operation.msg, data.byteLength ?? data.length);
      }
    } else if (operation.op === 'service_response') {
      this.#answer(operation);
    } else if (operation.op === 'status') {
      this.dispatchEvent(new CustomEvent('status', { detail: operation }));
    }
  }

  #answer({ id, result, values }) {
    const call = this.#calls.get(id);
    if (!call) return;
    this.#calls.delete(id);
    clearTimeout(call.timer);
    if (result === false) call.reject(new ServiceError(typeof values === 'string' ? values : JSON.stringify(values)));
    else call.resolve(values);
  }
}
