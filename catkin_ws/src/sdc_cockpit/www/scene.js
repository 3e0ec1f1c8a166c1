// The 3D view. Axes as in ROS: x forward, y left, z up, metres.
import * as THREE from "../lib/three.module.js";

const SKY = 0x9fc3e6, GRASS = 0x4b6b45, ASPHALT = 0x3a3e44;
const KIND_COLOURS = { car: 0xc0392b, pedestrian: 0xe67e22, obstacle: 0xb07a3c };
const LIGHT_COLOURS = [0xff3b30, 0xffcc00, 0x34e36b, 0x30343a, 0x30343a];
const PATH_WIDTH = 0.7;
const VIEWS = ["chase", "top", "driver"];
// A slow machine draws less often: drawing takes at most this share of the time.
const LARGEST_SHARE = 0.35;

function mesh(geometry, colour, material = THREE.MeshLambertMaterial) {
  return new THREE.Mesh(geometry, new material({ color: colour }));
}

function box(length, width, height, colour, x = 0, y = 0, z = 0) {
  const one = mesh(new THREE.BoxGeometry(length, width, height), colour);
  one.position.set(x, y, z);
  return one;
}

function car(colour) {
  const group = new THREE.Group();
  group.add(box(4.7, 1.9, 0.62, colour, 0, 0, 0.63), box(2.5, 1.66, 0.52, 0x1c232b, -0.25, 0, 1.18));
  group.add(box(1.5, 1.5, 0.06, colour, -0.35, 0, 1.47));
  for (const [x, y] of [[1.4, 0.85], [1.4, -0.85], [-1.45, 0.85], [-1.45, -0.85]]) {
    const wheel = mesh(new THREE.CylinderGeometry(0.34, 0.34, 0.24, 18), 0x14171a);
    wheel.position.set(x, y, 0.34);
    group.add(wheel);
  }
  for (const y of [0.65, -0.65]) {
    group.add(box(0.06, 0.34, 0.14, 0xff2a1c, -2.36, y, 0.78), box(0.06, 0.34, 0.14, 0xfff6d8, 2.36, y, 0.7));
  }
  return group;
}

function segments(numbers, z) {
  const positions = new Float32Array((numbers.length / 2) * 3);
  for (let i = 0; i < numbers.length / 2; i += 1) positions.set([numbers[2 * i], numbers[2 * i + 1], z], 3 * i);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  return geometry;
}

function dots(colour, size) {
  const one = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ color: colour, size }));
  one.frustumCulled = false;
  return one;
}

// Points without a height lie on the ground.
function setDots(one, points) {
  one.visible = points.length > 0;
  if (!one.visible) return;
  const positions = new Float32Array(points.flatMap(([x, y, z]) => [x, y, z ?? 0.3]));
  one.geometry.dispose();
  one.geometry = new THREE.BufferGeometry();
  one.geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
}

export class Scene {
  view = "chase";
  #renderer; #scene = new THREE.Scene(); #camera = new THREE.PerspectiveCamera(60, 4 / 3, 0.3, 700);
  #car = car(0x2f74c0); #road = new THREE.Group(); #things = new THREE.Group(); #lights = new THREE.Group();
  #ground; #path; #points; #fixes; #state = null; #shown = null; #notBefore = 0; #fullSpeed; #speedColours; #canvas; #yaw = null;
  #thingsKey = ""; #lightsKey = "";

