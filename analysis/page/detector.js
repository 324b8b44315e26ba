// SPDX-License-Identifier: MIT
//
// The image of a detector, beside the scene and in it.

const image = byId("image");
const paint = image.getContext("2d");
const scaleBytes = unpack(data.detectors.scale);
const scaleInk = new Uint32Array(Uint8Array.from({ length: 4 * 256 }, (_, i) => (i % 4 < 3 ? scaleBytes[3 * (i >> 2) + (i % 4)] : 255)).buffer); // as pixels
const FRAME = { left: 46, right: 10, top: 8, bottom: 22, bar: 52 }; // CSS pixels about the picture

/* index: of the detector, -1 before the first; kind: "rect" or "ellipse"; region: four numbers of the criterion, or null; turn: degrees about its centre, counterclockwise; scaled: its user chose the scale */
const sensor = { index: -1, kind: "rect", region: null, turn: 0, scaled: false, area: null, picture: null, pictures: new Map() };
const current = () => detectors[sensor.index];

/* Axis of the detector that runs to the right: x of a plane, phi of an intensity grid. */
const rightAxis = (detector) => (detector.type === "intensity" ? 1 : 0);

/* Least and greatest coordinate along an axis. */
function span(detector, axis) {
  return [detectorPlace(detector, 0, axis), detectorPlace(detector, 65535, axis)];
}

function imageValues(detector) {
  if (!detector.image.values) detector.image.values = unpack(detector.image.value);
  return detector.image.values;
}

/* Flux in the region, of the whole image: cells count by the part of them (4 x 4 points) that lies inside. */
function imageFlux(detector) {
  const { n, cells, step, flux } = detector.image, values = imageValues(detector), POINTS = 4;
  const ends = [0, 1].map((axis) => span(detector, axis));
  const edge = (axis, k) => ends[axis][0] + Math.min(k * step / cells[axis], 1) * (ends[axis][1] - ends[axis][0]);
  const angle = Math.PI / 180, extent = (axis, k) => detector.type === "intensity" && axis === 0
    ? Math.cos(edge(0, k) * angle) - Math.cos(edge(0, k + 1) * angle) : edge(axis, k + 1) - edge(axis, k);
  let inside = 0, all = 0;
  for (let j = 0; j < n[1]; j++)
    for (let i = 0; i < n[0]; i++) {
      const own = values[j * n[0] + i] * extent(0, i) * extent(1, j);
      all += own;
      for (let k = 0; own > 0 && k < POINTS * POINTS; k++) {
        const [u, v] = [(k % POINTS + 0.5) / POINTS, (Math.floor(k / POINTS) + 0.5) / POINTS];
        const [x, y] = [edge(0, i) + u * (edge(0, i + 1) - edge(0, i)), edge(1, j) + v * (edge(1, j + 1) - edge(1, j))];
        if (regionHas(x, y)) inside += own / (POINTS * POINTS);
      }
    }
  return all > 0 ? (flux * inside) / all : 0;
}

/* Values as a picture of one pixel per cell, upwards and to the right as people expect. */
function pictureOf(detector, log) {
  const key = `${detectors.indexOf(detector)} ${log}`;
  if (sensor.pictures.has(key)) return sensor.pictures.get(key);
  const [nx, ny] = detector.image.n, most = detector.image.most;
  const values = imageValues(detector);
  const least = log ? values.reduce((a, b) => (b > 0 ? Math.min(a, b) : a), most) : 0;
  const level = (v) => (!log ? v / most : v > 0 ? Math.log(v / least) / Math.max(Math.log(most / least), 1e-9) : 0);
  const swapped = rightAxis(detector) === 1;
  const cells = element("canvas", { width: swapped ? ny : nx, height: swapped ? nx : ny });
  const context = cells.getContext("2d"), pixels = context.createImageData(cells.width, cells.height), ink = new Uint32Array(pixels.data.buffer);
  for (let j = 0; j < ny; j++)
    for (let i = 0; i < nx; i++) {
      const column = swapped ? j : i, row = cells.height - 1 - (swapped ? i : j);
      const step = most > 0 ? Math.round(255 * Math.min(Math.max(level(values[j * nx + i]), 0), 1)) : 0;
      ink[row * cells.width + column] = scaleInk[step];
    }
  context.putImageData(pixels, 0, 0);
  const texture = new THREE.CanvasTexture(cells);
  texture.magFilter = texture.minFilter = THREE.NearestFilter;
  texture.generateMipmaps = false;
  const made = { cells, values, most, least, texture };
  sensor.pictures.set(key, made);
  return made;
}

function forgetPictures() {
  for (const { texture } of sensor.pictures.values()) texture.dispose();
  sensor.pictures.clear();
}

/* The picture on the detector itself, in the scene. */
const screens = [];

function screenOf(detector) {
  if (detector.type !== "plane" || !detector.image) return null;
  const material = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2 });
  const plane = new THREE.Mesh(new THREE.PlaneBufferGeometry(detector.size[0], detector.size[1]), material);
  const [x, y] = [vectorOf(detector.x), vectorOf(detector.y)];
  plane.matrixAutoUpdate = false;
  plane.matrix.makeBasis(x, y, new THREE.Vector3().crossVectors(x, y)).setPosition(vectorOf(detector.origin));
  plane.visible = false;
  world.add(plane);
  return plane;
}

