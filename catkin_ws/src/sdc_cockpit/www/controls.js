// Hands on the car: keyboard, touch pads and gamepad. While this page drives it repeats the
// controls; the server brakes the car when they stop to arrive.
const REPEAT_MS = 50;
const CONFIRM_MS = 2000;
const KEYS = {
  KeyW: "w", ArrowUp: "up", KeyS: "s", ArrowDown: "down", KeyA: "a", ArrowLeft: "left", KeyD: "d", ArrowRight: "right", Space: "space",
};
const DEAD_ZONE = 0.06;

export class Controls {
  driving = false;
  #held = new Set(); #connection; #timer = null;

  constructor(connection, pads) {
    this.#connection = connection;
    addEventListener("keydown", (event) => this.#onKey(event, true));
    addEventListener("keyup", (event) => this.#onKey(event, false));
    addEventListener("blur", () => this.#held.clear());
    document.addEventListener("visibilitychange", () => document.hidden && this.driving && this.giveBack());
    for (const pad of pads.querySelectorAll("button")) {
      const hold = (held) => {
        held ? this.#held.add(pad.dataset.key) : this.#held.delete(pad.dataset.key);
        pad.classList.toggle("held", held);
      };
      pad.addEventListener("pointerdown", (event) => {
        pad.setPointerCapture(event.pointerId);
        hold(true);
      });
      for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) pad.addEventListener(end, () => hold(false));
      pad.addEventListener("contextmenu", (event) => event.preventDefault());
    }
  }

  get held() {
    return [...this.#held];
  }

  takeOver() {
    this.#connection.send("drive");
    // At once: the answer may take longer than the server waits for controls.
    this.#repeat(true);
    setTimeout(() => this.driving || this.#repeat(false), CONFIRM_MS);
  }

  #repeat(on) {
    clearInterval(this.#timer);
    if (on) {
      this.#send();
      this.#timer = setInterval(() => this.#send(), REPEAT_MS);
    }
  }

  giveBack() {
    this.#connection.send("release");
  }

  // Called with what the server reports.
  setDriving(driving) {
    if (driving === this.driving) return;
    this.driving = driving;
    if (!driving) this.#held.clear();
    this.#repeat(driving);
  }

  #onKey(event, down) {
    const key = KEYS[event.code];
    if (!key || !this.driving || event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.("input, select")) return;
    down ? this.#held.add(key) : this.#held.delete(key);
    event.preventDefault();
    this.#send();
  }

  #send() {
    this.#connection.send(...(this.#gamepad() ?? ["keys", { held: this.held }]));
  }

  #gamepad() {
    for (const pad of navigator.getGamepads?.() ?? []) {
      if (pad?.mapping !== "standard" || !pad.connected) continue;
      const steer = Math.abs(pad.axes[0]) > DEAD_ZONE ? pad.axes[0] : 0;
      const [brake, throttle] = [pad.buttons[6].value, pad.buttons[7].value];
      if (this.#held.size === 0 && (steer || brake > DEAD_ZONE || throttle > DEAD_ZONE)) {
        return ["pedals", { throttle, brake, steer: Math.min(Math.max(steer, -1), 1) }];
      }
    }
    return null;
  }
}
