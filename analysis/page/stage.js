// SPDX-License-Identifier: MIT
//
// The canvas: drawn when something has changed, or on every frame while something moves; the
// colours of the light and the dark scheme; scale bar, axes and labels over it.

const renderer = (() => {
  try {
    return new THREE.WebGLRenderer({ canvas, antialias: true });
  } catch (failed) {
    byId("note").textContent = "This browser draws no WebGL: the scene cannot be shown.";
    byId("note").hidden = false;
    throw failed;
  }
})();
renderer.sortObjects = true;
const world = new THREE.Scene();

const frames = { drawn: 0, milliseconds: [], before: [], after: [], wanted: false, animate: null };

/* Asks for a new frame. */
function redraw() {
  if (frames.wanted) return;
  frames.wanted = true;
  requestAnimationFrame(drawFrame);
}

function drawFrame(time) {
  frames.wanted = false;
  const begin = performance.now();
  const moving = frames.animate ? frames.animate(time) : false;
  for (const call of frames.before) call();
  renderer.render(world, camera);
  for (const call of frames.after) call();
  frames.drawn++;
  frames.milliseconds.push(performance.now() - begin);
  if (frames.milliseconds.length > 120) frames.milliseconds.shift();
  if (moving) redraw();
}

controls.addEventListener("change", redraw);
controls.addEventListener("change", () => (pickCache.valid = false));

function resize() {
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
  reshape();
  pickCache.valid = false;
  redraw();
}

/* What changes with the scheme asks to be told. */
const scheme = { dark: false, told: [] };

function setScheme(dark) {
  scheme.dark = dark;
  document.documentElement.dataset.scheme = dark ? "dark" : "light";
  renderer.setClearColor(getComputedStyle(document.documentElement).getPropertyValue("--stage").trim());
  for (const call of scheme.told) call();
  redraw();
}

/* 1, 2 or 5 times a power of ten. */
function roundLength(most) {
  const power = Math.pow(10, Math.floor(Math.log10(most)));
  return power * [5, 2, 1].find((step) => step * power <= most);
}

function drawScale() {
  const perPixel = (2 * halfHeight()) / Math.max(canvas.clientHeight, 1);
  const length = roundLength(140 * perPixel);
  byId("scale-bar").style.width = length / perPixel + "px";
  byId("scale-text").textContent = `${figure(length, 4)} ${scene.unit}`;
}

function drawAxes() {
  const inverse = new THREE.Matrix4().getInverse(camera.matrixWorld);
  const parts = ["x", "y", "z"].map((name, k) => {
    const d = new THREE.Vector3(k === 0, k === 1, k === 2).transformDirection(inverse);
    return { name, d };
  });
  parts.sort((a, b) => a.d.z - b.d.z);
  byId("axes").innerHTML = parts.map(({ name, d }) =>
    `<line x1="0" y1="0" x2="${(20 * d.x).toFixed(2)}" y2="${(-20 * d.y).toFixed(2)}"/>` +
    `<text x="${(26 * d.x).toFixed(2)}" y="${(-26 * d.y).toFixed(2)}">${name}</text>`).join("");
}

/* [{at: Vector3, element}] */
const labels = [];

function addLabel(text, kind, at) {
  const span = element("span", { className: kind, textContent: text });
  byId("labels").append(span);
  labels.push({ at, element: span, width: span.offsetWidth + 8 });
}

function placeLabels() {
  const p = new THREE.Vector3();
  for (const label of labels) {
    p.copy(label.at).project(camera);
    label.element.style.left = Math.min((0.5 + 0.5 * p.x) * canvas.clientWidth, canvas.clientWidth - label.width) + "px";
    label.element.style.top = (0.5 - 0.5 * p.y) * canvas.clientHeight + "px";
    label.element.hidden = Math.abs(p.x) > 1 || Math.abs(p.y) > 1 || p.z > 1;
  }
}

frames.after.push(drawScale, drawAxes, placeLabels);