/* That of the detector beside it alone. */
function hangPicture(picture) {
  screens.forEach((plane, index) => {
    if (!plane) return;
    plane.visible = index === sensor.index && picture !== null && byId("hang").checked;
    if (!plane.visible || plane.material.map === picture.texture) return;
    plane.material.map = picture.texture;
    plane.material.needsUpdate = true;
  });
  redraw();
}

/* Detector coordinates of a place on the canvas, beyond the detector if `beyond`, and back; [right, up]. */
function toCoordinates(x, y, beyond = false) {
  const { left, top, width, height, u, v } = sensor.area;
  const clamp = (t) => (beyond ? t : Math.min(Math.max(t, 0), 1));
  return [u[0] + clamp((x - left) / width) * (u[1] - u[0]), v[0] + clamp(1 - (y - top) / height) * (v[1] - v[0])];
}
function toCanvas(a, b) {
  const { left, top, width, height, u, v } = sensor.area;
  return [left + (width * (a - u[0])) / (u[1] - u[0]), top + height * (1 - (b - v[0]) / (v[1] - v[0]))];
}

function layOut(detector) {
  const width = Math.max(image.clientWidth || 380, 160), right = rightAxis(detector);
  const u = span(detector, right), v = span(detector, 1 - right);
  const room = width - FRAME.left - FRAME.right - FRAME.bar;
  const ratio = Math.min(Math.max((v[1] - v[0]) / (u[1] - u[0]), 0.25), 1.3);
  const height = Math.round(room * ratio);
  sensor.area = { left: FRAME.left, top: FRAME.top, width: room, height, u, v };
  const dense = Math.min(window.devicePixelRatio || 1, 2), total = height + FRAME.top + FRAME.bottom;
  const size = [width, total].map((length) => Math.round(length * dense));
  if (image.width !== size[0] || image.height !== size[1]) { // a new buffer takes long
    [image.width, image.height] = size;
    image.style.height = total + "px";
  }
  paint.setTransform(dense, 0, 0, dense, 0, 0);
}

function drawDots(detector) {
  const right = rightAxis(detector), style = getComputedStyle(document.documentElement);
  const dots = registrationsOn(sensor.index).filter(([, r]) => shown.state[r] !== HIDDEN);
  paint.fillStyle = imageHolds(detector) ? "#7fe0ff" : style.getPropertyValue("--strong");
  paint.globalAlpha = Math.max(0.15, Math.min(0.9, 30 / Math.sqrt(dots.length)));
  for (const [i] of dots) {
    const place = [0, 1].map((axis) => detectorPlace(detector, registration.relative[2 * i + axis], axis));
    const [x, y] = toCanvas(place[right], place[1 - right]);
    paint.fillRect(x - 1, y - 1, 2, 2);
  }
  paint.globalAlpha = 1;
}

/* [row of a registration, ray] of those on a detector that count: as the criteria that are switched
 * on, and that the ray matches, have it. */
function registrationsOn(index) {
  const found = [];
  for (let r = 0; r < ray.count; r++) {
    const by = where.length ? ray.where[r] & whereOn : 1;
    for (let i = ray.firstRegistration[r]; i < ray.firstRegistration[r + 1]; i++)
      if (registration.detector[i] === index && registration.counted[i] & by) found.push([i, r]);
  }
  return found;
}

function drawFrameAndScale(detector, picture) {
  const { left, top, width, height, u, v } = sensor.area, style = getComputedStyle(document.documentElement);
  const names = axisNames(detector), right = rightAxis(detector), unit = axisUnit(detector);
  paint.strokeStyle = style.getPropertyValue("--line");
  paint.strokeRect(left - 0.5, top - 0.5, width + 1, height + 1);
  paint.fillStyle = style.getPropertyValue("--faint");
  paint.font = "11px system-ui, sans-serif";
  paint.textBaseline = "top";
  u.forEach((value, k) => {
    paint.textAlign = k ? "right" : "left";
    paint.fillText(figure(value, 4), left + k * width, top + height + 4);
  });
  paint.textAlign = "center";
  paint.fillText(`${names[right]} / ${unit}`, left + width / 2, top + height + 4);
  paint.textAlign = "right";
  v.forEach((value, k) => {
    paint.textBaseline = k ? "top" : "bottom";
    paint.fillText(figure(value, 4), left - 5, top + (1 - k) * height);
  });
  paint.textBaseline = "middle";
  paint.fillText(names[1 - right], left - 5, top + height / 2);
  if (detector.image && !picture) {
    paint.textAlign = "left";
    paint.textBaseline = "top";
    paint.fillText(allCriteriaOn() ? "the image is of all paths; these are rays of the class that is chosen"
      : "the image is of all criteria; these are rays of those that are on", left + 4, top + 4, width - 8);
  }
  if (!picture) return;
  const x = left + width + 10;
  for (let k = 0; k < height; k++) {
    const step = Math.round((255 * (height - 1 - k)) / Math.max(height - 1, 1));
    paint.fillStyle = `rgb(${scaleBytes.subarray(3 * step, 3 * step + 3).join(",")})`;
    paint.fillRect(x, top + k, 9, 1.5);
  }
  paint.fillStyle = style.getPropertyValue("--faint");
  paint.textAlign = "left";
  paint.textBaseline = "top";
  paint.fillText(figure(picture.most, 2), x + 11, top);
  paint.textBaseline = "bottom";
  paint.fillText(figure(picture.least, 2), x + 11, top + height);
  paint.textAlign = "right";
  paint.textBaseline = "top";
  const beside = FRAME.right + FRAME.bar; // photons/m² are squeezed rather than written over the axis' last number
  paint.fillText(written(detector.image.unit), left + width + beside, top + height + 4, beside - 5);
}

