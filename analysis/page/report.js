// SPDX-License-Identifier: MIT
//
// What happened along a ray: of one leg beside the pointer, of a whole ray as tables.

/* Length of leg l as the map has it: along its points. A leg that leaves has none. */
function legLength(l) {
  if (leg.event[l] & EVENT_LEFT) return 0;
  const step = strokes.first[l + 1] - strokes.first[l] > 1 ? CURVE_STROKES : 1, p = strokes.position;
  let sum = 0;
  for (let s = strokes.first[l]; s < strokes.first[l + 1]; s += step) {
    const from = 6 * s, to = 6 * (s + step - 1) + 3;
    sum += Math.hypot(p[to] - p[from], p[to + 1] - p[from + 1], p[to + 2] - p[from + 2]);
  }
  return sum;
}

/* From the emission to the end of leg l. */
function pathTo(l) {
  let sum = 0;
  for (let k = ray.firstLeg[leg.ray[l]]; k <= l; k++) sum += legLength(k);
  return sum;
}

const stepOf = (l) => l - ray.firstLeg[leg.ray[l]];

/* Floats have 9 digits. */
const placeWords = (v, at) => [0, 1, 2].map((k) => figure(v[3 * at + k], 9)).join("  ");

function definitions(rows) {
  const list = element("dl", {});
  for (const [name, value] of rows)
    list.append(element("dt", { textContent: name }), element("dd", { textContent: value }));
  return list;
}

function showTip(l, x, y) {
  const r = leg.ray[l], unit = scene.unit, tip = byId("tip");
  const left = leg.event[l] & EVENT_LEFT;
  tip.replaceChildren(
    element("strong", { textContent: `ray ${ray.id[r]}, step ${stepOf(l)}` }),
    definitions([
      ["source", scene.sources[ray.source[r]].name],
      ["ends at", objectName(leg.object[l]) || (left ? "left the scene" : "inside a medium")],
      ["event", eventWords(leg.event[l]) || "\u2013"],
      ["medium", mediumName(leg.medium[l]) || "\u2013"],
      ["position", `${placeWords(leg.position, l)} ${unit}`],
      ["length", left ? "\u2013" : `${figure(legLength(l))} ${unit}`],
      ["path so far", `${figure(pathTo(l))} ${unit}`],
      ["light", lightWords(l)],
      ["flux of the ray", `${figure(ray.flux[r])} ${scene.flux_unit}`],
    ]));
  tip.classList.remove("body");
  placeTip(x, y);
}

/* Buttons that others add to the tip of a body: each makes them for an object's index. */
const bodyActions = [];

function showBodyTip(index, x, y) {
  const hide = element("button", { type: "button", textContent: "hide" });
  hide.addEventListener("click", () => {
    byId("objects").querySelector(`[data-object="${index}"]`).click();
    hideTip();
  });
  const { name, surface } = scene.objects[index];
  byId("tip").replaceChildren(element("strong", { textContent: name }), ` ${surface || ""} `, hide,
    ...bodyActions.flatMap((make) => make(index)));
  byId("tip").classList.add("body");
  placeTip(x, y);
}

function placeTip(x, y) {
  const tip = byId("tip");
  tip.hidden = false;
  const w = tip.offsetWidth, h = tip.offsetHeight;
  tip.style.left = Math.max(4, Math.min(x + 16, canvas.clientWidth - w - 4)) + "px";
  tip.style.top = Math.max(4, y + 16 + h > canvas.clientHeight ? y - h - 12 : y + 16) + "px";
}

function hideTip() {
  byId("tip").hidden = true;
  byId("tip").classList.remove("body");
}

/* Degrees between the reversed light and a detector's axis; on an intensity grid of the light. */
function registrationAngle(i) {
  const detector = detectors[registration.detector[i]];
  const sign = detector.type === "intensity" ? 1 : -1;
  const d = new THREE.Vector3().fromArray(registration.direction, 3 * i).multiplyScalar(sign);
  const axis = vectorOf(detector.axis);
  return (Math.atan2(new THREE.Vector3().crossVectors(d, axis).length(), d.dot(axis)) * 180) / Math.PI;
}

/* A registration's place in the detector's own units, as the criterion language has it. */
function detectorPlace(detector, relative, axis) {
  const part = relative / 65535;
  if (detector.type === "intensity") return part * (axis === 0 ? 180 : 360);
  return (part - 0.5) * detector.size[axis];
}

const axisNames = (detector) => (detector.type === "intensity" ? ["theta", "phi"] : ["x", "y"]);
const axisUnit = (detector) => (detector.type === "intensity" ? "deg" : scene.unit);

function registrationWords(i) {
  const detector = detectors[registration.detector[i]];
  const places = axisNames(detector).map((name, axis) =>
    `${name} ${figure(detectorPlace(detector, registration.relative[2 * i + axis], axis))}`);
  return `${registration.registered[i] ? "registered" : "only crossed"}: ${places.join(", ")} ${axisUnit(detector)}, ` +
    `angle ${figure(registrationAngle(i), 5)} deg, optical path ${figure(registration.optical_path[i], 9)} ${scene.unit}`;
}

