// SPDX-License-Identifier: MIT
//
// Headings, keys, and the start.

const AXES = { x: [new THREE.Vector3(-1, 0, 0), new THREE.Vector3(0, 1, 0)],
  y: [new THREE.Vector3(0, 1, 0), new THREE.Vector3(1, 0, 0)],
  z: [new THREE.Vector3(0, 0, 1), new THREE.Vector3(0, 1, 0)],
  "3d": null };

/* The view that nobody has moved: it fits again when the window changes. */
let standing = null;
controls.addEventListener("start", () => (standing = null));

function setView(name) {
  standing = name;
  const [toward, up] = AXES[name] || [vectorOf(data.view.toward), vectorOf(data.view.up)];
  look(inSight, toward, up);
  redraw();
}

/* The same direction, everything in sight. */
function fit() {
  standing = null;
  const toward = camera.position.clone().sub(controls.target);
  look(inSight, toward, new THREE.Vector3(0, 0, 1).applyQuaternion(camera.quaternion));
  redraw();
}

function toggle(button, call) {
  button.addEventListener("click", () => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(on));
    call(on);
    pickCache.valid = false;
    redraw();
  });
}

const KEYS = [
  [" ", "space", "play or pause", () => setPlaying(!player.playing)],
  ["a", "a", "whole rays, no animation", () => byId("still").click()],
  [".", ". ,", "a step of the animation on, and back", () => setTravelled(player.at + 0.01)],
  [",", null, null, () => setTravelled(player.at - 0.01)],
  ["f", "f", "fit the scene", fit],
  ["0", "0 1 2 3", "in three dimensions, along x, y, z", () => setView("3d")],
  ["1", null, null, () => setView("x")],
  ["2", null, null, () => setView("y")],
  ["3", null, null, () => setView("z")],
  ["p", "p", "parallel projection or perspective", () => byId("lens").click()],
  ["c", "c", "cut opaque bodies open", () => byId("cut").click()],
  ["ArrowLeft", "arrows", "turn", () => turn(-0.1, 0)],
  ["ArrowRight", null, null, () => turn(0.1, 0)],
  ["ArrowUp", null, null, () => turn(0, 0.1)],
  ["ArrowDown", null, null, () => turn(0, -0.1)],
  ["+", "+ -", "zoom", () => setHalfHeight(halfHeight() / 1.2)],
  ["-", null, null, () => setHalfHeight(halfHeight() * 1.2)],
  ["Escape", "Esc", "no ray, no class, no region", () => {
    if (dropDrag()) return;
    chooseRay(-1);
    if (sensor.region) takeStep({ region: null });
    if (shown.class >= 0) chooseClass(-1);
  }],
  ["z", "z Z", "a step of regions back, and on", undo],
  ["Z", null, null, redo],
  ["?", "?", "this help", () => byId("help").showModal()],
];

document.addEventListener("keydown", (event) => {
  const key = KEYS.find(([name]) => name === event.key);
  const typing = event.key !== "Escape" && event.target.matches("input[type=text], input[type=search], textarea, select");
  const own = event.key === " " && event.target.matches("button, summary, input");
  const sliding = event.key.startsWith("Arrow") && event.target.matches("input");
  const chord = (event.ctrlKey || event.metaKey) && event.key.toLowerCase() !== "z"; // Ctrl+Z is as z
  if (!key || byId("help").open || typing || own || sliding || chord || event.altKey) return;
  event.preventDefault();
  if (event.key.startsWith("Arrow") || "+-".includes(event.key)) standing = null;
  key[3]();
  pickCache.valid = false;
  redraw();
});

whenData(() => {
  byId("title").textContent = data.title;
  byId("about").textContent = `rays: ${data.criterion || "all"}; ` + (ray.count < data.matched
    ? `${whole(ray.count)} of ${whole(data.matched)} matching rays, those with the smallest ids${where.length > 1 ? " of each criterion" : ""},`
    : `${whole(ray.count)} ray${ray.count === 1 ? "" : "s"}`) + ` of ${whole(data.total)} in the map`;
});
byId("provenance").textContent = `Written by ${data.program}.`;
/* In the help: those with a description, and `more`. */
const listKeys = (more = []) => byId("keys").replaceChildren(
  ...[["drag", "turn"], ["right drag, two fingers", "shift"], ["wheel, pinch", "zoom"],
    ["point at a ray", "what happened on that leg"], ["click a ray", "its whole report"],
    ["drag on an image", "draw a region, move it, resize it by its edges, or turn it by the ring beside it; with Shift a new one"],
    ["arrows, < >", "on an image: move the region, with Shift resize it; turn it"],
    ...KEYS.filter((key) => key[1]).map((key) => key.slice(1, 3)), ...more].flatMap(([name, text]) =>
    [element("dt", { textContent: name }), element("dd", { textContent: text })]));
