// Live plots of the last seconds of simulated time, with Chart.js. They are drawn in turn, so that
// a picture waits for one of them at most.
import "../lib/chart.js";

const WINDOW_S = 30;
const REDRAW_MS = 200;
// Colours of page.css.
const [PLAN, SPEED, ERROR, TEXT, LINE] = ["warn", "accent", "good", "soft", "line"].map(pageColour);

function pageColour(name) {
  const probe = document.createElement("i");
  probe.style.color = `var(--${name})`;
  document.body.append(probe);
  const colour = getComputedStyle(probe).color;
  probe.remove();
  return colour;
}

function plot(canvas, colours, range) {
  const datasets = colours.map((colour) => ({
    data: [], borderColor: colour, borderWidth: 1.8, borderDash: colour === PLAN ? [6, 5] : [], pointRadius: 0, showLine: true, tension: 0,
  }));
  const tick = { color: TEXT, font: { size: 11 }, maxTicksLimit: 6, maxRotation: 0 };
  const grid = { color: LINE, borderColor: LINE };
  return new Chart(canvas, {
    type: "line",
    data: { datasets },
    options: {
      animation: false, parsing: false, normalized: true, responsive: true, maintainAspectRatio: false, events: [],
      plugins: { legend: { display: false }, tooltip: { enabled: false } },
      scales: {
        x: { type: "linear", display: false, grid, ticks: { ...tick, callback: (value) => (value < 0 ? "" : `${Math.round(value)} s`) } },
        y: { grid, ticks: { ...tick, maxTicksLimit: 5 }, ...range },
      },
    },
  });
}

export class Plots {
  #speed; #error; #next; #old = 0; #last = -Infinity;

  constructor(speedCanvas, errorCanvas) {
    this.#speed = plot(speedCanvas, [PLAN, SPEED], { suggestedMin: 0, suggestedMax: 12 });
    this.#error = plot(errorCanvas, [ERROR], { suggestedMin: -0.2, suggestedMax: 0.2 });
    this.#next = this.#speed;
    setInterval(() => this.#old > 0 && this.#draw(), REDRAW_MS);
  }

  add({ t, speed, plan, cross_track: error }) {
    if (t === null || t === this.#last) return;
    const rows = [[this.#speed.data.datasets[0], plan], [this.#speed.data.datasets[1], speed], [this.#error.data.datasets[0], error]];
    for (const [dataset, value] of rows) {
      if (t < this.#last) dataset.data.length = 0;
      if (value !== null) dataset.data.push({ x: t, y: value });
      while (dataset.data.length && dataset.data[0].x < t - WINDOW_S) dataset.data.shift();
    }
    this.#last = t;
    this.#old = 2;
  }

  #draw() {
    const t = this.#last;
    this.#old -= 1;
    const chart = this.#next;
    this.#next = chart === this.#speed ? this.#error : this.#speed;
    chart.options.scales.x.display = true;
    chart.options.scales.x.min = t - WINDOW_S;
    chart.options.scales.x.max = t;
    chart.update("none");
  }
}
