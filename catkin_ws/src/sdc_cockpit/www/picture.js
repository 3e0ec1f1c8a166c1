// The camera picture with the lane mask as an overlay. Only the newest picture is drawn.
import { set } from "./panels.js";

// The front camera: 90 degrees wide, mounted at x 0.7, z 1.7, 0.5 degrees nose down.
const FOCAL_PX = 320, CENTRE = [320, 240], MOUNT_X = 0.7, MOUNT_Z = 1.7, PITCH = (0.5 * Math.PI) / 180;
const MASK_COLOUR = "#00ff6a";
const FARTHEST_M = 100;
const KEPT_LATENCIES = 2000;
const OVERLAY_LASTS_S = 0.5;

export class Picture {
  latencies = [];
  arrivals = [];
  drawn = 0;
  #canvas; #context; #tint; #connection;
  #waiting = null; #newest = 0; #mask = null; #overlay = null; #hint; #masked = false;

  constructor(connection, canvas, hint) {
    this.#canvas = canvas;
    this.#context = canvas.getContext("2d", { alpha: false });
    this.#tint = document.createElement("canvas");
    this.#connection = connection;
    this.#hint = hint;
    connection.addEventListener("hello", () => { this.#newest = 0; });
    connection.addEventListener("picture", (event) => this.#receive(event.detail));
    document.addEventListener("visibilitychange", () => this.#draw());
    connection.addEventListener("mask", (event) => this.#receiveMask(event.detail));
    connection.addEventListener("overlay", (event) => this.#receiveOverlay(event.detail));
  }

  // The pictures of the last drive go when the next one starts.
  await() {
    if (!this.#hint.hidden) return;
    this.#context.clearRect(0, 0, this.#canvas.width, this.#canvas.height);
    this.#hint.hidden = false;
  }

  // A mask that is on its way when masks are hidden is not shown.
  showMask(shown) {
    this.#masked = shown;
    if (!shown) this.#mask = this.#overlay = null;
  }

  // The picture of the lab on perception, which is shown in the place of the camera's.
  async #receiveOverlay({ bytes, stamp }) {
    const image = await createImageBitmap(new Blob([bytes], { type: "image/jpeg" }));
    this.#overlay?.image.close();
    this.#overlay = this.#masked ? { image, stamp } : null;
  }

  async #receive(detail) {
    this.#record(this.arrivals, detail.wall);
    const image = await createImageBitmap(new Blob([detail.bytes], { type: "image/jpeg" }));
    if (detail.number < this.#newest) {
      image.close();
      return;
    }
    this.#newest = detail.number;
    this.#waiting?.image.close();
    this.#waiting = { image, ...detail };
    this.#draw();
  }

  async #receiveMask(detail) {
    const image = await createImageBitmap(new Blob([detail.bytes], { type: "image/png" }));
    const context = this.#tint.getContext("2d");
    [this.#tint.width, this.#tint.height] = [image.width, image.height];
    context.drawImage(image, 0, 0);
    context.globalCompositeOperation = "multiply";
    context.fillStyle = MASK_COLOUR;
    context.fillRect(0, 0, image.width, image.height);
    this.#mask = this.#masked ? { stamp: detail.stamp } : null;
    image.close();
  }

  #record(latencies, wall) {
    if (!Number.isNaN(wall)) latencies.push(Date.now() - 1000 * wall);
    if (latencies.length > KEPT_LATENCIES) latencies.shift();
  }

  // Draws at once: a browser without a graphics card is late with its animation frames. A hidden page
  // draws nothing, so that the server sends it no more pictures.
  #draw() {
    if (this.#waiting === null || document.hidden) return;
    const { image, number, wall, stamp } = this.#waiting;
    const [hasMask, hasOverlay] = [this.#mask, this.#overlay].map((layer) => layer && Math.abs(layer.stamp - stamp) < OVERLAY_LASTS_S);
    this.#waiting = null;
    if (this.#canvas.width !== image.width || this.#canvas.height !== image.height) {
      [this.#canvas.width, this.#canvas.height] = [image.width, image.height];
    }
    this.#context.globalCompositeOperation = "source-over";
    this.#context.drawImage(hasOverlay ? this.#overlay.image : image, 0, 0);
    if (hasMask) {
      this.#context.globalCompositeOperation = "lighter";
      this.#context.drawImage(this.#tint, 0, 0);
    }
    image.close();
    this.drawn += 1;
    this.#record(this.latencies, wall);
    this.#connection.send("drawn", { picture: number });
    set(this.#hint, "hidden", true);
  }

  // Return the place on the road that a click shows, in the map frame, or null above the horizon.
  place(event, pose) {
    const box = this.#canvas.getBoundingClientRect();
    const right = ((event.clientX - box.left) / box.width) * 2 * CENTRE[0] - CENTRE[0];
    const down = ((event.clientY - box.top) / box.height) * 2 * CENTRE[1] - CENTRE[1];
    const angle = Math.atan2(down, FOCAL_PX) + PITCH;
    const depth = MOUNT_Z / Math.tan(angle);
    if (angle <= 0 || depth > FARTHEST_M || !pose) return null;
    const slant = Math.hypot(depth, MOUNT_Z) * Math.cos(Math.atan2(down, FOCAL_PX));
    return ahead(pose, MOUNT_X + depth, (-right / FOCAL_PX) * slant);
  }
}

// Return the point this far ahead and to the left of a pose.
export function ahead([x, y, yaw], forward, left = 0) {
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  return { x: x + c * forward - s * left, y: y + s * forward + c * left };
}

// Return the point this far ahead of a pose along the planned path, and straight on after its end.
export function aheadOnPath([x, y, yaw], path, distance) {
  let [place, left] = [[x, y, yaw], distance];
  for (const [nextX, nextY] of path) {
    const [dx, dy] = [nextX - place[0], nextY - place[1]];
    const step = Math.hypot(dx, dy);
    if (dx * Math.cos(place[2]) + dy * Math.sin(place[2]) <= 0) continue; // behind
    place[2] = Math.atan2(dy, dx);
    if (step >= left) break;
    [place, left] = [[nextX, nextY, place[2]], left - step];
  }
  return ahead(place, left);
}
