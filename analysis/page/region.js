// SPDX-License-Identifier: MIT
//
// Regions of a detector: a rectangle or ellipse drawn on its image becomes a criterion, and the rays
// that are registered in it stand out. It is moved, resized, typed, and steps of that are undone.

const GRIP = 7; // pixels about an edge that take hold of it
const KNOB = 18; // pixels from an edge to what turns the region
const TURN = ["turn"];

/* hold: what the pointer has of the region (see gripAt), null while it draws a new one. before: the state to undo to. */
const drag = { from: null, hold: null, before: null };
const steps = { past: [], undone: [] };
const state = () => ({ index: sensor.index, kind: sensor.kind, region: sensor.region, turn: sensor.turn });
const canTurn = (detector) => detector.type !== "intensity";

/* Bounds [u0, v0, u1, v1] of the region on the picture, the lesser first. */
function regionBounds(detector, kind, region) {
  const right = rightAxis(detector), sorted = (p, q) => [Math.min(p, q), Math.max(p, q)];
  const [a0, a1] = kind === "rect" ? sorted(region[0], region[2]) : [region[0] - region[2], region[0] + region[2]];
  const [b0, b1] = kind === "rect" ? sorted(region[1], region[3]) : [region[1] - region[3], region[1] + region[3]];
  return right === 0 ? [a0, b0, a1, b1] : [b0, a0, b1, a1];
}

/* [right, up] */
function centreOf(region) {
  const [u0, v0, u1, v1] = regionBounds(current(), sensor.kind, region);
  return [(u0 + u1) / 2, (v0 + v1) / 2];
}

/* A place [right, up] turned as the region is: on planes alone, whose axes are lengths. */
function turned([u, v], by = sensor.turn, [p, q] = centreOf(sensor.region)) {
  const angle = by * Math.PI / 180, c = Math.cos(angle), s = Math.sin(angle);
  return by === 0 ? [u, v] : [p + (u - p) * c - (v - q) * s, q + (u - p) * s + (v - q) * c];
}

/* Where its parts lie on the canvas: u, v from 0 to 1 between its edges. */
function partOnCanvas(u, v) {
  const [u0, v0, u1, v1] = regionBounds(current(), sensor.kind, sensor.region);
  return toCanvas(...turned([u0 + u * (u1 - u0), v0 + v * (v1 - v0)]));
}

/* What turns it: above it, or below it where there is no room. */
function knobOnCanvas() {
  const { left, top, width, height } = sensor.area, [x, y] = partOnCanvas(0.5, 0.5);
  const [above, below] = [1, 0].map((v) => {
    const [a, b] = partOnCanvas(0.5, v), length = Math.max(Math.hypot(a - x, b - y), 1e-9);
    return [a + (a - x) / length * KNOB, b + (b - y) / length * KNOB];
  });
  const free = ([a, b]) => a > left && a < left + width && b > top && b < top + height;
  return !free(above) && free(below) ? below : above;
}

const ROUND = Array.from({ length: 73 }, (_, k) => [0.5 + 0.5 * Math.cos(k * Math.PI / 36), 0.5 + 0.5 * Math.sin(k * Math.PI / 36)]);
const CORNERS = [[0, 0], [1, 0], [1, 1], [0, 1]], MIDDLES = [[0, 0.5], [1, 0.5], [0.5, 0], [0.5, 1]];

function drawRegion(detector) {
  if (!sensor.region) return;
  const outline = (sensor.kind === "rect" ? CORNERS : ROUND).map((at) => partOnCanvas(...at));
  const knob = canTurn(detector) ? knobOnCanvas() : null;
  for (const [ink, width] of [["#000000", 3.5], ["#ffd24d", 1.8]]) {
    paint.strokeStyle = ink;
    paint.lineWidth = width;
    paint.beginPath();
    outline.forEach(([x, y], k) => (k ? paint.lineTo(x, y) : paint.moveTo(x, y)));
    paint.closePath();
    if (knob) {
      paint.moveTo(knob[0] + 4.5, knob[1]);
      paint.arc(...knob, 4.5, 0, 2 * Math.PI);
    }
    paint.stroke();
  }
  paint.lineWidth = 1;
  for (const at of sensor.kind === "rect" ? [...CORNERS, ...MIDDLES] : MIDDLES) { // corners lie outside of an ellipse
    const [x, y] = partOnCanvas(...at);
    paint.fillStyle = "#000000";
    paint.fillRect(x - 3.5, y - 3.5, 7, 7);
    paint.fillStyle = "#ffd24d";
    paint.fillRect(x - 2.5, y - 2.5, 5, 5);
  }
}

