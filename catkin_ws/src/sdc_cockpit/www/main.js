// The page of the cockpit: connects its parts. The large libraries are loaded after the first
// messages, so that the picture does not wait for them.
import { Connection, token } from "./connection.js";
import { Controls } from "./controls.js";
import { addLog, clearLog, set, showInstruments, showNodes } from "./panels.js";
import { Drives } from "./drives.js";
import { Parameters } from "./parameters.js";
import { aheadOnPath, Picture } from "./picture.js";

const NOTICE_MS = 4000;
const OBSTACLE_AHEAD_M = 30;
const MODES = { none: "no drive runs", starting: "starting", over: "the drive is over", stack: "the stack drives", person: "a viewer drives", braking: "braking", "other program": "another program drives" };
// Without a simulation these have no effect.
const NEED_SIMULATION = ["drive", "pause", "step", "reset", "obstacle", "mask"];
// While this page can start a drive, their place is that of Start.
const WHILE_DRIVING = ["drive", "pause", "step", "reset", "obstacle"];
const $ = (id) => document.getElementById(id);

const connection = new Connection();
const picture = new Picture(connection, $("picture"), $("no-picture"));
const controls = new Controls(connection, $("pads"));
const drives = new Drives(connection, notice);
new Parameters(connection);
let state = null, viewer = null, speedScale = null, scene = null, plots = null, road = 0, maskShown = false, noticeTimer = 0;
window.cockpit = { picture, get state() { return state; }, get driving() { return controls.driving; }, get held() { return controls.held; }, get scene() { return scene !== null; } };

function notice(text, level = "info") {
  clearTimeout(noticeTimer);
  Object.assign($("notice"), { textContent: text, className: level, hidden: false });
  noticeTimer = setTimeout(() => { $("notice").hidden = true; }, NOTICE_MS);
}

function showDriver(mode, mine) {
  set($("driver"), "textContent", mine ? "you drive" : MODES[mode] ?? mode);
  set($("driver"), "className", `badge ${mode}`);
  set($("drive"), "textContent", mine ? "Give back" : "Take over");
  $("drive").classList.toggle("active", mine);
  set($("pads"), "hidden", !mine);
  document.body.classList.toggle("driving", mine);
}

async function loadRoad(number) {
  road = number;
  const answer = await fetch(`api/road?token=${encodeURIComponent(token)}`);
  if (!answer.ok) throw new Error(`the road: ${answer.status} ${answer.statusText}`);
  scene.setRoad(await answer.json());
}

function failed(panel) {
  return (error) => notice(`${panel}: ${error.message}`, "warn");
}

async function loadLibraries() {
  import("./plots.js").then(({ Plots }) => { plots = new Plots($("speed-plot"), $("error-plot")); })
    .catch(failed("Plots"));
  try {
    const { Scene } = await import("./scene.js");
    scene = new Scene($("scene"));
    scene.setSpeedScale(...speedScale);
    $("no-scene").hidden = true;
  } catch (error) {
    $("no-scene").textContent = `This browser shows no 3D view: ${error.message}`;
    failed("3D view")(error);
  }
}

function onState(news) {
  if (state === null) setTimeout(loadLibraries, 300);
  state = news;
  const mine = state.mode === "person" && state.driver === viewer;
  if (mine !== controls.driving && !mine && state.mode === "braking") notice("The controls did not arrive: the car brakes", "warn");
  controls.setDriving(mine);
  showRunning(mine);
  showInstruments(state);
  drives.update(state);
  plots?.add(state);
  scene?.update(state);
  if (scene && state.road > 0 && state.road !== road) loadRoad(state.road).catch(failed("3D view"));
}

