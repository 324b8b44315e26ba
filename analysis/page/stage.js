// SPDX-License-Identifier: MIT
//
// The canvas: drawn when something has changed, or on every frame while something moves; the
// colours of the light and the dark scheme; scale bar, axes and labels over it.

/* Whether the processor draws, not a graphics card: then motion starts at the last level. places: whether textures can hold those of bodies. */
function drawsBySoftware() {
  if (drawsBySoftware.told !== undefined) return drawsBySoftware.told;
  const context = document.createElement("canvas").getContext("webgl");
  const told = context && context.getExtension("WEBGL_debug_renderer_info");
  const name = told ? context.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  drawsBySoftware.places = Boolean(context && context.getExtension("OES_texture_float") && context.getParameter(context.MAX_VERTEX_TEXTURE_IMAGE_UNITS));
  const lose = context && context.getExtension("WEBGL_lose_context");
  if (lose) lose.loseContext();
  return (drawsBySoftware.told = /swiftshader|llvmpipe|software|basic render/i.test(name));
}
const drawnBySoftware = drawsBySoftware();

function note(text) {
  byId("note").textContent = text;
  byId("note").hidden = !text;
}

/* Edges of bodies and the first rays, in two dimensions, where there is no WebGL. */
function plainRenderer() {
  const MOST = 20000, p = new THREE.Vector3(); // strokes
  const context = canvas.getContext("2d");
  let ground = "#fff";
  const trace = ({ attributes: { position }, index }, matrix) => {
    context.beginPath();
    for (let i = 0; i < index.count; i++) {
      p.fromArray(position.array, 3 * index.array[i]).applyMatrix4(matrix).project(camera);
      context[i % 2 ? "lineTo" : "moveTo"]((0.5 + 0.5 * p.x) * canvas.width, (0.5 - 0.5 * p.y) * canvas.height);
    }
    context.stroke();
  };
  const render = () => {
    camera.updateMatrixWorld();
    context.fillStyle = ground;
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.strokeStyle = "#8888";
    for (const body of bodies) if (body.visible) trace(body.shape.line, body.matrix);
    const screen = screenStrokes(), ratio = canvas.width / Math.max(canvas.clientWidth, 1), tint = rayLines.geometry.attributes.tint.array;
    context.globalAlpha = rayUniforms.opacity.value;
    for (let s = 0; s < Math.min(strokes.count, MOST); s++) {
      if (Number.isNaN(screen[4 * s]) || strokes.path[2 * s] > rayUniforms.now.value) continue;
      context.strokeStyle = `rgb(${tint.subarray(6 * s, 6 * s + 3).join(",")})`;
      context.beginPath();
      context.moveTo(ratio * screen[4 * s], ratio * screen[4 * s + 1]);
      context.lineTo(ratio * screen[4 * s + 2], ratio * screen[4 * s + 3]);
      context.stroke();
    }
    context.globalAlpha = 1;
  };
  return { render, setClearColor: (colour) => (ground = colour),
    setDrawingBufferSize: (width, height, ratio) => Object.assign(canvas, { width: ratio * width, height: ratio * height }) };
}

const renderer = (() => {
  try {
    if (!drawsBySoftware.places) throw new Error("no texture tells where bodies are");
    return new THREE.WebGLRenderer({ canvas, antialias: !drawnBySoftware, preserveDrawingBuffer: drawnBySoftware }); // four samples cost a processor four times
  } catch (failed) {
    note("This browser has no WebGL: edges and rays are drawn as plain lines.");
    return plainRenderer();
  }
})();
canvas.addEventListener("webglcontextlost", (event) => {
  event.preventDefault(); // or it is never restored
  note("The graphics card was lost; waiting for it.");
});
canvas.addEventListener("webglcontextrestored", () => {
  note("");
  redraw();
});
renderer.sortObjects = true;
const world = new THREE.Scene();

const frames = { drawn: 0, milliseconds: [], before: [], after: [], wanted: false, fresh: false, animate: null, size: null };

/* Asks for a new frame. */
function redraw() {
  frames.fresh = true;
  askForFrame();
}

function askForFrame() {
  if (frames.wanted) return;
  frames.wanted = true;
  requestAnimationFrame(drawFrame);
}

/* While something moves and frames come too slowly: level 1 has half the resolution, and each
 * further one draws half as many rays, the first ones, and coarser bodies. What stands still is drawn in full. */
const SLOW = 70, QUICK = 25, PAUSE = 250; // milliseconds
const RAYS_ONLY = 1; // a layer
const LIGHT_WORK = drawnBySoftware ? 4000 : 10000; // strokes that are always drawn
const LIGHT_TRIANGLES = 50 * LIGHT_WORK;
const SLICE = 20000; // strokes that a processor draws at a time: what moves meanwhile need not wait for all
const pace = { end: Infinity, drawn: 0, level: 0, known: 0, last: 0, slow: 0, quick: 0, moving: false, held: false, timer: 0 };
const lastLevel = () => 1 + Math.max(0, Math.ceil(Math.log2(strokes.count / LIGHT_WORK)), Math.ceil(0.5 * Math.log2(trianglesAtRest() / LIGHT_TRIANGLES)));