/* What of the region lies there: its edges [across, up], each 0 for the least, 1 for the greatest, null
 * for neither; [null, null] is its inside; TURN what turns it. null: nothing of it. */
function gripAt(x, y) {
  if (!sensor.region) return null;
  const knob = knobOnCanvas();
  if (canTurn(current()) && Math.hypot(x - knob[0], y - knob[1]) <= GRIP) return TURN;
  const [u0, v0, u1, v1] = regionBounds(current(), sensor.kind, sensor.region);
  const [x0, y0] = toCanvas(u0, v0), [x1, y1] = toCanvas(u1, v1);
  [x, y] = toCanvas(...turned(toCoordinates(x, y, true), -sensor.turn));
  const side = (t, a, b) => {
    const inwards = Math.min(GRIP, Math.abs(b - a) / 4), along = (t - a) * Math.sign(b - a), length = Math.abs(b - a);
    return along < -GRIP || along > length + GRIP ? undefined : along < inwards ? 0 : along > length - inwards ? 1 : null;
  };
  const edges = [side(x, x0, x1), side(y, y0, y1)];
  return edges.includes(undefined) ? null : edges;
}

const CURSORS = { "null null": "move", "null 0": "ns-resize", "null 1": "ns-resize", "0 null": "ew-resize", "1 null": "ew-resize",
  "turn": "grab", "0 0": "nesw-resize", "1 1": "nesw-resize", "0 1": "nwse-resize", "1 0": "nwse-resize" };

/* As the criterion is evaluated: closed, in the detector's own units, corners in any order. */
function regionHas(x, y) {
  const { kind, region } = sensor, between = (v, a, b) => v >= Math.min(a, b) && v <= Math.max(a, b);
  [x, y] = turned([x, y], -sensor.turn);
  if (kind === "rect") return between(x, region[0], region[2]) && between(y, region[1], region[3]);
  const u = (x - region[0]) / region[2], v = (y - region[1]) / region[3];
  return u * u + v * v <= 1;
}

function regionText(detector) {
  const { kind, region, turn } = sensor;
  if (!region) return null;
  const [u0, v0, u1, v1] = regionBounds(detector, kind, region);
  const corners = CORNERS.flatMap(([u, v]) => turned([u0 + u * (u1 - u0), v0 + v * (v1 - v0)])).map((value) => Number(value.toPrecision(12)));
  const part = turn === 0 ? `${kind}(${region.join(", ")})` : kind === "rect" ? `polygon(${corners.join(", ")})` : `ellipse(${region.join(", ")}, ${turn} deg)`;
  return `registered(${detector.word}, ${part})`;
}

/* After a change of region, detector, class or criteria. */
function refreshRegion() {
  const detector = current();
  if (!detector) return;
  /* A class's criterion has that of the page in front. */
  const of = (shown.class >= 0 && classes[shown.class].criterion) || (allCriteriaOn() ? data.criterion : null);
  showCriterion(byId("region-criterion"), sensor.region ? allOf([of, criteriaOn(), regionText(detector)]) : null);
  shown.region = null;
  const inside = [];
  if (sensor.region) {
    shown.region = new Uint8Array(ray.count);
    for (const [i, r] of registrationsOn(sensor.index)) {
      const place = [0, 1].map((axis) => detectorPlace(detector, registration.relative[2 * i + axis], axis));
      if (!regionHas(...place)) continue;
      shown.region[r] = 1;
      inside.push(r);
    }
  }
  refreshRays();
  refreshClasses();
  const strong = inside.filter((r) => shown.state[r] === STRONG);
  const registered = strong.reduce((sum, r) => sum + ray.flux[r], 0);
  const flux = ray.flux.reduce((sum, f, r) => sum + (shown.state[r] === STRONG ? f : 0), 0);
  byId("region-count").textContent = sensor.region
    ? `${whole(shown.inRegion)} of the ${whole(ray.count)} rays in this page, ${figure(flux, 4)} ${scene.flux_unit}; registered there ${whole(strong.length)} times, ${figure(registered, 4)} ${scene.flux_unit}` +
      (imageHolds(detector) ? `; of the whole image about ${figure(imageFlux(detector), 4)} ${scene.flux_unit}` : "") : "";
  const fields = [...byId("region").querySelectorAll("input")];
  fields.forEach((field, k) => (field.value = sensor.region ? String([...sensor.region, sensor.turn][k]) : ""));
  drawImage();
}