// What is on the page belongs to the drive that runs, or to one that is over.
function showRunning(mine) {
  const { idle } = drives, { phase, running } = state, time = state.t === null ? "" : `${state.t.toFixed(1)} s`;
  showDriver(idle ? "none" : phase ? (time ? "over" : "starting") : state.mode, mine);
  set($("no-picture"), "textContent", idle ? "No drive runs: press Start" : phase ?? "waiting for the first picture");
  set($("clock"), "textContent", idle ? time && `the last one ended at ${time}` : phase ?? time + (running ? "" : ", paused"));
  if (!idle && !time) picture.await();
  document.body.classList.toggle("past", idle && time !== "");
  set($("pause"), "textContent", idle || state.running || time === "" ? "Pause" : "Resume");
  for (const id of WHILE_DRIVING) set($(id), "hidden", idle);
  for (const id of NEED_SIMULATION) set($(id), "disabled", idle || state.t === null);
}

function obstacle(place) {
  if (place) connection.send("obstacle", place);
}

function clicked(event, place) {
  if (place) connection.send(event.shiftKey ? "goal" : "obstacle", place);
}

function setMask(shown) {
  maskShown = shown;
  $("mask").setAttribute("aria-pressed", shown);
  connection.send("show", { mask: shown });
  picture.showMask(shown);
}

function setView(view) {
  for (const button of $("views").children) button.setAttribute("aria-pressed", button.dataset.view === view);
  scene?.setView(view);
}

const actions = {
  drive: () => (controls.driving ? controls.giveBack() : controls.takeOver()),
  pause: () => connection.send(state?.running === false ? "resume" : "pause"),
  step: () => connection.send("step"),
  reset: () => connection.send("reset"),
  obstacle: () => state?.pose && obstacle(aheadOnPath(state.pose, state.path, OBSTACLE_AHEAD_M)),
  mask: () => setMask(!maskShown),
  "to-drives": () => {
    $("drives-panel").scrollIntoView();
    $("start-form").querySelector("input").focus();
  },
  help: () => {
    $("keys").hidden = !$("keys").hidden;
    $("help").setAttribute("aria-expanded", !$("keys").hidden);
  },
};
const SHORTCUTS = { KeyP: "drive", KeyK: "pause", Period: "step", Backspace: "reset", KeyO: "obstacle", KeyM: "mask", KeyH: "help", KeyG: "to-drives" };

for (const [id, action] of Object.entries(actions)) $(id).addEventListener("click", action);
for (const button of $("views").children) button.addEventListener("click", () => setView(button.dataset.view));
$("picture").addEventListener("click", (event) => clicked(event, picture.place(event, state?.pose)));
$("scene").addEventListener("click", (event) => clicked(event, scene?.place(event)));
$("level").addEventListener("change", () => { $("log").className = `scroll ${$("level").value}`; });
$("log").classList.add("info");
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.repeat || event.target.matches("select, input")) return;
  if (event.code in SHORTCUTS) {
    event.preventDefault();
    $(SHORTCUTS[event.code]).click();
  } else if (event.code === "KeyV" && scene) setView(scene.nextView());
  else if (controls.driving && event.code === "KeyQ") connection.send("reverse");
  else if (controls.driving && event.code === "Escape") controls.giveBack();
});

connection.addEventListener("hello", ({ detail }) => {
  viewer = detail.viewer;
  speedScale = [detail.full_speed, detail.speed_colours];
  clearLog();
  addLog(detail.log);
  if (maskShown) connection.send("show", { mask: true });
});
connection.addEventListener("state", ({ detail }) => onState(detail));
connection.addEventListener("nodes", ({ detail }) => showNodes(detail.nodes));
connection.addEventListener("log", ({ detail }) => addLog(detail.lines));
connection.addEventListener("notice", ({ detail }) => notice(detail.text, detail.level));
// What fails in any panel, and has no notice of its own.
addEventListener("error", ({ error }) => error && failed("This page")(error));
addEventListener("unhandledrejection", ({ reason }) => failed("This page")(reason));
connection.addEventListener("lost", () => {
  controls.setDriving(false);
  showDriver("connection lost", false);
});

let counted = { drawn: 0, at: performance.now() };
setInterval(() => {
  const now = performance.now();
  $("picture-rate").textContent = `${(((picture.drawn - counted.drawn) * 1000) / (now - counted.at)).toFixed(0)} pictures/s`;
  counted = { drawn: picture.drawn, at: now };
}, 1000);
connection.open();
