// The page of `rt-cli view`: shows images as they come, and sends what pointer, keys and menus ask for.

import { drawPlot, percent } from "./plot.js";

const get = (id) => document.getElementById(id);
const image = get("image");
const context = image.getContext("2d");
const decoder = new TextDecoder();

/** Pixels that a pointer may move between press and release to be a click. */
const CLICK = 4;
/** Drag of an arrow key in heights of the image: 5 degrees of the 180 that a height has. */
const ARROW = 5 / 180;
/** Factor of flight with Shift. */
const HASTE = 4;
/** Render time in seconds after which the end is announced. */
const LONG = 3;
/** Wait before the server is asked again when it did not answer, in milliseconds. */
const RETRY = 1000;

let session = null;
let state = { version: 0, view: -1 };
let errors = [];
let picked = null;
/** View that the marker of the last pick belongs to. */
let markedView = -1;

// Requests

async function post(path, value) {
  try {
    const response = await fetch(path, { method: "POST", body: JSON.stringify(value) });
    if (response.ok) return await response.json();
    toast(await response.text());
  } catch {
    // The loop that waits for images says that the connection is lost.
  }
  return undefined;
}

/** Sends values one after the other; those that wait are merged. */
function sender(path, merge) {
  const waiting = [];
  const sendAll = async () => {
    send.isBusy = true;
    while (waiting.length > 0) await post(path, waiting.shift());
    send.isBusy = false;
  };
  const send = (value) => {
    send.count += 1;
    const last = waiting.at(-1);
    if (last === undefined || !merge(last, value)) waiting.push(value);
    if (!send.isBusy) send.done = sendAll();
  };
  send.isBusy = false;
  send.count = 0;
  /** Settles when all values are sent. */
  send.done = Promise.resolve();
  return send;
}

const sendCamera = sender("camera", (last, next) => {
  const [[kind, value]] = Object.entries(next);
  if (kind === "zoom" && kind in last) {
    last.zoom += value;
    return true;
  }
  if (["orbit", "look", "pan", "fly"].includes(kind) && kind in last) {
    last[kind] = last[kind].map((part, index) => part + value[index]);
    return true;
  }
  return false;
});

const sendSettings = sender("settings", (last, next) => Object.assign(last, next));

// Images

async function watch() {
  for (;;) {
    try {
      session ??= await start();
      const sent = sendSettings.count;
      const response = await fetch(`frame?after=${state.version}&view=${state.view}&errors=${errors.length}`);
      if (!response.ok) throw new Error((await response.text()).trim());
      const bytes = new Uint8Array(await response.arrayBuffer());
      const end = bytes.indexOf(10);
      const next = JSON.parse(decoder.decode(bytes.subarray(0, end)));
      if (bytes.length > end + 1) await draw(bytes.subarray(end + 1), next.size, next.pixel_side);
      show(next, sent === sendSettings.count);
      banner(next.message);
    } catch (error) {
      const reason = error instanceof TypeError ? "rt-cli does not answer. Is it still running?" : error.message;
      banner(reason);
      state.version = 0;
      await new Promise((resolve) => setTimeout(resolve, RETRY));
    }
  }
}

/** Draws an image of this size; the pixels of a preview are squares of it. */
async function draw(png, [width, height], side) {
  const blob = new Blob([png], { type: "image/png" });
  const bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none" });
  if (image.width !== width || image.height !== height) {
    [image.width, image.height] = [width, height];
    get("frame").style.setProperty("--aspect", width / height);
  }
  context.imageSmoothingEnabled = false;
  context.clearRect(0, 0, width, height);
  context.drawImage(bitmap, 0, 0, bitmap.width * side, bitmap.height * side);
  bitmap.close();
  image.classList.remove("is-empty");
  image.classList.toggle("is-magnified", image.clientWidth * devicePixelRatio >= 2 * image.width);
}