  // Throws an error where the browser has no WebGL.
  constructor(canvas) {
    this.#canvas = canvas;
    this.#renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.#scene.background = new THREE.Color(SKY);
    this.#scene.fog = new THREE.Fog(SKY, 120, 420);
    this.#scene.add(new THREE.HemisphereLight(0xffffff, 0x6b7a5c, 0.9));
    const sun = new THREE.DirectionalLight(0xfff2dd, 0.55);
    sun.position.set(40, -60, 90);
    this.#ground = mesh(new THREE.PlaneBufferGeometry(1600, 1600), GRASS, THREE.MeshBasicMaterial);
    this.#ground.position.z = -0.08;
    const material = new THREE.MeshBasicMaterial({
      vertexColors: THREE.VertexColors, side: THREE.DoubleSide, transparent: true, opacity: 0.85,
    });
    this.#path = new THREE.Mesh(new THREE.BufferGeometry(), material);
    this.#path.frustumCulled = false;
    this.#points = dots(0xffe14d, 0.16);
    this.#fixes = dots(0xff3fd8, 0.5);
    this.#scene.add(this.#points, this.#fixes);
    this.#camera.up.set(0, 0, 1);
    this.#scene.add(sun, this.#ground, this.#road, this.#path, this.#car, this.#things, this.#lights);
    requestAnimationFrame(() => this.#frame());
  }

  // The colours, red, green and blue in 0..1, are those of standstill, half and full speed.
  setSpeedScale(fullSpeed, colours) {
    this.#fullSpeed = fullSpeed;
    this.#speedColours = colours.map((rgb) => new THREE.Color(...rgb));
  }

  setView(view) {
    this.view = view;
    this.#shown = null;
  }

  nextView() {
    return VIEWS[(VIEWS.indexOf(this.view) + 1) % VIEWS.length];
  }

  setRoad({ route, edges, dashes, surface }) {
    this.#road.clear ? this.#road.clear() : this.#road.remove(...this.#road.children);
    const geometry = segments(surface, 0);
    const index = [];
    for (let i = 0; i < surface.length / 2; i += 4) index.push(i, i + 1, i + 2, i, i + 2, i + 3);
    geometry.setIndex(index);
    const asphalt = mesh(geometry, ASPHALT, THREE.MeshBasicMaterial);
    asphalt.material.side = THREE.DoubleSide;
    const white = new THREE.LineBasicMaterial({ color: 0xf4f4f0 });
    this.#road.add(asphalt, new THREE.LineSegments(segments(edges, 0.03), white));
    this.#road.add(new THREE.LineSegments(segments(dashes, 0.03), white));
    this.#road.add(new THREE.Line(segments(route, 0.05), new THREE.LineBasicMaterial({ color: 0x59c2ff })));
    for (const one of this.#road.children) one.frustumCulled = false;
    this.#shown = null;
  }

  update(state) {
    this.#state = state;
  }

  // Return the place on the ground at a click, in the map frame, or null for the sky.
  place(event) {
    const area = this.#canvas.getBoundingClientRect();
    const point = new THREE.Vector2(
      (2 * (event.clientX - area.left)) / area.width - 1, 1 - (2 * (event.clientY - area.top)) / area.height,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(point, this.#camera);
    const hit = ray.ray.intersectPlane(new THREE.Plane(new THREE.Vector3(0, 0, 1), 0), new THREE.Vector3());
    return hit && { x: hit.x, y: hit.y };
  }

  #frame() {
    requestAnimationFrame(() => this.#frame());
    const now = performance.now();
    const size = `${this.#canvas.clientWidth} ${this.#canvas.clientHeight}`;
    if (!this.#state?.pose || now < this.#notBefore || (this.#shown?.state === this.#state && this.#shown.size === size)) return;
    if (!this.#shown || this.#shown.size !== size) {
      this.#renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
      this.#renderer.setSize(this.#canvas.clientWidth, this.#canvas.clientHeight, false);
      this.#camera.aspect = this.#canvas.clientWidth / Math.max(1, this.#canvas.clientHeight);
      this.#camera.updateProjectionMatrix();
    }
    this.#shown = { state: this.#state, size };
    this.#place();
    this.#renderer.render(this.#scene, this.#camera);
    this.#notBefore = now + (performance.now() - now) / LARGEST_SHARE;
  }

  #place() {
    const { pose: [x, y, yaw], path, obstacles, lights, points, fixes } = this.#state;
    this.#car.position.set(x, y, 0);
    this.#car.rotation.z = yaw;
    this.#ground.position.x = x;
    this.#ground.position.y = y;
    this.#drawPath(path);
    this.#drawThings(obstacles);
    this.#drawLights(lights);
    setDots(this.#points, points);
    setDots(this.#fixes, fixes);
    this.#aim(x, y, yaw);
  }

  #aim(x, y, yaw) {
    const turn = this.#yaw === null ? 0 : Math.atan2(Math.sin(yaw - this.#yaw), Math.cos(yaw - this.#yaw));
    this.#yaw = this.#yaw === null || Math.abs(turn) > 1 ? yaw : this.#yaw + 0.25 * turn;
    const used = this.view === "chase" ? this.#yaw : yaw;
    const [c, s] = [Math.cos(used), Math.sin(used)];
    this.#car.visible = this.view !== "driver";
    this.#camera.up.set(0, 0, 1);
    if (this.view === "chase") {
      this.#camera.position.set(x - 10 * c, y - 10 * s, 5);
      this.#camera.lookAt(x + 9 * c, y + 9 * s, 0.5);
    } else if (this.view === "driver") {
      this.#camera.position.set(x + 0.7 * c, y + 0.7 * s, 1.7);
      this.#camera.lookAt(x + 20 * c, y + 20 * s, 1.5);
    } else {
      this.#camera.up.set(c, s, 0);
      this.#camera.position.set(x + 14 * c, y + 14 * s, 55);
      this.#camera.lookAt(x + 14 * c, y + 14 * s, 0);
    }
  }

  #drawPath(path) {
    const positions = new Float32Array(path.length * 6);
    const colours = new Float32Array(path.length * 6);
    const index = [];
    const colour = new THREE.Color();
    path.forEach(([x, y, speed], i) => {
      const [px, py] = path[Math.max(0, i - 1)];
      const [nx, ny] = path[Math.min(path.length - 1, i + 1)];
      const length = Math.hypot(nx - px, ny - py) || 1;
      const [lx, ly] = [(-(ny - py) / length) * 0.5 * PATH_WIDTH, ((nx - px) / length) * 0.5 * PATH_WIDTH];
      positions.set([x + lx, y + ly, 0.08, x - lx, y - ly, 0.08], 6 * i);
      const place = 2 * Math.min(Math.max(speed / this.#fullSpeed, 0), 1), first = Math.min(Math.floor(place), 1);
      colour.copy(this.#speedColours[first]).lerp(this.#speedColours[first + 1], place - first);
      colours.set([colour.r, colour.g, colour.b, colour.r, colour.g, colour.b], 6 * i);
      if (i) index.push(2 * i - 2, 2 * i - 1, 2 * i, 2 * i, 2 * i - 1, 2 * i + 1);
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    geometry.setIndex(index);
    this.#path.geometry.dispose();
    this.#path.geometry = geometry;
    this.#path.visible = path.length > 1;
  }

  #drawThings(obstacles) {
    const key = obstacles.map(({ id, kind, box: b }) => [id, kind, ...b.slice(3)].join()).join(";");
    if (key !== this.#thingsKey) {
      this.#thingsKey = key;
      this.#things.remove(...this.#things.children);
      for (const { kind, box: [, , , length, width, height] } of obstacles) {
        const colour = KIND_COLOURS[kind] ?? 0xb07a3c;
        const one = new THREE.Group();
        one.add(kind === "car" ? car(colour) : box(length, width, height, colour, 0, 0, 0.5 * height));
        this.#things.add(one);
      }
    }
    obstacles.forEach(({ box: [x, y, yaw] }, i) => {
      this.#things.children[i].position.set(x, y, 0);
      this.#things.children[i].rotation.z = yaw;
    });
  }

  #drawLights(lights) {
    const key = JSON.stringify(lights);
    if (key === this.#lightsKey) return;
    this.#lightsKey = key;
    this.#lights.remove(...this.#lights.children);
    for (const [x, y, yaw, lineX, lineY, state] of lights) {
      const pole = box(0.16, 0.16, 3.4, 0x55595e, x, y, 1.7);
      const lamp = mesh(new THREE.SphereGeometry(0.36, 14, 10), LIGHT_COLOURS[state], THREE.MeshBasicMaterial);
      lamp.position.set(x, y, 3.4);
      const line = mesh(new THREE.PlaneBufferGeometry(0.4, 3.2), 0xf4f4f0, THREE.MeshBasicMaterial);
      line.position.set(lineX, lineY, 0.05);
      line.rotation.z = yaw;
      this.#lights.add(pole, lamp, line);
    }
  }
}
