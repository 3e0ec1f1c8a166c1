"use strict";
(() => {
const data = JSON.parse(document.getElementById("slider-data").textContent);
const columns = {};
for (const [name, packed] of Object.entries(data.ticks)) {
  columns[name] = new Float32Array(Uint8Array.from(atob(packed), (c) => c.charCodeAt(0)).buffer);
}
const count = columns.time_s.length;
const byId = (id) => document.getElementById(id);
const slider = byId("tick"), scene = byId("scene"), band = byId("reason-band"), picture = byId("picture");
const COLOURS = { cruise: "#2e8b57", bend: "#e0a800", braking_ahead: "#d1341f", end_of_route: "#7d3c98", accelerating: "#1f5fa8",
  obstacle: "#8b0000", traffic_light: "#e67e22", path_timeout: "#202124", odometry_timeout: "#5f6368" };
const OTHER = ["#16a085", "#af7ac5", "#a04000", "#2c3e50"];
const LIGHTS = ["#d1341f", "#e0a800", "#2e8b57"];
const CAR_M = [4.7, 2.0], LANE_M = 3.5, VIEW_M = 62;
const OBSTACLE_STEP_S = 0.5;
// A colour of page.css, which depends on whether the page is light or dark.
function pageColour(name) {
  scene.style.color = `var(--${name})`;
  return getComputedStyle(scene).color;
}
// The colour of a share of the full speed, as speed_colours of road_markings.py.
function speedColour(share) {
  const place = 2 * Math.min(Math.max(share, 0), 1), first = Math.min(Math.floor(place), 1);
  const [from, to] = data.speed_colours.slice(first, first + 2);
  return `rgb(${from.map((value, i) => 255 * (value + (place - first) * (to[i] - value)))})`;
}
const colourOf = (number) => number < 0 ? "#9aa0a6" : COLOURS[data.reasons[number][0]] || OTHER[number % OTHER.length];
const maxSpeed = Math.max(1, ...data.paths.flatMap(([, rows]) => rows.map((row) => row[2])).slice(0, 100000));

// The index of the last entry [time, ...] that is not later; -1 if there is none.
function lastBefore(entries, time, timeOf = (entry) => entry[0]) {
  let low = 0, high = entries.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timeOf(entries[middle]) <= time) low = middle + 1; else high = middle;
  }
  return low - 1;
}
function latest(entries, time) {
  const index = lastBefore(entries, time);
  return index < 0 ? null : entries[index][1];
}

// Obstacles are recorded twice a second; between two records they move evenly.
function obstaclesAt(time) {
  const index = lastBefore(data.obstacles, time), next = data.obstacles[index + 1];
  if (index < 0) return [];
  const [since, rows] = data.obstacles[index];
  const share = next ? 1 - (next[0] - time) / Math.min(OBSTACLE_STEP_S, next[0] - since) : 0;
  if (share <= 0) return rows;
  const to = new Map(next[1].map((row) => [row[0], row]));
  return rows.map((row) => {
    const end = to.get(row[0]);
    return end ? [row[0], row[1] + share * (end[1] - row[1]), row[2] + share * (end[2] - row[2]), ...row.slice(3)] : row;
  });
}

function context(canvas) {
  const ratio = window.devicePixelRatio || 1, box = canvas.getBoundingClientRect();
  canvas.width = Math.round(box.width * ratio);
  canvas.height = Math.round(box.height * ratio);
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  return [pen, box.width, box.height];
}

function polyline(pen, points, style, width, dash = []) {
  pen.strokeStyle = style; pen.lineWidth = width; pen.setLineDash(dash);
  pen.beginPath();
  points.forEach(([x, y], number) => number ? pen.lineTo(x, y) : pen.moveTo(x, y));
  pen.stroke();
  pen.setLineDash([]);
}
function box(pen, x, y, yaw, length, width, colour) {
  pen.save();
  pen.translate(x, y); pen.rotate(yaw);
  pen.fillStyle = colour;
  pen.fillRect(-length / 2, -width / 2, length, width);
  pen.fillStyle = "rgba(255, 255, 255, 0.75)";
  pen.fillRect(length / 4 - 0.3, -width * 0.4, 0.6, width * 0.8);
  pen.restore();
}

// The view from above, the car's heading points up, in metres.
function drawScene(tick) {
  const [pen, width, height] = context(scene);
  const x = columns.x_m[tick], y = columns.y_m[tick], yaw = columns.yaw_rad[tick], time = columns.time_s[tick];
  const scale = Math.max(width, height) / VIEW_M;
  pen.translate(width / 2, height * 0.72);
  pen.scale(scale, -scale);
  pen.rotate(Math.PI / 2 - yaw);
  pen.translate(-x, -y);
  pen.lineCap = pen.lineJoin = "round";
  const near = (point) => Math.hypot(point[0] - x, point[1] - y) < 1.5 * VIEW_M;
  let piece = [];
  const pieces = [piece];
  for (const point of data.route) {
    if (near(point)) piece.push(point);
    else if (piece.length) pieces.push(piece = []);
  }
  for (const part of pieces) polyline(pen, part, pageColour("road"), LANE_M);
  for (const part of pieces) polyline(pen, part, "#fff", 0.15, [1, 1.5]);
  const path = latest(data.paths, time) || [];
  for (let i = 1; i < path.length; i++) {
    polyline(pen, path.slice(i - 1, i + 1), speedColour(path[i][2] / maxSpeed), 0.8);
  }
  const states = latest(data.lights, time) || {};
  for (const [id, [lineX, lineY, half]] of Object.entries(data.lines)) {
    pen.fillStyle = LIGHTS[states[id]] || "#5f6368";
    pen.beginPath(); pen.arc(lineX, lineY, Math.min(half, 1.2), 0, 7); pen.fill();
  }
  for (const [, boxX, boxY, boxYaw, length, side] of obstaclesAt(time)) {
    box(pen, boxX, boxY, boxYaw, Math.max(length, 0.8), Math.max(side, 0.8), "#8b0000");
  }
  box(pen, x, y, yaw, ...CAR_M, "#193c78");
}