/** Shows the state of the server. Menus keep their choice if settings were sent after the state was requested. */
function show(next, isCurrent) {
  const isOtherView = next.view !== state.view;
  const wasFinished = state.is_finished;
  state = next;
  if (isOtherView || next.first_error === 0) errors = [];
  errors.length = Math.min(errors.length, next.first_error);
  errors.push(...next.errors);
  if (next.view > markedView) get("marker").hidden = true;
  const samples = next.spp === 0 ? "preview" : `${next.spp} <small>of ${next.max_spp > 1 << 20 ? "∞" : next.max_spp}</small>`;
  get("samples").innerHTML = samples;
  get("progress").value = next.is_finished ? 1 : next.spp / next.max_spp;
  get("seconds").textContent = duration(next.seconds);
  get("rate").textContent = next.mega_rays_per_second > 0 ? `${next.mega_rays_per_second.toPrecision(3)} Mrays/s` : "–";
  const last = errors.at(-1);
  const interval = last && last[1] > 0 ? ` <small>${range(last[2], last[3])}</small>` : "";
  get("error").innerHTML = last ? percent(last[1]) + interval : "–";
  if (isOtherView || next.errors.length > 0) plot();
  const part = next.is_finished ? "" : `${next.spp}/${next.max_spp > 1 << 20 ? "∞" : next.max_spp} `;
  document.title = `${part}${session.name} – rt-cli view`;
  document.body.dataset.view = next.view;
  document.body.dataset.state = next.is_finished ? "finished" : "rendering";
  if (next.is_finished && !wasFinished && next.seconds > LONG) toast(`Finished in ${duration(next.seconds)}`);
  // Menus show what the server has, unless it is about to get something else.
  if (sendSettings.isBusy || !isCurrent) return;
  select("integrator", next.integrator);
  select("tone", next.tone);
  select("spp", String(next.max_spp));
  showSize(next.wanted_size);
  get("exposure").value = next.exposure;
  get("exposure-value").textContent = stops(next.exposure);
}

const stops = (exposure) => `${Number(exposure).toFixed(1).replace("-", "−")} EV`;
const plot = () => drawPlot(get("plot"), errors, "The error is known after two passes.");

function range(low, high) {
  return `${percent(low).replace(" %", "")}–${percent(high)}`;
}

function duration(seconds) {
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const minutes = Math.floor(seconds / 60);
  return `${minutes} min ${Math.floor(seconds % 60)} s`;
}

function banner(text) {
  get("banner").textContent = text ?? "";
  get("banner").hidden = !text;
}

let toastEnd = 0;
function toast(text) {
  get("toast").textContent = text.trim();
  clearTimeout(toastEnd);
  toastEnd = setTimeout(() => get("toast").replaceChildren(), 2500);
}

// Settings

/** Chooses an option, and adds it if it is not there. */
function select(id, value) {
  const list = get(id);
  if (![...list.options].some((option) => option.value === value)) list.add(new Option(value, value));
  list.value = value;
}

async function start() {
  const response = await fetch("session");
  if (!response.ok) throw new Error((await response.text()).trim());
  const info = await response.json();
  get("name").textContent = info.name;
  get("name").title = info.name;
  for (const { name, follows_light: followsLight } of info.integrators) {
    get(followsLight ? "light-integrators" : "debug-views").append(new Option(name, name));
  }
  for (const name of info.tones) get("tone").add(new Option(name, name));
  const counts = new Set([1, 16, 64, 256, 1024, 4096, info.spp]);
  for (const count of [...counts].sort((a, b) => a - b)) {
    get("spp").add(new Option(count === info.spp ? `${count} (scene)` : count, count));
  }
  get("spp").add(new Option("no limit", 2 ** 31));
  get("size").options[0].text = `Scene, ${info.size.join(" × ")}`;
  return info;
}

const isSameSize = (a, b) => a[0] === b[0] && a[1] === b[1];
/** Last size that this page has chosen, or has found to be that of its choice. */
let chosenSize = null;

/** Size of a choice in the menu; undefined for a size that another page has chosen. */
function sizeOf(choice) {
  if (choice === "scene") return session.size;
  if (choice === "other") return undefined;
  const scale = devicePixelRatio * (choice === "half" ? 0.5 : 1);
  const stage = get("stage");
  return [stage.clientWidth, stage.clientHeight].map((length) => Math.max(16, Math.round(length * scale)));
}

function sendSize() {
  const size = sizeOf(get("size").value);
  if (size === undefined) return;
  chosenSize = size;
  sendSettings({ size });
}

