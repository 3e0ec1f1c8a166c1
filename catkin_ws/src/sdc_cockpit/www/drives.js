// Start, stop, list and compare drives.
import { token } from "./connection.js";
import { set } from "./panels.js";

const $ = (id) => document.getElementById(id);
const SWITCHES = ["sync", "camera"];
const NUMBERS = ["planned_speed_mps", "friction", "side_wind_mps", "seed"];
// What the car waited for is why it ended with these.
const WAITING = ["blocked", "timeout"];
const query = (values = {}) => new URLSearchParams({ ...values, token }).toString();
const fixed = (value, digits, unit) => (value === null || value === undefined ? "–" : `${value.toFixed(digits)} ${unit}`);

// How a drive ended, and where its report is: a link, or the path of the file.
function showEnd({ status, exit_status: exit, route_completion_percent: percent, duration_s: time, driving_score: score, problem, reason, report }, link) {
  const good = status === "completed" && !problem && !exit;
  const why = problem || (good ? `${fixed(time, 1, "s")}, driving score ${score.toFixed()}` : WAITING.includes(status) && reason);
  const text = `${status?.replaceAll("_", " ") ?? "failed, without a report"}${status ? ` at ${fixed(percent, 0, "%")}` : ""}${why ? `: ${why}` : ""}. `;
  if (link) link.textContent = `Open ${link.textContent}`;
  $("end").replaceChildren(text[0].toUpperCase() + text.slice(1), link ?? (report ? `Report: ${report}` : ""));
  Object.assign($("end"), { className: good ? "good" : "bad", hidden: false });
}

export class Drives {
  #connection; #notice; #offered = false; #running = null; #ended = null; #chosen = []; #begins = new URLSearchParams(location.search).has("drive");

  constructor(connection, notice) {
    this.#connection = connection;
    this.#notice = notice;
    connection.addEventListener("ended", ({ detail }) => showEnd(detail));
    connection.addEventListener("hello", ({ detail }) => this.#choices(detail));
    connection.addEventListener("drives", ({ detail }) => this.#show(detail));
    $("start-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#start(event.target.elements);
    });
    $("stop").addEventListener("click", () => connection.send("stop"));
    $("compare").addEventListener("click", () => this.#compare());
  }

  // Whether this page can start a drive, and none runs.
  get idle() {
    return this.#offered && this.#running === null;
  }

  // Called with each state of the drive.
  update({ progress, phase, reason }) {
    set($("progress"), "hidden", this.#running === null);
    set($("progress"), "value", progress ?? 0);
    const share = phase ? `: ${phase}` : progress === null ? "" : `, ${Math.round(100 * progress)} %`;
    set($("drive-state"), "textContent", this.#running ? `${this.#running} runs${share}` : "none runs");
    if (this.#ended === null || this.#running !== null) return;
    showEnd({ reason, ...this.#ended }, this.#files(this.#ended)[0]);
    this.#ended = null;
  }

  // Choices, ranges and sentences are those of the table of ./drive's arguments.
  #choices({ fields }) {
    for (const [name, { about, enum: names, minimum, maximum }] of Object.entries(fields)) {
      const input = $("start-form").elements[name];
      if (!input) continue;
      Object.assign(input, { title: about ?? "" }, names ? {} : { min: minimum ?? "", max: maximum ?? "" });
      if (names) input.replaceChildren(input.options[0], ...names.map((one) => new Option(one.replaceAll("_", " "), one)));
    }
  }

  #start(fields) {
    const values = {};
    for (const name of SWITCHES) values[name] = fields[name].checked;
    for (const name of NUMBERS) if (fields[name].value !== "") values[name] = Number(fields[name].value);
    if (fields.steering_method.value) values.steering_method = fields.steering_method.value;
    this.#connection.send("start", { scenario: fields.scenario.value, arguments: values });
  }

  #show({ offered, running, ended, past }) {
    this.#offered = offered;
    for (const id of ["drives-panel", "to-drives"]) $(id).hidden = !offered;
    this.#running = running;
    $("next-drive").hidden = !this.idle;
    $("stop").hidden = running === null;
    if (running !== null) $("end").hidden = true;
    const names = new Set(past.map(({ name }) => name));
    this.#chosen = this.#chosen.filter((name) => names.has(name));
    $("past-drives").hidden = past.length === 0;
    $("past").replaceChildren(...past.map((drive) => this.#row(drive)));
    this.#choose();
    if (this.idle && this.#begins) $("start-form").requestSubmit();
    if (this.idle) this.#begins = false;
    // Its banner comes with the next state, which has the last reason of its speed.
    this.#ended = past.find(({ name }) => name === ended) ?? null;
  }

  #row(drive) {
    const line = document.createElement("tr");
    const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: this.#chosen.includes(drive.name) });
    box.setAttribute("aria-label", `Compare ${drive.name}`);
    box.disabled = drive.status === null;
    box.addEventListener("change", () => {
      this.#chosen = this.#chosen.filter((name) => name !== drive.name);
      if (box.checked) this.#chosen = [...this.#chosen, drive.name].slice(-2);
      for (const one of $("past").querySelectorAll("input")) one.checked = this.#chosen.includes(one.dataset.name);
      this.#choose();
    });
    box.dataset.name = drive.name;
    line.insertCell().append(box);
    const good = drive.exit_status === 0;
    const texts = [
      drive.name, `${drive.status ?? "no report"}${good || drive.status !== "completed" ? "" : ", limits violated"}`, fixed(drive.route_completion_percent, 0, "%"),
      fixed(drive.duration_s, 1, "s"), fixed(drive.cross_track_rms_m, 3, "m"), fixed(drive.driving_score, 0, ""),
    ];
    for (const text of texts) line.insertCell().textContent = text;
    line.cells[1].title = drive.arguments.join(" ");
    line.cells[2].className = good ? "good" : "bad";
    line.cells[2].title = drive.problem;
    line.insertCell().append(...this.#files(drive));
    return line;
  }

  // Links to the files of a drive, the report first.
  #files({ name, page, key }) {
    const files = [["report.html", "report"], ["drive.log", "log"]].slice(page ? 0 : 1);
    return files.map(([file, textContent]) => Object.assign(document.createElement("a"), {
      href: `drives/${encodeURIComponent(name)}/${file}?key=${key}`, target: "_blank", rel: "noopener", textContent,
    }));
  }

  #choose() {
    $("compare").disabled = this.#chosen.length !== 2;
  }

  async #compare() {
    $("compare").disabled = true;
    const [a, b] = this.#chosen;
    try {
      const answer = await fetch(`api/compare?${query({ a, b })}`);
      const { text, picture, error } = await answer.json();
      if (error) throw new Error(error);
      $("comparison-text").textContent = text;
      $("comparison-picture").src = picture;
      $("comparison-picture").hidden = picture === "";
      $("comparison").hidden = false;
      $("comparison").scrollIntoView({ block: "nearest" });
    } catch (error) {
      this.#notice(`No comparison: ${error.message}`, "warn");
    }
    this.#choose();
  }
}