/* The image is of the light of all criteria and classes; of some, the rays of the page stand for it. */
const imageHolds = (detector) => detector.image !== null && allCriteriaOn() && shown.class < 0;

function drawImage() {
  const detector = current();
  if (!detector) return;
  layOut(detector);
  const { left, top, width, height } = sensor.area;
  const picture = imageHolds(detector) ? pictureOf(detector, byId("log").checked) : null;
  paint.clearRect(0, 0, image.width, image.height);
  paint.imageSmoothingEnabled = false;
  if (picture) paint.drawImage(picture.cells, left, top, width, height);
  if (!picture || byId("dots").checked) drawDots(detector);
  drawFrameAndScale(detector, picture);
  drawRegion(detector);
  sensor.picture = picture;
  hangPicture(picture);
}
scheme.told.push(drawImage);

/* "W/(m\u00b2 sr)" of "W/(m2 sr)". */
const written = (unit) => unit.replaceAll("m2", "m\u00b2");

/* Whether most of what is not dark is less than 3 % of the peak: `raymap detector` shows that on a
 * logarithmic scale, too. */
function isSpiky(levels, most) {
  const bright = levels.filter((v) => v > 0);
  return bright.filter((v) => v < 0.03 * most).length > 0.5 * bright.length;
}

function describeDetector() {
  const detector = current(), of = detector.image;
  const note = of
    ? `${of.quantity}, peak ${figure(of.peak, 4)} ${written(of.unit)}; flux ${figure(of.flux, 5)} ± ${figure(of.flux_error, 2)} ${scene.flux_unit} of ${whole(of.registrations)} registrations` +
      (of.step > 1 ? `; ${of.step} x ${of.step} of its ${of.cells.join(" x ")} cells to a pixel` : "")
    : "places where rays of this page were registered";
  byId("image-note").textContent = note;
  if (!sensor.scaled) byId("log").checked = of !== null && isSpiky(imageValues(detector), of.most);
  image.setAttribute("aria-label", `image of detector ${detector.name}: ${note}. Draw on it to select rays; arrow keys move what is drawn, with Shift they resize it, < and > turn it.`);
}

/* The value of the cell under the pointer. */
function showValue(event) {
  const detector = current(), [x, y] = placeOn(image, event), { left, top, width, height } = sensor.area;
  const inside = x >= left && x <= left + width && y >= top && y <= top + height;
  if (!inside || !sensor.picture) return void (byId("image-value").textContent = "");
  const right = rightAxis(detector), place = toCoordinates(x, y), own = [place[right], place[1 - right]];
  const n = detector.image.n, cell = own.map((value, axis) => {
    const [low, high] = span(detector, axis);
    const part = (value - low) / (high - low) * detector.image.cells[axis] / detector.image.step;
    return Math.min(Math.max(Math.floor(part), 0), n[axis] - 1);
  });
  byId("image-value").textContent = axisNames(detector).map((name, axis) => `${name} ${figure(own[axis], 4)}`).join(", ") +
    ` ${axisUnit(detector)}: ${figure(sensor.picture.values[cell[1] * n[0] + cell[0]], 4)} ${written(detector.image.unit)}`;
}
image.addEventListener("pointermove", showValue);
image.addEventListener("pointerleave", () => (byId("image-value").textContent = ""));

byId("log").addEventListener("change", () => {
  sensor.scaled = true;
  drawImage();
});
byId("dots").addEventListener("change", drawImage);
byId("hang").addEventListener("change", drawImage);
whenData(() => {
  const chosen = byId("detector").selectedOptions[0];
  forgetPictures();
  world.remove(...screens.filter((plane) => plane));
  screens.splice(0, screens.length, ...detectors.map(screenOf));
  byId("detector").replaceChildren(...detectors.map((one, index) => element("option", { value: String(index), textContent: one.name })));
  byId("detector-box").hidden = detectors.length === 0;
  const again = chosen ? detectors.findIndex((one) => one.name === chosen.textContent) : -1;
  if (again < 0) Object.assign(sensor, { index: -1, region: null });
  else if (again !== sensor.index) Object.assign(sensor, { index: again });
});