/** Shows the size of the server. The choice stays while its size is that of the server, also during a resize of the window. */
function showSize(size) {
  if (chosenSize && isSameSize(size, chosenSize)) return;
  const list = get("size");
  const other = list.querySelector("[value=other]");
  const choice = ["scene", "window", "half"].find((choice) => isSameSize(size, sizeOf(choice)));
  chosenSize = choice ? size : null;
  other.text = size.join(" × ");
  other.hidden = choice !== undefined;
  list.value = choice ?? "other";
}

get("integrator").addEventListener("change", (event) => sendSettings({ integrator: event.target.value }));
get("tone").addEventListener("change", (event) => sendSettings({ tone: event.target.value }));
get("spp").addEventListener("change", (event) => sendSettings({ spp: Number(event.target.value) }));
get("size").addEventListener("change", sendSize);
get("exposure").addEventListener("input", (event) => {
  get("exposure-value").textContent = stops(event.target.value);
  sendSettings({ exposure: Number(event.target.value) });
});
get("exposure").addEventListener("dblclick", (event) => {
  event.target.value = 0;
  sendSettings({ exposure: 0 });
});
get("settings").addEventListener("submit", (event) => event.preventDefault());

let resizeEnd = 0;
addEventListener("resize", () => {
  clearTimeout(resizeEnd);
  resizeEnd = setTimeout(() => {
    plot();
    if (session && get("size").value !== "scene") sendSize();
  }, 200);
});

// Pointers

const pointers = new Map();
let drag = null;

/** Middle of all pointers, and the distance between two of them. */
function grip() {
  const all = [...pointers.values()];
  const x = all.reduce((sum, at) => sum + at.x, 0) / all.length;
  const y = all.reduce((sum, at) => sum + at.y, 0) / all.length;
  const spread = all.length > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0;
  return { x, y, spread };
}

function kindOfDrag(event) {
  if (pointers.size > 1) return "pan";
  if (event.button === 2) return "look";
  return event.button === 1 || event.shiftKey ? "pan" : "orbit";
}

image.addEventListener("pointerdown", (event) => {
  image.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  const mayClick = pointers.size === 1 && event.button === 0 && !event.shiftKey;
  drag = { kind: kindOfDrag(event), last: grip(), start: grip(), mayClick };
});
// The middle button would scroll.
image.addEventListener("mousedown", (event) => event.button === 1 && event.preventDefault());

image.addEventListener("pointermove", (event) => {
  if (!drag || !pointers.has(event.pointerId)) return;
  pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  const now = grip();
  if (drag.mayClick && Math.hypot(now.x - drag.start.x, now.y - drag.start.y) <= CLICK) return;
  drag.mayClick = false;
  const height = image.clientHeight || 1;
  sendCamera({ [drag.kind]: [(now.x - drag.last.x) / height, (now.y - drag.last.y) / height] });
  if (now.spread > 0 && drag.last.spread > 0) sendCamera({ zoom: Math.log(now.spread / drag.last.spread) / Math.log(1 / 0.9) });
  drag.last = now;
});

function release(event) {
  if (!pointers.delete(event.pointerId) || !drag) return;
  if (drag.mayClick && event.type === "pointerup") pick(event);
  drag = pointers.size > 0 ? { kind: "orbit", last: grip(), start: grip(), mayClick: false } : null;
}
image.addEventListener("pointerup", release);
image.addEventListener("pointercancel", release);
image.addEventListener("contextmenu", (event) => event.preventDefault());
image.addEventListener("wheel", (event) => {
  event.preventDefault();
  const notches = -event.deltaY / (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 3 : event.ctrlKey ? 20 : 100);
  sendCamera({ zoom: notches });
}, { passive: false });

// Picks

const number = (value) => Number(value.toPrecision(6)).toString().replace("-", "−");
const vector = (values, text) => values.map(text).join(", ");
const component = (value) => number(Number(value.toFixed(4)));

async function pick(event) {
  const box = image.getBoundingClientRect();
  const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  const inside = (share, length) => Math.min(Math.max(Math.floor(share * length), 0), length - 1);
  // Moves of the camera that wait to be sent came before the click.
  await sendCamera.done;
  const answer = await post("pick", [inside(x, image.width), inside(y, image.height)]);
  if (answer === undefined) return;
  showPicked(answer.hit);
  if (answer.view < state.view) return;
  markedView = answer.view;
  const marker = get("marker");
  [marker.style.left, marker.style.top] = [`${100 * x}%`, `${100 * y}%`];
  marker.hidden = false;
}

