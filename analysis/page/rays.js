// SPDX-License-Identifier: MIT
//
// All rays as one set of lines: one draw call. A leg is one stroke, a curved one several. Every
// vertex knows the path travelled up to it, or where the map has times when its light was there, by
// which the animation cuts the lines, and the state of its ray.

const HIDDEN = 0, DIM = 1, SHOWN = 2, STRONG = 3;
let CURVE_STROKES = 4; // between two points of a curved leg
const MOST_SWATCHES = 12; // in the legend
const LEAVING = 0.12; // length of a leg that leaves, of the scene's size

/* Cubic through b from c to d with the slopes of its neighbours (Catmull and Rom 1974). */
function spline(a, b, c, d, t) {
  return [0, 1, 2].map((k) => 0.5 * (2 * b[k] + t * (c[k] - a[k] +
    t * (2 * a[k] - 5 * b[k] + 4 * c[k] - d[k] + t * (3 * (b[k] - c[k]) + d[k] - a[k])))));
}

/* Points of a curved leg behind its first, its last one included. */
function curvePoints(from, first, last, to) {
  const node = [from];
  for (let i = first; i < last; i++) node.push(curve.position.subarray(3 * i, 3 * i + 3));
  node.push(to);
  const points = [];
  for (let i = 0; i + 1 < node.length; i++) {
    const before = node[i - 1] || node[i], behind = node[i + 2] || node[i + 1];
    for (let s = 1; s <= CURVE_STROKES; s++)
      points.push(spline(before, node[i], node[i + 1], behind, s / CURVE_STROKES));
  }
  return points;
}

/* Where a leg ends in the picture: that of one that leaves nearby. */
function legEnd(r, l, from) {
  if (!(leg.event[l] & EVENT_LEFT) || leg.event[l] & EVENT_GRADIENT)
    return leg.position.subarray(3 * l, 3 * l + 3);
  const length = 2 * LEAVING * whereabouts.radius;
  return [0, 1, 2].map((k) => from[k] + length * ray.end_direction[3 * r + k]);
}

const distance = (a, b) => Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
let firstTime = 0;

/* What length along a leg adds. */
function paceOf(r, l, from, points) {
  if (!times) return 1;
  if (leg.event[l] & EVENT_LEFT && !(leg.event[l] & EVENT_GRADIENT)) return times.leaving[r];
  const length = points.reduce(([sum, at], to) => [sum + distance(at, to), to], [0, from])[0];
  return length > 0 ? (times.end[l] - times.begin[l]) / length : 0;
}

/* position: [2 strokes][3], path: [2 strokes], leg: [strokes]; first: stroke of a leg's first. */
const strokes = {};

function makeStrokes() {
  const n = leg.count + CURVE_STROKES * (curve.leg.length * 2);
  const position = new Float32Array(6 * n), path = new Float32Array(2 * n), of = new Uint32Array(n);
  const first = new Uint32Array(leg.count + 1);
  let count = 0, point = 0;
  for (let r = 0; r < ray.count; r++) {
    let from = ray.start.subarray(3 * r, 3 * r + 3), travelled = 0;
    for (let l = ray.firstLeg[r]; l < ray.firstLeg[r + 1]; l++) {
      const firstPoint = point;
      while (point < curve.leg.length && curve.leg[point] === l) point++;
      const end = legEnd(r, l, from);
      first[l] = count;
      const points = point > firstPoint ? curvePoints(from, firstPoint, point, end) : [end];
      const pace = paceOf(r, l, from, points);
      if (times) travelled = times.begin[l] - firstTime;
      for (const to of points) {
        position.set(from, 6 * count);
        position.set(to, 6 * count + 3);
        path[2 * count] = travelled;
        travelled += pace * distance(from, to);
        path[2 * count + 1] = travelled;
        of[count++] = l;
        from = to;
      }
    }
  }
  first[leg.count] = count;
  return { count, first, position: position.subarray(0, 6 * count), path: path.subarray(0, 2 * count), leg: of.subarray(0, count) };
}