function drawBand(tick) {
  const [pen, width, height] = context(band);
  const at = (number) => (number / Math.max(count - 1, 1)) * width;
  for (let from = 0, to; from < count; from = to) {
    for (to = from + 1; to < count && columns.reason[to] === columns.reason[from]; to++);
    pen.fillStyle = colourOf(columns.reason[from]);
    pen.fillRect(at(from), 0, Math.max(at(to) - at(from), 1), height);
  }
  pen.fillStyle = "#000";
  pen.fillRect(at(tick) - 1, 0, 2, height);
}

const shown = (value, digits, unit) => Number.isNaN(value) ? "–" : value.toFixed(digits) + unit;
const degrees = (radians) => radians * 180 / Math.PI;
const TERMS = [
  ["time", (c, i) => shown(data.start_s + c.time_s[i], 2, " s")],
  ["distance", (c, i) => shown(c.s_m[i], 1, " m")],
  ["speed", (c, i) => shown(c.speed_mps[i], 2, " m/s")],
  ["target speed", (c, i) => shown(c.target_mps[i], 2, " m/s")],
  ["cross-track error", (c, i) => shown(c.cross_track_m[i], 3, " m")],
  ["heading error", (c, i) => shown(degrees(c.heading_error_rad[i]), 2, "°")],
  ["steer", (c, i) => shown(c.steer[i], 3, "")],
  ["throttle", (c, i) => shown(c.throttle[i], 2, "")],
  ["brake", (c, i) => shown(c.brake[i], 2, "")],
];
const values = TERMS.map(([name]) => {
  const row = byId("terms").insertRow();
  row.insertCell().textContent = name;
  const value = row.insertCell();
  value.className = "value";
  return value;
});

function show() {
  const tick = Number(slider.value), number = columns.reason[tick], time = columns.time_s[tick];
  const [name, meaning] = number < 0 ? ["no reason", "the driving software publishes none"] : data.reasons[number];
  byId("reason").textContent = name.replaceAll("_", " ");
  byId("reason").style.borderColor = colourOf(number);
  const detail = data.details[columns.detail[tick]];
  byId("reason-meaning").textContent = detail ? `${meaning}: ${detail}` : meaning;
  slider.setAttribute("aria-valuetext", `${(data.start_s + time).toFixed(2)} s: ${byId("reason").textContent}`);
  TERMS.forEach(([, text], row) => { values[row].textContent = text(columns, tick); });
  if (data.pictures.length) {
    let nearest = Math.max(lastBefore(data.pictures, time), 0);
    const next = data.pictures[nearest + 1];
    if (next && next[0] - time < time - data.pictures[nearest][0]) nearest++;
    const address = "data:" + "image/jpeg;base64," + data.pictures[nearest][1];
    if (picture.getAttribute("src") !== address) picture.setAttribute("src", address);
    byId("picture-time").textContent = `camera at ${(data.start_s + data.pictures[nearest][0]).toFixed(2)} s`;
  }
  drawScene(tick);
  drawBand(tick);
}
function moveTo(tick) {
  slider.value = Math.min(Math.max(tick, 0), count - 1);
  show();
}

data.reasons.forEach(([name], number) => {
  const button = document.createElement("button");
  button.textContent = name.replaceAll("_", " ");
  button.style.borderColor = colourOf(number);
  button.title = "go to the next place";
  button.addEventListener("click", () => {
    const here = Number(slider.value);
    const starts = [...columns.reason.keys()].filter((i) => columns.reason[i] === number && (!i || columns.reason[i - 1] !== number));
    moveTo(starts.find((start) => start > here) ?? starts[0]);
  });
  byId("reason-buttons").append(button);
});

let playing = 0;
function play(from, startedAt) {
  const time = from + (performance.now() - startedAt) / 1000;
  const tick = lastBefore(columns.time_s, time, (value) => value);
  moveTo(tick);
  if (tick < count - 1) playing = requestAnimationFrame(() => play(from, startedAt)); else stop();
}
function stop() {
  cancelAnimationFrame(playing);
  playing = 0;
  byId("play").textContent = "Play";
}
byId("play").addEventListener("click", () => {
  if (playing) { stop(); return; }
  byId("play").textContent = "Pause";
  if (Number(slider.value) >= count - 1) slider.value = 0;
  play(columns.time_s[slider.value], performance.now());
});
band.addEventListener("pointerdown", (event) => {
  const area = band.getBoundingClientRect();
  moveTo(Math.round((event.clientX - area.left) / area.width * (count - 1)));
  slider.focus();
  event.preventDefault();
});
slider.max = count - 1;
slider.value = 0;
slider.addEventListener("input", () => { stop(); show(); });
window.addEventListener("resize", show);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
byId("picture-box").hidden = !data.pictures.length;
show();
})();
