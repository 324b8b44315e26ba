// SPDX-License-Identifier: MIT
//
// The page's data: columns of rays, legs (segments), registrations and points of curved legs, as in
// the map; and small helpers that every other script uses. Other data may take their place: what is
// made of them is made again.

const byId = (id) => document.getElementById(id);

let data = firstData;
const renewals = [];

/* Now, and again with other data, in the order of the calls. */
function whenData(call) {
  renewals.push(call);
  call(true);
}

/* Of these only with another scene. */
const whenScene = (call) => whenData((isOther) => isOther && call());

/* Of these also when only places have changed. */
const placings = [];
function whenPlaced(call) {
  placings.push(call);
  whenScene(call);
}

/* Other places of the same things. The view stays. */
function takePlaces({ objects = {}, detectors: frames = [], ...rest }) {
  const half = halfHeight();
  for (const [index, matrix] of Object.entries(objects)) scene.objects[index].matrix = matrix;
  for (const one of [scene, data.scene]) Object.assign(one, rest);
  frames.forEach((frame, k) => Object.assign(detectors[k], frame));
  for (const call of placings) call();
  setHalfHeight(half);
  redraw();
}

/* Parts that are not given stay. The view stays. */
function takeData(parts) {
  const half = halfHeight();
  data = { ...data, ...parts };
  for (const call of renewals) call(parts.scene !== undefined);
  setHalfHeight(half);
  setScheme(scheme.dark);
}

const ARRAYS = { f32: Float32Array, f64: Float64Array, u8: Uint8Array, u16: Uint16Array, i32: Int32Array, u64: BigUint64Array };

function unpack(packed) {
  const text = atob(packed.d);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const values = new ARRAYS[packed.t](bytes.buffer);
  return packed.o ? Int32Array.from(values, (v) => v + packed.o) : values;
}

function unpackAll(columns) {
  const table = {};
  for (const name of Object.keys(columns)) table[name] = unpack(columns[name]);
  return table;
}

/* Row of a ray's first leg (registration); one entry more than there are rays. */
function runningSum(counts) {
  const sum = new Uint32Array(counts.length + 1);
  for (let i = 0; i < counts.length; i++) sum[i + 1] = sum[i] + counts[i];
  return sum;
}

const ray = {}, leg = {}, registration = {}, curve = {}, colour = {}, words = {}, scene = {}, detectors = [];
let times = null; // ns, of maps with arrival times
let EVENT_LEFT = 0, EVENT_GRADIENT = 0;

whenData(() => {
  const { rays } = data;
  for (const [table, columns] of [[ray, rays.ray], [leg, rays.leg], [registration, rays.registration], [curve, rays.curve], [colour, rays.colour]])
    Object.assign(table, unpackAll(columns));
  Object.assign(words, rays.words);
  Object.assign(scene, data.scene);
  detectors.splice(0, detectors.length, ...data.detectors.list);
  times = data.times ? unpackAll(data.times) : null;
  ray.id = Array.from(ray.id, String); // numbers are exact up to 2^53 only
  ray.count = ray.id.length;
  leg.count = leg.event.length;
  ray.firstLeg = runningSum(ray.legs);
  ray.firstRegistration = runningSum(ray.registrations);
  leg.ray = new Uint32Array(leg.count);
  for (let r = 0; r < ray.count; r++) leg.ray.fill(r, ray.firstLeg[r], ray.firstLeg[r + 1]);
  EVENT_LEFT = 1 << words.event.indexOf("left");
  EVENT_GRADIENT = 1 << words.event.indexOf("gradient");
});

/* An element with properties and children; text is never HTML. */
function element(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

const MINUS = "\u2212";

/* A number for people. */
function figure(value, digits = 6) {
  if (value === null || !Number.isFinite(value)) return "\u2013";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e7 || size < 1e-4 ? value.toExponential(digits - 1) : value.toPrecision(digits);
  return text.replace(/(\.\d*?)0+(e|$)/, "$1$2").replace(/\.(e|$)/, "$1").replace("e+", "e").replace(/-/g, MINUS);
}

const thousands = new Intl.NumberFormat("en-US");
const whole = (n) => thousands.format(n);

function eventWords(bits) {
  return words.event.filter((word, bit) => bits & (1 << bit)).join(", ");
}

/* The letter of a step: of several events the first in the order of precedence. */
function eventLetter(bits) {
  const letters = words.letter.filter((letter, bit) => letter && bits & (1 << bit));
  return [...words.precedence].find((letter) => letters.includes(letter)) || "-";
}

const objectName = (index) => (index >= 0 ? scene.objects[index].name : null);
const mediumName = (index) => (index >= 0 && index < scene.media.length ? scene.media[index] : null);

/* What a leg's light is: a wavelength, shares of a few, or how many. */
function lightWords(legIndex) {
  const c = colour.of[legIndex];
  const n = Math.min(colour.live[c], 4);
  const share = (k) => colour.share[4 * c + k] / 65535;
  if (scene.mode === "rgb") {
    const rgb = [0, 0, 0];
    for (let k = 0; k < n; k++) rgb[colour.channel[4 * c + k]] = share(k);
    return "rgb " + rgb.map((v) => figure(v, 3)).join(" ");
  }
  const nm = (k) => figure(scene.wavelengths[colour.channel[4 * c + k]], 7) + " nm";
  if (n === 1) return nm(0);
  if (colour.live[c] > 4) return `${colour.live[c]} wavelengths, most at ${nm(0)}`;
  return Array.from({ length: n }, (_, k) => `${nm(k)} ${figure(share(k), 3)}`).join(", ");
}

/* Several criteria as one. */
function allOf(criteria) {
  const given = criteria.filter((text) => text);
  return given.length > 1 ? given.map((text) => `(${text})`).join(" and ") : given[0] || "all";
}

function copyButton(box) {
  const button = box.querySelector("button");
  button.addEventListener("click", async () => {
    const code = box.querySelector("code");
    let done = false;
    try {
      await navigator.clipboard.writeText(code.textContent);
      done = true;
    } catch (refused) { // pages from files may not
      getSelection().selectAllChildren(code);
      done = document.execCommand("copy");
    }
    button.textContent = done ? "copied" : "press Ctrl+C";
    setTimeout(() => (button.textContent = "copy"), 1500);
  });
}

function showCriterion(box, text) {
  box.hidden = !text;
  box.querySelector("code").textContent = text || "";
}
