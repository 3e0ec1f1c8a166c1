// One websocket, opened again when it is lost. Texts are JSON; pictures are bytes.
const HEADER_BYTES = 24;
const RETRY_MS = 1000;
const KINDS = { 1: "picture", 2: "mask", 3: "overlay" };
export const token = new URLSearchParams(location.search).get("token") ?? "";

export class Connection extends EventTarget {
  #socket = null;

  open() {
    const address = new URL("ws", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    address.search = new URLSearchParams({ token }).toString();
    this.#socket = new WebSocket(address);
    this.#socket.binaryType = "arraybuffer";
    this.#socket.onmessage = (event) => this.#receive(event.data);
    this.#socket.onclose = () => {
      this.dispatchEvent(new CustomEvent("lost"));
      setTimeout(() => this.open(), RETRY_MS);
    };
  }

  send(type, values = {}) {
    if (this.#socket?.readyState === WebSocket.OPEN) {
      this.#socket.send(JSON.stringify({ type, ...values }));
    }
  }

  #receive(data) {
    if (typeof data === "string") {
      const { type, ...detail } = JSON.parse(data);
      this.dispatchEvent(new CustomEvent(type, { detail }));
      return;
    }
    const view = new DataView(data);
    const detail = {
      number: view.getUint32(4, true),
      stamp: view.getFloat64(8, true),
      wall: view.getFloat64(16, true),
      bytes: data.slice(HEADER_BYTES),
    };
    this.dispatchEvent(new CustomEvent(KINDS[view.getUint8(0)], { detail }));
  }
}