function setLevel(level) {
  const before = pace.level;
  pace.level = Math.min(Math.max(level, 0), lastLevel());
  const part = Math.pow(0.5, Math.max(pace.level - 1, 0));
  pace.end = strokes.first[ray.firstLeg[Math.ceil(part * ray.count)]];
  if ((pace.level > 0) !== (before > 0)) setResolution();
}

function setResolution() {
  const full = Math.min(window.devicePixelRatio || 1, 2);
  const size = [canvas.clientWidth, canvas.clientHeight, pace.level > 0 ? 0.5 * full : full];
  if (String(size) === frames.size) return; // a new buffer takes long where a processor draws
  frames.size = String(size);
  renderer.setDrawingBufferSize(...size);
}

/* Something moves now; it rests when no frame was asked for in a while, and nothing is held that moves next. */
function stir() {
  if (!pace.moving) {
    pace.last = pace.slow = pace.quick = 0;
    setLevel(pace.known);
  }
  pace.moving = true;
  clearTimeout(pace.timer);
  pace.timer = setTimeout(() => {
    if (frames.fresh || pace.held) return stir();
    pace.moving = false;
    setLevel(0);
    redraw();
  }, PAUSE);
}

function keepPace(time) {
  const gap = pace.moving && pace.last ? time - pace.last : 0;
  pace.last = time;
  pace.slow = gap > SLOW ? pace.slow + 1 : 0;
  pace.quick = gap > 0 && gap < QUICK ? pace.quick + 1 : 0;
  const slow = pace.slow > 1 || gap > 6 * SLOW;
  if (slow || pace.quick > 20) {
    setLevel(pace.level + (slow ? Math.ceil(Math.log2(gap / SLOW)) : -1));
    pace.known = pace.level; // for the next time that something moves
    pace.slow = pace.quick = 0;
  }
}

/* Strokes from `first` on; behind the first slice they are added to the picture. */
function drawSlice(first) {
  const end = Math.min(pace.end, strokes.count, drawnBySoftware ? first + SLICE : Infinity);
  rayLines.geometry.setDrawRange(2 * first, 2 * (end - first));
  renderer.autoClear = first === 0;
  camera.layers.set(first === 0 ? 0 : RAYS_ONLY);
  renderer.render(world, camera);
  camera.layers.set(0);
  pace.drawn = end;
  if (!isWhole()) askForFrame();
}
const isWhole = () => pace.drawn >= Math.min(pace.end, strokes.count);

function drawFrame(time) {
  frames.wanted = false;
  if (!frames.fresh) return drawSlice(pace.drawn);
  frames.fresh = false;
  const begin = performance.now();
  keepPace(time);
  const moving = frames.animate ? frames.animate(time) : false;
  for (const call of frames.before) call();
  drawSlice(0);
  for (const call of frames.after) call();
  frames.drawn++;
  frames.milliseconds.push(performance.now() - begin);
  if (frames.milliseconds.length > 120) frames.milliseconds.shift();
  if (!moving) return;
  stir();
  redraw();
}

controls.addEventListener("change", () => {
  pickCache.valid = false;
  if (!sight.jumps) stir();
  redraw();
});

function resize() {
  setResolution();
  reshape();
  pickCache.valid = false;
  redraw();
}

/* What changes with the scheme asks to be told; `own` are of the present data. */
const scheme = { dark: false, told: [], own: [] };
whenData(() => (scheme.own = []));

function setScheme(dark) {
  scheme.dark = dark;
  document.documentElement.dataset.scheme = dark ? "dark" : "light";
  renderer.setClearColor(getComputedStyle(document.documentElement).getPropertyValue("--stage").trim());
  for (const call of [...scheme.own, ...scheme.told]) call();
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

/* [{at: Vector3, element, width, height}] */
const labels = [];
whenPlaced(() => {
  labels.length = 0;
  byId("labels").replaceChildren();
});

function addLabel(text, kind, at) {
  const span = element("span", { className: kind, textContent: text });
  byId("labels").append(span);
  const label = { at, element: span, width: span.offsetWidth + 8, height: span.offsetHeight };
  labels.push(label);
  return label;
}

/* A label that would stand upon one before it is not shown. */
function placeLabels() {
  const p = new THREE.Vector3(), taken = [];
  for (const label of labels) {
    p.copy(label.at).project(camera);
    const left = Math.min((0.5 + 0.5 * p.x) * canvas.clientWidth, canvas.clientWidth - label.width);
    const top = (0.5 - 0.5 * p.y) * canvas.clientHeight;
    const meets = (box) => Math.abs(box.top - top) < label.height && left < box.left + box.width && box.left < left + label.width;
    const outside = Math.abs(p.x) > 1 || Math.abs(p.y) > 1 || p.z > 1;
    label.element.style.left = left + "px";
    label.element.style.top = top + "px";
    label.element.hidden = outside || taken.some(meets);
    if (!label.element.hidden) taken.push({ left, top, width: label.width });
  }
}

frames.after.push(drawScale, drawAxes, placeLabels);
