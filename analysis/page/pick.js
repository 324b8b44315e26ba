// SPDX-License-Identifier: MIT
//
// The leg under the pointer: the nearest of all strokes on the screen. Where they lie there is
// kept until the view changes.

const REACH = 7; // pixels

const pickCache = { valid: false, screen: null };
whenData(() => Object.assign(pickCache, { valid: false, screen: null }));

/* Ends of all strokes in pixels; NaN for what is hidden or behind the eye. */
function screenStrokes() {
  if (pickCache.valid) return pickCache.screen;
  if (!pickCache.screen) pickCache.screen = new Float32Array(4 * strokes.count);
  camera.updateMatrixWorld();
  const m = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix,
    new THREE.Matrix4().getInverse(camera.matrixWorld)).elements;
  const w2 = 0.5 * canvas.clientWidth, h2 = 0.5 * canvas.clientHeight, p = strokes.position;
  for (let s = 0; s < strokes.count; s++) {
    const visible = shown.state[leg.ray[strokes.leg[s]]] > DIM;
    for (let e = 0; e < 2; e++) {
      const i = 6 * s + 3 * e, x = p[i], y = p[i + 1], z = p[i + 2];
      const w = m[3] * x + m[7] * y + m[11] * z + m[15];
      const seen = visible && w > 1e-6;
      pickCache.screen[4 * s + 2 * e] = seen ? w2 + (w2 * (m[0] * x + m[4] * y + m[8] * z + m[12])) / w : NaN;
      pickCache.screen[4 * s + 2 * e + 1] = seen ? h2 - (h2 * (m[1] * x + m[5] * y + m[9] * z + m[13])) / w : NaN;
    }
  }
  pickCache.valid = true;
  return pickCache.screen;
}

/* The leg nearest to a place on the canvas, or -1. */
function legAt(x, y) {
  const screen = screenStrokes(), now = rayUniforms.now.value;
  let best = REACH * REACH, found = -1;
  for (let s = 0; s < strokes.count; s++) {
    const ax = screen[4 * s] - x, ay = screen[4 * s + 1] - y;
    const dx = screen[4 * s + 2] - x - ax, dy = screen[4 * s + 3] - y - ay;
    const square = dx * dx + dy * dy;
    const t = square > 0 ? Math.min(Math.max(-(ax * dx + ay * dy) / square, 0), 1) : 0;
    const u = ax + t * dx, v = ay + t * dy, distance = u * u + v * v;
    if (distance < best && strokes.path[2 * s] + t * (strokes.path[2 * s + 1] - strokes.path[2 * s]) <= now) {
      best = distance;
      found = strokes.leg[s];
    }
  }
  return found;
}

/* The body seen there, or -1: of one that encloses the scene only the far side is. */
function bodyAt(x, y) {
  const caster = new THREE.Raycaster(), normal = new THREE.Vector3(), probe = new THREE.Mesh(undefined, solidMaterials[0]), hits = [];
  caster.setFromCamera({ x: (2 * x) / canvas.clientWidth - 1, y: 1 - (2 * y) / canvas.clientHeight }, camera);
  bodies.forEach((body, index) => {
    if (!body.visible || !caster.ray.intersectsSphere(body.sphere)) return;
    const own = [];
    probe.geometry = body.shape.solid;
    probe.matrixWorld.copy(body.matrix);
    probe.raycast(caster, own);
    for (const { distance: at, point, face } of own) hits.push({ at, point, face, body, index });
  });
  const hit = hits.sort((a, b) => a.at - b.at).find(({ point, face, body }) => {
    const outwards = point.clone().sub(whereabouts.centre);
    normal.copy(face.normal).transformDirection(body.matrix);
    const before = outwards.dot(normal) * normal.dot(caster.ray.direction) < 0;
    const isCut = shading.cut.value > 0.5 && body.object.look !== "glass" && outwards.dot(caster.ray.direction) < 0;
    return !(body.encloses && before) && !isCut;
  });
  return hit ? hit.index : -1;
}

function placeOn(canvasElement, event) {
  const box = canvasElement.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

/* A click is a press that does not move. */
const press = { x: 0, y: 0, held: false, wanted: false };

canvas.addEventListener("pointerdown", (event) => {
  [press.x, press.y] = placeOn(canvas, event);
  press.held = true;
  hideTip();
});
window.addEventListener("pointerup", (event) => {
  if (!press.held) return;
  press.held = false;
  const [x, y] = placeOn(canvas, event);
  if (event.target !== canvas || Math.hypot(x - press.x, y - press.y) > 4) return;
  const l = legAt(x, y), body = l < 0 ? bodyAt(x, y) : -1;
  chooseRay(l < 0 ? -1 : leg.ray[l], l);
  if (l >= 0) showTip(l, x, y);
  else if (body >= 0) showBodyTip(body, x, y);
});
canvas.addEventListener("pointermove", (event) => {
  if (press.held || event.pointerType === "touch") return;
  const [x, y] = placeOn(canvas, event);
  if (!press.wanted)
    requestAnimationFrame(() => {
      press.wanted = false;
      const l = controls.enabled ? legAt(...press.last) : -1; // off: an object is dragged
      markLeg(l);
      if (l < 0 && !byId("tip").classList.contains("body")) hideTip();
      else if (l < 0) return;
      else showTip(l, ...press.last);
    });
  press.wanted = true;
  press.last = [x, y];
});
canvas.addEventListener("pointerleave", () => {
  markLeg(-1);
  if (!byId("tip").classList.contains("body")) hideTip(); // its button is outside the canvas
});