/* The switches that are on, where some are off. */
function criteriaOn() {
  if (allCriteriaOn()) return null;
  const on = where.filter((_, index) => whereOn & (1 << index)).map((one) => `(${one.criterion})`);
  return on.length ? on.join(" or ") : "ray < 0";
}

/* Numbers as short as the picture's resolution allows: the text says what was evaluated. Edges go outwards,
 * those that are as short already stay. */
function shortNumber(value, detector, round) {
  const step = Math.max(...[0, 1].map((axis) => span(detector, axis)[1] - span(detector, axis)[0])) / 2000;
  const digits = Math.max(0, Math.min(12, Math.ceil(-Math.log10(step))));
  const scaled = value * 10 ** digits, nearest = Math.round(scaled);
  return Number(((Math.abs(scaled - nearest) < 1e-6 ? nearest : round(scaled)) / 10 ** digits).toFixed(digits)) + 0;
}

/* Between two places on the picture, [right, up] each. */
function regionBetween(from, to) {
  const detector = current(), right = rightAxis(detector);
  const a = [from[right], to[right]], b = [from[1 - right], to[1 - right]];
  const [a0, a1, b0, b1] = [Math.min(...a), Math.max(...a), Math.min(...b), Math.max(...b)];
  const numbers = sensor.kind === "rect" ? [a0, b0, a1, b1]
    : [(a0 + a1) / 2, (b0 + b1) / 2, (a1 - a0) / 2, (b1 - b0) / 2];
  const rounds = sensor.kind === "rect" ? [Math.floor, Math.floor, Math.ceil, Math.ceil] : [Math.round, Math.round, Math.ceil, Math.ceil];
  const region = numbers.map((value, k) => shortNumber(value, detector, rounds[k]));
  const empty = a0 === a1 || b0 === b1;
  return empty ? null : region;
}

/* The region moved by [right, up], its size kept to the last digit. */
function movedBy(region, by) {
  const detector = current(), right = rightAxis(detector);
  const [a, b] = [by[right], by[1 - right]].map((value) => shortNumber(value, detector, Math.round));
  const add = sensor.kind === "rect" ? [a, b, a, b] : [a, b, 0, 0];
  return region.map((value, k) => Number((value + add[k]).toPrecision(12)));
}

/* Those of its edges that are held go to [right, up] of the region before it is turned, whose centre is the old one. */
function resizedTo(region, hold, to) {
  const bounds = regionBounds(current(), sensor.kind, region);
  hold.forEach((edge, axis) => edge !== null && (bounds[2 * edge + axis] = to[axis]));
  const resized = regionBetween(bounds.slice(0, 2), bounds.slice(2));
  if (!resized || sensor.turn === 0) return resized;
  const centre = centreOf(resized);
  return movedBy(resized, turned(centre, sensor.turn, centreOf(region)).map((value, k) => value - centre[k]));
}

/* Degrees, from -180 to 180. */
const turnedBy = (turn, by) => Number((((turn + by + 180) % 360 + 360) % 360 - 180).toPrecision(12));

/* By which a pointer went round the region's centre, in whole degrees. */
function angleBetween(from, to) {
  const centre = centreOf(sensor.region), [a, b] = [from, to].map(([u, v]) => Math.atan2(v - centre[1], u - centre[0]));
  return Math.round((b - a) * 180 / Math.PI);
}

/* A step: some of `index`, `kind`, `region`. */
function takeStep(next, before = state()) {
  if (before.region || next.region) {
    steps.past.push(before);
    steps.undone = [];
  }
  showState(next);
}

function showState(next) {
  const { index } = sensor;
  Object.assign(sensor, next);
  if (!sensor.region) sensor.turn = 0;
  byId("draw-rect").setAttribute("aria-pressed", String(sensor.kind === "rect"));
  byId("draw-ellipse").setAttribute("aria-pressed", String(sensor.kind === "ellipse"));
  byId("undo").disabled = !steps.past.length;
  byId("redo").disabled = !steps.undone.length;
  byId("detector").value = String(sensor.index);
  if (sensor.index !== index) {
    sensor.scaled = false;
    describeDetector();
  }
  nameFields();
  refreshRegion();
}

/* From one list of states to the other: undone and done again. */
function goTo(from, to) {
  if (!from.length) return;
  to.push(state());
  showState(from.pop());
}
const undo = () => goTo(steps.past, steps.undone), redo = () => goTo(steps.undone, steps.past);

