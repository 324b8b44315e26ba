// SPDX-License-Identifier: MIT
//
// Regions of a detector: a rectangle or ellipse drawn on its image becomes a criterion, and the rays
// that are registered in it stand out.

/* Bounds [u0, v0, u1, v1] of the region on the picture. */
function regionBounds(detector, kind, region) {
  const right = rightAxis(detector);
  const [a0, a1, b0, b1] = kind === "rect" ? [region[0], region[2], region[1], region[3]]
    : [region[0] - region[2], region[0] + region[2], region[1] - region[3], region[1] + region[3]];
  return right === 0 ? [a0, b0, a1, b1] : [b0, a0, b1, a1];
}

function drawRegion(detector) {
  if (!sensor.region) return;
  const [u0, v0, u1, v1] = regionBounds(detector, sensor.kind, sensor.region);
  const [x0, y0] = toCanvas(u0, v0), [x1, y1] = toCanvas(u1, v1);
  for (const [ink, width] of [["#000000", 3.5], ["#ffd24d", 1.8]]) {
    paint.strokeStyle = ink;
    paint.lineWidth = width;
    paint.beginPath();
    if (sensor.kind === "rect") paint.rect(x0, y1, x1 - x0, y0 - y1);
    else paint.ellipse((x0 + x1) / 2, (y0 + y1) / 2, Math.abs(x1 - x0) / 2, Math.abs(y1 - y0) / 2, 0, 0, 2 * Math.PI);
    paint.stroke();
  }
  paint.lineWidth = 1;
}

/* As the criterion is evaluated: closed, in the detector's own units, corners in any order. */
function regionHas(kind, region, x, y) {
  const between = (v, a, b) => v >= Math.min(a, b) && v <= Math.max(a, b);
  if (kind === "rect") return between(x, region[0], region[2]) && between(y, region[1], region[3]);
  const u = (x - region[0]) / region[2], v = (y - region[1]) / region[3];
  return u * u + v * v <= 1;
}

function regionText(detector) {
  return sensor.region ? `registered(${detector.word}, ${sensor.kind}(${sensor.region.join(", ")}))` : null;
}

/* After a change of region, detector or class. */
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
      if (!regionHas(sensor.kind, sensor.region, ...place)) continue;
      shown.region[r] = 1;
      inside.push(r);
    }
  }
  refreshRays();
  const strong = inside.filter((r) => shown.state[r] === STRONG);
  const registered = strong.reduce((sum, r) => sum + ray.flux[r], 0);
  const flux = ray.flux.reduce((sum, f, r) => sum + (shown.state[r] === STRONG ? f : 0), 0);
  byId("region-count").textContent = sensor.region
    ? `${whole(shown.inRegion)} of the ${whole(ray.count)} rays in this page, ${figure(flux, 4)} ${scene.flux_unit}; registered there ${whole(strong.length)} times, ${figure(registered, 4)} ${scene.flux_unit}` +
      (detector.image && allCriteriaOn() && shown.class < 0 ? `; of the whole image about ${figure(imageFlux(detector), 4)} ${scene.flux_unit}` : "") : "";
  const fields = [...byId("region").querySelectorAll("input")];
  fields.forEach((field, k) => (field.value = sensor.region ? String(sensor.region[k]) : ""));
  drawImage();
}

/* The switches that are on, where some are off. */
function criteriaOn() {
  if (allCriteriaOn()) return null;
  const on = where.filter((_, index) => whereOn & (1 << index)).map((one) => `(${one.criterion})`);
  return on.length ? on.join(" or ") : "ray < 0";
}

/* Numbers as short as the picture's resolution allows: the text says what was evaluated. Edges go outwards. */
function shortNumber(value, detector, round) {
  const step = Math.max(...[0, 1].map((axis) => span(detector, axis)[1] - span(detector, axis)[0])) / 2000;
  const digits = Math.max(0, Math.min(12, Math.ceil(-Math.log10(step))));
  return Number((round(value * 10 ** digits) / 10 ** digits).toFixed(digits)) + 0;
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

function setKind(kind) {
  sensor.kind = kind;
  sensor.region = null;
  byId("draw-rect").setAttribute("aria-pressed", String(kind === "rect"));
  byId("draw-ellipse").setAttribute("aria-pressed", String(kind === "ellipse"));
  nameFields();
  refreshRegion();
}

function nameFields() {
  if (!current()) return;
  const [a, b] = axisNames(current());
  const names = sensor.kind === "rect" ? [`${a}0`, `${b}0`, `${a}1`, `${b}1`] : [a, b, `r${a[0]}`, `r${b[0]}`];
  byId("region").querySelectorAll("label span").forEach((label, k) => (label.textContent = names[k]));
}

image.addEventListener("pointerdown", (event) => {
  sensor.pressed = toCoordinates(...placeOn(image, event));
  image.setPointerCapture(event.pointerId);
});
image.addEventListener("pointermove", (event) => {
  if (!sensor.pressed) return;
  sensor.region = regionBetween(sensor.pressed, toCoordinates(...placeOn(image, event)));
  drawImage();
});
image.addEventListener("pointerup", (event) => {
  if (!sensor.pressed) return;
  sensor.region = regionBetween(sensor.pressed, toCoordinates(...placeOn(image, event)));
  sensor.pressed = null;
  refreshRegion();
});
image.addEventListener("pointercancel", () => (sensor.pressed = null));
byId("draw-rect").addEventListener("click", () => setKind("rect"));
byId("draw-ellipse").addEventListener("click", () => setKind("ellipse"));
byId("draw-none").addEventListener("click", () => setKind(sensor.kind));
byId("region").addEventListener("submit", (event) => {
  event.preventDefault();
  const typed = [...byId("region").querySelectorAll("input")].map((field) => field.value.trim().replace(",", ".").replace(MINUS, "-"));
  const numbers = typed.map((text) => (/^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(text) ? Number(text) : NaN));
  const wrong = numbers.findIndex((value) => !Number.isFinite(value));
  const refused = wrong >= 0 ? `"${typed[wrong]}" is no number` :
    sensor.kind === "ellipse" && !(numbers[2] > 0 && numbers[3] > 0) ? "the half-axes of an ellipse must be > 0" : null;
  if (refused) {
    byId("region-count").textContent = `Refused: ${refused}.`;
    return;
  }
  sensor.region = numbers;
  refreshRegion();
});
copyButton(byId("region-criterion"));