/* What holds much of the light's way is open as well as what encloses the scene: the wall of a rod, a tube. */
function openHolding() {
  const HOLDS = 0.2, FEW = 100, step = Math.max(1, Math.floor(strokes.count / 4000)), middles = [];
  for (let s = 0; s < strokes.count; s += step) {
    const [a, b] = [strokes.position.subarray(6 * s, 6 * s + 3), strokes.position.subarray(6 * s + 3, 6 * s + 6)];
    middles.push({ at: new THREE.Vector3((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2), length: distance(a, b) });
  }
  const lengthIn = (list, body) => list.reduce((sum, { at, length }) => sum + (!body || body.box.containsPoint(at) ? length : 0), 0);
  const whole = lengthIn(middles, null), few = middles.filter((_, k) => k % Math.ceil(middles.length / FEW) === 0);
  for (const body of bodies) {
    if (body.encloses || body.object.look === "glass" || !few.some(({ at }) => body.box.containsPoint(at))) continue;
    if (lengthIn(middles, body) > HOLDS * whole) body.encloses = body.batch.stale = true;
  }
}

let longestPath = 0;

const rayUniforms = {
  now: { value: Infinity }, trail: { value: 1 }, fade: { value: 1 }, opacity: { value: 0.5 },
  glow: { value: new THREE.Vector3() },
};

const rayMaterial = new THREE.ShaderMaterial({
  uniforms: rayUniforms, transparent: true, depthWrite: false,
  vertexShader: `
    attribute float path, state;
    attribute vec3 tint;
    varying float vPath, vState;
    varying vec3 vTint;
    void main() {
      vPath = path; vState = state; vTint = tint;
      gl_Position = state < 0.5 ? vec4(2.0, 2.0, 2.0, 1.0)
                                : projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    }`,
  fragmentShader: `
    uniform float now, trail, fade, opacity;
    uniform vec3 glow;
    varying float vPath, vState;
    varying vec3 vTint;
    void main() {
      if (vPath > now) discard;
      float head = clamp(1.0 - (now - vPath) / trail, 0.0, 1.0);
      float alpha = opacity * (vState < 1.5 ? 0.12 : vState < 2.5 ? 1.0 : 2.0) * mix(fade, 2.5, head);
      gl_FragColor = vec4(mix(vTint, glow, 0.5 * head * head), clamp(alpha, 0.0, 1.0));
    }`,
});

const rayLines = new THREE.LineSegments(new THREE.BufferGeometry(), rayMaterial);
rayLines.frustumCulled = false;
rayLines.renderOrder = 2;
rayLines.layers.enable(RAYS_ONLY);
world.add(rayLines);

function rayGeometry() {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(strokes.position, 3));
  geometry.setAttribute("path", new THREE.BufferAttribute(strokes.path, 1));
  geometry.setAttribute("tint", new THREE.BufferAttribute(new Uint8Array(6 * strokes.count), 3, true));
  geometry.setAttribute("state", new THREE.BufferAttribute(new Uint8Array(2 * strokes.count), 1));
  return geometry;
}

const classes = [];

whenData(() => {
  CURVE_STROKES = curve.leg.length > 50000 ? 1 : 4;
  firstTime = times && leg.count ? times.begin.reduce((least, v) => Math.min(least, v), Infinity) : 0;
  Object.assign(strokes, makeStrokes());
  openHolding();
  longestPath = strokes.path.reduce((most, v) => Math.max(most, v), 0);
  rayLines.geometry.dispose();
  rayLines.geometry = rayGeometry();
  rayLines.visible = strokes.count > 0;
  if (drawnBySoftware) pace.known = lastLevel();
  setLevel(pace.moving ? pace.known : 0);
  /* Ghost order: specular reflections at surfaces that also let light through. */
  ray.order = unpack(data.order.ghost);
  ray.scatter = unpack(data.order.scatter);
  ray.class = unpack(data.classes.of);
  classes.splice(0, classes.length, ...data.classes.list);
});

/* Colours that can be told apart on white and on black (Okabe and Ito 2008), then grey. */
const KINDS = {
  light: ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b59f00", "#56b4e9", "#7a4fbf", "#8c564b", "#333333"],
  dark: ["#4aa8e8", "#ff8a3d", "#2fd6a3", "#e79ac6", "#f0e442", "#9ad4f5", "#b795f2", "#c9978c", "#e8e8e8"],
};
const REST = { light: "#9aa0a6", dark: "#6d747b" };
function kindColour(index) {
  const set = scheme.dark ? "dark" : "light";
  return index >= 0 && index < KINDS[set].length ? KINDS[set][index] : REST[set];
}

const colouring = { mode: data.color };

/* The criteria that were given, which of them each ray matches, and which are switched on: bits. */
const where = [];
let whereOn = -1;
whenData(() => {
  if (data.where.list.length !== where.length) whereOn = -1;
  where.splice(0, where.length, ...data.where.list);
  ray.where = unpack(data.where.match);
});
const allCriteriaOn = () => where.every((_, index) => whereOn & (1 << index));

/* The first of them that a ray matches, of those that are on. */
function whereOf(r) {
  const bits = ray.where[r] & whereOn;
  return bits ? 31 - Math.clz32(bits & -bits) : -1;
}