function nameFields() {
  if (!current()) return;
  const [a, b] = axisNames(current());
  const names = sensor.kind === "rect" ? [`${a}0`, `${b}0`, `${a}1`, `${b}1`] : [a, b, `r${a[0]}`, `r${b[0]}`];
  byId("region").querySelectorAll("label span").forEach((label, k) => (label.textContent = [...names, "turned"][k]));
  byId("region-turn").hidden = !canTurn(current());
}

image.addEventListener("pointerdown", (event) => {
  const [x, y] = placeOn(image, event);
  const hold = event.shiftKey ? null : gripAt(x, y);
  Object.assign(drag, { from: toCoordinates(x, y, hold === TURN), hold, before: state() });
  image.setPointerCapture(event.pointerId);
});
image.addEventListener("pointermove", (event) => {
  const [x, y] = placeOn(image, event);
  if (!drag.from) image.style.cursor = (!event.shiftKey && CURSORS[(gripAt(x, y) || []).map(String).join(" ")]) || "crosshair";
  if (!drag.from) return;
  const to = toCoordinates(x, y), { region, turn } = drag.before;
  if (!drag.hold) Object.assign(sensor, { region: regionBetween(drag.from, to), turn: 0 });
  else if (drag.hold === TURN) sensor.turn = turnedBy(turn, angleBetween(drag.from, toCoordinates(x, y, true)));
  else if (drag.hold.some((edge) => edge !== null)) sensor.region = resizedTo(region, drag.hold, turned(to, -turn, centreOf(region)));
  else sensor.region = movedBy(region, to.map((value, k) => value - drag.from[k]));
  drawImage();
});
/* A press that has not moved is a step only where it takes a region away. */
image.addEventListener("pointerup", () => {
  if (!drag.from) return;
  const { before, hold } = drag, { turn } = sensor, region = sensor.region === before.region && !hold ? null : sensor.region;
  drag.from = null;
  if (region !== before.region || turn !== before.turn) takeStep({ region, turn }, before);
});
/* The pointer was taken away, or Esc pressed. */
function dropDrag() {
  if (!drag.from) return false;
  drag.from = null;
  showState(drag.before);
  return true;
}
image.addEventListener("pointercancel", dropDrag);

/* Arrows move the region by a hundredth of the picture; with Shift its right and its upper edge; < and > turn it by a degree. */
image.addEventListener("keydown", (event) => {
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  const turn = { "<": 1, ">": -1 }[event.key];
  if (!(way || turn) || !sensor.region || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  event.stopPropagation(); // or the scene turns, too
  if (turn) return void (canTurn(current()) && takeStep({ turn: turnedBy(sensor.turn, turn) }));
  const { u, v } = sensor.area, [, , u1, v1] = regionBounds(current(), sensor.kind, sensor.region);
  const by = [way[0] * (u[1] - u[0]) / 100, way[1] * (v[1] - v[0]) / 100];
  const region = event.shiftKey ? resizedTo(sensor.region, way.map((k) => (k ? 1 : null)), [u1 + by[0], v1 + by[1]])
    : movedBy(sensor.region, by);
  if (region) takeStep({ region });
});
for (const kind of ["rect", "ellipse"]) byId(`draw-${kind}`).addEventListener("click", () => takeStep({ kind, region: null }));
byId("draw-none").addEventListener("click", () => takeStep({ region: null }));
byId("undo").addEventListener("click", undo);
byId("redo").addEventListener("click", redo);
byId("detector").addEventListener("change", (event) => takeStep({ index: Number(event.target.value), region: null }));
byId("region").addEventListener("submit", (event) => {
  event.preventDefault();
  const typed = [...byId("region").querySelectorAll("input")].map((field, k) => field.value.trim().replace(",", ".").replace(MINUS, "-") || (k === 4 ? "0" : ""));
  const numbers = typed.map((text) => (/^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(text) ? Number(text) : NaN));
  const wrong = numbers.findIndex((value) => !Number.isFinite(value));
  const refused = wrong >= 0 ? `"${typed[wrong]}" is no number` :
    sensor.kind === "ellipse" && !(numbers[2] > 0 && numbers[3] > 0) ? "the half-axes of an ellipse must be > 0" : null;
  if (refused) {
    byId("region-count").textContent = `Refused: ${refused}.`;
    return;
  }
  takeStep({ region: numbers.slice(0, 4), turn: canTurn(current()) ? turnedBy(numbers[4], 0) : 0 });
});
copyButton(byId("region-criterion"));