function table(headings, rows, numbers) {
  const made = element("table", {}, element("thead", {}, element("tr", {},
    ...headings.map((text) => element("th", { textContent: text, scope: "col" })))));
  const body = element("tbody", {});
  for (const { cells, kind, span, leg: l } of rows) {
    const row = element("tr", { className: kind || "" });
    cells.forEach((text, c) => row.append(element("td", {
      textContent: text, className: numbers.includes(c) ? "number" : "", colSpan: span && c === cells.length - 1 ? span : 1 })));
    if (l !== undefined) {
      row.addEventListener("pointerenter", () => markLeg(l));
      row.addEventListener("pointerleave", () => markLeg(-1));
    }
    body.append(row);
  }
  made.append(body);
  return made;
}

function historyRows(r) {
  const rows = [];
  const registrations = (step, after) => {
    for (let i = ray.firstRegistration[r]; i < ray.firstRegistration[r + 1]; i++) {
      const detector = detectors[registration.detector[i]];
      if (registration.leg[i] === step && detector.after_step === after)
        rows.push({ cells: [step, registration.registered[i] ? "V" : "", detector.name, registrationWords(i)], span: 4, kind: "registration" });
    }
  };
  for (let l = ray.firstLeg[r]; l < ray.firstLeg[r + 1]; l++) {
    const step = stepOf(l);
    registrations(step, false);
    rows.push({ leg: l, cells: [step, eventLetter(leg.event[l]), objectName(leg.object[l]) || "\u2013",
      leg.primitive[l] >= 0 ? leg.primitive[l] : "\u2013", mediumName(leg.medium[l]) || "\u2013", lightWords(l), eventWords(leg.event[l])] });
    registrations(step, true);
  }
  return rows;
}

function geometryRows(r) {
  const rows = [{ cells: ["start", ...[0, 1, 2].map((k) => figure(ray.start[3 * r + k], 9)), "", "0"] }];
  for (let l = ray.firstLeg[r]; l < ray.firstLeg[r + 1]; l++)
    rows.push({ leg: l, cells: [stepOf(l), ...[0, 1, 2].map((k) => figure(leg.position[3 * l + k], 9)), figure(legLength(l)),
      figure(pathTo(l))] });
  return rows;
}

function reportOf(r) {
  const last = ray.firstLeg[r + 1] - 1, unit = scene.unit;
  const where = last >= ray.firstLeg[r] ? objectName(leg.object[last]) : null;
  const start = objectName(ray.start_object[r]);
  return [
    definitions([
      ["source", scene.sources[ray.source[r]].name + (start ? `, from object ${start}` : "")],
      ["stop", words.stop[ray.stop[r]] + (where ? ` at ${where}` : "")],
      ["flux", `${figure(ray.flux[r], 9)} ${scene.flux_unit}`],
      ["wavelength", Number.isNaN(ray.wavelength[r]) ? "undefined (more than one channel)" : `${figure(ray.wavelength[r], 10)} nm`],
      ["path length", `${figure(ray.path_length[r], 9)} ${unit}`],
      ["optical path", `${figure(ray.optical_path[r], 9)} ${unit}`],
      ["ghost order", String(ray.order[r])],
      ["scatter order", String(ray.scatter[r])],
      ...(ray.class[r] >= 0 ? [["path class", classes[ray.class[r]].sequence]] : []),
    ]),
    table(["step", "", "object", "prim", "medium", "light", "events"], historyRows(r), [0, 3]),
    table(["step", "x", "y", "z", "length", `path, ${unit}`], geometryRows(r), [0, 1, 2, 3, 4, 5]),
  ];
}

/* Who may know rays, by their id, that the page does not hold. */
const elsewhere = { rays: [] };

/* r < 0: none. */
function chooseRay(r) {
  markRay(r);
  markLeg(-1);
  byId("ray-name").textContent = r < 0 ? "" : ray.id[r];
  byId("ray-id").value = r < 0 ? "" : ray.id[r];
  byId("ray-report").replaceChildren(...(r < 0 ? [] : reportOf(r)));
  if (r >= 0) byId("ray-box").open = true;
}

byId("ray-none").addEventListener("click", () => chooseRay(-1));
byId("ray-id").addEventListener("change", (event) => {
  const typed = event.target.value.trim(), r = /^\d+$/.test(typed) ? ray.id.indexOf(String(BigInt(typed))) : -1;
  if (r >= 0) return chooseRay(r);
  chooseRay(-1);
  byId("ray-report").textContent = "This page holds no such ray.";
  if (/^\d+$/.test(typed)) elsewhere.rays.forEach((find) => find(String(BigInt(typed))));
});