const isOn = (r) => !where.length || whereOf(r) >= 0;

function bytesOf(ink) {
  const value = parseInt(ink.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

function legColour(l) {
  if (colouring.mode === "natural") {
    return nightOrDay().subarray(3 * colour.of[l], 3 * colour.of[l] + 3);
  }
  const r = leg.ray[l];
  return bytesOf(kindColour({ path: ray.class[r], order: ray.order[r], criterion: whereOf(r) }[colouring.mode]));
}

function paintRays() {
  const tint = rayLines.geometry.attributes.tint;
  for (let s = 0; s < strokes.count; s++) {
    const ink = legColour(strokes.leg[s]);
    tint.array.set(ink, 6 * s);
    tint.array.set(ink, 6 * s + 3);
  }
  tint.needsUpdate = true;
  rayUniforms.glow.value.setScalar(scheme.dark ? 1 : 0);
  drawLegend();
  redraw();
}
scheme.told.push(() => paintRays());

/* What is shown: one class of paths or all, and which of them lie in the region of a detector. */
const shown = { class: -1, region: null, state: null, count: 0, inRegion: 0, legs: 0 };
whenData(() => Object.assign(shown, { class: -1, region: null, state: new Uint8Array(ray.count) }));

function refreshRays() {
  shown.count = shown.inRegion = shown.legs = 0;
  for (let r = 0; r < ray.count; r++) {
    const visible = (shown.class < 0 || ray.class[r] === shown.class) && isOn(r);
    const inside = shown.region ? shown.region[r] === 1 : false;
    shown.state[r] = !visible ? HIDDEN : !shown.region ? SHOWN : inside ? STRONG : DIM;
    shown.count += visible ? 1 : 0;
    shown.inRegion += visible && inside ? 1 : 0;
    shown.legs += visible && (inside || !shown.region) ? ray.legs[r] : 0;
  }
  const state = rayLines.geometry.attributes.state;
  for (let s = 0; s < strokes.count; s++)
    state.array[2 * s] = state.array[2 * s + 1] = shown.state[leg.ray[strokes.leg[s]]];
  state.needsUpdate = true;
  pickCache.valid = false;
  byId("shown").textContent = `${whole(shown.count)} of ${whole(ray.count)} shown`;
  setOpacity();
  redraw();
}

/* Few lines are nearly opaque, more of them fainter, as the inverse square root. */
function setOpacity() {
  const automatic = Math.max(0.85 * Math.sqrt(Math.min(700 / Math.max(shown.legs, 1), 1)), 0.04);
  rayUniforms.opacity.value = automatic * Math.pow(2, Number(byId("opacity").value));
  redraw();
}

const nightOrDay = () => (scheme.dark ? colour.night : colour.paper);

/* [colour, what it is]: every wavelength, shortest first, and one mixture for all. */
function naturalLegend() {
  const known = new Map();
  if (scene.mode === "rgb") return ray.count ? [[colour.of[0], "each in the colour of its light"]] : [];
  for (let l = 0; l < leg.count; l++) {
    const c = colour.of[l], alone = colour.live[c] === 1;
    const key = alone ? scene.wavelengths[colour.channel[4 * c]] : Infinity;
    if (!known.has(key)) known.set(key, [c, alone ? lightWords(l) : "several wavelengths"]);
  }
  const sorted = [...known].sort(([a], [b]) => a - b).map(([, item]) => item);
  const step = Math.max(1, Math.ceil(sorted.length / MOST_SWATCHES));
  return sorted.filter((_, k) => k % step === 0 || k === sorted.length - 1);
}

function drawLegend() {
  const entry = (ink, text) => {
    const swatch = element("span", { className: "swatch" });
    swatch.style.background = ink;
    return element("li", {}, swatch, text);
  };
  const items = [];
  if (colouring.mode === "natural") {
    items.push(...naturalLegend().map(([c, text]) => entry(`rgb(${nightOrDay().subarray(3 * c, 3 * c + 3).join(",")})`, text)));
  } else if (colouring.mode === "order") {
    const most = ray.order.reduce((a, b) => Math.max(a, b), 0), last = KINDS.light.length;
    for (let k = 0; k <= Math.min(most, last); k++)
      items.push(entry(kindColour(k), k === last ? `${k} or more` : `ghost order ${k}`));
  } else {
    items.push(element("li", { textContent: colouring.mode === "path" ? "colours as in the table of path classes"
      : "colours as of the criteria above, the first that a ray matches" }));
  }
  byId("legend").replaceChildren(...items);
}