function showPicked(found) {
  picked = found;
  get("pick").hidden = !found;
  get("pick-hint").hidden = Boolean(found);
  get("look-at").hidden = !found;
  if (!found) {
    get("pick-hint").textContent = "The background is there.";
    return;
  }
  const names = found.object.filter((name) => name !== "");
  get("pick-object").textContent = names.length > 0 ? names.join(" › ") : "without a name";
  get("pick-material").textContent = found.material || "without a name";
  get("pick-position").textContent = vector(found.position, number);
  get("pick-normal").textContent = vector(found.normal, component);
  get("pick-t").textContent = number(found.t);
  get("pick-distance").textContent = number(found.distance);
  get("look-at").scrollIntoView({ block: "nearest" });
}

// Actions

async function copyCamera() {
  let text = "";
  try {
    text = await (await fetch("camera")).text();
    await navigator.clipboard.writeText(text);
    toast("Camera copied: paste it into the scene file");
  } catch {
    // Without access to the clipboard, the text is there to be copied by hand.
    get("camera-text").value = text;
    get("camera-dialog").showModal();
    get("camera-text").select();
  }
}

const reset = () => sendCamera({ reset: null });
const lookAtPicked = () => picked && sendCamera({ look_at: picked.position });

get("copy").addEventListener("click", copyCamera);
get("reset").addEventListener("click", reset);
get("look-at").addEventListener("click", lookAtPicked);
get("help-button").addEventListener("click", () => get("help").showModal());

// Keys

const FLIGHT = { KeyW: [0, 0, -1], KeyS: [0, 0, 1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0] };
const held = new Set();
let flown = 0;
let isFast = false;

function fly(now) {
  if (held.size === 0) return;
  const seconds = Math.min((now - flown) / 1000, 0.1) * (isFast ? HASTE : 1);
  flown = now;
  const sum = [0, 1, 2].map((axis) => [...held].reduce((total, key) => total + FLIGHT[key][axis], 0) * seconds);
  if (sum.some((part) => part !== 0)) sendCamera({ fly: sum });
  requestAnimationFrame(fly);
}

/** Actions by the letter on the key. */
const ACTIONS = {
  arrowleft: () => sendCamera({ orbit: [ARROW, 0] }),
  arrowright: () => sendCamera({ orbit: [-ARROW, 0] }),
  arrowup: () => sendCamera({ orbit: [0, ARROW] }),
  arrowdown: () => sendCamera({ orbit: [0, -ARROW] }),
  "+": () => sendCamera({ zoom: 1 }),
  "=": () => sendCamera({ zoom: 1 }),
  "-": () => sendCamera({ zoom: -1 }),
  f: lookAtPicked,
  r: reset,
  c: copyCamera,
  h: () => get("help").showModal(),
  "?": () => get("help").showModal(),
};

/** Action of a key. Keys without a Latin letter, as on a Cyrillic keyboard, have that of their place. */
function actionOf({ key, code }) {
  const isLatin = /^[a-z]$/i.test(key);
  return ACTIONS[key.toLowerCase()] ?? (isLatin ? undefined : ACTIONS[code.replace("Key", "").toLowerCase()]);
}

addEventListener("keydown", (event) => {
  isFast = event.shiftKey;
  const isControl = event.target.closest("select, input, textarea, dialog") !== null;
  if (isControl || event.ctrlKey || event.metaKey || event.altKey || event.getModifierState("AltGraph")) return;
  // The letter of an action comes before the place of flight: where they differ, a key does what its letter says.
  const action = actionOf(event);
  if (action) {
    action();
    event.preventDefault();
    return;
  }
  if (event.code in FLIGHT) {
    const isFirst = held.size === 0;
    held.add(event.code);
    if (isFirst) {
      // One step at once, so that a short press moves the camera however long the next frame takes.
      const now = performance.now();
      flown = now - 16;
      fly(now);
    }
    event.preventDefault();
  }
});
addEventListener("keyup", (event) => {
  isFast = event.shiftKey;
  held.delete(event.code);
});
addEventListener("blur", () => held.clear());

image.classList.add("is-empty");
plot();
watch();
