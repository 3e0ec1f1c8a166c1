// Instruments, nodes and log.
const LARGEST_LOG = 300;
const $ = (id) => document.getElementById(id);
// Offers the browser to break a name after each slash, and nowhere else.
const breakable = (name) => name.split(/(?<=\/)/).flatMap((part) => [document.createElement("wbr"), part]);
const number = (value, digits) => (value === null || value === undefined ? "–" : value.toFixed(digits).replace(/^-(?=[0.]+$)/, ""));

// Change a property of an element; an equal value costs no layout.
export function set(element, property, value) {
  if (element[property] !== value) element[property] = value;
}

export function showInstruments({ speed, cross_track: error, lane_offset: offset, command, reason }) {
  set($("speed"), "textContent", number(speed, 1));
  set($("cross-track"), "textContent", number(error, 2));
  set($("lane-offset"), "textContent", number(offset, 2));
  set($("gear"), "textContent", command?.hand_brake ? "P" : command?.gear ?? "–");
  for (const name of ["throttle", "brake"]) {
    set($(name), "value", command?.[name] ?? 0);
    set($(name).nextElementSibling, "textContent", number(command?.[name], 2));
  }
  set($("steer").style, "left", `${Math.round(50 + 48 * (command?.steer ?? 0))}%`);
  set($("steer-value"), "textContent", number(command?.steer, 2));
  set($("reason"), "textContent", reason ?? "–");
}

function row(kind, name, rate = "") {
  const line = document.createElement("tr");
  line.className = kind;
  for (const [text, style] of [[name, ""], [rate, "rate"]]) {
    const cell = line.insertCell();
    cell.append(...breakable(text));
    cell.className = style;
  }
  return line;
}

export function showNodes(nodes) {
  const rows = nodes.flatMap(({ node, topics }) => [
    row("node", node), ...topics.map(([topic, rate]) => row("topic", topic, rate.toFixed(1))),
  ]);
  $("nodes").replaceChildren(...rows);
}

export function addLog(lines) {
  const list = $("log");
  const atEnd = list.scrollHeight - list.scrollTop - list.clientHeight < 30;
  for (const { level, node, text } of lines) {
    const item = document.createElement("li");
    const source = document.createElement("b");
    item.className = level;
    source.textContent = `${level} ${node}  `;
    item.append(source, text.startsWith(`${node}: `) ? text.slice(node.length + 2) : text);
    list.append(item);
  }
  while (list.childElementCount > LARGEST_LOG) list.firstElementChild.remove();
  if (atEnd) list.scrollTop = list.scrollHeight;
}

export function clearLog() {
  $("log").replaceChildren();
}