listKeys();
const NO_RAY = ["No ray matches: the scene alone is shown.", "No rays yet: the scene alone is shown."];
whenData(() => {
  if (ray.count === 0) note(NO_RAY[data.total > 0 ? 0 : 1]);
  else if (NO_RAY.includes(byId("note").textContent)) note("");
});

for (const button of byId("views").querySelectorAll("[data-view]"))
  button.addEventListener("click", () => setView(button.dataset.view));
byId("fit").addEventListener("click", fit);
toggle(byId("lens"), changeLens);
toggle(byId("cut"), (on) => (shading.cut.value = on ? 1 : 0));
byId("scheme").addEventListener("click", () => setScheme(!scheme.dark));
byId("help-open").addEventListener("click", () => byId("help").showModal());
byId("opacity").addEventListener("input", setOpacity);
byId("colour").addEventListener("change", (event) => {
  colouring.mode = event.target.value;
  paintRays();
});

document.addEventListener("dragstart", (event) => event.preventDefault());
window.addEventListener("beforeprint", () => renderer.render(world, camera));

const night = window.matchMedia("(prefers-color-scheme: dark)");
night.addEventListener("change", () => setScheme(night.matches));
new ResizeObserver(() => {
  resize();
  if (standing) setView(standing);
}).observe(byId("stage"));
new ResizeObserver(drawImage).observe(byId("detector-box"));

stir(); // the first view is soon there
resize();
setTravelled(1);
setScheme(night.matches);
setView("3d");
whenData(() => {
  const marked_id = byId("ray-name").textContent;
  chooseRay(marked_id ? ray.id.indexOf(marked_id) : -1);
  setTravelled(player.at);
  refreshRays();
  const first = Math.max(detectors.findIndex((one) => one.image && one.image.registrations > 0), 0);
  if (detectors.length) showState({ index: sensor.index < 0 ? first : sensor.index });
  if (current()) describeDetector();
});

/* For tests and the curious. */
window.raymap = {
  zoom: () => halfHeight(),
  isInSight: () => inSight.every((corner) => {
    const p = corner.clone().project(camera);
    return Math.abs(p.x) <= 1 && Math.abs(p.y) <= 1;
  }),
  draw: redraw,
  hasImage: () => sensor.picture !== null,
  statistics: () => ({ rays: ray.count, legs: leg.count, strokes: strokes.count, shown: shown.count,
    drawn: pace.drawn, ...(renderer.info ? { calls: renderer.info.render.calls, triangles: renderer.info.render.triangles } : {}),
    frames: frames.drawn, milliseconds: frames.milliseconds.slice(), travelled: player.at, level: pace.level, resting: !pace.moving && !frames.wanted && isWhole() }),
  /* Ids of the rays that are shown, and the largest id in the page. */
  shown: () => ray.id.filter((id, r) => shown.state[r] !== HIDDEN),
  lastRay: () => ray.id[ray.count - 1],
  clickBody: (index) => {
    showBodyTip(index, 50, 90);
    return byId("tip").textContent;
  },
  knob: knobOnCanvas,
  bodyAt: (x, y) => { const k = bodyAt(x, y); return k < 0 ? null : scene.objects[k].name; },
  /* Where the middle of a ray's leg is on the canvas. */
  middle: (id, step) => {
    const s = strokes.first[ray.firstLeg[ray.id.indexOf(id)] + step], screen = screenStrokes();
    return [0.5 * (screen[4 * s] + screen[4 * s + 2]), 0.5 * (screen[4 * s + 1] + screen[4 * s + 3])];
  },
};
document.documentElement.dataset.ready = "yes";
